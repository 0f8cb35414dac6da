//! How far the farthest point of one surface is from another, between two bounds.
//!
//! Branch and bound (as Guthe, Borodin and Klein 2005), the part that may be farthest first. A part
//! is a convex polygon. From one triangle its distance is convex, so it is largest at a corner: a
//! part over a triangle is closed at once. A part that reaches beyond is clipped by the triangle's
//! prism, and what is left over goes to the triangles beside it; so flat places end exactly, and
//! cover is decided, where bisection alone would go on for ever along common edges.

use crate::tree::TriangleTree;
use crate::triangle::distance_squared;
use glam::DVec3;
use lodc_mesh::NONE;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Parts that are looked at together. Part of the result, unlike the number of threads.
const TOGETHER: usize = 512;

/// Most corners of a part.
const CORNERS: usize = 8;

/// A part is clipped if at least this share of it lies over the triangle next to its middle.
const WORTH_CLIPPING: f64 = 0.125;

/// Boxes that the search for one triangle may open: at first, and for a part that may be farthest.
const PATIENCE: [u32; 2] = [128, 4_096];

/// The largest distance of any point of a surface from another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Farthest {
    /// A point is that far off.
    pub least: f64,
    /// No point is farther.
    pub most: f64,
    /// Boxes of the tree that were opened: the work that it took.
    pub opened: u64,
}

/// What a search for the farthest point may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Excess of the upper over the lower bound that is left, as a share.
    pub tolerance: f64,
    /// Distances below this are none.
    pub floor: f64,
    /// Boxes of the tree that may be opened after all triangles were looked at once: so many for
    /// each of them, and so many besides. Beyond, the bounds stay apart.
    pub boxes: [u32; 2],
    /// On the thread that asks, none besides: for one that a thread pool may be waiting for.
    pub alone: bool,
}

impl Search {
    /// Within 2 %, distances below a billionth of a length as none, 2,000 boxes a triangle and
    /// three million besides.
    #[must_use]
    pub fn within(length: f64) -> Self {
        Self { tolerance: 0.02, floor: 1e-9 * length, boxes: [2_000, 3_000_000], alone: false }
    }

    /// Looks for the point of `from` that is farthest from `to`. Infinite if only `to` is empty.
    #[must_use]
    pub fn farthest(&self, from: &[[DVec3; 3]], to: &TriangleTree) -> Farthest {
        if from.is_empty() {
            return Farthest { least: 0.0, most: 0.0, opened: 0 };
        }
        if to.order().is_empty() {
            return Farthest { least: f64::INFINITY, most: f64::INFINITY, opened: 0 };
        }
        let mut open =
            Open { search: *self, least: 0.0, closed: 0.0, opened: 0, parts: BinaryHeap::new() };
        let first = |t: &[DVec3; 3]| Part::new(Polygon::triangle(*t), NONE, to, PATIENCE[0]);
        let parts: Vec<(Part, Found)> = match self.alone {
            true => from.iter().map(first).collect(),
            false => from.par_iter().map(first).collect(),
        };
        open.take(&parts);
        let [each, besides] = self.boxes.map(u64::from);
        let most = open.opened + each * from.len() as u64 + besides;
        loop {
            let next = open.next();
            if next.is_empty() || open.opened >= most {
                open.parts.extend(next);
                return open.bounds();
            }
            let allowed = open.allowed();
            let slack = 0.25 * self.floor;
            let divide = |part: &Part| part.divided(to, allowed, slack);
            let divided: Vec<Vec<(Part, Found)>> = match self.alone {
                true => next.iter().map(divide).collect(),
                false => next.par_iter().map(divide).collect(),
            };
            open.take(&divided.concat());
        }
    }
}

/// What looking at a part has found.
#[derive(Clone, Copy, Debug)]
struct Found {
    /// A point of it is that far off.
    distance: f64,
    opened: u32,
}

/// The parts that may have a point farther than any found.
struct Open {
    search: Search,
    /// The largest distance found.
    least: f64,
    /// No point of the parts that were closed is farther than this.
    closed: f64,
    /// Boxes that were opened, and parts looked at.
    opened: u64,
    parts: BinaryHeap<Part>,
}

impl Open {
    /// The distance up to which nothing is looked for.
    fn allowed(&self) -> f64 {
        self.least * (1.0 + self.search.tolerance) + self.search.floor
    }

    /// Takes parts with what was found in them, and closes those that are near enough.
    fn take(&mut self, parts: &[(Part, Found)]) {
        for (_, found) in parts {
            self.least = self.least.max(found.distance);
            self.opened += u64::from(found.opened) + 1;
        }
        for (part, _) in parts {
            if part.most > self.allowed() {
                self.parts.push(*part);
            } else {
                self.closed = self.closed.max(part.most);
            }
        }
    }

    /// The parts to be looked at next, the farthest first.
    fn next(&mut self) -> Vec<Part> {
        let mut next = Vec::with_capacity(TOGETHER);
        while let Some(part) = self.parts.pop() {
            if part.most <= self.allowed() {
                // All others are nearer.
                self.closed = self.closed.max(part.most);
                self.parts.clear();
                break;
            }
            next.push(part);
            if next.len() == TOGETHER {
                break;
            }
        }
        next
    }

    fn bounds(&self) -> Farthest {
        let open = self.parts.peek().map_or(0.0, |part| part.most);
        let most = self.least.max(self.closed).max(open);
        Farthest { least: self.least, most, opened: self.opened }
    }
}

/// A convex polygon.
#[derive(Clone, Copy, Debug)]
struct Polygon {
    corners: [DVec3; CORNERS],
    count: usize,
}

impl Polygon {
    const EMPTY: Self = Self { corners: [DVec3::ZERO; CORNERS], count: 0 };

    fn triangle(corners: [DVec3; 3]) -> Self {
        let mut polygon = Self::EMPTY;
        polygon.corners[..3].copy_from_slice(&corners);
        polygon.count = 3;
        polygon
    }

    fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    fn push(&mut self, corner: DVec3) {
        if self.count < CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    fn middle(&self) -> DVec3 {
        self.corners().iter().sum::<DVec3>() / self.count as f64
    }

    /// Twice its area.
    fn area(&self) -> f64 {
        let c = self.corners();
        (1..c.len().max(2) - 1)
            .map(|i| (c[i] - c[0]).cross(c[i + 1] - c[0]))
            .sum::<DVec3>()
            .length()
    }

    /// The parts on the negative and the positive side of a plane. A corner within `slack` of it is
    /// on both, and no side is thinner: slivers along common edges would be divided for ever.
    fn cut(&self, at: DVec3, normal: DVec3, slack: f64) -> [Self; 2] {
        let normal = normal.normalize_or_zero();
        let height = |p: DVec3| (p - at).dot(normal);
        let heights = self.corners.map(height);
        let heights = &heights[..self.count];
        if heights.iter().all(|&h| h <= slack) {
            return [*self, Self::EMPTY];
        }
        if heights.iter().all(|&h| h >= -slack) {
            return [Self::EMPTY, *self];
        }
        let mut sides = [Self::EMPTY; 2];
        for i in 0..self.count {
            let before = if i == 0 { self.count - 1 } else { i - 1 };
            let (p, q) = (self.corners[before], self.corners[i]);
            let (h, k) = (heights[before], heights[i]);
            if h < -slack && k > slack || h > slack && k < -slack {
                let crossing = p + (q - p) * (h / (h - k));
                sides.iter_mut().for_each(|side| side.push(crossing));
            }
            if k <= slack {
                sides[0].push(q);
            }
            if k >= -slack {
                sides[1].push(q);
            }
        }
        sides
    }

    /// Returns whether it is more than a line.
    fn has_area(&self) -> bool {
        self.count >= 3
    }

    /// The same in one or two parts that have room for the corners that clipping adds.
    fn simple(&self) -> [Self; 2] {
        if self.count <= CORNERS - 3 {
            return [*self, Self::EMPTY];
        }
        let half = self.count / 2;
        let mut parts = [Self::EMPTY; 2];
        self.corners[..=half].iter().for_each(|&c| parts[0].push(c));
        self.corners[half..self.count].iter().for_each(|&c| parts[1].push(c));
        parts[1].push(self.corners[0]);
        parts
    }

    /// Two halves, across its longest diagonal or edge.
    fn halves(&self) -> [Self; 2] {
        let mut longest = (0.0, DVec3::ZERO, DVec3::ZERO);
        for (i, &a) in self.corners().iter().enumerate() {
            for &b in &self.corners()[i + 1..] {
                let length = (b - a).length_squared();
                if length > longest.0 {
                    longest = (length, a, b);
                }
            }
        }
        let (_, a, b) = longest;
        self.cut((a + b) * 0.5, b - a, 0.0)
    }
}

/// A part of a surface.
#[derive(Clone, Copy, Debug)]
struct Part {
    polygon: Polygon,
    /// The triangle of the other surface nearest to its middle.
    near: u32,
    /// No point of it is farther than this.
    most: f64,
}

impl Part {
    /// A part with the distance of its middle. `hint` is a triangle that is probably near.
    fn new(polygon: Polygon, hint: u32, to: &TriangleTree, patience: u32) -> (Self, Found) {
        let middle = polygon.middle();
        let (distance, near, found) = ask(middle, hint, to, patience);
        let radius = polygon.corners().iter().map(|c| (*c - middle).length_squared());
        let radius = radius.fold(0.0, f64::max).sqrt();
        let most = (distance + radius).min(farthest_corner(&polygon, to.corners_of(near)).0);
        (Self { polygon, near, most: most.max(found.distance) }, found)
    }

    /// The parts that it falls into, with what was found there.
    fn divided(&self, to: &TriangleTree, allowed: f64, slack: f64) -> Vec<(Self, Found)> {
        let triangle = to.corners_of(self.near);
        let (_, corner) = farthest_corner(&self.polygon, triangle);
        let (_, _, found) = ask(corner, self.near, to, PATIENCE[1]);
        let mut parts = Vec::with_capacity(8);
        let (over, beyond) = clip(&self.polygon, triangle, slack);
        let most = farthest_corner(&over, triangle).0;
        let is_worth_it = most <= allowed
            && over.area() >= WORTH_CLIPPING * self.polygon.area()
            && beyond.iter().any(Polygon::has_area);
        let rest = if is_worth_it {
            parts.push((Self { polygon: over, near: self.near, most }, found));
            beyond
        } else {
            let [a, b] = self.polygon.halves();
            [a, b, Polygon::EMPTY]
        };
        for polygon in rest.iter().flat_map(Polygon::simple).filter(Polygon::has_area) {
            parts.push(Self::new(polygon, self.near, to, PATIENCE[1]));
        }
        if let Some((_, first)) = parts.first_mut() {
            first.distance = first.distance.max(found.distance);
            first.opened += found.opened;
        }
        parts
    }
}

/// An upper bound of the distance of a point, the triangle that has it, and what was found: the
/// distance, unless the search ended early.
fn ask(p: DVec3, hint: u32, to: &TriangleTree, patience: u32) -> (f64, u32, Found) {
    let mut left = patience;
    let (squared, near, is_sure) = to.distance_at_most(p, hint, &mut left);
    let distance = squared.sqrt();
    let found = Found { distance: if is_sure { distance } else { 0.0 }, opened: patience - left };
    (distance, near, found)
}

impl Ord for Part {
    fn cmp(&self, other: &Self) -> Ordering {
        self.most.total_cmp(&other.most)
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

/// The largest distance of a corner from a triangle, and the corner. 0 without corners.
fn farthest_corner(polygon: &Polygon, triangle: [DVec3; 3]) -> (f64, DVec3) {
    let distances = polygon.corners().iter().map(|&c| (distance_squared(c, triangle), c));
    let (squared, corner) = distances
        .fold((0.0, polygon.corners[0]), |best, new| if new.0 > best.0 { new } else { best });
    (squared.sqrt(), corner)
}

/// Divides a polygon into the part in the prism over a triangle, upright on its edges, and the
/// parts beyond each edge.
fn clip(polygon: &Polygon, [a, b, c]: [DVec3; 3], slack: f64) -> (Polygon, [Polygon; 3]) {
    let normal = (b - a).cross(c - a);
    let mut rest = *polygon;
    let mut beyond = [Polygon::EMPTY; 3];
    for (out, [from, to]) in beyond.iter_mut().zip([[a, b], [b, c], [c, a]]) {
        if !rest.has_area() {
            break;
        }
        // Points outwards.
        [rest, *out] = rest.cut(from, (to - from).cross(normal), slack);
    }
    (rest, beyond)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(triangles: &[[DVec3; 3]]) -> TriangleTree {
        TriangleTree::new(triangles)
    }

    /// A square of side 1 divided into `n` by `n` squares, its heights given.
    fn sheet(n: u32, height: impl Fn(f64, f64) -> f64) -> Vec<[DVec3; 3]> {
        let at = |i: u32, j: u32| {
            let [x, y] = [i, j].map(|k| f64::from(k) / f64::from(n));
            DVec3::new(x, y, height(x, y))
        };
        let square = |(i, j): (u32, u32)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).flat_map(square).collect()
    }

    #[test]
    fn a_bump_is_as_far_as_it_is_high() {
        let flat = sheet(1, |_, _| 0.0);
        let bump = sheet(8, |x, y| if x == 0.5 && y == 0.5 { 0.25 } else { 0.0 });
        for (from, to, far) in [(&bump, &flat, 0.25), (&flat, &flat, 0.0), (&bump, &bump, 0.0)] {
            let Farthest { least, most, .. } = Search::within(1.0).farthest(from, &tree(to));
            assert!((least - far).abs() < 1e-9 && (far - 1e-9..=1.02 * far + 1e-9).contains(&most));
        }
    }

    #[test]
    fn one_plane_divided_in_two_ways_is_nowhere_apart() {
        // Bisection alone would go on along all edges.
        let (a, b) = (sheet(7, |x, y| 0.3 * x + 0.1 * y), sheet(5, |x, y| 0.3 * x + 0.1 * y));
        let search = Search::within(1.0);
        let found = search.farthest(&a, &tree(&b));
        assert!(found.most <= 2e-9, "{found:?}");
        assert!(search.farthest(&b, &tree(&a)).most <= 2e-9);
    }

    #[test]
    fn a_hole_between_samples_is_found() {
        let whole = sheet(1, |_, _| 0.0);
        let mut holed = sheet(40, |_, _| 0.0);
        holed.remove(1234);
        let Farthest { least, most, .. } = Search::within(1.0).farthest(&whole, &tree(&holed));
        // The radius of the circle in a triangle with two sides of 1/40.
        let radius = (2.0 - 2.0f64.sqrt()) / 2.0 / 40.0;
        assert!(least <= radius * 1.0001 && most >= radius * 0.9999, "{least} {most} {radius}");
        assert!(most <= 1.03 * least, "{least} {most}");
    }

    #[test]
    fn bounds_hold_for_random_triangles() {
        let mut random = lodc_mesh::SplitMix64::new(3);
        for round in 0..60 {
            let mut point = || DVec3::from_array([0; 3].map(|_| f64::from(random.unit())));
            let mut some = |n: usize| (0..n).map(|_| [0; 3].map(|_| point())).collect::<Vec<_>>();
            let (from, to) = (some(1 + round % 5), some(1 + round / 5));
            let tree = tree(&to);
            let Farthest { least, most, .. } = Search::within(1.0).farthest(&from, &tree);
            assert!(least <= most && most <= 1.021 * least + 1e-8, "{round}: {least} {most}");
            let mut seen = 0.0f64;
            for &[a, b, c] in &from {
                for i in 0..=40 {
                    for j in 0..=40 - i {
                        let [s, t] = [i, j].map(|k| f64::from(k) / 40.0);
                        let p = a + (b - a) * s + (c - a) * t;
                        seen = seen.max(tree.distance_squared(p).sqrt());
                    }
                }
            }
            assert!(seen <= most + 1e-12, "{round}: {seen} {most}");
            assert!(seen >= 0.9 * least, "{round}: {seen} {least}");
        }
    }
}
