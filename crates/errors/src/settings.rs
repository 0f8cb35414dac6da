//! How closely a pass searches, and the limits of all work.

/// Meshes of no more triangles than this have few, with all others of their scene: all of their
/// levels are looked at more closely. Chosen by hand.
pub(crate) const FEW_TRIANGLES: u32 = 16_384;

/// Meshes of no more triangles than this are very small: their curves are checked, and means of
/// small parts have more samples. Chosen by hand: it takes some milliseconds.
const VERY_SMALL_TRIANGLES: usize = 1_024;

/// Samples of a mesh of a large scene, for each triangle, if it has few triangles. Chosen by hand.
const SAMPLES_PER_TRIANGLE_IN_SCENE: f64 = 4.0;

/// How closely a pass searches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// Meshes of few triangles are looked at closely, and this is one.
    pub(crate) few_triangles: bool,
    /// The mesh is one of a scene that has many triangles, and has few itself.
    pub(crate) is_in_scene: bool,
    /// Samples that a mesh of few triangles gets in all.
    pub(crate) few_triangles_samples: f64,
    /// Samples that all faces together keep where few faces are left.
    pub(crate) few_faces_samples: usize,
    pub(crate) limits: Limits,
}

impl Settings {
    /// For the shape in which all steps are measured.
    pub(crate) const AT_REST: Self = Self {
        few_triangles: true,
        is_in_scene: false,
        few_triangles_samples: 20_000.0,
        few_faces_samples: 40_000,
        limits: Limits::DEFAULT,
    };

    /// For shapes of which only what exceeds the errors of another one matters.
    pub(crate) const IN_POSES: Self = Self { few_triangles_samples: 10_000.0, ..Self::AT_REST };

    /// For a mesh of some triangles in a scene whose meshes have so many together: each takes its
    /// share of what one mesh of as many would take, or a little more.
    pub(crate) fn in_scene(self, triangles: usize, scene_triangles: usize) -> Self {
        let scene_triangles = scene_triangles.max(triangles).max(1);
        let share = triangles as f64 / scene_triangles as f64;
        let samples = self.few_triangles_samples;
        let in_scene =
            (samples * share).max(SAMPLES_PER_TRIANGLE_IN_SCENE * triangles as f64).min(samples);
        let few_triangles = scene_triangles <= FEW_TRIANGLES as usize;
        let few_triangles_samples = if few_triangles { samples } else { in_scene };
        let is_in_scene = !few_triangles && triangles <= FEW_TRIANGLES as usize;
        Self { few_triangles, is_in_scene, few_triangles_samples, ..self }
    }

    /// Whether a mesh of some triangles is very small, and none of a large scene.
    pub(crate) fn is_very_small(&self, triangles: usize) -> bool {
        !self.is_in_scene && triangles <= VERY_SMALL_TRIANGLES
    }
}

/// Limits of the work that any mesh may take. Where one is met, an answer is not given: another way
/// is taken to it, or what is stated is a bound that holds all the same.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Work of a pass ([`Work`](crate::work::Work)): for each triangle of the input, and besides.
    /// After that levels are measured one by one.
    pub(crate) work: [u64; 2],
    /// Boxes that one search of a pass for a near triangle may open. What it finds then raises
    /// nothing. And for the farthest point of a triangle.
    pub(crate) boxes_nearest: u32,
    pub(crate) boxes_farthest: u64,
    /// Boxes that the search for the farthest point of a level may open: for each triangle that is
    /// searched, for each of the input, and besides. Beyond, its bounds stay apart, and the upper
    /// one is stated.
    pub(crate) boxes_per_level: [u32; 3],
    /// Most levels that are measured, and boxes that may be opened for them: for each triangle of
    /// the input, and besides. After that no level is measured between two that were.
    pub(crate) max_levels: usize,
    pub(crate) boxes: [u64; 2],
    /// Samples on either surface that tell the mean distance of a level: one that is measured by
    /// itself, and one between which others are interpolated, at least and at most.
    pub(crate) samples: usize,
    pub(crate) rung_samples: [usize; 2],
}

impl Limits {
    /// Chosen by hand. Real meshes need less than a third of the work.
    pub(crate) const DEFAULT: Self = Self {
        work: [600, 3_000_000],
        boxes_nearest: 4_000,
        boxes_farthest: 4_000,
        boxes_per_level: [200, 50, 500_000],
        max_levels: 100,
        boxes: [500, 5_000_000],
        samples: 4_096,
        rung_samples: [1_024, 2_048],
    };

    /// Returns how many boxes may be opened for levels of a mesh of some triangles.
    pub(crate) fn max_boxes(&self, triangles: usize) -> u64 {
        self.boxes[0] * triangles as u64 + self.boxes[1]
    }

    /// Returns how much work a pass over a mesh of some triangles may take.
    pub(crate) fn max_work(&self, triangles: usize) -> u64 {
        self.work[0] * triangles as u64 + self.work[1]
    }
}
