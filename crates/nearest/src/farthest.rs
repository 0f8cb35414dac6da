//! How far the farthest point of one surface is from another, between a lower and an upper bound.
//!
//! Branch and bound (as Guthe, Borodin and Klein 2005), the part that may be farthest first. A part
//! is a convex polygon. Its distance from one triangle is a convex function, so it is largest at a
//! corner: a part whose corners are all near enough to one triangle is done. Of any other part, the
//! region is cut off that is near enough to the triangle found near its middle: above and below the
//! triangle, and as far around it as the distance allows. What is left is compared with other
//! triangles. So flat regions end exactly, and it is decided whether triangles cover a part, where
//! bisection alone would go on for ever along common edges.

use crate::moving::{Hit, Query};
use crate::polygon::Polygon;
use crate::surface::Surface;
use crate::triangle::is_within;
use glam::DVec3;
use lodc_mesh::NONE;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Rows of triangles in a batch that is searched in parallel, and triangles in a row, searched one
/// after the other; later as many parts as rows are divided in parallel. Results depend on these,
/// not on the number of threads. Chosen by hand.
const ROWS_PER_BATCH: usize = 512;
const TRIANGLES_PER_ROW: usize = 32;

/// Triangles found near others of a row before that one is tried on. Chosen by hand.
const RECENT_TRIANGLES: usize = 4;

/// Triangles, spread evenly, whose middles are measured first, for a lower bound. Chosen by hand.
const INITIAL_TRIANGLES: usize = 1_024;

/// A part is cut if at least this share of it is near enough to the triangle near its middle, else
/// halved. Chosen by hand.
const WORTH_CUTTING: f64 = 0.125;

/// A search for a triangle to cut a part by ends at one within this share of the accepted distance.
/// Chosen by hand.
const NEAR_SHARE: f64 = 0.25;

/// The distance of a cut part's farthest corner from the whole surface is measured where it is at
/// most this many times the lower bound from the part's triangle: farther ones more often have
/// another triangle that is nearer. Chosen by hand.
const MEASURED_CORNER_RATIO: f64 = 1.5;

/// Boxes that the search for the triangle near one point may open: at first, and for a part that
/// may be farthest. Chosen by hand.
const MAX_BOXES_AT_FIRST: u32 = 128;
const MAX_BOXES: u32 = 4_096;

/// Boxes that may be opened for a triangle before all others had their turn. Chosen by hand.
const FIRST_TURN_BOXES: u64 = 2_000;

/// Distances below this share of the floor are rounding errors. Chosen by hand.
const SLACK_OF_FLOOR: f64 = 0.1;

/// Parts are cut at this share of the accepted distance, so that rounding leaves what is cut off
/// within it. Chosen by hand.
const CUT_SHARE: f64 = 0.999;

/// Bounds of the largest distance of any point of a surface from another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Farthest {
    /// A point is at least this far off, or this distance was known before.
    pub lower: f64,
    /// No point is farther.
    pub upper: f64,
    /// Boxes of the tree that were opened, and parts: the work that it took.
    pub opened_boxes: u64,
}

/// How a search for the point of one surface that is farthest from another ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarthestSearch {
    /// The upper bound may exceed the lower one by this share of it.
    pub tolerance: f64,
    /// Distances up to this count as 0.
    pub floor: f64,
    /// Boxes of the tree that may be opened after each triangle had its first turn: this many times
    /// the number of triangles, and so many more. Beyond, the bounds stay apart.
    pub boxes: [u32; 2],
}

impl FarthestSearch {
    /// Within 2 %; distances up to a billionth of `length`, the diagonal of the surfaces, count as
    /// 0; 2,000 boxes a triangle and three million more.
    #[must_use]
    pub fn for_size(length: f64) -> Self {
        Self { tolerance: 0.02, floor: 1e-9 * length, boxes: [2_000, 3_000_000] }
    }

    /// Returns the upper bound that is good enough where a distance of `lower` is known: nothing is
    /// searched up to it.
    #[must_use]
    pub fn accepted(&self, lower: f64) -> f64 {
        lower * (1.0 + self.tolerance) + self.floor
    }

    /// Looks for the point of `from` that is farthest from `to`. Infinite if only `to` is empty.
    #[must_use]
    pub fn farthest(&self, from: &[[DVec3; 3]], to: &(impl Surface + Sync)) -> Farthest {
        self.farthest_beyond(0.0, from, to)
    }

    /// The same where a distance is known already: of a point of this surface, or of any other that
    /// the bounds are for, too. Nearer points are not searched for.
    #[must_use]
    pub fn farthest_beyond(
        &self,
        known_distance: f64,
        from: &[[DVec3; 3]],
        to: &(impl Surface + Sync),
    ) -> Farthest {
        self.farthest_with_hints(known_distance, from.len(), |i| (from[i], NONE), to)
    }

    /// The same for `count` triangles, neighbours near each other, of which `from` returns the
    /// corners and a triangle of the other surface that is probably near, or [`NONE`].
    #[must_use]
    pub fn farthest_with_hints(
        &self,
        known_distance: f64,
        count: usize,
        from: impl Fn(usize) -> ([DVec3; 3], u32) + Sync,
        to: &(impl Surface + Sync),
    ) -> Farthest {
        if count == 0 {
            return Farthest { lower: known_distance, upper: known_distance, opened_boxes: 0 };
        }
        let point = from(0).0[0];
        let any = Query { point, hint: NONE, enough: f64::MAX, max_boxes: MAX_BOXES_AT_FIRST };
        if to.near(any).0.triangle == NONE {
            return Farthest { lower: f64::INFINITY, upper: f64::INFINITY, opened_boxes: 0 };
        }
        let mut state = SearchState::new(*self, known_distance);
        if known_distance == 0.0 {
            let limits = state.limits();
            let stride = (count / INITIAL_TRIANGLES).max(1);
            let initial = |i: usize| {
                let (corners, hint) = from(i * stride);
                Part::measure(Polygon::triangle(corners), hint, to, limits, MAX_BOXES_AT_FIRST).1
            };
            let initial: Vec<Measured> =
                (0..count.div_ceil(stride)).into_par_iter().map(initial).collect();
            initial.into_iter().for_each(|measured| state.record(measured));
        }
        let batch_triangles = ROWS_PER_BATCH * TRIANGLES_PER_ROW;
        for first in (0..count).step_by(batch_triangles) {
            let end = (first + batch_triangles).min(count);
            let row = |start: usize| {
                let mut state = SearchState::new(*self, state.lower);
                // Triangles that were near the last ones, the latest first; the hint comes before.
                let mut hints = [NONE; RECENT_TRIANGLES + 1];
                for i in start..(start + TRIANGLES_PER_ROW).min(end) {
                    let (corners, hint) = from(i);
                    hints[0] = hint;
                    if let Some(near) = state.add_triangle(corners, &hints, to, MAX_BOXES_AT_FIRST)
                    {
                        hints[1..].rotate_right(1);
                        hints[1] = near;
                    }
                    state.divide_parts(to, state.opened_boxes + FIRST_TURN_BOXES);
                }
                state
            };
            let starts: Vec<usize> = (first..end).step_by(TRIANGLES_PER_ROW).collect();
            let rows: Vec<SearchState> = starts.into_par_iter().map(row).collect();
            rows.into_iter().for_each(|row| state.join(row));
        }
        let [per_triangle, more] = self.boxes.map(u64::from);
        let max_boxes = state.opened_boxes + per_triangle * count as u64 + more;
        while state.opened_boxes < max_boxes {
            let farthest_parts = state.pop_parts(ROWS_PER_BATCH);
            if farthest_parts.is_empty() {
                break;
            }
            let limits = state.limits();
            let divide = |part: &Part| {
                let mut parts = Vec::new();
                part.divide(to, limits, &mut Vec::new(), |part| parts.push(part));
                parts
            };
            let parts: Vec<Vec<(Part, Measured)>> = farthest_parts.par_iter().map(divide).collect();
            parts.iter().flatten().for_each(|part| state.add_part(part));
        }
        state.bounds()
    }
}

/// Looks for points beyond a distance in one triangle after the other, on the calling thread.
/// Allocates less than a [`FarthestSearch`] for each would.
#[derive(Clone, Debug)]
pub struct TriangleSearcher(SearchState);

impl TriangleSearcher {
    /// Makes one with the tolerance and the floor of `search`; its `boxes` do not count.
    #[must_use]
    pub fn new(search: FarthestSearch) -> Self {
        Self(SearchState::new(search, 0.0))
    }

    /// Looks for a point of a triangle that is farther from `to` than `known_distance`, the least
    /// that is returned. `hint` is a triangle that is probably near, or [`NONE`]. When `max_boxes`
    /// are opened, the bounds stay apart.
    pub fn search(
        &mut self,
        known_distance: f64,
        corners: [DVec3; 3],
        hint: u32,
        to: &impl Surface,
        max_boxes: u64,
    ) -> Farthest {
        let Self(state) = self;
        state.clear(known_distance);
        state.add_triangle(corners, &[hint], to, MAX_BOXES);
        state.divide_parts(to, max_boxes);
        state.bounds()
    }
}

/// Distances that decide what is done with a part.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// The largest distance found.
    lower: f64,
    /// The upper bound that is good enough: nothing is searched up to it.
    accepted: f64,
    /// Distances below this are rounding errors.
    slack: f64,
}

impl Limits {
    /// Returns whether a triangle of the other surface is near enough to all of a triangle.
    fn accept(&self, corners: [DVec3; 3], near: u32, to: &impl Surface) -> bool {
        near != NONE && {
            let triangle = to.corners(near);
            corners.iter().all(|&c| is_within(c, triangle, self.accepted * self.accepted))
        }
    }
}

/// The distance of one point from the other surface.
#[derive(Clone, Copy, Debug)]
struct Measured {
    /// 0 if the exact distance is not known.
    distance: f64,
    opened_boxes: u32,
}

impl Measured {
    const NOTHING: Self = Self { distance: 0.0, opened_boxes: 0 };
}

/// The parts that may have a point farther than any found, and what was found.
#[derive(Clone, Debug)]
struct SearchState {
    search: FarthestSearch,
    /// The largest distance found.
    lower: f64,
    /// No point of the parts that are done is farther than this.
    done_upper: f64,
    /// Boxes that were opened, and parts.
    opened_boxes: u64,
    queue: BinaryHeap<QueueEntry>,
    /// Parts by their index in queue entries, and indices that are free.
    parts: Vec<Part>,
    free_indices: Vec<u32>,
    /// Buffers.
    pieces: Vec<Polygon>,
    divided: Vec<(Part, Measured)>,
}

impl SearchState {
    fn new(search: FarthestSearch, known_distance: f64) -> Self {
        Self {
            search,
            lower: known_distance,
            done_upper: 0.0,
            opened_boxes: 0,
            queue: BinaryHeap::new(),
            parts: vec![],
            free_indices: vec![],
            pieces: vec![],
            divided: vec![],
        }
    }

    /// Starts another search.
    fn clear(&mut self, known_distance: f64) {
        (self.lower, self.done_upper, self.opened_boxes) = (known_distance, 0.0, 0);
        self.queue.clear();
        self.parts.clear();
        self.free_indices.clear();
    }

    fn limits(&self) -> Limits {
        let Self { search, lower, .. } = self;
        Limits {
            lower: *lower,
            accepted: search.accepted(*lower),
            slack: SLACK_OF_FLOOR * search.floor,
        }
    }

    fn record(&mut self, measured: Measured) {
        self.lower = self.lower.max(measured.distance);
        self.opened_boxes += u64::from(measured.opened_boxes) + 1;
    }

    /// Adds a part and the distance of a point of it; it is done if it is near enough.
    fn add_part(&mut self, (part, measured): &(Part, Measured)) {
        self.record(*measured);
        if part.upper <= self.limits().accepted || !part.polygon.has_area() {
            self.done_upper = self.done_upper.max(part.upper);
            return;
        }
        let index = self.free_indices.pop().unwrap_or(self.parts.len() as u32);
        match self.parts.get_mut(index as usize) {
            Some(slot) => *slot = *part,
            None => self.parts.push(*part),
        }
        self.queue.push(QueueEntry { upper: part.upper, index });
    }

    /// Adds a triangle as a part. `hints` are triangles that are probably near, or [`NONE`].
    /// Returns a triangle of the other surface near it, if none of the hints was near enough.
    fn add_triangle(
        &mut self,
        corners: [DVec3; 3],
        hints: &[u32],
        to: &impl Surface,
        max_boxes: u32,
    ) -> Option<u32> {
        let limits = self.limits();
        if hints.iter().any(|&hint| limits.accept(corners, hint, to)) {
            self.done_upper = self.done_upper.max(limits.accepted);
            return None;
        }
        let hint = hints.iter().copied().find(|&hint| hint != NONE).unwrap_or(NONE);
        let part = Part::measure(Polygon::triangle(corners), hint, to, limits, max_boxes);
        self.add_part(&part);
        Some(part.0.near_triangle)
    }

    /// Divides parts, the farthest first, until all are near enough or `max_boxes` were opened.
    fn divide_parts(&mut self, to: &impl Surface, max_boxes: u64) {
        while self.opened_boxes < max_boxes {
            let Some(part) = self.pop() else { return };
            let limits = self.limits();
            let mut divided = std::mem::take(&mut self.divided);
            part.divide(to, limits, &mut self.pieces, |part| divided.push(part));
            divided.drain(..).for_each(|part| self.add_part(&part));
            self.divided = divided;
        }
    }

    /// Adds the results and the parts of another search.
    fn join(&mut self, mut other: Self) {
        self.lower = self.lower.max(other.lower);
        self.done_upper = self.done_upper.max(other.done_upper);
        self.opened_boxes += other.opened_boxes;
        while let Some(part) = other.pop() {
            self.add_part(&(part, Measured::NOTHING));
        }
        // The last `pop` may have raised it.
        self.done_upper = self.done_upper.max(other.done_upper);
    }

    /// Removes the part that may be farthest; `None` if all parts are near enough.
    fn pop(&mut self) -> Option<Part> {
        let QueueEntry { upper, index } = self.queue.pop()?;
        if upper <= self.limits().accepted {
            // All others are nearer.
            self.done_upper = self.done_upper.max(upper);
            self.queue.clear();
            return None;
        }
        self.free_indices.push(index);
        Some(self.parts[index as usize])
    }

    /// Removes up to `count` parts, the farthest first.
    fn pop_parts(&mut self, count: usize) -> Vec<Part> {
        std::iter::from_fn(|| self.pop()).take(count).collect()
    }

    fn bounds(&self) -> Farthest {
        let queue_upper = self.queue.peek().map_or(0.0, |entry| entry.upper);
        let upper = self.lower.max(self.done_upper).max(queue_upper);
        Farthest { lower: self.lower, upper, opened_boxes: self.opened_boxes }
    }
}

/// A part of a surface.
#[derive(Clone, Copy, Debug)]
struct Part {
    polygon: Polygon,
    /// A triangle of the other surface near its middle.
    near_triangle: u32,
    /// No point of it is farther from the other surface than this.
    upper: f64,
}

impl Part {
    /// Returns a part and the distance of its middle. `hint` is a triangle that is probably near.
    fn measure(
        polygon: Polygon,
        hint: u32,
        to: &impl Surface,
        limits: Limits,
        max_boxes: u32,
    ) -> (Self, Measured) {
        let (middle, radius) = polygon.disc();
        let enough = (limits.accepted - radius).max(NEAR_SHARE * limits.accepted);
        let (near, measured) = measure_point(middle, hint, to, enough, max_boxes);
        let mut upper = near.squared.sqrt() + radius;
        if upper > limits.accepted && near.triangle != NONE {
            upper = upper.min(polygon.farthest_corner(to.corners(near.triangle)).0);
        }
        let upper = upper.max(measured.distance);
        (Self { polygon, near_triangle: near.triangle, upper }, measured)
    }

    /// Divides it: calls `add` with the new parts, each with the distance of a point. `pieces` is a
    /// buffer.
    fn divide(
        &self,
        to: &impl Surface,
        limits: Limits,
        pieces: &mut Vec<Polygon>,
        mut add: impl FnMut((Self, Measured)),
    ) {
        let triangle = to.corners(self.near_triangle);
        let cut_distance = CUT_SHARE * limits.accepted;
        let near_part = self.polygon.split_near(triangle, cut_distance, limits.slack, pieces);
        let mut done_upper = near_part.farthest_corner(triangle).0;
        // A polygon without area is never cut.
        let is_cut = done_upper <= limits.accepted
            && near_part.double_area() > WORTH_CUTTING * self.polygon.double_area();
        let (distance, corner) = self.polygon.farthest_corner(triangle);
        let is_promising = distance > limits.lower
            && (!is_cut || distance <= MEASURED_CORNER_RATIO * limits.lower);
        let measured_corner = if is_promising {
            measure_point(corner, self.near_triangle, to, limits.lower, MAX_BOXES).1
        } else {
            Measured::NOTHING
        };
        if !is_cut {
            pieces.clear();
            // What is no larger than a rounding error is done.
            let is_small = self.polygon.disc().1 <= limits.slack;
            done_upper = if is_small { self.upper } else { 0.0 };
            if !is_small {
                pieces.extend(self.polygon.halves(triangle));
            }
        }
        let mut add_polygon = |polygon: Polygon| {
            if polygon.has_area() {
                add(Self::measure(polygon, self.near_triangle, to, limits, MAX_BOXES));
            }
        };
        for polygon in pieces.drain(..) {
            if polygon.is_simple() {
                add_polygon(polygon);
            } else {
                polygon.split().into_iter().for_each(&mut add_polygon);
            }
        }
        // What is done, as a part of no area.
        let done = Self { polygon: Polygon::EMPTY, upper: done_upper, ..*self };
        add((done, measured_corner));
    }
}

/// Returns the triangle nearest to a point, or the first one within a distance `enough`; and the
/// distance if it is exact: beyond `enough`, and from a search that was not cut short.
fn measure_point(
    point: DVec3,
    hint: u32,
    to: &impl Surface,
    enough: f64,
    max_boxes: u32,
) -> (Hit, Measured) {
    let (near, opened_boxes) = to.near(Query { point, hint, enough: enough * enough, max_boxes });
    let is_exact = opened_boxes < max_boxes && near.squared > enough * enough;
    let distance = if is_exact { near.squared.sqrt() } else { 0.0 };
    (near, Measured { distance, opened_boxes })
}

/// A part in the queue: the one that may be farthest comes first.
#[derive(Clone, Copy, Debug)]
struct QueueEntry {
    upper: f64,
    /// Of the part.
    index: u32,
}

impl Ord for QueueEntry {
    fn cmp(&self, other: &Self) -> Ordering {
        self.upper.total_cmp(&other.upper).then(other.index.cmp(&self.index))
    }
}

impl PartialOrd for QueueEntry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Eq for QueueEntry {}

impl PartialEq for QueueEntry {
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
            let Farthest { lower, upper, .. } =
                FarthestSearch::for_size(1.0).farthest(from, &tree(to));
            assert!(
                (lower - far).abs() < 1e-9 && (far - 1e-9..=1.02 * far + 1e-9).contains(&upper)
            );
        }
    }

    #[test]
    fn one_plane_divided_in_two_ways_is_nowhere_apart() {
        // Bisection alone would go on along all edges.
        let (a, b) = (sheet(7, |x, y| 0.3 * x + 0.1 * y), sheet(5, |x, y| 0.3 * x + 0.1 * y));
        let search = FarthestSearch::for_size(1.0);
        let found = search.farthest(&a, &tree(&b));
        assert!(found.upper <= 2e-9, "{found:?}");
        assert!(search.farthest(&b, &tree(&a)).upper <= 2e-9);
    }

    #[test]
    fn a_hole_between_samples_is_found() {
        let whole = sheet(1, |_, _| 0.0);
        let mut holed = sheet(40, |_, _| 0.0);
        holed.remove(1234);
        let Farthest { lower, upper, .. } =
            FarthestSearch::for_size(1.0).farthest(&whole, &tree(&holed));
        // The radius of the circle in a triangle with two sides of 1/40.
        let radius = (2.0 - 2.0f64.sqrt()) / 2.0 / 40.0;
        assert!(lower <= radius * 1.0001 && upper >= radius * 0.9999, "{lower} {upper} {radius}");
        assert!(upper <= 1.03 * lower, "{lower} {upper}");
    }

    #[test]
    fn a_thin_strip_that_stands_on_slivers_is_divided_along_its_length() {
        // Each sliver is seen from its edge: halves across that never get shorter.
        let sliver = |i: u32| {
            let x = f64::from(i) / 20.0;
            [[-1.0, 0.0], [1.0, 0.0], [0.0, 0.01]].map(|[y, z]| DVec3::new(x, y, z))
        };
        let slivers: Vec<[DVec3; 3]> = (0..=20).map(sliver).collect();
        for width in [0.0, 1e-12, 1e-6] {
            let [a, b, c] = [[0.0, 0.0], [1.0, 0.0], [1.0, width]];
            let strip = [a, b, c].map(|[x, z]| DVec3::new(x, 0.0, z));
            let found = FarthestSearch::for_size(1.0).farthest(&[strip], &tree(&slivers));
            assert!(found.opened_boxes < 2_000, "{width}: {found:?}");
            assert!(found.upper < 0.026 && found.lower > 0.024, "{width}: {found:?}");
        }
    }

    #[test]
    fn bounds_hold_for_random_triangles() {
        let mut random = lodc_mesh::SplitMix64::new(3);
        for round in 0..60 {
            let mut point = || DVec3::from_array([0; 3].map(|_| f64::from(random.unit())));
            let mut some = |n: usize| (0..n).map(|_| [0; 3].map(|_| point())).collect::<Vec<_>>();
            let (from, to) = (some(1 + round % 5), some(1 + round / 5));
            let tree = tree(&to);
            let Farthest { lower, upper, .. } =
                FarthestSearch::for_size(1.0).farthest(&from, &tree);
            assert!(lower <= upper && upper <= 1.021 * lower + 1e-8, "{round}: {lower} {upper}");
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
            assert!(seen <= upper + 1e-12, "{round}: {seen} {upper}");
            assert!(seen >= 0.9 * lower, "{round}: {seen} {lower}");
        }
    }
}
