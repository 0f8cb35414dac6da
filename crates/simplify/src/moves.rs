//! The collapses of a run, for another one of the same mesh to begin with.

/// A collapse of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Move {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) changes_topology: bool,
}

/// The legal collapses of a run, in their order.
#[derive(Clone, Debug, Default)]
pub struct Moves(pub(crate) Vec<Move>);
