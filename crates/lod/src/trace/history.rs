//! The history of strips through a collapse sequence: which indices every record changes, and which
//! elements it removes.

use lodc_mesh::NONE;

/// The way in which removed elements come back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A vertex repetition: each element is the one before it.
    Vertex,
    /// An edge repetition: each element is the one two before it.
    Edge,
    /// A dead front: all before the first triangle that is drawn. It stays in the buffer.
    Front,
    /// A dead back: all after the last triangle that is drawn. It stays in the buffer.
    Back,
}

impl Kind {
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
    /// The offset of the first of them before the record, counted from where the strip starts at
    /// LOD 0, whatever was removed at the front.
    pub at: u32,
    /// Number of elements.
    pub count: u32,
    /// The way in which they come back.
    pub kind: Kind,
}

/// The number of changes that one record makes to one strip. The changes themselves follow one
/// another in [`History`].
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
    /// Offsets in a strip, as before the record, that change.
    pub changes: Vec<u32>,
    /// The removals.
    pub removals: Vec<Removal>,
    /// For each index of the strips the first LOD without it, [`NONE`] if it is never removed.
    pub index_removal_lods: Vec<u32>,
    /// For each index whether it is removed at the front of its strip.
    pub at_front: Vec<bool>,
    /// For each index that is removed at the front or back of its strip its offset then, where it
    /// stays in the buffer; for others [`NONE`].
    pub removed_at: Vec<u32>,
    /// For each strip the first LOD at which it draws nothing.
    pub removal_lods: Vec<u32>,
}

impl History {
    /// Adds a strip of `indices` indices. Returns where they start.
    pub(crate) fn begin_strip(&mut self, indices: usize) -> usize {
        let first = self.index_removal_lods.len();
        self.index_removal_lods.resize(first + indices, NONE);
        self.at_front.resize(first + indices, false);
        self.removed_at.resize(first + indices, NONE);
        first
    }

    /// Appends the history of further strips.
    pub fn append(&mut self, more: Self) {
        self.events.extend(more.events);
        self.changes.extend(more.changes);
        self.removals.extend(more.removals);
        self.index_removal_lods.extend(more.index_removal_lods);
        self.at_front.extend(more.at_front);
        self.removed_at.extend(more.removed_at);
        self.removal_lods.extend(more.removal_lods);
    }
}
