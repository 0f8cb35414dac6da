//! How long a generator may search.

/// How long a generator may search. Figures are seconds per million triangles on one core, roughly.
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
