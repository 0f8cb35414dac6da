//! How far the farthest point of one surface is from another, between two bounds.
//!
//! Branch and bound (as Guthe, Borodin and Klein 2005), the part that may be farthest first. A part
//! is a convex polygon. From one triangle its distance is convex, so it is largest at a corner: a
//! part whose corners are near enough to one triangle is closed. From any other part that is cut
//! off which is near enough to the triangle next to its middle: over the triangle, and as far
//! around it as the distance allows. What is left goes to the triangles beside it; so flat places
//! end exactly, and cover is decided, where bisection alone would go on for ever along common
//! edges.

use crate::moving::Hit;
use crate::polygon::Polygon;
use crate::surface::Surface;
use crate::triangle::is_within;
use glam::DVec3;
use lodc_mesh::NONE;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Parts, and triangles in a row, that are looked at together. Part of the result, unlike the
/// number of threads.
const TOGETHER: usize = 512;
const IN_A_ROW: usize = 32;

/// Triangles, spread evenly, that are looked at before all others, for a bound to begin with.
const FIRST: usize = 1_024;

/// A part is cut if at least this share of it is near the triangle next to its middle.
const WORTH_CUTTING: f64 = 0.125;

/// A triangle within this share of the bound is near enough to cut a part by.
const NEAR: f64 = 0.25;

/// The farthest corner of a part that is cut is asked where it is at most this many times the
/// bound off: farther ones have more often a triangle besides that is nearer.
const PROMISING: f64 = 1.5;

/// Boxes that the search for one triangle may open: at first, and for a part that may be farthest.
const PATIENCE: [u32; 2] = [128, 4_096];

/// Boxes that may be opened for a triangle before all others were looked at.
const IN_TURN: u64 = 2_000;

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
    /// Boxes of the tree that may be opened after all triangles were looked at once: the
    /// first number for each of them, and the second besides. Beyond, the bounds stay apart.
    pub boxes: [u32; 2],
}

impl Search {
    /// Within 2 %, distances below a billionth of a length as none, 2,000 boxes a triangle and
    /// three million besides.
    #[must_use]
    pub fn within(length: f64) -> Self {
        Self { tolerance: 0.02, floor: 1e-9 * length, boxes: [2_000, 3_000_000] }
    }

    /// Looks for the point of `from` that is farthest from `to`. Infinite if only `to` is empty.
    #[must_use]
    pub fn farthest(&self, from: &[[DVec3; 3]], to: &(impl Surface + Sync)) -> Farthest {
        self.beyond(0.0, from, to)
    }

    /// The same where a point is known that is `least` off, of this surface or of any other that
    /// the bounds are for, too.
    #[must_use]
    pub fn beyond(&self, least: f64, from: &[[DVec3; 3]], to: &(impl Surface + Sync)) -> Farthest {
        let Some(&[p, ..]) = from.first() else {
            return Farthest { least, most: least, opened: 0 };
        };
        if to.near(p, NONE, 0.0, PATIENCE[0]).0.triangle == NONE {
            return Farthest { least: f64::INFINITY, most: f64::INFINITY, opened: 0 };
        }
        let mut open = Open::new(*self, least);
        let bound = open.bound();
        // A bound to begin with, where none is known.
        let stride = if least > 0.0 { from.len() } else { (from.len() / FIRST).max(1) };
        let first = |row: &[[DVec3; 3]]| {
            let part = Part::new(Polygon::triangle(row[0]), NONE, to, bound, PATIENCE[0]);
            part.1
        };
        let found: Vec<SearchResult> = from.par_chunks(stride).map(first).collect();
        found.into_iter().for_each(|found| open.learn(found));
        for together in from.chunks(TOGETHER * IN_A_ROW) {
            let row = |row: &[[DVec3; 3]]| {
                let mut open = Open::new(*self, open.least);
                let mut near = NONE;
                for &corners in row {
                    near = open.triangle(corners, near, to, PATIENCE[0]);
                    open.explore(to, open.opened + IN_TURN);
                }
                open
            };
            let rows: Vec<Open> = together.par_chunks(IN_A_ROW).map(row).collect();
            rows.into_iter().for_each(|row| open.join(row));
        }
        let [each, besides] = self.boxes.map(u64::from);
        let most = open.opened + each * from.len() as u64 + besides;
        while open.opened < most {
            let next = open.next(TOGETHER);
            if next.is_empty() {
                break;
            }
            let bound = open.bound();
            let divide = |part: &Part| {
                let mut parts = Vec::new();
                part.divide(to, bound, &mut Vec::new(), |part| parts.push(part));
                parts
            };
            let parts: Vec<Vec<(Part, SearchResult)>> = next.par_iter().map(divide).collect();
            parts.iter().flatten().for_each(|part| open.take(part));
        }
        open.bounds()
    }
}

/// Looks for points beyond a bound in one triangle after the other, on the thread that asks.
#[derive(Clone, Debug)]
pub struct Seeker(Open);

impl Seeker {
    /// One that searches as `search` says.
    #[must_use]
    pub fn new(search: Search) -> Self {
        Self(Open::new(search, 0.0))
    }

    /// Looks for a point of a triangle that is farther than `least`, the least distance that is
    /// returned. `near` is a triangle that is probably near, or [`NONE`]; no more than `boxes` are
    /// opened, or the bounds stay apart.
    pub fn seek(
        &mut self,
        least: f64,
        corners: [DVec3; 3],
        near: u32,
        to: &impl Surface,
        boxes: u64,
    ) -> Farthest {
        let Self(open) = self;
        open.clear(least);
        open.triangle(corners, near, to, PATIENCE[1]);
        open.explore(to, boxes);
        open.bounds()
    }
}

/// The state of a search.
#[derive(Clone, Copy, Debug)]
struct Bound {
    /// The largest distance found, and the one up to which nothing is looked for.
    least: f64,
    allowed: f64,
    /// Distances below this are rounding errors.
    slack: f64,
}

impl Bound {
    /// Returns whether a triangle is near enough to a triangle of the other surface.
    fn is_within(&self, corners: [DVec3; 3], near: u32, to: &impl Surface) -> bool {
        near != NONE && {
            let triangle = to.corners(near);
            corners.iter().all(|&c| is_within(c, triangle, self.allowed * self.allowed))
        }
    }
}

/// What looking at a part has found.
#[derive(Clone, Copy, Debug)]
struct SearchResult {
    /// A point of it is that far off.
    distance: f64,
    opened: u32,
}

/// The parts that may have a point farther than any found.
#[derive(Clone, Debug)]
struct Open {
    search: Search,
    /// The largest distance found.
    least: f64,
    /// No point of the parts that were closed is farther than this.
    closed: f64,
    /// Boxes that were opened, and parts looked at.
    opened: u64,
    order: BinaryHeap<Rank>,
    /// Parts by the numbers that their ranks have, and numbers that are free.
    parts: Vec<Part>,
    free: Vec<u32>,
    /// Room for dividing.
    around: Vec<Polygon>,
    divided: Vec<(Part, SearchResult)>,
}

impl Open {
    fn new(search: Search, least: f64) -> Self {
        Self {
            search,
            least,
            closed: 0.0,
            opened: 0,
            order: BinaryHeap::new(),
            parts: vec![],
            free: vec![],
            around: vec![],
            divided: vec![],
        }
    }

    /// Begins anew.
    fn clear(&mut self, least: f64) {
        (self.least, self.closed, self.opened) = (least, 0.0, 0);
        self.order.clear();
        self.parts.clear();
        self.free.clear();
    }

    fn bound(&self) -> Bound {
        let Search { tolerance, floor, .. } = self.search;
        let allowed = self.least * (1.0 + tolerance) + floor;
        Bound { least: self.least, allowed, slack: 0.1 * floor }
    }

    fn learn(&mut self, found: SearchResult) {
        self.least = self.least.max(found.distance);
        self.opened += u64::from(found.opened) + 1;
    }

    /// Takes a part with what was found in it, and closes it if it is near enough.
    fn take(&mut self, (part, found): &(Part, SearchResult)) {
        self.learn(*found);
        if part.most <= self.bound().allowed || !part.polygon.has_area() {
            self.closed = self.closed.max(part.most);
            return;
        }
        let number = self.free.pop().unwrap_or(self.parts.len() as u32);
        match self.parts.get_mut(number as usize) {
            Some(place) => *place = *part,
            None => self.parts.push(*part),
        }
        self.order.push(Rank { most: part.most, number });
    }

    /// Looks at a triangle. Returns a triangle of the other surface near it.
    fn triangle(
        &mut self,
        corners: [DVec3; 3],
        near: u32,
        to: &impl Surface,
        patience: u32,
    ) -> u32 {
        let bound = self.bound();
        if bound.is_within(corners, near, to) {
            self.closed = self.closed.max(bound.allowed);
            return near;
        }
        let part = Part::new(Polygon::triangle(corners), near, to, bound, patience);
        self.take(&part);
        part.0.near
    }

    /// Divides parts until all are near enough or `most` boxes were opened.
    fn explore(&mut self, to: &impl Surface, most: u64) {
        while self.opened < most {
            let Some(part) = self.pop() else { return };
            let bound = self.bound();
            let mut divided = std::mem::take(&mut self.divided);
            part.divide(to, bound, &mut self.around, |part| divided.push(part));
            divided.drain(..).for_each(|part| self.take(&part));
            self.divided = divided;
        }
    }

    /// Takes over what another search has found and left.
    fn join(&mut self, mut other: Self) {
        self.least = self.least.max(other.least);
        self.closed = self.closed.max(other.closed);
        self.opened += other.opened;
        while let Some(part) = other.pop() {
            self.take(&(part, SearchResult { distance: 0.0, opened: 0 }));
        }
        self.closed = self.closed.max(other.closed);
    }

    /// Returns the part that may be farthest; none if all that are left are near enough.
    fn pop(&mut self) -> Option<Part> {
        let Rank { most, number } = self.order.pop()?;
        if most <= self.bound().allowed {
            // All others are nearer.
            self.closed = self.closed.max(most);
            self.order.clear();
            return None;
        }
        self.free.push(number);
        Some(self.parts[number as usize])
    }

    /// The parts to be looked at next, the farthest first.
    fn next(&mut self, count: usize) -> Vec<Part> {
        std::iter::from_fn(|| self.pop()).take(count).collect()
    }

    fn bounds(&self) -> Farthest {
        let open = self.order.peek().map_or(0.0, |rank| rank.most);
        let most = self.least.max(self.closed).max(open);
        Farthest { least: self.least, most, opened: self.opened }
    }
}

/// A part of a surface.
#[derive(Clone, Copy, Debug)]
struct Part {
    polygon: Polygon,
    /// A triangle of the other surface near its middle.
    near: u32,
    /// No point of it is farther than this.
    most: f64,
}

impl Part {
    /// A part with the distance of its middle, as far as it matters. `hint` is a triangle that is
    /// probably near.
    fn new(
        polygon: Polygon,
        hint: u32,
        to: &impl Surface,
        bound: Bound,
        patience: u32,
    ) -> (Self, SearchResult) {
        let (middle, radius) = polygon.disc();
        let enough = (bound.allowed - radius).max(NEAR * bound.allowed);
        let (near, found) = ask(middle, hint, to, enough, patience);
        let mut most = near.squared.sqrt() + radius;
        if most > bound.allowed && near.triangle != NONE {
            most = most.min(polygon.farthest_corner(to.corners(near.triangle)).0);
        }
        (Self { polygon, near: near.triangle, most: most.max(found.distance) }, found)
    }

    /// Calls `add` with the parts that it falls into, with what was found there. `around` is room
    /// for them.
    fn divide(
        &self,
        to: &impl Surface,
        bound: Bound,
        around: &mut Vec<Polygon>,
        mut add: impl FnMut((Self, SearchResult)),
    ) {
        let triangle = to.corners(self.near);
        let inside = self.polygon.near(triangle, 0.999 * bound.allowed, bound.slack, around);
        let mut most = inside.farthest_corner(triangle).0;
        // Of a line nothing would be cut off.
        let is_cut = most <= bound.allowed && inside.area() > WORTH_CUTTING * self.polygon.area();
        let (far, corner) = self.polygon.farthest_corner(triangle);
        let found = match far > bound.least && (!is_cut || far <= PROMISING * bound.least) {
            true => ask(corner, self.near, to, bound.least, PATIENCE[1]).1,
            false => SearchResult { distance: 0.0, opened: 0 },
        };
        if !is_cut {
            around.clear();
            // What is no larger than a rounding error stays as it is.
            let is_small = self.polygon.disc().1 <= bound.slack;
            most = if is_small { self.most } else { 0.0 };
            if !is_small {
                around.extend(self.polygon.halves());
            }
        }
        let mut part = |polygon: Polygon| {
            if polygon.has_area() {
                add(Self::new(polygon, self.near, to, bound, PATIENCE[1]));
            }
        };
        for polygon in around.drain(..) {
            if polygon.is_simple() {
                part(polygon);
            } else {
                polygon.simple().into_iter().for_each(&mut part);
            }
        }
        add((Self { polygon: Polygon::EMPTY, near: self.near, most }, found));
    }
}

/// Looks for a triangle near a point, or the first within a distance `enough`. What is found is the
/// distance, unless it is within that or the search ended early: then it may be smaller.
fn ask(p: DVec3, hint: u32, to: &impl Surface, enough: f64, patience: u32) -> (Hit, SearchResult) {
    let (near, opened) = to.near(p, hint, enough * enough, patience);
    let is_sure = opened < patience && near.squared > enough * enough;
    let distance = if is_sure { near.squared.sqrt() } else { 0.0 };
    (near, SearchResult { distance, opened })
}

/// The place of a part in the order: the farthest first.
#[derive(Clone, Copy, Debug)]
struct Rank {
    most: f64,
    number: u32,
}

impl Ord for Rank {
    fn cmp(&self, other: &Self) -> Ordering {
        self.most.total_cmp(&other.most).then(other.number.cmp(&self.number))
    }
}

impl PartialOrd for Rank {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Eq for Rank {}

impl PartialEq for Rank {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TriangleTree;

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
