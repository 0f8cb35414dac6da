//! The trait of surfaces that can be asked which triangle is near a point, and triangles that move
//! as one.

use crate::moving::{Hit, MovingTree, Triangles};
use glam::DVec3;

/// Triangles with a tree over them.
pub trait Surface {
    /// Returns the corners of a triangle.
    fn corners(&self, triangle: u32) -> [DVec3; 3];

    /// Returns the nearest triangle to a point, or the first within the squared distance `enough`,
    /// and how many boxes were opened. As many as `patience`: the search was cut short, and a
    /// nearer triangle may have been missed. `hint` is a triangle that is probably near, or
    /// [`lodc_mesh::NONE`].
    fn near(&self, p: DVec3, hint: u32, enough: f64, patience: u32) -> (Hit, u32);
}

/// Triangles that move, with their tree.
#[derive(Clone, Copy, Debug)]
pub struct Moving<'a, T> {
    /// The triangles.
    pub triangles: &'a T,
    /// Their tree.
    pub tree: &'a MovingTree,
}

impl<T: Triangles> Surface for Moving<'_, T> {
    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles.corners(triangle)
    }

    #[inline]
    fn near(&self, p: DVec3, hint: u32, enough: f64, patience: u32) -> (Hit, u32) {
        let mut nearest = Hit::NOTHING;
        let opened = self.tree.search(self.triangles, p, hint, enough, patience, &mut nearest);
        (nearest, opened)
    }
}
