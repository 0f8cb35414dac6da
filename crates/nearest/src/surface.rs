//! Surfaces that can be searched for a triangle near a point.

use crate::moving::{Hit, MovingTree, Query, Triangles};
use glam::DVec3;

/// Triangles with a tree over them.
pub trait Surface {
    /// Returns the corners of a triangle.
    fn corners(&self, triangle: u32) -> [DVec3; 3];

    /// Returns a triangle near a point, and how many boxes were opened. If these are as many as
    /// `query.max_boxes`, the search was cut short, and a nearer triangle may have been missed.
    fn near(&self, query: Query) -> (Hit, u32);
}

/// Triangles that move, with their tree, as a [`Surface`].
#[derive(Clone, Copy, Debug)]
pub struct MovingSurface<'a, T> {
    /// The triangles.
    pub triangles: &'a T,
    /// Their tree.
    pub tree: &'a MovingTree,
}

impl<T: Triangles> Surface for MovingSurface<'_, T> {
    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles.corners(triangle)
    }

    #[inline]
    fn near(&self, query: Query) -> (Hit, u32) {
        let mut nearest = Hit::NONE;
        let opened_boxes = self.tree.search(self.triangles, query, &mut nearest);
        (nearest, opened_boxes)
    }
}
