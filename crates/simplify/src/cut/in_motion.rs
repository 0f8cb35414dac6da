//! A region in motion: the accumulated quadrics of its groups in other shapes than at rest, and the
//! surroundings of a group there (Mohr and Gleicher 2003; DeCoro and Rusinkiewicz 2005).
//!
//! A shape counts at a group only where something around it has moved, now or in what collapsed
//! onto it. So a target that moves an eyebrow costs nothing elsewhere, neither time nor memory.

use super::mesh::WorkingMesh;
use super::quadrics::{Quadric, Quadrics};
use crate::number::{GroupShapes, ShapeSet, index_in};
use glam::Vec3;

/// Accumulated quadrics in motion, of the planes of faces and borders.
#[derive(Default)]
pub(crate) struct MovingQuadrics {
    /// For each own group the shapes in which its quadric is another than at rest. Empty without
    /// shapes.
    sets: Vec<ShapeSet>,
    /// The start of each group's quadrics, one for each shape of its set.
    starts: Vec<u32>,
    quadrics: Vec<Quadric>,
    /// A buffer for the quadrics of one group.
    merged: Vec<Quadric>,
}

impl MovingQuadrics {
    /// Empties all lists, which keep their capacity.
    pub(super) fn clear(&mut self) {
        self.sets.clear();
        self.starts.clear();
        self.quadrics.clear();
    }

    /// The quadrics of the next group, which has none yet: zeros in each shape of a set.
    pub(super) fn push(&mut self, set: ShapeSet) -> &mut [Quadric] {
        let start = self.quadrics.len();
        self.sets.push(set);
        self.starts.push(start as u32);
        self.quadrics.resize(start + set.count_ones() as usize, Quadric::default());
        &mut self.quadrics[start..]
    }

    /// Adds the quadrics of a group of another region as those of the next one.
    pub(super) fn push_of(&mut self, other: &Self, group: u32) {
        let Some(&set) = other.sets.get(group as usize) else { return };
        self.push(set).copy_from_slice(other.row(group));
    }

    /// The shapes in which a group's quadric is another than at rest.
    #[inline]
    pub(super) fn set(&self, group: u32) -> ShapeSet {
        self.sets.get(group as usize).copied().unwrap_or(0)
    }

    /// The quadrics of a group, one for each shape of its set.
    fn row(&self, group: u32) -> &[Quadric] {
        let start = self.starts[group as usize] as usize;
        &self.quadrics[start..start + self.set(group).count_ones() as usize]
    }

    /// Returns whether there are none, since the mesh has one shape only.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.sets.is_empty()
    }

    /// The greatest value of a group's quadrics; 0 without any.
    #[inline]
    pub(crate) fn greatest(&self, group: u32, value: impl Fn(&Quadric) -> f64) -> f64 {
        if self.set(group) == 0 {
            return 0.0;
        }
        self.row(group).iter().map(value).fold(0.0, f64::max)
    }

    /// Takes an empty buffer, which [`Self::replace`] takes back.
    pub(super) fn take_buffer(&mut self) -> Vec<Quadric> {
        let mut buffer = std::mem::take(&mut self.merged);
        buffer.clear();
        buffer
    }

    /// Replaces the quadrics of a group by those of another set: in its own room if they fit, in
    /// that of a group that is gone, or in new room.
    pub(super) fn replace(&mut self, group: u32, gone: u32, set: ShapeSet, row: Vec<Quadric>) {
        let has_room = |g: u32| self.set(g).count_ones() >= set.count_ones();
        if !has_room(group) {
            if has_room(gone) {
                self.starts.swap(group as usize, gone as usize);
            } else {
                self.starts[group as usize] = self.quadrics.len() as u32;
                let end = self.quadrics.len() + set.count_ones() as usize;
                self.quadrics.resize(end, Quadric::default());
            }
        }
        self.sets[group as usize] = set;
        let start = self.starts[group as usize] as usize;
        self.quadrics[start..start + row.len()].copy_from_slice(&row);
        self.merged = row;
    }
}

/// What pricing and merging read of a region in motion.
#[derive(Clone, Copy)]
pub(crate) struct InMotion<'a> {
    pub(crate) shapes: &'a GroupShapes,
    pub(crate) mesh: &'a WorkingMesh,
    pub(crate) quadrics: &'a Quadrics,
    pub(crate) moving: &'a MovingQuadrics,
    /// The number of each group in the whole mesh.
    pub(crate) groups: &'a [u32],
}

impl InMotion<'_> {
    /// The position of a group in a shape, in working units.
    #[inline]
    pub(crate) fn position(&self, group: u32, shape: u32) -> Vec3 {
        let moved = self.shapes.position(self.groups[group as usize], shape);
        moved.unwrap_or(self.mesh.group_positions[group as usize].position)
    }

    /// The shapes in which something at a group, or next to it, has moved.
    #[inline]
    pub(crate) fn around(&self, group: u32) -> ShapeSet {
        let moved = |g: u32| self.shapes.moved(self.groups[g as usize]);
        let mut set = self.moving.set(group) | moved(group);
        self.mesh.each_neighbour(group, |g| set |= moved(g));
        set
    }

    /// The accumulated quadric of a group in a shape, of faces and borders.
    #[inline]
    pub(crate) fn quadric(&self, group: u32, shape: u32) -> Quadric {
        let set = self.moving.set(group);
        if set >> shape & 1 != 0 {
            return self.moving.row(group)[index_in(set, shape)];
        }
        let mut quadric = self.quadrics.surface[group as usize];
        if let Some(border) = self.quadrics.border(group) {
            quadric.add(border);
        }
        quadric
    }

    /// The sum of the quadrics of two groups, one of which moves onto the other.
    pub(super) fn merged(&self, from: u32, to: u32, shape: u32) -> Quadric {
        let delta = self.position(to, shape).as_dvec3() - self.position(from, shape).as_dvec3();
        let mut quadric = self.quadric(to, shape);
        quadric.add(&self.quadric(from, shape).transported(delta));
        quadric
    }
}
