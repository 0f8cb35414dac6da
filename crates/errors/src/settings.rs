//! How closely a pass searches.

#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// Samples that a mesh of few triangles gets in all.
    pub(crate) few_triangles_samples: f64,
    /// Samples that all faces together keep where few faces are left.
    pub(crate) few_faces_samples: usize,
    /// In meshes of up to this many triangles, all that a step may concern are searched, and mean
    /// distances are those of points spread over the faces. Of 10,000 mutated meshes two stated
    /// 6 % too little without.
    pub(crate) exhaustive_triangles: usize,
    /// Whether the mean distance of faces that samples do not represent is looked up.
    pub(crate) look_up_means: bool,
}

impl Settings {
    /// For the shape in which all steps are measured.
    pub(crate) const AT_REST: Self = Self {
        few_triangles_samples: 30_000.0,
        few_faces_samples: 3_000,
        exhaustive_triangles: 512,
        look_up_means: true,
    };

    /// For shapes of which only what exceeds the errors of another one matters.
    pub(crate) const IN_POSES: Self = Self {
        few_triangles_samples: 5_000.0,
        few_faces_samples: 2_000,
        exhaustive_triangles: 0,
        look_up_means: false,
    };
}
