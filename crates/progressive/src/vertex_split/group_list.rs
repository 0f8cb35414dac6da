//! The list of wedge groups that a batch of splits is walked through: one bit for each group says
//! whether the next step splits it (docs/STREAM.md, section 4; `source/batches.rs` makes the
//! order).

use crate::entropy::adaptive_probability::AdaptiveBit;
use crate::entropy::integer_codes::{GammaCode, bit_length};
use lodc_mesh::NONE;

// How many contexts say whether a group is split, along each axis. Constants of the format, chosen
// by hand.

/// Classes of a group: its number of splits in this batch, up to 3, plus 4 if the batch brought it.
const GROUP_CLASSES: usize = 8;
/// Numbers of triangles of a group's first vertex: 0 to one fewer, or more.
const TRIANGLE_CLASSES: usize = 10;
/// Binary logarithms of the ratio of the groups still to be visited to the steps still to come: 0
/// to one fewer, or more.
const RATIO_CLASSES: usize = 8;

/// Contexts of batches.
#[derive(Clone, Debug)]
pub(crate) struct BatchContexts {
    /// Number of steps.
    pub(crate) steps: GammaCode,
    /// The next step splits the group.
    pub(crate) splits: [[[AdaptiveBit; TRIANGLE_CLASSES]; GROUP_CLASSES]; RATIO_CLASSES],
}

impl BatchContexts {
    pub(crate) const NEW: Self = Self {
        steps: GammaCode::NEW,
        splits: [[[AdaptiveBit::NEW; TRIANGLE_CLASSES]; GROUP_CLASSES]; RATIO_CLASSES],
    };
}

/// The list, and how far the present batch has walked. A group is named by its first vertex.
#[derive(Clone, Debug)]
pub(crate) struct GroupList {
    /// For each first vertex of a group the group behind it in the list, or [`NONE`].
    next: Vec<u32>,
    /// Number of groups.
    groups: u32,
    /// The present group; [`NONE`] behind the last.
    pub(super) group: u32,
    /// Splits of the present group in this batch.
    splits: u32,
    /// Groups from the present one on.
    groups_remaining: u32,
    /// Steps of the batch that are not coded yet.
    pub(super) steps_remaining: u32,
    /// Number of vertices before the batch.
    first_new: u32,
}

impl GroupList {
    /// The list of an object that begins with `points` points.
    pub(super) fn new(points: u32) -> Self {
        let mut next: Vec<u32> = (1..=points).collect();
        if let Some(last) = next.last_mut() {
            *last = NONE;
        }
        Self {
            next,
            groups: points,
            group: NONE,
            splits: 0,
            groups_remaining: 0,
            steps_remaining: 0,
            first_new: points,
        }
    }

    /// Reserves memory for this many more vertices.
    pub(super) fn reserve(&mut self, vertices: usize) {
        self.next.reserve_exact(vertices);
    }

    /// Begins a batch of `steps` steps.
    pub(super) fn begin(&mut self, steps: u32) {
        self.first_new = self.next.len() as u32;
        (self.group, self.splits, self.groups_remaining) = (0, 0, self.groups);
        self.steps_remaining = steps;
    }

    /// Goes on to the next group.
    pub(super) fn advance(&mut self) {
        self.group = self.next[self.group as usize];
        self.splits = 0;
        self.groups_remaining = self.groups_remaining.saturating_sub(1);
    }

    /// Counts a split of the present group.
    pub(super) fn count_split(&mut self) {
        self.splits += 1;
        self.steps_remaining -= 1;
    }

    /// Adds a vertex: as a new group behind the present one, or as a further wedge of a group.
    pub(super) fn add_vertex(&mut self, is_group: bool) {
        let new = self.next.len() as u32;
        self.next.push(NONE);
        if is_group {
            self.next.swap(new as usize, self.group as usize);
            self.next[self.group as usize] = new;
            self.groups += 1;
            self.groups_remaining += 1;
        }
    }

    /// Returns the group behind the present one.
    pub(super) fn following(&self) -> Option<u32> {
        self.next.get(self.group as usize).copied().filter(|&next| next != NONE)
    }

    /// Returns the context of whether the present group is split, given the number of triangles of
    /// its first vertex.
    #[inline]
    pub(super) fn context<'c>(
        &self,
        contexts: &'c mut BatchContexts,
        triangles: u32,
    ) -> &'c mut AdaptiveBit {
        let ratio =
            bit_length(self.groups_remaining).saturating_sub(bit_length(self.steps_remaining));
        let class = self.splits.min(3) + if self.group >= self.first_new { 4 } else { 0 };
        let triangles = (triangles as usize).min(TRIANGLE_CLASSES - 1);
        &mut contexts.splits[(ratio as usize).min(RATIO_CLASSES - 1)][class as usize][triangles]
    }
}
