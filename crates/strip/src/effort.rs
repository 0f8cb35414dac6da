//! How long a generator may search: the levels of effort that options name.

/// The time that a generator may take. Figures are seconds per million triangles on one core,
/// roughly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Effort {
    /// About half a second: one greedy pass and little more.
    Fast,
    /// A few seconds.
    #[default]
    Default,
    /// Up to a minute.
    Thorough,
}

impl Effort {
    /// All efforts, the quickest first.
    pub const ALL: [Self; 3] = [Self::Fast, Self::Default, Self::Thorough];

    /// The name in options.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Default => "default",
            Self::Thorough => "thorough",
        }
    }

    /// One line of help.
    #[must_use]
    pub const fn help(self) -> &'static str {
        match self {
            Self::Fast => "One greedy pass and little more",
            Self::Default => "A few seconds per million triangles",
            Self::Thorough => "Up to a minute per million triangles",
        }
    }
}
