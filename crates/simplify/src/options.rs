//! Options of a simplification.

/// The metric that orders collapses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum MetricKind {
    /// Distance to planes, refitted to the current surface, with a small accumulated term.
    #[default]
    Quadric,
    /// Viewpoint entropy over 20 pictures (thesis 3.2.1): what is hidden goes first, then what
    /// covers few pixels.
    Viewpoint,
    /// Kullback–Leibler divergence between areas seen and areas in space: flat regions go first,
    /// however they are cut up.
    Divergence,
    /// Error of the shaded surface, as far as it is seen: what a viewer would notice least goes
    /// first.
    Hybrid,
}

impl MetricKind {
    /// All metrics, in the order in which help lists them.
    pub const ALL: [Self; 4] = [Self::Quadric, Self::Viewpoint, Self::Divergence, Self::Hybrid];

    /// The name in options.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quadric => "quadric",
            Self::Viewpoint => "viewpoint",
            Self::Divergence => "kl",
            Self::Hybrid => "hybrid",
        }
    }

    /// One line of help.
    #[must_use]
    pub const fn help(self) -> &'static str {
        match self {
            Self::Quadric => "Distance to the surface: the quickest, and the closest in space",
            Self::Viewpoint => "Viewpoint entropy over 20 pictures: hidden parts go first",
            Self::Divergence => {
                "Kullback-Leibler divergence between visible and actual areas over 20 pictures"
            }
            Self::Hybrid => "Error of the shaded surface where it is seen: for single objects",
        }
    }
}

/// Importance of differences of attributes, as factors of the defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Normals.
    pub normal: f64,
    /// Texture coordinates.
    pub uv: f64,
    /// Vertex colours.
    pub color: f64,
    /// Joints and their weights: shapes in poses, or the weights themselves where there is no pose.
    pub skin: f64,
    /// Shapes with morph targets, by themselves at weight 1.
    pub morph: f64,
}

impl Weights {
    /// All 1: the lengths that they scale were measured (`price::attributes`).
    pub const DEFAULT: Self = Self { normal: 1.0, uv: 1.0, color: 1.0, skin: 1.0, morph: 1.0 };
}

/// Options of a simplification.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The metric that orders collapses.
    pub metric: MetricKind,
    /// No topology change before the terminal phase.
    pub preserve_topology: bool,
    /// Border vertices stay until the terminal phase.
    pub lock_border: bool,
    /// True if attributes count in the cost.
    pub attributes: bool,
    /// Importance of each of them.
    pub weights: Weights,
    /// Pixels across the pictures that viewpoint metrics look at, 8 to 1024. Time grows with its
    /// square.
    pub picture: u32,
    /// The number of samples of the surface that [`MetricKind::Hybrid`] looks at, about; at least
    /// one for each triangle. Time grows with it.
    pub hybrid_samples: u32,
}

impl Options {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        metric: MetricKind::Quadric,
        preserve_topology: false,
        lock_border: false,
        attributes: true,
        weights: Weights::DEFAULT,
        picture: 256,
        hybrid_samples: 16_000,
    };
}

impl Default for Options {
    fn default() -> Self {
        Self::DEFAULT
    }
}
