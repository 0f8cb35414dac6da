//! Moving all faces of a group to another: dead faces leave every star, the others change hands.
//!
//! A closed fan stays in counter-clockwise order: the moving group's path from the one face beside
//! the collapsed edge to the other takes the place of the two faces that die. Faces at hubs know
//! their places there, so that leaving takes constant time whatever the star.

use crate::cut::{Corner, HUB_VALENCE, IS_HUB, OPEN, Star, WorkingMesh, next, previous};

impl WorkingMesh {
    /// Moves all of `from`'s faces to `to`. Faces that lose a corner die, and `died` gets their
    /// triangles.
    pub(crate) fn merge(&mut self, from: u32, to: u32, mut died: impl FnMut(u32)) {
        let room = std::mem::take(&mut self.stars[from as usize]);
        let range = room.start as usize..(room.start + room.len) as usize;
        let turn = self.arena[range.clone()].iter().position(|c| c.ahead == to).unwrap_or(0);
        self.arena[range.clone()].rotate_left(turn);
        let spliced = self.flags[from as usize] & OPEN == 0 && self.flags[to as usize] & OPEN == 0;
        // In a closed fan the next corner leads to the group behind: no face has to be looked at.
        let closed = !self.has(from, OPEN);
        let first = self.arena[range.clone()].first().map_or(to, |c| c.ahead);
        let (mut kept, end) = (range.start, range.end);
        // Where the path of the moving group belongs in the star of `to`.
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
                if self.has(to, IS_HUB) && (self.has(ahead, IS_HUB) || self.has(behind, IS_HUB)) {
                    self.hub_epoch += 1;
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
        self.join(room, kept - room.start as usize, to, if spliced { Some(gap) } else { None });
    }

    /// Puts the first `moved` corners of `from`'s room into the star of `to`: into a gap, or at its
    /// end. The star takes `from`'s room, its own, or new room.
    fn join(&mut self, from: Star, moved: usize, to: u32, gap: Option<usize>) {
        let star = self.stars[to as usize];
        let (path, old) = (from.start as usize, star.start as usize);
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
            let (start, capacity) = if len <= from.capacity as usize {
                (path, from.capacity)
            } else {
                let start = self.arena.len();
                let capacity = len + len / 2;
                if start + capacity > self.arena.capacity() {
                    // By little: all regions are there at once.
                    self.arena.reserve_exact(capacity + start / 8);
                }
                self.arena.resize(start + capacity, Corner::new(0, 0, 0));
                (start, capacity as u32)
            };
            self.arena[start..start + len].copy_from_slice(&joined);
            self.stars[to as usize] = Star { start: start as u32, len: len as u32, capacity };
            self.joined = joined;
        }
        if self.has(to, IS_HUB) {
            self.number_slots(to, kept);
        } else if len > HUB_VALENCE {
            self.make_hub(to);
        }
    }

    /// Slot of a face in the star of the group at its corner `at`.
    #[inline]
    fn slot_of(&self, group: u32, face: u32, at: usize) -> Option<usize> {
        if self.has(group, IS_HUB) {
            let slot = self.hub_slots[face as usize][at] as usize;
            return (slot < self.valence(group)).then_some(slot);
        }
        let start = self.stars[group as usize].start as usize;
        if let Some(&eight) = self.arena[start..].first_chunk::<8>() {
            // No guess where the search ends. What lies behind a star's end is found after it.
            let found = (0..8).fold(0, |found, i| found | u32::from(eight[i].face() == face) << i);
            let slot = found.trailing_zeros() as usize;
            if slot < self.valence(group).min(8) {
                return Some(slot);
            }
        }
        self.star(group).iter().position(|c| c.face() == face)
    }

    /// Names the group now ahead of `group` in a face. In `group`'s star, the moving one was.
    #[inline]
    fn set_ahead(&mut self, group: u32, face: u32, ahead: u32) {
        if self.has(group, OPEN) {
            // Nobody reads it there.
            return;
        }
        if let Some(slot) = self.slot_of(group, face, 0) {
            self.arena[self.stars[group as usize].start as usize + slot].ahead = ahead;
        }
    }

    /// Takes a face out of the star of the group at its corner `at`. Returns where it stood.
    #[inline]
    fn leave(&mut self, group: u32, face: u32, at: usize) -> Option<usize> {
        let slot = self.slot_of(group, face, at)?;
        let star = &mut self.stars[group as usize];
        let (start, last) = (star.start as usize, star.len as usize - 1);
        star.len -= 1;
        if self.has(group, IS_HUB) {
            let corner = self.arena[start + last];
            self.arena[start + slot] = corner;
            self.hub_slots[corner.face() as usize][corner.at()] = slot as u32;
        } else {
            self.arena.copy_within(start + slot + 1..start + last + 1, start + slot);
            // A closed fan: the slot behind now follows the slot before.
        }
        Some(slot)
    }
}
