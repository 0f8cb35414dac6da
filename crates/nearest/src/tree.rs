//! A search tree for the nearest triangle of a fixed set: a binary tree of boxes, split at the
//! median, so that its depth is the logarithm of the number of triangles.

use crate::bounds::Bounds;
use crate::moving::{Hit, Query};
use crate::surface::Surface;
use crate::triangle::{closest, is_within};
use glam::DVec3;
use lodc_mesh::NONE;
use rayon::prelude::*;
use std::ops::Range;

/// No leaf has more triangles than this. Chosen by hand.
const MAX_LEAF_TRIANGLES: usize = 2;

/// Boxes that [`TriangleTree::may_be_within`] may open. Surfaces open some dozens; where very many
/// triangles overlap, as at a vertex of thousands, a search that went on would open them all.
const MAX_BOXES_WITHIN: u32 = 4_000;

/// Boxes that [`TriangleTree::nearest_of`] may open.
const MAX_BOXES_OF: u32 = 1_000;

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
    /// A leaf's first slot, or an inner node.
    index: u32,
    /// A leaf's triangles; 0 for inner nodes.
    count: u32,
}

impl Child {
    /// The slots of a leaf.
    fn slots(self) -> Range<usize> {
        let first = self.index as usize;
        first..first + self.count as usize
    }
}

/// A search tree over triangles. A triangle may be a segment: two of its corners may be the same.
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
    /// Builds the tree of triangles by their corners, in `O(n log n)`, on all threads.
    #[must_use]
    pub fn new(corners: &[[DVec3; 3]]) -> Self {
        let item = |(t, corners): (usize, &[DVec3; 3])| Item::new(t as u32, corners);
        let mut items: Vec<Item> = corners.par_iter().enumerate().map(item).collect();
        let empty = Child { index: 0, count: 0 };
        let node = Node { bounds: [Bounds::EMPTY; 2], child: [empty; 2] };
        let mut nodes = vec![node; inner_nodes(corners.len())];
        let (_, root) = build(&mut items, SubtreeStart { node: 0, slot: 0 }, &mut nodes);
        let order: Vec<u32> = items.iter().map(|item| item.triangle).collect();
        let mut slot = vec![0; order.len()];
        for (&triangle, own_slot) in order.iter().zip(0..) {
            slot[triangle as usize] = own_slot;
        }
        let corners = order.iter().map(|&t| corners[t as usize]).collect();
        Self { root, nodes, order, slot, corners }
    }

    /// Builds the tree of segments, each as a triangle whose last two corners are the same.
    #[must_use]
    pub fn of_segments(segments: &[[DVec3; 2]]) -> Self {
        Self::new(&segments.iter().map(|&[a, b]| [a, b, b]).collect::<Vec<_>>())
    }

    /// Moves the triangles to new corners, in `O(n)`. The tree keeps its shape: the less they
    /// moved, the faster are searches.
    pub fn move_to(&mut self, corners: &[[DVec3; 3]]) {
        for (in_slot, &triangle) in self.corners.iter_mut().zip(&self.order) {
            *in_slot = corners[triangle as usize];
        }
        for node in (0..self.nodes.len()).rev() {
            self.nodes[node].bounds = self.nodes[node].child.map(|child| {
                if child.count == 0 {
                    let [a, b] = &self.nodes[child.index as usize].bounds;
                    return Bounds::union(a, b);
                }
                let boxes = self.corners[child.slots()].iter().map(bounds);
                boxes.fold(Bounds::EMPTY, |a, b| Bounds::union(&a, &b))
            });
        }
    }

    /// The triangles in an order in which neighbours are near each other in space.
    #[must_use]
    pub fn spatial_order(&self) -> &[u32] {
        &self.order
    }

    /// The corners of a triangle, as they are now.
    #[must_use]
    pub fn corners_of(&self, triangle: u32) -> [DVec3; 3] {
        self.corners[self.slot[triangle as usize] as usize]
    }

    /// Returns the nearest point to `p`, of equally near ones the first that the search meets;
    /// `hint` is a triangle that is probably near, or [`NONE`]. `None` if there is no triangle.
    #[must_use]
    pub fn nearest(&self, p: DVec3, hint: u32) -> Option<Nearest> {
        let mut best = Nearest { triangle: NONE, barycentric: [0.0; 3], squared: f64::INFINITY };
        let visit_slot = |slot: usize, best: &mut Nearest| {
            let (barycentric, squared) = closest(p, self.corners[slot]);
            if squared < best.squared {
                *best = Nearest { triangle: self.order[slot], barycentric, squared };
            }
        };
        if let Some(&slot) = self.slot.get(hint as usize) {
            visit_slot(slot as usize, &mut best);
        }
        self.visit_leaves(p, best.squared, &mut { u32::MAX }, |slots| {
            slots.for_each(|slot| visit_slot(slot, &mut best));
            best.squared
        });
        (best.triangle != NONE).then_some(best)
    }

    /// Returns the nearest point to `p` of the triangles that count, if its squared distance is at
    /// most `squared`; of equally near ones the first that the search meets. The search ends after
    /// 1,000 boxes, where very many triangles are about as near, with the nearest so far.
    #[must_use]
    pub fn nearest_of(
        &self,
        p: DVec3,
        squared: f64,
        counts: impl Fn(u32) -> bool,
    ) -> Option<Nearest> {
        let mut best =
            Nearest { triangle: NONE, barycentric: [0.0; 3], squared: squared.next_up() };
        self.visit_leaves(p, best.squared, &mut { MAX_BOXES_OF }, |slots| {
            for slot in slots.filter(|&slot| counts(self.order[slot])) {
                let (barycentric, squared) = closest(p, self.corners[slot]);
                if squared < best.squared {
                    best = Nearest { triangle: self.order[slot], barycentric, squared };
                }
            }
            best.squared
        });
        (best.triangle != NONE).then_some(best)
    }

    /// Returns the squared distance from a point to the nearest triangle; infinite if there is
    /// none.
    #[must_use]
    pub fn distance_squared(&self, p: DVec3) -> f64 {
        self.nearest_triangle(p, NONE).squared
    }

    /// Returns the nearest triangle to a point, and [`Self::distance_squared`], the same to the
    /// bit; `hint` as for [`Self::nearest`]. [`Hit::NONE`] if there is no triangle.
    #[must_use]
    pub fn nearest_triangle(&self, point: DVec3, hint: u32) -> Hit {
        self.near(Query { point, hint, enough: 0.0, max_boxes: u32::MAX }).0
    }

    /// Returns whether a triangle is within a squared distance of a point: false is certain, true
    /// is also the answer where 4,000 boxes were opened without one. Ends at the first that is
    /// found, so it is far cheaper than [`Self::distance_squared`] where there is one. `hint` is a
    /// triangle that is probably near, or [`NONE`], and becomes the one that was found.
    #[must_use]
    pub fn may_be_within(&self, p: DVec3, squared: f64, hint: &mut u32) -> bool {
        let is_within = |slot: usize| is_within(p, self.corners[slot], squared);
        if self.slot.get(*hint as usize).is_some_and(|&slot| is_within(slot as usize)) {
            return true;
        }
        let mut found = None;
        let limit = squared.next_up();
        let is_complete = self.visit_leaves(p, limit, &mut { MAX_BOXES_WITHIN }, |mut slots| {
            found = slots.find(|&slot| is_within(slot));
            if found.is_some() { 0.0 } else { limit }
        });
        *hint = found.map_or(*hint, |slot| self.order[slot]);
        found.is_some() || !is_complete
    }

    /// Visits the leaves whose squared distance to a point is below `limit`, of two boxes the
    /// nearer first. `visit` gets the slots of a leaf and returns the limit from then on. Returns
    /// false if `boxes_left` boxes were opened before the end; it counts down.
    #[inline]
    fn visit_leaves(
        &self,
        p: DVec3,
        mut limit: f64,
        boxes_left: &mut u32,
        mut visit: impl FnMut(Range<usize>) -> f64,
    ) -> bool {
        if self.order.is_empty() {
            return true;
        }
        // On each level of the tree at most one box waits; 2³² triangles are halved 32 times.
        let mut stack = [(0.0, self.root); 32];
        let (mut depth, mut child) = (0, self.root);
        loop {
            if child.count == 0 {
                if *boxes_left == 0 {
                    return false;
                }
                *boxes_left -= 1;
                let node = &self.nodes[child.index as usize];
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
                    child = nearer.1;
                    continue;
                }
            } else {
                limit = visit(child.slots());
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
            child = stack[depth].1;
        }
    }
}

impl Surface for TriangleTree {
    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.corners_of(triangle)
    }

    fn near(&self, Query { point, hint, enough, max_boxes }: Query) -> (Hit, u32) {
        let mut best = Hit::NONE;
        if let Some(&slot) = self.slot.get(hint as usize) {
            best.replace_if_nearer(point, self.corners[slot as usize], hint);
        }
        let mut boxes_left = max_boxes;
        if best.squared > enough {
            self.visit_leaves(point, best.squared, &mut boxes_left, |slots| {
                for slot in slots {
                    best.replace_if_nearer(point, self.corners[slot], self.order[slot]);
                }
                if best.squared > enough { best.squared } else { 0.0 }
            });
        }
        (best, max_boxes - boxes_left)
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
    /// Those of `n` and of `n + 1` triangles: the halves of both have `n / 2` or one more.
    fn pair(n: usize) -> (usize, usize) {
        if n < MAX_LEAF_TRIANGLES {
            return (0, 0);
        }
        let (half, half_and_one) = pair(n / 2);
        let with_root = |low: usize, high: usize, n: usize| {
            if n <= MAX_LEAF_TRIANGLES { 0 } else { 1 + low + high }
        };
        if n.is_multiple_of(2) {
            (with_root(half, half, n), with_root(half, half_and_one, n + 1))
        } else {
            (with_root(half, half_and_one, n), with_root(half_and_one, half_and_one, n + 1))
        }
    }
    pair(n).0
}

/// Where a subtree starts: its first node and the slot of its first triangle.
#[derive(Clone, Copy)]
struct SubtreeStart {
    node: u32,
    slot: u32,
}

/// Triangles of a subtree from which on its halves are built in parallel. Chosen by hand: in
/// smaller ones starting a task takes as long.
const MIN_PARALLEL: usize = 4096;

/// Builds the subtree of some triangles into `nodes`, which has room for exactly that, and puts the
/// triangles into the order of slots. Returns its box and what is in it.
fn build(items: &mut [Item], start: SubtreeStart, nodes: &mut [Node]) -> (Bounds, Child) {
    let all = items.iter().fold(Bounds::EMPTY, |all, item| Bounds::union(&all, &item.bounds));
    if items.len() <= MAX_LEAF_TRIANGLES {
        return (all, Child { index: start.slot, count: items.len() as u32 });
    }
    let (node, nodes) = nodes.split_first_mut().expect("every subtree has a node");
    // Halves of equal number: whatever the mesh, the depth is logarithmic.
    let axis = all.longest_axis();
    let half = items.len() / 2;
    items.select_nth_unstable_by(half, |a, b| {
        let [x, y] = [a, b].map(|item| item.bounds.middle(axis));
        x.total_cmp(&y).then(a.triangle.cmp(&b.triangle))
    });
    let in_parallel = items.len() >= MIN_PARALLEL;
    let (low_items, high_items) = items.split_at_mut(half);
    let (low_nodes, high_nodes) = nodes.split_at_mut(inner_nodes(half));
    let low_start = SubtreeStart { node: start.node + 1, slot: start.slot };
    let high_start = SubtreeStart {
        node: low_start.node + low_nodes.len() as u32,
        slot: start.slot + half as u32,
    };
    let mut low = || build(low_items, low_start, low_nodes);
    let mut high = || build(high_items, high_start, high_nodes);
    let (low, high) = if in_parallel { rayon::join(low, high) } else { (low(), high()) };
    *node = Node { bounds: [low.0, high.0], child: [low.1, high.1] };
    (all, Child { index: start.node, count: 0 })
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
                let a = point(4.0);
                [a, a + point(1.0), a + point(1.0)]
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
        tree.move_to(&corners);
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
            let hit = tree.nearest_triangle(p, i);
            assert_eq!(hit.squared, squared);
            assert_eq!(hit.squared, distance_squared(p, corners[hit.triangle as usize]));
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
