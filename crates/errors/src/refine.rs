//! Branch and bound over a triangle: how far its farthest point is from a surface (as Guthe,
//! Borodin and Klein 2005 bound the Hausdorff distance).

use crate::tree::{Nearest, Tree, Triangles};
use crate::triangle::{centroid, distance_squared};
use glam::DVec3;

/// Squared distances below this are rounding errors: 2⁻⁴⁴ of the diagonal.
pub(crate) const FLOOR: f64 = 3.0e-27;

/// Relative excess over the bound that is not looked for, squared.
const TOLERANCE: f64 = 1.03 * 1.03;

/// A search for points farther than a bound.
pub(crate) struct Refine<'a, T> {
    pub(crate) triangles: &'a T,
    pub(crate) tree: &'a Tree,
    /// The squared bound; rises to what is found.
    pub(crate) bound: f64,
    /// Most halvings of a triangle.
    pub(crate) depth: u32,
    /// Points that may still be asked.
    pub(crate) left: u32,
    /// Boxes that one search may open.
    pub(crate) patience: u32,
    /// Boxes opened.
    pub(crate) opened: u64,
}

impl<T: Triangles> Refine<'_, T> {
    /// Raises the bound to the distance of a triangle's farthest point, up to the tolerance.
    /// `near` is a triangle of the surface near it, or [`lodc_mesh::NONE`].
    pub(crate) fn triangle(&mut self, corners: [DVec3; 3], near: u32) {
        self.part(corners, near, 0);
    }

    fn part(&mut self, corners: [DVec3; 3], near: u32, depth: u32) {
        if near != lodc_mesh::NONE && self.is_within(corners, near) {
            return;
        }
        if self.left == 0 {
            return;
        }
        self.left -= 1;
        let middle = centroid(corners);
        let mut nearest = Nearest { squared: f64::INFINITY, triangle: near };
        let opened =
            self.tree.search(self.triangles, middle, near, 0.0, self.patience, &mut nearest);
        self.opened += u64::from(opened) + 1;
        if nearest.squared == f64::INFINITY {
            return;
        }
        self.bound = self.bound.max(nearest.squared);
        let [a, b, c] = corners;
        let radius = [(a - middle), (b - middle), (c - middle)].map(DVec3::length_squared);
        let radius = radius[0].max(radius[1]).max(radius[2]).sqrt();
        let most = nearest.squared.sqrt() + radius;
        if most * most <= self.allowed()
            || nearest.triangle != near && self.is_within(corners, nearest.triangle)
            || depth == self.depth
        {
            return;
        }
        let [a, b, c] = corners;
        let edges = [(b - a).length_squared(), (c - b).length_squared(), (a - c).length_squared()];
        let longest = (0..3).fold(0, |best, i| if edges[i] > edges[best] { i } else { best });
        // Turned so that the longest edge is the first.
        let [a, b, c] = [[a, b, c], [b, c, a], [c, a, b]][longest];
        let half = (a + b) * 0.5;
        self.part([a, half, c], nearest.triangle, depth + 1);
        self.part([half, b, c], nearest.triangle, depth + 1);
    }

    fn allowed(&self) -> f64 {
        (self.bound * TOLERANCE).max(FLOOR)
    }

    /// A triangle whose corners are all within a distance of one triangle is within it as a whole:
    /// the distance to a convex set is convex.
    fn is_within(&self, corners: [DVec3; 3], triangle: u32) -> bool {
        let surface = self.triangles.corners(triangle);
        let allowed = self.allowed();
        corners.iter().all(|&c| distance_squared(c, surface) <= allowed)
    }
}
