//! How closely a pass looks.

/// Thresholds of a pass. Shares are of the bound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Care {
    /// Threads of a pool from which on the other way has one of its own.
    pub(crate) threads: usize,
    /// Samples that a mesh of few triangles gets in all.
    pub(crate) samples: f64,
    /// Samples that faces keep where few are left, in all.
    pub(crate) kept: usize,
    /// Meshes of up to so many triangles are searched as a whole after every step.
    pub(crate) exhaustive: usize,
    /// Whether faces without samples are asked for their mean distance.
    pub(crate) means: bool,
    /// A point of a new face is near enough within this share.
    pub(crate) asked: f64,
    /// A new face with a point beyond this share is asked at more points.
    pub(crate) warm: f64,
    /// The share beyond which a face is asked at more points where very few are left.
    pub(crate) tepid: f64,
}

impl Care {
    /// For the shape that all steps are measured in.
    pub(crate) const AT_REST: Self = Self {
        threads: 2,
        samples: 30_000.0,
        kept: 10_000,
        exhaustive: 100,
        means: true,
        asked: 0.39,
        warm: 0.4,
        tepid: 0.15,
    };

    /// For shapes of which only what exceeds the errors of another one matters.
    pub(crate) const IN_POSES: Self = Self {
        threads: 4,
        samples: 5_000.0,
        kept: 2_000,
        exhaustive: 0,
        means: false,
        asked: 0.6,
        warm: 0.6,
        tepid: 0.3,
    };
}
