//! The list of wedge groups that a batch of splits is walked through: one bit for each group says
//! whether the next step splits it (docs/STREAM.md, section 4; `source/batches.rs` makes the
//! order).

use crate::entropy::adaptive_probability::AdaptiveBit;
use crate::entropy::integer_codes::{GammaCode, bit_length};
use lodc_mesh::NONE;

/// Classes of a group: by its number of splits in this batch (up to 3), and whether it came with
/// the batch.
const CLASSES: usize = 8;
/// Numbers of triangles of a group's first vertex that are told apart: 0 to one fewer, or more.
const TRIANGLES: usize = 10;
/// Ratios of the groups to the splits that are to come, as powers of two, that are told apart: 0 to
/// one fewer, or more.
const RATIOS: usize = 8;

/// Contexts of batches.
#[derive(Clone, Debug)]
pub(crate) struct BatchContexts {
    /// Number of steps.
    pub(crate) steps: GammaCode,
    /// A step splits off the group.
    pub(crate) splits: [[[AdaptiveBit; TRIANGLES]; CLASSES]; RATIOS],
}

impl BatchContexts {
    pub(crate) const NEW: Self =
        Self { steps: GammaCode::NEW, splits: [[[AdaptiveBit::NEW; TRIANGLES]; CLASSES]; RATIOS] };
}

/// The list, and how far the present batch has walked. A group is named by its first vertex.
#[derive(Clone, Debug)]
pub(crate) struct GroupList {
    /// For each vertex the group behind it in the list; of those that are groups.
    next: Vec<u32>,
    groups: u32,
    /// The present group; [`NONE`] behind the last.
    pub(super) group: u32,
    /// Splits of it in this batch.
    splits: u32,
    /// Groups from the present one on.
    groups_remaining: u32,
    /// Steps of the batch that are not coded yet.
    pub(super) steps_remaining: u32,
    /// Vertices before the batch.
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

    /// Notes a split of the group at hand.
    pub(super) fn split(&mut self) {
        self.splits += 1;
        self.steps_remaining -= 1;
    }

    /// Adds a vertex: a group of its own behind the one at hand, or one of a group.
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

    /// Returns the group behind the one at hand.
    pub(super) fn following(&self) -> Option<u32> {
        self.next.get(self.group as usize).copied().filter(|&next| next != NONE)
    }

    /// Returns the context of whether the group at hand is split, given the number of triangles of
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
        let triangles = (triangles as usize).min(TRIANGLES - 1);
        &mut contexts.splits[(ratio as usize).min(RATIOS - 1)][class as usize][triangles]
    }
}
