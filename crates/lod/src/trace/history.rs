//! The history of strips through a collapse sequence: which indices every record changes, and which
//! elements it removes.
//!
//! An element is an index of a strip while the strip shrinks. Its offset counts the elements that
//! are still in the buffer before it, from where the strip starts at LOD 0: those of dead fronts
//! stay in the buffer and count.

use lodc_mesh::NONE;

/// What removed elements are, and so how they come back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RemovalKind {
    /// A vertex repetition: each element is the one before it.
    Vertex,
    /// An edge repetition: each element is the one two before it.
    Edge,
    /// A dead front: all before the first triangle that is drawn. It stays in the buffer of strips.
    Front,
    /// A dead back: all after the last triangle that is drawn. It stays in the buffer of strips.
    Back,
}

impl RemovalKind {
    /// All kinds, each at the number by which files name it.
    pub const ALL: [Self; 4] = [Self::Vertex, Self::Edge, Self::Front, Self::Back];

    /// Returns the distance at which an element of a repetition finds its equal before it; 0 for
    /// ends.
    #[must_use]
    pub const fn period(self) -> u32 {
        match self {
            Self::Vertex => 1,
            Self::Edge => 2,
            Self::Front | Self::Back => 0,
        }
    }
}

/// Consecutive elements that a record removes from a strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Removal {
    /// The offset of the first of them before the record.
    pub offset: u32,
    /// Number of elements.
    pub count: u32,
    /// What they are.
    pub kind: RemovalKind,
}

/// A record that changes a strip, and how many of the changes and removals in [`History`] are its:
/// those after the ones of the events before it.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// The strip.
    pub strip: u32,
    /// The record.
    pub record: u32,
    /// Number of its indices that change.
    pub changes: u32,
    /// Number of runs of elements that are removed.
    pub removals: u32,
}

/// All changes of some consecutive strips, strip by strip, each in order of records. The event
/// without changes is the one with which a strip dies.
#[derive(Debug, Default)]
pub struct History {
    /// One for each strip and record that changes it.
    pub events: Vec<Event>,
    /// Offsets before the record of the elements that it changes.
    pub changes: Vec<u32>,
    /// Runs of elements that records remove.
    pub removals: Vec<Removal>,
    /// For each index of the strips the first LOD without it, [`NONE`] if it is never removed.
    pub index_removal_lods: Vec<u32>,
    /// For each index whether it is removed at the front of its strip.
    pub is_removed_at_front: Vec<bool>,
    /// For each index that is removed at the front or back of its strip its offset then, where it
    /// stays in the buffer; for others [`NONE`].
    pub end_offsets: Vec<u32>,
    /// For each strip the first LOD at which it draws nothing.
    pub removal_lods: Vec<u32>,
}

impl History {
    /// Adds a strip of `index_count` indices, none of them removed so far. Returns where they start
    /// in the lists by index.
    pub(crate) fn begin_strip(&mut self, index_count: usize) -> usize {
        let first = self.index_removal_lods.len();
        self.index_removal_lods.resize(first + index_count, NONE);
        self.is_removed_at_front.resize(first + index_count, false);
        self.end_offsets.resize(first + index_count, NONE);
        first
    }

    /// Appends the history of further strips.
    pub fn append(&mut self, more: Self) {
        self.events.extend(more.events);
        self.changes.extend(more.changes);
        self.removals.extend(more.removals);
        self.index_removal_lods.extend(more.index_removal_lods);
        self.is_removed_at_front.extend(more.is_removed_at_front);
        self.end_offsets.extend(more.end_offsets);
        self.removal_lods.extend(more.removal_lods);
    }
}
