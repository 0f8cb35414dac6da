//! A search tree for the nearest triangle of a mesh under simplification, whose triangles move and
//! disappear. Boxes grow when a triangle moves and are closed when their triangles are gone.

use crate::bounds::Bounds;
use crate::capsule::Capsule;
use crate::sah::{self, Child, MAX_STACK, Node, WIDTH};
use crate::triangle;
use glam::DVec3;
use lodc_mesh::NONE;

/// A set of triangles as a tree sees it.
pub trait Triangles {
    /// Returns the corners of a triangle.
    fn corners(&self, triangle: u32) -> [DVec3; 3];
    /// Returns whether a triangle is still there.
    fn is_live(&self, triangle: u32) -> bool;
}

/// A search for a triangle near a point.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// The point.
    pub point: DVec3,
    /// A triangle that is probably near, or [`NONE`].
    pub hint: u32,
    /// The search ends at the first triangle within this squared distance; with 0, at the nearest.
    pub enough: f64,
    /// The search ends when it has opened this many boxes.
    pub max_boxes: u32,
}

/// The nearest triangle found so far.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// The squared distance to it; infinite before there is one.
    pub squared: f64,
    /// The triangle; [`NONE`] before there is one.
    pub triangle: u32,
}

impl Hit {
    /// Before there is one.
    pub const NONE: Self = Self { squared: f64::INFINITY, triangle: NONE };

    /// Replaces it by a triangle, given with its corners, if that is nearer to a point.
    #[inline]
    pub fn replace_if_nearer(&mut self, p: DVec3, corners: [DVec3; 3], triangle: u32) {
        if triangle::may_be_within(p, corners, self.squared) {
            let squared = triangle::distance_squared(p, corners);
            if squared < self.squared {
                *self = Self { squared, triangle };
            }
        }
    }
}

/// A tree over triangles that move and die. Boxes only grow, until all of their triangles have
/// died; dead ones are passed over.
#[derive(Clone, Debug)]
pub struct MovingTree {
    /// The root is the first; none without triangles.
    nodes: Vec<Node>,
    /// The triangle in each slot of a leaf. Large ones are in several leaves.
    slots: Vec<u32>,
    /// Capsules of nodes whose boxes are far larger than what is in them.
    capsules: Vec<[Capsule; WIDTH]>,
    /// The box of the first leaf of each triangle ([`WIDTH`] × node + index), which grows with it;
    /// [`NONE`] if the tree does not hold it. Empty for triangles that stay.
    box_of: Vec<u32>,
    /// Half the area of all boxes: what searches cost, by the heuristic. When the tree was built,
    /// and now.
    built_area: f64,
    area: f64,
}

impl MovingTree {
    /// Builds a tree of the triangles 0 to `count` (exclusive), which stay as they are. `corners`
    /// returns the positions of a triangle's corners.
    #[must_use]
    pub fn of_all(count: u32, corners: impl Fn(u32) -> [[f32; 3]; 3]) -> Self {
        Self::of_some(0..count, corners)
    }

    /// Builds a tree of some triangles, which stay as they are.
    #[must_use]
    pub fn of_some(
        triangles: impl Iterator<Item = u32>,
        corners: impl Fn(u32) -> [[f32; 3]; 3],
    ) -> Self {
        let sah::Tree { nodes, slots, capsules } = sah::build(triangles, corners);
        Self { nodes, slots, capsules, box_of: vec![], built_area: 0.0, area: 0.0 }
    }

    /// Builds the tree of some triangles, which may move, out of `all_count`.
    #[must_use]
    pub fn of(
        triangles: impl Iterator<Item = u32>,
        all_count: usize,
        corners: impl Fn(u32) -> [[f32; 3]; 3],
    ) -> Self {
        Self::of_some(triangles, corners).for_moving(all_count)
    }

    /// Returns the tree after triangles have moved or gone, in linear time, with the same shape:
    /// searches in it take longer than in one that is built anew, the longer the more has changed.
    /// `corners` returns where a triangle is now, whether it has moved; `None` if it is gone.
    #[must_use]
    pub fn refitted(&self, corners: impl Fn(u32) -> Option<([[f32; 3]; 3], bool)>) -> Self {
        let mut tree = Self { box_of: vec![], ..self.clone() };
        // Children come after their parents.
        for i in (0..tree.nodes.len()).rev() {
            for k in 0..WIDTH {
                let child = tree.nodes[i].child[k];
                let mut bounds = Bounds::EMPTY;
                match child.as_node() {
                    Some(index) => {
                        let node = &tree.nodes[index];
                        bounds =
                            (0..WIDTH).fold(bounds, |all, k| Bounds::union(&all, &node.bounds(k)));
                    }
                    None => {
                        // A box may be of parts of large triangles: it stays if none has moved.
                        let before = tree.nodes[i].bounds(k);
                        for &t in &tree.slots[child.slots()] {
                            match corners(t) {
                                Some((corners, true)) => {
                                    corners.into_iter().for_each(|p| _ = bounds.include(p));
                                }
                                Some((_, false)) => bounds = Bounds::union(&bounds, &before),
                                None => {}
                            }
                        }
                    }
                }
                tree.nodes[i].set_bounds(k, &bounds);
            }
        }
        if !tree.capsules.is_empty() {
            tree.refit_capsules(corners);
        }
        tree
    }

    fn refit_capsules(&mut self, corners: impl Fn(u32) -> Option<([[f32; 3]; 3], bool)>) {
        for i in 0..self.nodes.len() {
            for k in 0..WIDTH {
                let child = self.nodes[i].child[k];
                if child.as_node().is_some() {
                    continue;
                }
                for &t in &self.slots[child.slots()] {
                    let Some((corners, true)) = corners(t) else { continue };
                    let mut parent = (WIDTH * i + k) as u32;
                    while parent != NONE {
                        let node = &self.nodes[parent as usize / WIDTH];
                        if let Some(capsules) = self.capsules.get_mut(node.capsules as usize) {
                            capsules[parent as usize % WIDTH].include(&corners);
                        }
                        parent = node.parent;
                    }
                }
            }
        }
    }

    /// Prepares a tree for triangles that move, out of `all_count`.
    #[must_use]
    pub fn for_moving(mut self, all_count: usize) -> Self {
        self.box_of = vec![NONE; all_count];
        let mut area = 0.0;
        for (node, index) in self.nodes.iter().zip(0..) {
            for k in 0..WIDTH {
                area += f64::from(node.bounds(k).half_area());
                if node.child[k].as_node().is_none() {
                    for &triangle in &self.slots[node.child[k].slots()] {
                        let leaf = &mut self.box_of[triangle as usize];
                        *leaf = (*leaf).min((WIDTH * index + k) as u32);
                    }
                }
            }
        }
        (self.built_area, self.area) = (area, area);
        self
    }

    /// Returns how many times as much searches cost as when the tree was built, by the areas of
    /// boxes, which have grown since.
    #[must_use]
    pub fn growth(&self) -> f64 {
        if self.built_area > 0.0 { self.area / self.built_area } else { 1.0 }
    }

    /// Returns a word of a triangle's box, to load its cache line early.
    #[inline]
    pub fn touch(&self, triangle: u32) -> u32 {
        let leaf = self.box_of.get(triangle as usize).copied().unwrap_or(NONE);
        let node = self.nodes.get(leaf as usize / WIDTH);
        node.map_or(0, |node| node.low[0][0].to_bits() ^ node.high[2][3].to_bits())
    }

    /// Grows the boxes around a triangle to take in its new corners.
    pub fn grow(&mut self, triangle: u32, corners: &[[f32; 3]; 3]) {
        let mut leaf = self.box_of[triangle as usize];
        while leaf != NONE {
            let (node, k) = (&mut self.nodes[leaf as usize / WIDTH], leaf as usize % WIDTH);
            let mut bounds = node.bounds(k);
            let before = bounds.half_area();
            // All corners have to be tried.
            let has_grown = corners.iter().fold(false, |grown, &p| bounds.include(p) | grown);
            // Capsules of parents may be too small even where a box is not.
            if let Some(capsules) = self.capsules.get_mut(node.capsules as usize) {
                capsules[k].include(corners);
            } else if !has_grown && self.capsules.is_empty() {
                return;
            }
            self.area += f64::from(bounds.half_area() - before);
            node.set_bounds(k, &bounds);
            leaf = node.parent;
        }
    }

    /// Empties the boxes that hold no live triangle any more, after `triangle` has died.
    pub fn remove(&mut self, triangle: u32, is_live: impl Fn(u32) -> bool) {
        let mut leaf = self.box_of[triangle as usize];
        if leaf == NONE {
            return;
        }
        let child = self.nodes[leaf as usize / WIDTH].child[leaf as usize % WIDTH];
        if self.slots[child.slots()].iter().any(|&t| is_live(t)) {
            return;
        }
        while leaf != NONE {
            let (node, k) = (&mut self.nodes[leaf as usize / WIDTH], leaf as usize % WIDTH);
            self.area -= f64::from(node.bounds(k).half_area());
            node.set_bounds(k, &Bounds::EMPTY);
            if (0..WIDTH).any(|k| !node.bounds(k).is_empty()) {
                return;
            }
            leaf = node.parent;
        }
    }

    /// Looks for a triangle nearer than `nearest`. Returns how many boxes it has opened.
    pub fn search(&self, triangles: &impl Triangles, query: Query, nearest: &mut Hit) -> u32 {
        let Query { point, hint, enough, max_boxes } = query;
        if hint != NONE && hint != nearest.triangle && triangles.is_live(hint) {
            nearest.replace_if_nearer(point, triangles.corners(hint), hint);
        }
        if self.nodes.is_empty() || nearest.squared <= enough {
            return 0;
        }
        let point_f32 = PointF32::new(point);
        // Squared distances of boxes, below what they are, and what they hold, the nearest last.
        let mut stack = [(0.0f32, Child::NOTHING); MAX_STACK];
        let mut depth = 0;
        let mut node = &self.nodes[0];
        let mut opened_boxes = 0;
        loop {
            opened_boxes += 1;
            let mut distances = point_f32.distances_squared(node);
            if let Some(capsules) = self.capsules.get(node.capsules as usize) {
                for (distance, capsule) in distances.iter_mut().zip(capsules) {
                    if f64::from(*distance) < nearest.squared {
                        *distance = distance.max(capsule.distance_squared(point) as f32);
                    }
                }
            }
            let first = depth;
            for (k, &distance) in distances.iter().enumerate() {
                if f64::from(distance) < nearest.squared {
                    // Inserted so that the nearest is the last.
                    let mut i = depth;
                    while i > first && stack[i - 1].0 < distance {
                        stack[i] = stack[i - 1];
                        i -= 1;
                    }
                    stack[i] = (distance, node.child[k]);
                    depth += 1;
                }
            }
            loop {
                if depth == 0 || opened_boxes >= max_boxes && nearest.triangle != NONE {
                    return opened_boxes;
                }
                depth -= 1;
                let (distance, child) = stack[depth];
                if f64::from(distance) >= nearest.squared {
                    continue;
                }
                if let Some(index) = child.as_node() {
                    node = &self.nodes[index];
                    break;
                }
                opened_boxes += 1;
                for &t in &self.slots[child.slots()] {
                    if triangles.is_live(t) {
                        nearest.replace_if_nearer(point, triangles.corners(t), t);
                    }
                }
                if nearest.squared <= enough {
                    return opened_boxes;
                }
            }
        }
    }
}

/// A point between two of single precision on every axis.
#[derive(Clone, Copy)]
struct PointF32 {
    below: [f32; 3],
    above: [f32; 3],
}

impl PointF32 {
    #[inline]
    fn new(p: DVec3) -> Self {
        let p = p.to_array();
        let nearest = p.map(|x| x as f32);
        let below = |i: usize| match nearest[i] {
            x if f64::from(x) > p[i] => x.next_down(),
            x => x,
        };
        let above = |i: usize| match nearest[i] {
            x if f64::from(x) < p[i] => x.next_up(),
            x => x,
        };
        Self { below: std::array::from_fn(below), above: std::array::from_fn(above) }
    }

    /// Returns the squared distances to the boxes of a node, no more than they are; infinite for
    /// empty ones.
    #[inline]
    fn distances_squared(self, node: &Node) -> [f32; WIDTH] {
        let mut squared = [0.0f32; WIDTH];
        for axis in 0..3 {
            let (below, above) = (self.below[axis], self.above[axis]);
            let ends = node.low[axis].iter().zip(&node.high[axis]);
            for (squared, (low, high)) in squared.iter_mut().zip(ends) {
                let (under, over) = (low - above, below - high);
                let outside = if under > over { under } else { over };
                let outside = if outside > 0.0 { outside } else { 0.0 };
                *squared += outside * outside;
            }
        }
        // By more than five roundings.
        squared.map(|x| x * (1.0 - 1e-6))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FarthestSearch, MovingSurface, TriangleSearcher};
    use lodc_mesh::SplitMix64;

    struct Corners(Vec<[[f32; 3]; 3]>, Vec<bool>);

    impl Triangles for Corners {
        fn corners(&self, triangle: u32) -> [DVec3; 3] {
            self.0[triangle as usize].map(|p| DVec3::from(p.map(f64::from)))
        }
        fn is_live(&self, triangle: u32) -> bool {
            self.1[triangle as usize]
        }
    }

    fn nearest(tree: &MovingTree, triangles: &Corners, point: DVec3) -> f64 {
        let query = Query { point, hint: NONE, enough: 0.0, max_boxes: u32::MAX };
        let mut hit = Hit::NONE;
        tree.search(triangles, query, &mut hit);
        hit.squared
    }

    #[test]
    fn triangles_without_any_area_are_found() {
        for count in [1usize, 3, 200] {
            let line = |i: usize| {
                let at = |t: f32| [t * 3.0, t * 2.0 + i as f32 * 10.0, t];
                [at(0.0), at(1.0), at(-1.0)]
            };
            let triangles: Vec<_> = (0..count).map(line).collect();
            let tree = MovingTree::of_all(count as u32, |t| triangles[t as usize]);
            let all = Corners(triangles, vec![true; count]);
            for i in 0..count {
                let point = DVec3::new(0.0, i as f64 * 10.0, 0.0);
                assert!(nearest(&tree, &all, point) < 1e-12, "{i} of {count}");
            }
        }
    }

    /// Triangles of very unlike size, some long and askew, some in a fan.
    fn unlike(count: usize, random: &mut SplitMix64) -> Vec<[[f32; 3]; 3]> {
        let mut point = |s: f32| [0; 3].map(|_| (random.unit() - 0.5) * s);
        let mut triangles = Vec::new();
        for i in 0..count {
            let a = point(4.0);
            let near = |s: f32, q: [f32; 3]| std::array::from_fn(|k| a[k] + s * q[k]);
            let (b, c) = (near(1.0, point(1.0)), near(1.0, point(1.0)));
            triangles.push(match i % 5 {
                0 => [a, near(40.0, point(1.0)), near(0.001, point(1.0))],
                1 => [[1.0, 1.0, 1.0], point(8.0), point(8.0)],
                2 => [a, b, b],
                3 => [a, near(0.01, point(1.0)), near(0.01, point(1.0))],
                _ => [a, b, c],
            });
        }
        triangles
    }

    #[test]
    fn searches_find_the_nearest_of_triangles_that_move_and_die() {
        let mut random = SplitMix64::new(3);
        for count in [0usize, 1, 4, 5, 17, 300, 3_000] {
            let corners = unlike(count, &mut random);
            let mut all = Corners(corners, vec![true; count]);
            let mut tree = MovingTree::of(0..count as u32, count, |t| all.0[t as usize]);
            for round in 0..6 {
                for _ in 0..40 {
                    let p = DVec3::from([0; 3].map(|_| 12.0 * f64::from(random.unit() - 0.5)));
                    let slow = (0..count as u32)
                        .filter(|&t| all.is_live(t))
                        .map(|t| triangle::distance_squared(p, all.corners(t)))
                        .fold(f64::INFINITY, f64::min);
                    assert_eq!(nearest(&tree, &all, p), slow, "{count} {round}");
                }
                for _ in 0..count / 6 {
                    let t = random.below(count) as u32;
                    if round % 2 == 0 {
                        all.1[t as usize] = false;
                        tree.remove(t, |t| all.1[t as usize]);
                    } else {
                        let to = random.below(count);
                        all.0[t as usize][1] = all.0[to][0];
                        tree.grow(t, &all.0[t as usize]);
                    }
                }
            }
        }
    }

    #[test]
    fn a_tree_says_how_much_it_has_grown() {
        let row = |t: u32| [0.0, 0.4, 0.8].map(|x| [t as f32 + x, 0.5 * x, 0.0]);
        let mut tree = MovingTree::of(0..100, 100, row);
        assert_eq!(tree.growth(), 1.0);
        for t in 0..100 {
            tree.grow(t, &[[0.0; 3], [100.0, 0.0, 0.0], [50.0, 50.0, 0.0]]);
        }
        assert!(tree.growth() > 5.0, "{}", tree.growth());
    }

    #[test]
    fn few_boxes_are_opened_beside_triangles_that_are_huge_or_askew() {
        // A plane of two triangles below many small ones, and needles across.
        let mut random = SplitMix64::new(5);
        let mut corners = vec![
            [[-500.0, -500.0, -0.5], [500.0, -500.0, -0.5], [500.0, 500.0, -0.5]],
            [[-500.0, -500.0, -0.5], [500.0, 500.0, -0.5], [-500.0, 500.0, -0.5]],
        ];
        for _ in 0..20_000 {
            let a = [0; 3].map(|_| random.unit() - 0.5);
            let near = |s: f32| std::array::from_fn(|k| a[k] + s * [0.01, -0.007, 0.003][k]);
            corners.push([a, near(1.0), [a[0], a[1] + 0.005, a[2]]]);
        }
        for _ in 0..40 {
            let a = [0; 3].map(|_| random.unit() - 0.5);
            corners.push([a, a.map(|x| x + 0.6), [a[0] + 1e-3, a[1], a[2]]]);
        }
        let count = corners.len();
        let all = Corners(corners, vec![true; count]);
        let tree = MovingTree::of_all(count as u32, |t| all.0[t as usize]);
        let mut boxes = 0;
        for _ in 0..1_000 {
            let point = DVec3::from([0; 3].map(|_| f64::from(random.unit() - 0.5)));
            let query = Query { point, hint: NONE, enough: 0.0, max_boxes: u32::MAX };
            boxes += tree.search(&all, query, &mut Hit::NONE.clone());
        }
        assert!(boxes < 60 * 1_000, "{boxes}");
    }

    /// A cone of `n` needles from its top to its rim.
    fn cone(n: usize) -> Corners {
        let rim = |i: usize| {
            let (sine, cosine) = (i as f64 / n as f64 * std::f64::consts::TAU).sin_cos();
            [cosine as f32, sine as f32, 0.0]
        };
        let needles = (0..n).map(|i| [rim(i), rim(i + 1), [0.0, 0.0, 0.5]]);
        Corners(needles.collect(), vec![true; n])
    }

    #[test]
    fn tens_of_boxes_are_opened_between_fans_whichever_is_finer() {
        for (from, to) in [(9_000, 3_000), (9_000, 300), (300, 9_000)] {
            let (needles, others) = (cone(from), cone(to));
            let tree = MovingTree::of_all(to as u32, |t| others.0[t as usize]);
            let surface = MovingSurface { triangles: &others, tree: &tree };
            let mut searcher = TriangleSearcher::new(FarthestSearch::for_size(1.0));
            // How far the coarser rim is from the finer one.
            let known = 1.0 - (std::f64::consts::PI / from.min(to) as f64).cos();
            let mut boxes = 0;
            for t in 0..from as u32 {
                let corners = needles.corners(t);
                let found = searcher.search(known, corners, NONE, &surface, u64::MAX);
                assert!(found.upper <= 1.03 * known + 1e-8, "{from} {to}: {found:?}");
                boxes += found.opened_boxes;
            }
            let most = 60 * from.max(to) as u64;
            assert!(boxes < most, "{from} {to}: {} a needle", boxes / from.max(to) as u64);
        }
    }
}
