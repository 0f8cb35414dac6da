//! How far the farthest point of one surface is from another, between a lower and an upper bound.
//!
//! Branch and bound (as Guthe, Borodin and Klein 2005), the part that may be farthest first. A part
//! is a convex polygon. Its distance from one triangle is a convex function, so it is largest at a
//! corner: a part whose corners are near enough to one triangle is closed. Of any other part, the
//! region is cut off that is near enough to the triangle next to its middle: over the triangle, and
//! as far around it as the distance allows. The remaining pieces are compared with the triangles
//! beside it. So flat regions end exactly, and it is decided whether triangles cover a part, where
//! bisection alone would go on for ever along common edges.

use crate::moving::Hit;
use crate::polygon::Polygon;
use crate::surface::Surface;
use crate::triangle::is_within;
use glam::DVec3;
use lodc_mesh::NONE;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Rows of triangles in a batch that is searched in parallel, and triangles in a row, searched one
/// after the other. Results depend on these, not on the number of threads. Chosen by hand.
const ROWS_PER_BATCH: usize = 512;
const TRIANGLES_PER_ROW: usize = 32;

/// Triangles, spread evenly, whose middles are looked up first, for a lower bound. Chosen by hand.
const INITIAL_TRIANGLES: usize = 1_024;

/// A part is cut if at least this share of it is near the triangle next to its middle, else halved.
/// Chosen by hand.
const WORTH_CUTTING: f64 = 0.125;

/// A search for a triangle to cut a part by ends at one within this share of the bound. Chosen by
/// hand.
const NEAR_SHARE: f64 = 0.25;

/// The distance of a cut part's farthest corner is looked up where it is at most this many times
/// the lower bound: farther ones more often have another triangle that is nearer. Chosen by hand.
const PROMISING: f64 = 1.5;

/// Boxes that the search for the triangle near one point may open: at first, and for a part that
/// may be farthest. Chosen by hand.
const PATIENCE: [u32; 2] = [128, 4_096];

/// Boxes that may be opened for a triangle before all others had their turn. Chosen by hand.
const BOXES_PER_TRIANGLE: u64 = 2_000;

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
        let mut state = SearchState::new(*self, least);
        let bound = state.bound();
        // A bound to begin with, where none is known.
        let stride = if least > 0.0 { from.len() } else { (from.len() / INITIAL_TRIANGLES).max(1) };
        let initial = |row: &[[DVec3; 3]]| {
            let part = Part::new(Polygon::triangle(row[0]), NONE, to, bound, PATIENCE[0]);
            part.1
        };
        let results: Vec<SearchResult> = from.par_chunks(stride).map(initial).collect();
        results.into_iter().for_each(|results| state.record(results));
        for batch in from.chunks(ROWS_PER_BATCH * TRIANGLES_PER_ROW) {
            let row = |row: &[[DVec3; 3]]| {
                let mut state = SearchState::new(*self, state.least);
                let mut near = NONE;
                for &corners in row {
                    near = state.triangle(corners, near, to, PATIENCE[0]);
                    state.explore(to, state.opened + BOXES_PER_TRIANGLE);
                }
                state
            };
            let rows: Vec<SearchState> = batch.par_chunks(TRIANGLES_PER_ROW).map(row).collect();
            rows.into_iter().for_each(|row| state.join(row));
        }
        let [each, besides] = self.boxes.map(u64::from);
        let max_opened = state.opened + each * from.len() as u64 + besides;
        while state.opened < max_opened {
            let next = state.next(ROWS_PER_BATCH);
            if next.is_empty() {
                break;
            }
            let bound = state.bound();
            let divide = |part: &Part| {
                let mut parts = Vec::new();
                part.divide(to, bound, &mut Vec::new(), |part| parts.push(part));
                parts
            };
            let parts: Vec<Vec<(Part, SearchResult)>> = next.par_iter().map(divide).collect();
            parts.iter().flatten().for_each(|part| state.add_part(part));
        }
        state.bounds()
    }
}

/// Looks for points beyond a bound in one triangle after the other, on the thread that asks.
#[derive(Clone, Debug)]
pub struct Seeker(SearchState);

impl Seeker {
    /// One that searches as `search` says.
    #[must_use]
    pub fn new(search: Search) -> Self {
        Self(SearchState::new(search, 0.0))
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
        let Self(state) = self;
        state.clear(least);
        state.triangle(corners, near, to, PATIENCE[1]);
        state.explore(to, boxes);
        state.bounds()
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

/// What the search at one point found.
#[derive(Clone, Copy, Debug)]
struct SearchResult {
    /// The point is that far from the other surface; 0 if that is not known for sure.
    distance: f64,
    opened: u32,
}

/// The parts that may have a point farther than any found.
#[derive(Clone, Debug)]
struct SearchState {
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
    /// Kept to save allocating.
    pieces: Vec<Polygon>,
    divided: Vec<(Part, SearchResult)>,
}

impl SearchState {
    fn new(search: Search, least: f64) -> Self {
        Self {
            search,
            least,
            closed: 0.0,
            opened: 0,
            order: BinaryHeap::new(),
            parts: vec![],
            free: vec![],
            pieces: vec![],
            divided: vec![],
        }
    }

    /// Starts another search.
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

    fn record(&mut self, found: SearchResult) {
        self.least = self.least.max(found.distance);
        self.opened += u64::from(found.opened) + 1;
    }

    /// Adds a part with what was found in it, or closes it if it is near enough.
    fn add_part(&mut self, (part, found): &(Part, SearchResult)) {
        self.record(*found);
        if part.most <= self.bound().allowed || !part.polygon.has_area() {
            self.closed = self.closed.max(part.most);
            return;
        }
        let number = self.free.pop().unwrap_or(self.parts.len() as u32);
        match self.parts.get_mut(number as usize) {
            Some(slot) => *slot = *part,
            None => self.parts.push(*part),
        }
        self.order.push(Rank { most: part.most, number });
    }

    /// Adds a triangle as a part. Returns a triangle of the other surface near it.
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
        self.add_part(&part);
        part.0.near
    }

    /// Divides parts until all are near enough or `most` boxes were opened.
    fn explore(&mut self, to: &impl Surface, most: u64) {
        while self.opened < most {
            let Some(part) = self.pop() else { return };
            let bound = self.bound();
            let mut divided = std::mem::take(&mut self.divided);
            part.divide(to, bound, &mut self.pieces, |part| divided.push(part));
            divided.drain(..).for_each(|part| self.add_part(&part));
            self.divided = divided;
        }
    }

    /// Adds the results and the open parts of another search.
    fn join(&mut self, mut other: Self) {
        self.least = self.least.max(other.least);
        self.closed = self.closed.max(other.closed);
        self.opened += other.opened;
        while let Some(part) = other.pop() {
            self.add_part(&(part, SearchResult { distance: 0.0, opened: 0 }));
        }
        self.closed = self.closed.max(other.closed);
    }

    /// Returns the part that may be farthest; none if all open ones are near enough.
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
        let state = self.order.peek().map_or(0.0, |rank| rank.most);
        let most = self.least.max(self.closed).max(state);
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
        let enough = (bound.allowed - radius).max(NEAR_SHARE * bound.allowed);
        let (near, found) = find_near(middle, hint, to, enough, patience);
        let mut most = near.squared.sqrt() + radius;
        if most > bound.allowed && near.triangle != NONE {
            most = most.min(polygon.farthest_corner(to.corners(near.triangle)).0);
        }
        (Self { polygon, near: near.triangle, most: most.max(found.distance) }, found)
    }

    /// Divides it: calls `add` with the new parts, and with what was found at their middles.
    /// `pieces` is kept to save allocating.
    fn divide(
        &self,
        to: &impl Surface,
        bound: Bound,
        pieces: &mut Vec<Polygon>,
        mut add: impl FnMut((Self, SearchResult)),
    ) {
        let triangle = to.corners(self.near);
        let inside = self.polygon.split_near(triangle, 0.999 * bound.allowed, bound.slack, pieces);
        let mut most = inside.farthest_corner(triangle).0;
        // Of a line nothing would be cut off.
        let is_cut = most <= bound.allowed && inside.area() > WORTH_CUTTING * self.polygon.area();
        let (distance, corner) = self.polygon.farthest_corner(triangle);
        let found = match distance > bound.least && (!is_cut || distance <= PROMISING * bound.least)
        {
            true => find_near(corner, self.near, to, bound.least, PATIENCE[1]).1,
            false => SearchResult { distance: 0.0, opened: 0 },
        };
        if !is_cut {
            pieces.clear();
            // What is no larger than a rounding error stays as it is.
            let is_small = self.polygon.disc().1 <= bound.slack;
            most = if is_small { self.most } else { 0.0 };
            if !is_small {
                pieces.extend(self.polygon.halves());
            }
        }
        let mut part = |polygon: Polygon| {
            if polygon.has_area() {
                add(Self::new(polygon, self.near, to, bound, PATIENCE[1]));
            }
        };
        for polygon in pieces.drain(..) {
            if polygon.is_simple() {
                part(polygon);
            } else {
                polygon.split().into_iter().for_each(&mut part);
            }
        }
        add((Self { polygon: Polygon::EMPTY, near: self.near, most }, found));
    }
}

/// Returns the triangle nearest to a point, or the first one within a distance `enough`; and the
/// distance, 0 where it is not sure: within `enough`, or after a search that ended early.
fn find_near(
    p: DVec3,
    hint: u32,
    to: &impl Surface,
    enough: f64,
    patience: u32,
) -> (Hit, SearchResult) {
    let (near, opened) = to.near(p, hint, enough * enough, patience);
    let is_sure = opened < patience && near.squared > enough * enough;
    let distance = if is_sure { near.squared.sqrt() } else { 0.0 };
    (near, SearchResult { distance, opened })
}

/// The priority of a part: the farthest first.
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
