//! A tree of boxes over triangles that stay.

use crate::bounds::Bounds;
use crate::triangle::{closest, distance_squared};
use glam::DVec3;
use lodc_mesh::NONE;
use std::ops::Range;

/// No leaf has more triangles than this.
const LEAF: usize = 4;

/// Boxes that the question for a near triangle may open. Surfaces open some dozens; where very many
/// triangles overlap, as at a vertex of thousands, a search that went on would open them all.
const PATIENCE: u32 = 4_000;

/// The nearest point of some triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The triangle that it lies on, by its number when the tree was made.
    pub triangle: u32,
    /// Barycentric coordinates of the point on it.
    pub barycentric: [f64; 3],
    /// The squared distance to it.
    pub squared: f64,
}

/// A box and what is in it.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// A leaf's first slot, or an inner node's second child; the first child is the next node.
    first: u32,
    /// A leaf's triangles; 0 for inner nodes.
    count: u32,
}

/// A search tree over triangles. A triangle may be a segment: two of its corners may be one.
#[derive(Clone, Debug)]
pub struct TriangleTree {
    nodes: Vec<Node>,
    /// The triangle in each slot, and the slot of each triangle.
    order: Vec<u32>,
    slot: Vec<u32>,
    /// The corners of the triangle in each slot.
    corners: Vec<[DVec3; 3]>,
}

impl TriangleTree {
    /// The tree of triangles by their corners, in `O(n log n)`, on all threads.
    #[must_use]
    pub fn new(corners: &[[DVec3; 3]]) -> Self {
        let mut order: Vec<u32> = (0..corners.len() as u32).collect();
        let empty = Node { bounds: Bounds::EMPTY, first: 0, count: 0 };
        let mut nodes = vec![empty; nodes_of(corners.len())];
        build(corners, &mut order, Place { node: 0, slot: 0 }, &mut nodes);
        let mut slot = vec![0; order.len()];
        for (&triangle, at) in order.iter().zip(0..) {
            slot[triangle as usize] = at;
        }
        let corners = order.iter().map(|&t| corners[t as usize]).collect();
        Self { nodes, order, slot, corners }
    }

    /// The tree of segments, each as a triangle whose last two corners are one.
    #[must_use]
    pub fn of_segments(segments: &[[DVec3; 2]]) -> Self {
        Self::new(&segments.iter().map(|&[a, b]| [a, b, b]).collect::<Vec<_>>())
    }

    /// The triangles in an order in which neighbours are near each other.
    #[must_use]
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Returns the nearest point to `p`, of equally near triangles one that the search meets first;
    /// `hint` is a triangle that is probably near, or [`NONE`]. Nothing if there is no triangle.
    #[must_use]
    pub fn nearest(&self, p: DVec3, hint: u32) -> Option<Nearest> {
        let mut best = Nearest { triangle: NONE, barycentric: [0.0; 3], squared: f64::INFINITY };
        let visit = |slot: usize, best: &mut Nearest| {
            let (barycentric, squared) = closest(p, self.corners[slot]);
            if squared < best.squared {
                *best = Nearest { triangle: self.order[slot], barycentric, squared };
            }
        };
        if let Some(&slot) = self.slot.get(hint as usize) {
            visit(slot as usize, &mut best);
        }
        self.search(p, best.squared, u32::MAX, |slots| {
            slots.for_each(|slot| visit(slot, &mut best));
            best.squared
        });
        (best.triangle != NONE).then_some(best)
    }

    /// Returns the squared distance from a point to the nearest triangle; infinite if there is
    /// none.
    #[must_use]
    pub fn distance_squared(&self, p: DVec3) -> f64 {
        let mut best = f64::INFINITY;
        self.search(p, best, u32::MAX, |slots| {
            for corners in &self.corners[slots] {
                best = best.min(distance_squared(p, *corners));
            }
            best
        });
        best
    }

    /// Returns false if no triangle is within a squared distance of a point. Ends at the first that
    /// is, so it is far cheaper than [`Self::distance_squared`] where the answer is true; and true
    /// is also the answer where 4,000 boxes were opened without one.
    #[must_use]
    pub fn may_be_within(&self, p: DVec3, squared: f64) -> bool {
        let mut found = false;
        let beyond = squared.next_up();
        let all = self.search(p, beyond, PATIENCE, |slots| {
            found |= self.corners[slots].iter().any(|t| distance_squared(p, *t) <= squared);
            if found { 0.0 } else { beyond }
        });
        found || !all
    }

    /// Visits the leaves that are nearer to a point than a squared distance, which every visit may
    /// lower, the nearest box first. Returns false if `patience` boxes were opened before the end.
    #[inline]
    fn search(
        &self,
        p: DVec3,
        mut limit: f64,
        patience: u32,
        mut leaf: impl FnMut(Range<usize>) -> f64,
    ) -> bool {
        let mut open = [(0.0, 0u32); 64];
        let mut depth = usize::from(!self.order.is_empty());
        let mut opened = 0;
        while depth > 0 {
            depth -= 1;
            let (squared, at) = open[depth];
            if squared >= limit {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count > 0 {
                let first = node.first as usize;
                limit = leaf(first..first + node.count as usize);
                continue;
            }
            if opened == patience {
                return false;
            }
            opened += 1;
            let mut children = [at + 1, node.first]
                .map(|child| (self.nodes[child as usize].bounds.distance_squared(p), child));
            // The nearer one is opened first, so it is put down last.
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            open[depth..depth + 2].copy_from_slice(&children);
            depth += 2;
        }
        true
    }
}

/// Number of nodes the tree of `n` triangles has: its shape depends on their number alone.
fn nodes_of(n: usize) -> usize {
    /// Those of `n` and of `n + 1` triangles.
    fn pair(n: usize) -> (usize, usize) {
        if n < LEAF {
            return (1, 1);
        }
        let (half, more) = pair(n / 2);
        let of = |a: usize, b: usize, n: usize| if n <= LEAF { 1 } else { 1 + a + b };
        if n.is_multiple_of(2) {
            (of(half, half, n), of(half, more, n + 1))
        } else {
            (of(half, more, n), of(more, more, n + 1))
        }
    }
    pair(n).0
}

/// Place of a subtree: its first node and the slot of its first triangle.
#[derive(Clone, Copy)]
struct Place {
    node: u32,
    slot: u32,
}

/// Triangles from which on both halves of a subtree are built at once.
const PARALLEL: usize = 4096;

/// Builds the subtree of some triangles into `nodes`.
fn build(corners: &[[DVec3; 3]], order: &mut [u32], at: Place, nodes: &mut [Node]) {
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &p in order.iter().flat_map(|&t| &corners[t as usize]) {
        (lo, hi) = (lo.min(p), hi.max(p));
    }
    let (node, nodes) = nodes.split_first_mut().expect("every subtree has a node");
    let bounds = Bounds::around(lo, hi);
    *node = Node { bounds, first: at.slot, count: order.len() as u32 };
    if order.len() <= LEAF {
        return;
    }
    // Halves of equal number: the tree is never deeper than the logarithm, whatever the mesh.
    let extent = hi - lo;
    let axis = (0..3).max_by(|&i, &j| extent[i].total_cmp(&extent[j])).unwrap_or(0);
    let middle = |t: u32| corners[t as usize].iter().map(|c| c[axis]).sum::<f64>();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
    let parallel = order.len() >= PARALLEL;
    let (near, far) = order.split_at_mut(half);
    let (near_nodes, far_nodes) = nodes.split_at_mut(nodes_of(half));
    let first = Place { node: at.node + 1, slot: at.slot };
    let second = Place { node: first.node + near_nodes.len() as u32, slot: at.slot + half as u32 };
    (node.first, node.count) = (second.node, 0);
    let mut near = || build(corners, near, first, near_nodes);
    let mut far = || build(corners, far, second, far_nodes);
    if parallel {
        rayon::join(near, far);
    } else {
        near();
        far();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::SplitMix64;

    #[test]
    fn the_tree_agrees_with_looking_at_every_triangle() {
        let mut random = SplitMix64::new(3);
        let mut point = |s: f64| DVec3::from_array([(); 3].map(|()| f64::from(random.unit()))) * s;
        let mut corners: Vec<[DVec3; 3]> = (0..300)
            .map(|_| {
                let at = point(4.0);
                [at, at + point(1.0), at + point(1.0)]
            })
            .collect();
        // Segments, too.
        corners.iter_mut().step_by(7).for_each(|t| t[2] = t[1]);
        let tree = TriangleTree::new(&corners);
        for i in 0..300 {
            let p = point(6.0);
            let slow = corners.iter().map(|&t| closest(p, t).1).fold(f64::INFINITY, f64::min);
            for hint in [NONE, i] {
                let found = tree.nearest(p, hint).expect("there are triangles");
                assert!((found.squared - slow).abs() <= 1e-12 * (1.0 + slow), "{found:?} {slow}");
            }
            let squared = tree.distance_squared(p);
            assert!((squared - slow).abs() <= 1e-12 * (1.0 + slow), "{squared} {slow}");
            assert!(tree.may_be_within(p, squared));
            assert!(squared == 0.0 || !tree.may_be_within(p, squared * (1.0 - 1e-9)));
        }
        assert!(TriangleTree::new(&[]).nearest(DVec3::ZERO, NONE).is_none());
    }
}
