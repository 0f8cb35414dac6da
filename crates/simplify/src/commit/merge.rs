//! Moving all faces of a group to another: dead faces leave every star, the others change hands.
//!
//! A closed fan stays in counter-clockwise order, so that pricing need never look for the next face
//! around a group. Of the moving group's ring the two faces at the collapsed edge die; what is left
//! is one path, and it takes the place of those two faces in the target's ring:
//!
//! ```text
//!   faces by their other two groups, counter-clockwise
//!   ring of `from`:   (to d) (d a) (a b) (b c) (c to)       the first and the last die;
//!   ring of `to`:   … (x d) (d from) (from c) (c y) …       they are these two
//!   joined:         … (x d) (d a) (a b) (b c) (c y) …
//! ```
//!
//! Stars of all groups are in one arena; a star that outgrows its room there gets a new one. For
//! high-valence groups the slots of faces are kept, so that removing one takes
//! constant time however large the star is.

use crate::cut::{Corner, HIGH_VALENCE, IS_HIGH_VALENCE, OPEN, Star, WorkingMesh, next, previous};

impl WorkingMesh {
    /// Moves all of `from`'s faces to `to`, which leaves `from` with an empty star. Faces that had
    /// a corner at each die, and `died` gets their triangles.
    pub(crate) fn merge(&mut self, from: u32, to: u32, mut died: impl FnMut(u32)) {
        let vacated = std::mem::take(&mut self.stars[from as usize]);
        let range = vacated.start as usize..(vacated.start + vacated.len) as usize;
        // Rotated like this, a ring's first and last faces are those that die, and the path between
        // them is contiguous. The order of an open star means nothing: any rotation will do.
        let turn = self.arena[range.clone()].iter().position(|c| c.ahead == to).unwrap_or(0);
        self.arena[range.clone()].rotate_left(turn);
        let spliced = self.flags[from as usize] & OPEN == 0 && self.flags[to as usize] & OPEN == 0;
        // In a ring the group behind a corner is the one ahead of the next, which is here already.
        // Reading it from the face would be a cache miss for most of them.
        let closed = !self.has(from, OPEN);
        let first = self.arena[range.clone()].first().map_or(to, |c| c.ahead);
        let (mut kept, end) = (range.start, range.end);
        // The slot in the ring of `to` where the path belongs: that of the dead faces, which are
        // next to each other there.
        let mut gap = self.valence(to);
        for i in range {
            let corner = self.arena[i];
            let face = corner.face();
            let [ahead, behind] = if closed {
                [corner.ahead, if i + 1 < end { self.arena[i + 1].ahead } else { first }]
            } else {
                self.others(corner)
            };
            if ahead != to && behind != to {
                self.faces[face as usize].groups[corner.at()] = to;
                self.update_facet(face);
                self.set_ahead(behind, face, to);
                if self.has(to, IS_HIGH_VALENCE)
                    && (self.has(ahead, IS_HIGH_VALENCE) || self.has(behind, IS_HIGH_VALENCE))
                {
                    // Two high-valence groups may have come to share a face: see `link::Marks`.
                    self.high_valence_epoch += 1;
                }
                self.arena[kept] = corner;
                kept += 1;
                continue;
            }
            self.live_faces -= 1;
            died(self.faces[face as usize].triangle);
            let at_to = if ahead == to { next(corner.at()) } else { previous(corner.at()) };
            let apex = if ahead == to { previous(corner.at()) } else { next(corner.at()) };
            self.leave(if ahead == to { behind } else { ahead }, face, apex);
            let slot = self.leave(to, face, at_to);
            if let Some(slot) = slot {
                gap = if slot < gap { slot } else { gap.min(self.valence(to)) };
            }
        }
        let gap = spliced.then_some(gap);
        self.join(vacated, kept - vacated.start as usize, to, gap);
    }

    /// Puts the first `moved` corners of the vacated star into the star of `to`: at the slot `gap`,
    /// or at its end. The joined star stays where it is if it fits, else takes the vacated room if
    /// it fits there, else goes to the end of the arena.
    fn join(&mut self, vacated: Star, moved: usize, to: u32, gap: Option<usize>) {
        let star = self.stars[to as usize];
        let (path, old) = (vacated.start as usize, star.start as usize);
        let (kept, len) = (star.len as usize, star.len as usize + moved);
        let gap = gap.unwrap_or(kept).min(kept);
        if len <= star.capacity as usize {
            self.arena.copy_within(old + gap..old + kept, old + gap + moved);
            self.arena.copy_within(path..path + moved, old + gap);
            self.stars[to as usize].len = len as u32;
        } else {
            let mut joined = std::mem::take(&mut self.joined);
            joined.clear();
            joined.extend_from_slice(&self.arena[old..old + gap]);
            joined.extend_from_slice(&self.arena[path..path + moved]);
            joined.extend_from_slice(&self.arena[old + gap..old + kept]);
            let (start, capacity) = if len <= vacated.capacity as usize {
                (path, vacated.capacity)
            } else {
                let start = self.arena.len();
                // Half as much again: a star that grows with each of many collapses is copied a
                // logarithmic number of times.
                let capacity = len + len / 2;
                if start + capacity > self.arena.capacity() {
                    // By an eighth, where a vector would double: all regions of a mesh are in
                    // memory at once, and so is what each has to spare. The share is chosen by
                    // hand.
                    self.arena.reserve_exact(capacity + start / 8);
                }
                self.arena.resize(start + capacity, Corner::new(0, 0, 0));
                (start, capacity as u32)
            };
            self.arena[start..start + len].copy_from_slice(&joined);
            self.stars[to as usize] = Star { start: start as u32, len: len as u32, capacity };
            self.joined = joined;
        }
        if self.has(to, IS_HIGH_VALENCE) {
            self.number_slots(to, kept);
        } else if len > HIGH_VALENCE {
            self.make_high_valence(to);
        }
    }

    /// Slot of a face in the star of the group at its corner `at`.
    #[inline]
    fn slot_of(&self, group: u32, face: u32, at: usize) -> Option<usize> {
        if self.has(group, IS_HIGH_VALENCE) {
            let slot = self.star_slots[face as usize][at] as usize;
            return (slot < self.valence(group)).then_some(slot);
        }
        let start = self.stars[group as usize].start as usize;
        if let Some(&eight) = self.arena[start..].first_chunk::<8>() {
            // Nearly all stars have at most eight corners. All eight are compared without a branch,
            // since a processor cannot predict at which of them a loop would stop. Slots beyond
            // the star's end belong to others, and a match there counts for nothing.
            let found = (0..8).fold(0, |found, i| found | u32::from(eight[i].face() == face) << i);
            let slot = found.trailing_zeros() as usize;
            if slot < self.valence(group).min(8) {
                return Some(slot);
            }
        }
        self.star(group).iter().position(|c| c.face() == face)
    }

    /// Replaces the group ahead of `group` in a face, in the star of `group`.
    #[inline]
    fn set_ahead(&mut self, group: u32, face: u32, ahead: u32) {
        if self.has(group, OPEN) {
            // `ahead` is read in closed fans only.
            return;
        }
        if let Some(slot) = self.slot_of(group, face, 0) {
            self.arena[self.stars[group as usize].start as usize + slot].ahead = ahead;
        }
    }

    /// Takes a face out of the star of the group at its corner `at`. Returns the slot it had.
    #[inline]
    fn leave(&mut self, group: u32, face: u32, at: usize) -> Option<usize> {
        let slot = self.slot_of(group, face, at)?;
        let star = &mut self.stars[group as usize];
        let (start, last) = (star.start as usize, star.len as usize - 1);
        star.len -= 1;
        if self.has(group, IS_HIGH_VALENCE) {
            let corner = self.arena[start + last];
            self.arena[start + slot] = corner;
            self.star_slots[corner.face() as usize][corner.at()] = slot as u32;
        } else {
            // In order, as a closed fan has to stay; a high-valence group has no order, so its last
            // corner may fill the slot.
            self.arena.copy_within(start + slot + 1..start + last + 1, start + slot);
        }
        Some(slot)
    }
}
