//! Builds trees of boxes by the surface area heuristic (MacDonald and Booth 1990), in bins (Wald
//! 2007), four boxes to a node.
//!
//! Triangles whose boxes are far larger than they are, long ones that lie askew above all, are in
//! several leaves, each with the box of a part (Ernst and Greiner 2007): else a few of them would
//! lie in the way of every search.

use crate::bounds::Bounds;
use crate::capsule::Capsule;
use glam::{DVec3, Vec3A};
use lodc_mesh::NONE;
use rayon::prelude::*;
use std::ops::Range;

/// Boxes in a node.
pub(crate) const WIDTH: usize = 4;

/// No leaf has more triangles than this. Chosen by hand: fewer take more memory.
const MAX_LEAF_TRIANGLES: usize = 4;

/// Bins along an axis. Chosen by hand.
const BINS: usize = 8;

/// Nodes on the way from the root below which the heuristic decides; deeper ones are divided into
/// equal parts, so that any mesh has a tree of bounded depth.
const MAX_DECIDED_DEPTH: usize = 24;
/// Most nodes on the way from the root to a leaf: 2^28 triangles in equal parts take 14 more.
const MAX_DEPTH: usize = MAX_DECIDED_DEPTH + 14;
/// Entries that a search may have to remember: all but one child of every node on its way.
pub(crate) const MAX_STACK: usize = (WIDTH - 1) * MAX_DEPTH + WIDTH;

/// References of a subtree from which on its children are built in parallel. Chosen by hand: in
/// smaller ones starting a task takes as long.
const MIN_PARALLEL: usize = 8_192;

/// A triangle is askew if the area of its box is more than this many times its own. Chosen by hand.
const ASKEW_RATIO: f64 = 8.0;

/// A part of a triangle is divided if the area of its box exceeds that of the part by more than
/// this many times the mean triangle's area. Chosen by hand.
const EXCESS_RATIO: f64 = 16.0;
/// At most this many references are made for each triangle, on average, and this many more. Chosen
/// by hand.
const MAX_REFERENCES: [usize; 2] = [2, 64];
/// Most times that a triangle is halved. Chosen by hand.
const MAX_HALVINGS: u32 = 12;

/// What a box holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const COUNT_SHIFT: u32 = 28;
    /// Nothing: the box is empty.
    pub(crate) const NOTHING: Self = Self(Self::LEAF);

    fn node(index: usize) -> Self {
        Self(index as u32)
    }

    fn leaf(slots: Range<usize>) -> Self {
        let count = (slots.len() as u32) << Self::COUNT_SHIFT;
        Self(Self::LEAF | count | slots.start as u32)
    }

    /// The index of a node; `None` for a leaf.
    #[inline]
    pub(crate) fn as_node(self) -> Option<usize> {
        (self.0 & Self::LEAF == 0).then_some(self.0 as usize)
    }

    /// The slots of a leaf.
    #[inline]
    pub(crate) fn slots(self) -> Range<usize> {
        let start = (self.0 & ((1 << Self::COUNT_SHIFT) - 1)) as usize;
        start..start + (self.0 >> Self::COUNT_SHIFT & 7) as usize
    }
}

/// Four boxes, and what is in them.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Node {
    /// For each axis the lower ends of the boxes, and the upper ones.
    pub(crate) low: [[f32; WIDTH]; 3],
    pub(crate) high: [[f32; WIDTH]; 3],
    pub(crate) child: [Child; WIDTH],
    /// The box that holds this node: [`WIDTH`] × node + index; [`NONE`] for the root.
    pub(crate) parent: u32,
    /// The index of the node's capsules; [`NONE`] where boxes alone do.
    pub(crate) capsules: u32,
}

impl Node {
    const EMPTY: Self = Self {
        low: [[f32::INFINITY; WIDTH]; 3],
        high: [[f32::NEG_INFINITY; WIDTH]; 3],
        child: [Child::NOTHING; WIDTH],
        parent: NONE,
        capsules: NONE,
    };

    pub(crate) fn bounds(&self, i: usize) -> Bounds {
        Bounds::new(self.low.map(|axis| axis[i]), self.high.map(|axis| axis[i]))
    }

    pub(crate) fn set_bounds(&mut self, i: usize, bounds: &Bounds) {
        for axis in 0..3 {
            self.low[axis][i] = bounds.low()[axis];
            self.high[axis][i] = bounds.high()[axis];
        }
    }
}

/// A box in registers.
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: Vec3A,
    high: Vec3A,
}

impl Extent {
    const EMPTY: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    fn of(bounds: &Bounds) -> Self {
        Self { low: bounds.low().into(), high: bounds.high().into() }
    }

    #[inline]
    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Half the area of its sides; 0 if it is empty.
    #[inline]
    fn half_area(self) -> f32 {
        let d = (self.high - self.low).max(Vec3A::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    fn bounds(self) -> Bounds {
        Bounds::new(self.low.into(), self.high.into())
    }
}

/// A triangle, or a part of one, in its box.
#[derive(Clone, Copy, Debug)]
struct Reference {
    extent: Extent,
    triangle: u32,
    /// Whether its box is far larger than the triangle.
    is_askew: bool,
}

impl Reference {
    #[inline]
    fn center(&self) -> Vec3A {
        self.extent.low * 0.5 + self.extent.high * 0.5
    }
}

/// Boxes around some references, and around their centers.
#[derive(Clone, Copy, Debug)]
struct Group {
    extent: Extent,
    centers: Extent,
    count: u32,
    /// How many of them are askew.
    askew: u32,
}

impl Group {
    const EMPTY: Self = Self { extent: Extent::EMPTY, centers: Extent::EMPTY, count: 0, askew: 0 };

    #[inline]
    fn include(&mut self, reference: &Reference, center: Vec3A) {
        self.extent = self.extent.union(reference.extent);
        self.centers = self.centers.union(Extent { low: center, high: center });
        self.count += 1;
        self.askew += u32::from(reference.is_askew);
    }

    fn union(self, other: Self) -> Self {
        Self {
            extent: self.extent.union(other.extent),
            centers: self.centers.union(other.centers),
            count: self.count + other.count,
            askew: self.askew + other.askew,
        }
    }

    fn of(references: &[Reference]) -> Self {
        let mut group = Self::EMPTY;
        references.iter().for_each(|r| group.include(r, r.center()));
        group
    }

    /// What searches cost here, by the heuristic.
    fn cost(&self) -> f32 {
        self.extent.half_area() * self.count as f32
    }
}

/// A tree: the first node is the root. `slots` has the triangle of each slot.
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    pub(crate) slots: Vec<u32>,
    pub(crate) capsules: Vec<[Capsule; WIDTH]>,
}

/// Builds the tree of some triangles.
pub(crate) fn build(
    triangles: impl Iterator<Item = u32>,
    corners: impl Fn(u32) -> [[f32; 3]; 3],
) -> Tree {
    let mut references = references(triangles, &corners);
    assert!(references.len() < 1 << Child::COUNT_SHIFT, "too many triangles for a tree");
    let group = Group::of(&references);
    let mut nodes = Vec::with_capacity(references.len() / MAX_LEAF_TRIANGLES);
    subtree(&mut references, group, 0, 0, &mut nodes);
    for i in 0..nodes.len() {
        for k in 0..WIDTH {
            if let Some(child) = nodes[i].child[k].as_node() {
                nodes[child].parent = (WIDTH * i + k) as u32;
            }
        }
    }
    let slots: Vec<u32> = references.iter().map(|r| r.triangle).collect();
    let capsules = capsules(&mut nodes, &references, corners);
    Tree { nodes, slots, capsules }
}

/// Makes capsules for nodes of which most triangles are askew.
fn capsules(
    nodes: &mut [Node],
    references: &[Reference],
    corners: impl Fn(u32) -> [[f32; 3]; 3],
) -> Vec<[Capsule; WIDTH]> {
    let mut capsules = Vec::new();
    // How many references before each slot, and before the end, are askew.
    let askew: Vec<u32> = std::iter::once(0)
        .chain(references.iter().scan(0, |sum, r| {
            *sum += u32::from(r.is_askew);
            Some(*sum)
        }))
        .collect();
    if askew.last() == Some(&0) {
        return capsules;
    }
    // The slots below each node, children before their parents.
    let mut slots = vec![0..0; nodes.len()];
    for i in (0..nodes.len()).rev() {
        let below = nodes[i].child.map(|child| match child.as_node() {
            Some(index) => slots[index].clone(),
            None => child.slots(),
        });
        let filled = below.iter().filter(|range| !range.is_empty());
        slots[i] = filled.clone().map(|r| r.start).min().unwrap_or(0)
            ..filled.map(|r| r.end).max().unwrap_or(0);
        let of_node = below.map(|range| {
            let count = askew[range.end] - askew[range.start];
            if range.is_empty() || (count as usize) < range.len().div_ceil(2) {
                return Capsule::ALL;
            }
            Capsule::around(references[range].iter().map(|r| corners(r.triangle)))
        });
        if of_node.iter().any(|capsule| !capsule.is_all()) {
            nodes[i].capsules = capsules.len() as u32;
            capsules.push(of_node);
        }
    }
    capsules
}

/// Returns the references of some triangles, those of a triangle one after the other.
fn references(
    triangles: impl Iterator<Item = u32>,
    corners: &impl Fn(u32) -> [[f32; 3]; 3],
) -> Vec<Reference> {
    let mut total_area = 0.0;
    let references: Vec<Reference> = triangles
        .map(|triangle| {
            let corners = corners(triangle);
            let area = projected_area(&corners.map(|p| DVec3::from(p.map(f64::from))));
            total_area += area;
            let extent = Extent::of(&Bounds::of(&corners));
            let is_askew = f64::from(extent.half_area()) > ASKEW_RATIO * area;
            Reference { extent, triangle, is_askew }
        })
        .collect();
    let count = references.len();
    let allowed = EXCESS_RATIO * total_area / count.max(1) as f64;
    let [per_triangle, more] = MAX_REFERENCES;
    let max_count = per_triangle * count + more;
    // Parts are halved while their boxes exceed them by more than a limit, which rises until the
    // references allowed suffice, by estimate: halves exceed by half as much or less.
    let excess = |r: &Reference| {
        f64::from(r.extent.half_area())
            - projected_area(&corners(r.triangle).map(|p| DVec3::from(p.map(f64::from))))
    };
    let is_large = |r: &&Reference| f64::from(r.extent.half_area()) > allowed;
    let large: Vec<f64> = references.iter().filter(is_large).map(excess).collect();
    let parts = |limit: f64| -> f64 { large.iter().map(|e| (e / limit).max(1.0) - 1.0).sum() };
    // Triangles may have no area at all: none is cut into more parts than all references.
    let largest = large.iter().copied().fold(0.0, f64::max);
    let mut limit = allowed.max(largest / max_count as f64);
    while !large.is_empty() && parts(limit) > (max_count - count) as f64 {
        limit *= 1.5;
    }
    if large.is_empty() || limit <= 0.0 {
        return references;
    }
    let mut divided = Vec::with_capacity(max_count);
    for (done, &reference) in references.iter().enumerate() {
        let is_large = f64::from(reference.extent.half_area()) > limit;
        // Parts may be more than was estimated: then triangles that are left stay whole.
        if is_large && divided.len() - done < max_count - count {
            let corners = corners(reference.triangle).map(|p| DVec3::from(p.map(f64::from)));
            divide(&corners, reference, limit, MAX_HALVINGS, &mut divided);
        } else {
            divided.push(reference);
        }
    }
    divided
}

/// Adds the references of a part of a triangle, a convex polygon.
fn divide(
    polygon: &[DVec3],
    whole: Reference,
    limit: f64,
    halvings: u32,
    references: &mut Vec<Reference>,
) {
    let low = polygon.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = polygon.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let bounds = Bounds::around(low, high);
    let excess = f64::from(bounds.half_area()) - projected_area(polygon);
    if excess <= limit || halvings == 0 || polygon.len() < 3 {
        references.push(Reference { extent: Extent::of(&bounds), ..whole });
        return;
    }
    let axis = bounds.longest_axis();
    let middle = f64::from(bounds.middle(axis));
    for sign in [1.0, -1.0] {
        let mut half: Vec<DVec3> = Vec::with_capacity(polygon.len() + 1);
        for (i, &q) in polygon.iter().enumerate() {
            let p = polygon[(i + polygon.len() - 1) % polygon.len()];
            let [h, k] = [p, q].map(|p| sign * (p[axis] - middle));
            if (h < 0.0) != (k < 0.0) && h != k {
                let mut crossing = p + (q - p) * (h / (h - k));
                crossing[axis] = middle;
                half.push(crossing);
            }
            if k >= 0.0 {
                half.push(q);
            }
        }
        if !half.is_empty() {
            divide(&half, whole, limit, halvings - 1, references);
        }
    }
}

/// The areas of a polygon's projections along the three axes, added up: half the area of the
/// smallest boxes that it could be divided into.
fn projected_area(polygon: &[DVec3]) -> f64 {
    let normal: DVec3 = (2..polygon.len())
        .map(|i| (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]))
        .sum();
    0.5 * normal.abs().element_sum()
}

/// Builds the subtree of some references, of which `group` tells the boxes, and puts them into the
/// order of slots, of which the first is `first_slot`. Appends its nodes.
fn subtree(
    references: &mut [Reference],
    group: Group,
    first_slot: usize,
    depth: usize,
    nodes: &mut Vec<Node>,
) {
    let mut ranges = [0..references.len(), 0..0, 0..0, 0..0];
    let mut groups = [group, Group::EMPTY, Group::EMPTY, Group::EMPTY];
    let is_decided = depth < MAX_DECIDED_DEPTH;
    let mut count = 1;
    while count < WIDTH {
        // The largest box is divided next; below the decided depth the one of most triangles.
        let size = |i: usize| match is_decided {
            true => groups[i].extent.half_area(),
            false => ranges[i].len() as f32,
        };
        let divisible = (0..count).filter(|&i| ranges[i].len() > MAX_LEAF_TRIANGLES);
        // Ties go to the first.
        let Some(largest) = divisible.rev().max_by(|&i, &j| size(i).total_cmp(&size(j))) else {
            break;
        };
        let range = ranges[largest].clone();
        let halves = split(&mut references[range.clone()], groups[largest], is_decided);
        let middle = range.start + halves[0].count as usize;
        (ranges[largest], ranges[count]) = (range.start..middle, middle..range.end);
        (groups[largest], groups[count]) = (halves[0], halves[1]);
        count += 1;
    }
    let node = nodes.len();
    nodes.push(Node::EMPTY);
    let mut order = [0, 1, 2, 3];
    order.sort_unstable_by_key(|&i| (ranges[i].start, ranges[i].end));
    let is_parallel = references.len() >= MIN_PARALLEL;
    let mut parts = Vec::new();
    let mut rest = references;
    for i in order {
        let (part, others) = rest.split_at_mut(ranges[i].len());
        rest = others;
        nodes[node].set_bounds(i, &groups[i].extent.bounds());
        let start = first_slot + ranges[i].start;
        if part.len() <= MAX_LEAF_TRIANGLES {
            nodes[node].child[i] = Child::leaf(start..start + part.len());
        } else if is_parallel {
            parts.push((i, start, part));
        } else {
            nodes[node].child[i] = Child::node(nodes.len());
            subtree(part, groups[i], start, depth + 1, nodes);
        }
    }
    let build = |(i, start, part): (usize, usize, &mut [Reference])| {
        let mut nodes = Vec::new();
        subtree(part, groups[i], start, depth + 1, &mut nodes);
        (i, nodes)
    };
    let children: Vec<(usize, Vec<Node>)> =
        parts.into_par_iter().with_max_len(1).map(build).collect();
    for (i, child) in children {
        let offset = nodes.len();
        nodes[node].child[i] = Child::node(offset);
        nodes.extend(child.into_iter().map(|mut node| {
            for child in &mut node.child {
                if let Some(index) = child.as_node() {
                    *child = Child::node(index + offset);
                }
            }
            node
        }));
    }
}

/// Divides some references in two, by the surface area heuristic or in halves. Returns the boxes of
/// both parts, the first ones first: neither is empty.
fn split(references: &mut [Reference], group: Group, is_decided: bool) -> [Group; 2] {
    let extent = group.centers.high - group.centers.low;
    let axis = extent.max_position();
    // Of few it hardly matters how they are divided.
    if is_decided && extent[axis] > 0.0 && references.len() > 2 * MAX_LEAF_TRIANGLES {
        let low = group.centers.low[axis];
        let scale = BINS as f32 * (1.0 - 1e-6) / extent[axis];
        let bin = |center: Vec3A| (((center[axis] - low) * scale) as usize).min(BINS - 1);
        let mut bins = [Group::EMPTY; BINS];
        for r in references.iter() {
            let center = r.center();
            bins[bin(center)].include(r, center);
        }
        if let Some((first_right, halves)) = best_bin(&bins) {
            let mut left = 0;
            for i in 0..references.len() {
                if bin(references[i].center()) < first_right {
                    references.swap(left, i);
                    left += 1;
                }
            }
            return halves;
        }
    }
    let half = references.len() / 2;
    references.select_nth_unstable_by(half, |a, b| {
        let [x, y] = [a, b].map(|r| r.center()[axis]);
        x.total_cmp(&y).then(a.triangle.cmp(&b.triangle))
    });
    let (left, right) = references.split_at(half);
    [Group::of(left), Group::of(right)]
}

/// Returns the bin at which the right part begins where the heuristic's cost is least, and both
/// parts; `None` if all are in one.
fn best_bin(bins: &[Group; BINS]) -> Option<(usize, [Group; 2])> {
    let mut rights = *bins;
    for i in (0..BINS - 1).rev() {
        rights[i] = rights[i].union(rights[i + 1]);
    }
    let mut left = Group::EMPTY;
    let mut best = (f32::INFINITY, None);
    for i in 1..BINS {
        left = left.union(bins[i - 1]);
        if left.count == 0 || rights[i].count == 0 {
            continue;
        }
        let cost = left.cost() + rights[i].cost();
        if cost < best.0 {
            best = (cost, Some((i, [left, rights[i]])));
        }
    }
    best.1
}
