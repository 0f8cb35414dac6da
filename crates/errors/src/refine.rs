//! Branch and bound over a triangle: how far its farthest point is from a surface (as Guthe,
//! Borodin and Klein 2005 bound the Hausdorff distance).

use crate::work::PATIENCE;
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{Hit, MovingTree, Triangles, centroid, is_within};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Squared distances below this are rounding errors: 2⁻⁴⁴ of the diagonal.
pub(crate) const FLOOR: f64 = 3.0e-27;

/// Relative excess over the bound that is not looked for.
const TOLERANCE: f64 = 1.02;

/// A search for points farther than a bound.
pub(crate) struct Refine<'a, T> {
    pub(crate) triangles: &'a T,
    pub(crate) tree: &'a MovingTree,
    /// The squared bound; rises to what is found.
    pub(crate) bound: f64,
    /// Points that may still be asked.
    pub(crate) left: u32,
    /// Boxes that one search may open.
    pub(crate) patience: u32,
    /// Boxes opened.
    pub(crate) opened: u64,
}

/// A part of a triangle that may have a point beyond the bound.
struct Part {
    corners: [DVec3; 3],
    /// A triangle of the surface near it.
    near: u32,
    /// The distance of its middle, and one that no point of the part exceeds.
    middle: f64,
    most: f64,
    /// Parts are looked at in falling order of this.
    rank: f64,
}

impl Ord for Part {
    fn cmp(&self, other: &Self) -> Ordering {
        self.rank.total_cmp(&other.rank)
    }
}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Eq for Part {}

impl PartialEq for Part {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<'a, T: Triangles> Refine<'a, T> {
    /// A search from a squared bound with a number of points.
    pub(crate) fn new(triangles: &'a T, tree: &'a MovingTree, bound: f64, points: u32) -> Self {
        Self { triangles, tree, bound, left: points, patience: PATIENCE[0], opened: 0 }
    }

    /// Raises the bound to the distance of a triangle's farthest point, up to the tolerance and as
    /// far as the points that may be asked suffice: two thirds of them where a point may be
    /// farthest, the others near the farthest one. `near` is a triangle of the surface near it, or
    /// [`NONE`].
    pub(crate) fn triangle(&mut self, corners: [DVec3; 3], near: u32) {
        let third = self.left / 3;
        let mut is_late = false;
        let mut open = BinaryHeap::new();
        open.extend(self.ask(corners, near));
        while let Some(Part { corners: [a, b, c], near, most, .. }) = open.pop() {
            if most <= self.allowed() {
                continue;
            }
            if self.left == 0 {
                return;
            }
            let edges = [(b - a), (c - b), (a - c)].map(DVec3::length_squared);
            let longest = (0..3).fold(0, |best, i| if edges[i] > edges[best] { i } else { best });
            // Turned so that the longest edge is the first.
            let [a, b, c] = [[a, b, c], [b, c, a], [c, a, b]][longest];
            let half = (a + b) * 0.5;
            for corners in [[a, half, c], [half, b, c]] {
                let part = self.ask(corners, near);
                open.extend(
                    part.map(|p| Part { rank: if is_late { p.middle } else { p.most }, ..p }),
                );
            }
            if !is_late && self.left <= third {
                is_late = true;
                open = open.into_iter().map(|p| Part { rank: p.middle, ..p }).collect();
            }
        }
    }

    /// Asks the middle of a part. Returns the part if one of its points may be beyond the bound.
    fn ask(&mut self, corners: [DVec3; 3], near: u32) -> Option<Part> {
        if near != NONE && self.is_within(corners, near) || self.left == 0 {
            return None;
        }
        self.left -= 1;
        let middle = centroid(corners);
        let radius = corners.map(|c| (c - middle).length_squared());
        let radius = radius[0].max(radius[1]).max(radius[2]).sqrt();
        let enough = (self.allowed() - radius).max(0.0);
        let mut nearest = Hit { squared: f64::INFINITY, triangle: near };
        let opened = self.tree.search(
            self.triangles,
            middle,
            near,
            enough * enough,
            self.patience,
            &mut nearest,
        );
        self.opened += u64::from(opened) + 1;
        // A search that ended early says nothing that has to be heeded.
        if nearest.squared == f64::INFINITY || opened >= self.patience {
            return None;
        }
        self.bound = self.bound.max(nearest.squared);
        let distance = nearest.squared.sqrt();
        let most = distance + radius;
        let done = most <= self.allowed()
            || nearest.triangle != near && self.is_within(corners, nearest.triangle);
        (!done).then_some(Part {
            corners,
            near: nearest.triangle,
            middle: distance,
            most,
            rank: most,
        })
    }

    /// The distance up to which nothing is looked for.
    fn allowed(&self) -> f64 {
        self.bound.max(FLOOR).sqrt() * TOLERANCE
    }

    /// A triangle whose corners are all within a distance of one triangle is within it as a whole:
    /// the distance to a convex set is convex.
    fn is_within(&self, corners: [DVec3; 3], triangle: u32) -> bool {
        let surface = self.triangles.corners(triangle);
        let allowed = self.allowed();
        corners.iter().all(|&c| is_within(c, surface, allowed * allowed))
    }
}
