//! How closely a pass searches.

#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// Samples that a mesh of few triangles gets in all; and one that is searched exhaustively,
    /// whose samples tell mean distances alone (those of cubes to 2 %).
    few_triangles_samples: f64,
    exhaustive_samples: f64,
    /// Samples that all faces together keep where few faces are left.
    pub(crate) few_faces_samples: usize,
    /// In meshes of up to this many triangles, all that a step may concern are searched, and mean
    /// distances are those of points spread over the faces. Of 10,000 mutated meshes two stated
    /// 6 % too little without.
    exhaustive_triangles: usize,
    /// Whether the mean distance of faces that samples do not represent is looked up.
    pub(crate) look_up_means: bool,
}

impl Settings {
    /// For the shape in which all steps are measured.
    pub(crate) const AT_REST: Self = Self {
        few_triangles_samples: 30_000.0,
        exhaustive_samples: 9_000.0,
        few_faces_samples: 3_000,
        exhaustive_triangles: 512,
        look_up_means: true,
    };

    /// For shapes of which only what exceeds the errors of another one matters.
    pub(crate) const IN_POSES: Self = Self {
        few_triangles_samples: 5_000.0,
        exhaustive_samples: 5_000.0,
        few_faces_samples: 2_000,
        exhaustive_triangles: 0,
        look_up_means: false,
    };

    /// Returns whether all that a step may concern is searched in a mesh of `triangles` triangles.
    pub(crate) fn is_exhaustive(&self, triangles: usize) -> bool {
        triangles <= self.exhaustive_triangles
    }

    /// Returns how many samples a mesh of `triangles` triangles gets in all if that is few.
    pub(crate) fn few_triangles_samples(&self, triangles: usize) -> f64 {
        if self.is_exhaustive(triangles) {
            self.exhaustive_samples
        } else {
            self.few_triangles_samples
        }
    }
}
