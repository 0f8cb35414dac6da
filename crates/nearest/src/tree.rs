//! A search tree for the nearest triangle of a fixed set: a binary tree of boxes, split at the
//! median, so that its depth is the logarithm of the number of triangles.

use crate::bounds::Bounds;
use crate::moving::Hit;
use crate::surface::Surface;
use crate::triangle::{closest, is_within};
use glam::DVec3;
use lodc_mesh::NONE;
use rayon::prelude::*;
use std::ops::Range;

/// No leaf has more triangles than this.
const LEAF: usize = 2;

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

/// An inner node: the boxes of its two children and what is in them.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: [Bounds; 2],
    child: [Child; 2],
}

/// Content of a box.
#[derive(Clone, Copy, Debug)]
struct Child {
    /// A leaf's first slot, or a node.
    at: u32,
    /// A leaf's triangles; 0 for nodes.
    count: u32,
}

impl Child {
    fn slots(self) -> Range<usize> {
        let first = self.at as usize;
        first..first + self.count as usize
    }
}

/// A search tree over triangles. A triangle may be a segment: two of its corners may be one.
#[derive(Clone, Debug)]
pub struct TriangleTree {
    root: Child,
    /// Children come after their parent.
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
        let item = |(t, corners): (usize, &[DVec3; 3])| Item::new(t as u32, corners);
        let mut items: Vec<Item> = corners.par_iter().enumerate().map(item).collect();
        let empty = Child { at: 0, count: 0 };
        let node = Node { bounds: [Bounds::EMPTY; 2], child: [empty; 2] };
        let mut nodes = vec![node; inner_nodes(corners.len())];
        let (_, root) = build(&mut items, Subtree { node: 0, slot: 0 }, &mut nodes);
        let order: Vec<u32> = items.iter().map(|item| item.triangle).collect();
        let mut slot = vec![0; order.len()];
        for (&triangle, at) in order.iter().zip(0..) {
            slot[triangle as usize] = at;
        }
        let corners = order.iter().map(|&t| corners[t as usize]).collect();
        Self { root, nodes, order, slot, corners }
    }

    /// The tree of segments, each as a triangle whose last two corners are one.
    #[must_use]
    pub fn of_segments(segments: &[[DVec3; 2]]) -> Self {
        Self::new(&segments.iter().map(|&[a, b]| [a, b, b]).collect::<Vec<_>>())
    }

    /// Takes the triangles at new corners, in `O(n)`. The less they moved, the faster is the tree.
    pub fn follow(&mut self, corners: &[[DVec3; 3]]) {
        for (own, &triangle) in self.corners.iter_mut().zip(&self.order) {
            *own = corners[triangle as usize];
        }
        for at in (0..self.nodes.len()).rev() {
            self.nodes[at].bounds = self.nodes[at].child.map(|child| {
                if child.count == 0 {
                    let [a, b] = &self.nodes[child.at as usize].bounds;
                    return Bounds::union(a, b);
                }
                let boxes = self.corners[child.slots()].iter().map(bounds);
                boxes.fold(Bounds::EMPTY, |a, b| Bounds::union(&a, &b))
            });
        }
    }

    /// The triangles in an order in which neighbours are near each other.
    #[must_use]
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The corners of a triangle, as they are now.
    #[must_use]
    pub fn corners_of(&self, triangle: u32) -> [DVec3; 3] {
        self.corners[self.slot[triangle as usize] as usize]
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
        self.search(p, best.squared, &mut { u32::MAX }, |slots| {
            slots.for_each(|slot| visit(slot, &mut best));
            best.squared
        });
        (best.triangle != NONE).then_some(best)
    }

    /// Returns the squared distance from a point to the nearest triangle; infinite if there is
    /// none.
    #[must_use]
    pub fn distance_squared(&self, p: DVec3) -> f64 {
        self.distance_from(p, NONE).0
    }

    /// Returns [`Self::distance_squared`], the same to the bit, and the triangle, with a hint as
    /// for [`Self::nearest`].
    #[must_use]
    pub fn distance_from(&self, p: DVec3, hint: u32) -> (f64, u32) {
        let nearest = self.near(p, hint, 0.0, u32::MAX).0;
        (nearest.squared, nearest.triangle)
    }

    /// Returns false if no triangle is within a squared distance of a point. Ends at the first that
    /// is, so it is far cheaper than [`Self::distance_squared`] where the answer is true; and true
    /// is also the answer where 4,000 boxes were opened without one. `hint` is a triangle that is
    /// probably near, or [`NONE`], and becomes the one that was found.
    #[must_use]
    pub fn may_be_within(&self, p: DVec3, squared: f64, hint: &mut u32) -> bool {
        let is_within = |slot: usize| is_within(p, self.corners[slot], squared);
        if self.slot.get(*hint as usize).is_some_and(|&slot| is_within(slot as usize)) {
            return true;
        }
        let mut found = None;
        let beyond = squared.next_up();
        let all = self.search(p, beyond, &mut { PATIENCE }, |mut slots| {
            found = slots.find(|&slot| is_within(slot));
            if found.is_some() { 0.0 } else { beyond }
        });
        *hint = found.map_or(*hint, |slot| self.order[slot]);
        found.is_some() || !all
    }

    /// Visits the leaves that are nearer to a point than a squared distance, which every visit may
    /// lower, the nearest box first. Returns false if `patience` boxes were opened before the end;
    /// those that were opened are taken from it.
    #[inline]
    fn search(
        &self,
        p: DVec3,
        mut limit: f64,
        patience: &mut u32,
        mut leaf: impl FnMut(Range<usize>) -> f64,
    ) -> bool {
        if self.order.is_empty() {
            return true;
        }
        // One entry for each level that was passed: halves of 2^32 triangles.
        let mut stack = [(0.0, self.root); 32];
        let (mut depth, mut at) = (0, self.root);
        loop {
            if at.count == 0 {
                if *patience == 0 {
                    return false;
                }
                *patience -= 1;
                let node = &self.nodes[at.at as usize];
                let (a, b) =
                    (node.bounds[0].distance_squared(p), node.bounds[1].distance_squared(p));
                let [first, second] = node.child;
                let (nearer, farther) =
                    if a < b { ((a, first), (b, second)) } else { ((b, second), (a, first)) };
                if farther.0 < limit {
                    stack[depth] = farther;
                    depth += 1;
                }
                if nearer.0 < limit {
                    at = nearer.1;
                    continue;
                }
            } else {
                limit = leaf(at.slots());
            }
            loop {
                if depth == 0 {
                    return true;
                }
                depth -= 1;
                if stack[depth].0 < limit {
                    break;
                }
            }
            at = stack[depth].1;
        }
    }
}

impl Surface for TriangleTree {
    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.corners_of(triangle)
    }

    fn near(&self, p: DVec3, hint: u32, enough: f64, patience: u32) -> (Hit, u32) {
        let mut best = Hit::NOTHING;
        if let Some(&slot) = self.slot.get(hint as usize) {
            best.look(p, self.corners[slot as usize], hint);
        }
        let mut boxes_left = patience;
        if best.squared > enough {
            self.search(p, best.squared, &mut boxes_left, |slots| {
                for slot in slots {
                    best.look(p, self.corners[slot], self.order[slot]);
                }
                if best.squared > enough { best.squared } else { 0.0 }
            });
        }
        (best, patience - boxes_left)
    }
}

/// The box of a triangle.
fn bounds([a, b, c]: &[DVec3; 3]) -> Bounds {
    Bounds::around(a.min(*b).min(*c), a.max(*b).max(*c))
}

/// A triangle while the tree is built.
#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    triangle: u32,
}

impl Item {
    fn new(triangle: u32, corners: &[DVec3; 3]) -> Self {
        Self { bounds: bounds(corners), triangle }
    }
}

/// Number of inner nodes of the tree of `n` triangles: its shape depends on their number alone.
fn inner_nodes(n: usize) -> usize {
    /// Those of `n` and of `n + 1` triangles.
    fn pair(n: usize) -> (usize, usize) {
        if n < LEAF {
            return (0, 0);
        }
        let (half, more) = pair(n / 2);
        let of = |a: usize, b: usize, n: usize| if n <= LEAF { 0 } else { 1 + a + b };
        if n.is_multiple_of(2) {
            (of(half, half, n), of(half, more, n + 1))
        } else {
            (of(half, more, n), of(more, more, n + 1))
        }
    }
    pair(n).0
}

/// A subtree: its first node and the slot of its first triangle.
#[derive(Clone, Copy)]
struct Subtree {
    node: u32,
    slot: u32,
}

/// Triangles from which on both halves of a subtree are built at once.
const PARALLEL: usize = 4096;

/// Builds the subtree of some triangles into `nodes`.
fn build(items: &mut [Item], at: Subtree, nodes: &mut [Node]) -> (Bounds, Child) {
    let all = items.iter().fold(Bounds::EMPTY, |all, item| Bounds::union(&all, &item.bounds));
    if items.len() <= LEAF {
        return (all, Child { at: at.slot, count: items.len() as u32 });
    }
    let (node, nodes) = nodes.split_first_mut().expect("every subtree has a node");
    // Halves of equal number: the tree is never deeper than the logarithm, whatever the mesh.
    let axis = all.longest_axis();
    let half = items.len() / 2;
    items.select_nth_unstable_by(half, |a, b| {
        let [x, y] = [a, b].map(|item| item.bounds.middle(axis));
        x.total_cmp(&y).then(a.triangle.cmp(&b.triangle))
    });
    let parallel = items.len() >= PARALLEL;
    let (low, high) = items.split_at_mut(half);
    let (near_nodes, far_nodes) = nodes.split_at_mut(inner_nodes(half));
    let first = Subtree { node: at.node + 1, slot: at.slot };
    let second =
        Subtree { node: first.node + near_nodes.len() as u32, slot: at.slot + half as u32 };
    let mut low = || build(low, first, near_nodes);
    let mut high = || build(high, second, far_nodes);
    let (low, high) = if parallel { rayon::join(low, high) } else { (low(), high()) };
    *node = Node { bounds: [low.0, high.0], child: [low.1, high.1] };
    (all, Child { at: at.node, count: 0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangle::distance_squared;
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
        let mut tree = TriangleTree::new(&corners);
        assert_agrees(&tree, &corners, &mut point);
        // Moved, some far.
        for corner in corners.iter_mut().flatten() {
            *corner = *corner * 1.5 + point(0.5);
        }
        tree.follow(&corners);
        assert_agrees(&tree, &corners, &mut point);
        assert!(TriangleTree::new(&[]).nearest(DVec3::ZERO, NONE).is_none());
    }

    fn assert_agrees(
        tree: &TriangleTree,
        corners: &[[DVec3; 3]],
        point: &mut impl FnMut(f64) -> DVec3,
    ) {
        for i in 0..300 {
            let p = point(6.0);
            let slow = corners.iter().map(|&t| closest(p, t).1).fold(f64::INFINITY, f64::min);
            for hint in [NONE, i] {
                let found = tree.nearest(p, hint).expect("there are triangles");
                assert!((found.squared - slow).abs() <= 1e-12 * (1.0 + slow), "{found:?} {slow}");
            }
            let squared = tree.distance_squared(p);
            let (same, triangle) = tree.distance_from(p, i);
            assert_eq!(same, squared);
            assert_eq!(same, distance_squared(p, corners[triangle as usize]));
            assert!((squared - slow).abs() <= 1e-12 * (1.0 + slow), "{squared} {slow}");
            for mut hint in [NONE, i] {
                assert!(tree.may_be_within(p, squared, &mut hint));
                assert_eq!(distance_squared(p, corners[hint as usize]), squared);
                let less = squared * (1.0 - 1e-9);
                assert!(squared == 0.0 || !tree.may_be_within(p, less, &mut hint));
            }
        }
    }
}
