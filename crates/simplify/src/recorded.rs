//! The collapses of a run, so that another one of the same mesh can repeat the first of them.

/// A collapse of the group `from` onto the group `to`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecordedCollapse {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) changes_topology: bool,
}

/// The legal collapses of a run, in their order.
#[derive(Clone, Debug, Default)]
pub struct RecordedCollapses(pub(crate) Vec<RecordedCollapse>);
