//! Polygons to triangles: a fan where that is right, otherwise ear clipping in the plane that fits
//! best.
//!
//! Ear clipping after G. H. Meisters, "Polygons have ears" (1975). A polygon of n corners always
//! gives n − 2 triangles, whatever it looks like, and always the same ones.

/// Tests of a point against a triangle that any polygon may take. With those per corner, chosen by
/// hand: real polygons stay far below, and a crafted one of n corners takes no time of n².
const BASE_TESTS: u64 = 4_000_000;
/// Tests that it may take for each of its corners.
const TESTS_PER_CORNER: u64 = 200;

/// The corners of each triangle, as indices into the polygon.
type Triangles = Vec<[u32; 3]>;

/// Triangulates polygons; keeps its memory between them.
#[derive(Debug, Default)]
pub(super) struct Triangulator {
    /// The corners of the polygon in its plane.
    points: Vec<[f64; 2]>,
    /// The corners after and before each, of those that have not been clipped.
    next: Vec<u32>,
    previous: Vec<u32>,
    /// Corners that are not strictly convex: only they can lie in an ear.
    reflex: Vec<u32>,
    is_reflex: Vec<bool>,
    /// True if a corner is listed in `reflex`, whether it still is reflex or not.
    is_listed: Vec<bool>,
    /// Remaining tests of a point against a triangle. A polygon that needs more is finished as a
    /// fan.
    budget: u64,
    /// The result.
    triangles: Triangles,
    /// Polygons that did not come out as a set of triangles that all turn the right way.
    pub(super) imperfect: u64,
}

/// What is accepted as an ear; tried in this order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Tolerance {
    /// Positive area, no other corner in it or on its edges.
    Strict,
    /// Positive area, no other corner strictly inside.
    Touching,
    /// No area, corners all on a line.
    Flat,
    /// Anything.
    Any,
}

impl Triangulator {
    /// The triangles of a polygon of at least three corners.
    pub(super) fn triangulate(&mut self, corners: &[[f32; 3]]) -> &[[u32; 3]] {
        self.triangles.clear();
        let n = corners.len() as u32;
        if n == 3 {
            self.triangles.push([0, 1, 2]);
            return &self.triangles;
        }
        self.project(corners);
        if (1..n - 1).all(|i| self.area(0, i, i + 1) > 0.0) {
            self.triangles.extend((1..n - 1).map(|i| [0, i, i + 1]));
        } else {
            self.clip(n);
        }
        &self.triangles
    }

    /// Drops the axis in which the polygon's normal (Newell's) is largest: that keeps orientation,
    /// and is exact.
    fn project(&mut self, corners: &[[f32; 3]]) {
        let normal = newell(corners);
        let axis =
            (0..3).fold(0, |best, i| if normal[i].abs() > normal[best].abs() { i } else { best });
        let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
        if normal[axis] < 0.0 {
            (u, v) = (v, u);
        }
        self.points.clear();
        self.points.extend(corners.iter().map(|p| [f64::from(p[u]), f64::from(p[v])]));
    }

    /// Twice the signed area of a triangle of corners.
    fn area(&self, a: u32, b: u32, c: u32) -> f64 {
        let [a, b, c] = [a, b, c].map(|i| self.points[i as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }

    /// Cuts ears off until one triangle is left.
    fn clip(&mut self, n: u32) {
        self.next.clear();
        self.next.extend((1..n).chain([0]));
        self.previous.clear();
        self.previous.extend([n - 1].into_iter().chain(0..n - 1));
        self.is_reflex.clear();
        self.is_reflex.resize(n as usize, false);
        self.is_listed.clear();
        self.is_listed.resize(n as usize, false);
        self.reflex.clear();
        for i in 0..n {
            self.classify(i);
        }
        self.budget = BASE_TESTS + TESTS_PER_CORNER * u64::from(n);

        let (mut corners_left, mut corner, mut rejected) = (n, 0, 0);
        let (mut tolerance, mut imperfect) = (Tolerance::Strict, false);
        while corners_left > 3 {
            if self.budget == 0 {
                tolerance = Tolerance::Any;
            }
            let (p, q) = (self.previous[corner as usize], self.next[corner as usize]);
            if self.is_ear([p, corner, q], tolerance) {
                imperfect |= tolerance > Tolerance::Flat;
                self.triangles.push([p, corner, q]);
                (self.next[p as usize], self.previous[q as usize]) = (q, p);
                self.is_reflex[corner as usize] = false;
                self.classify(p);
                self.classify(q);
                (corners_left, rejected, tolerance) = (corners_left - 1, 0, Tolerance::Strict);
                // Not the corner right after: taking every other one gives rounder triangles.
                corner = self.next[q as usize];
            } else {
                (corner, rejected) = (q, rejected + 1);
                if rejected > corners_left {
                    rejected = 0;
                    tolerance = match tolerance {
                        Tolerance::Strict => Tolerance::Touching,
                        Tolerance::Touching => Tolerance::Flat,
                        _ => Tolerance::Any,
                    };
                }
            }
        }
        let last = [self.previous[corner as usize], corner, self.next[corner as usize]];
        imperfect |= self.area(last[0], last[1], last[2]) < 0.0;
        self.triangles.push(last);
        self.imperfect += u64::from(imperfect);
    }

    /// Decides whether a corner is reflex.
    fn classify(&mut self, i: u32) {
        let reflex = self.area(self.previous[i as usize], i, self.next[i as usize]) <= 0.0;
        if reflex && !self.is_listed[i as usize] {
            self.is_listed[i as usize] = true;
            self.reflex.push(i);
        }
        self.is_reflex[i as usize] = reflex;
    }

    /// Returns whether a corner can be cut off: the middle one of the triangle `t`.
    fn is_ear(&mut self, t: [u32; 3], tolerance: Tolerance) -> bool {
        let area = self.area(t[0], t[1], t[2]);
        match tolerance {
            Tolerance::Any => return true,
            Tolerance::Flat => return area == 0.0,
            _ if area <= 0.0 => return false,
            _ => {}
        }
        let mut i = 0;
        while let Some(&r) = self.reflex.get(i) {
            // Corners that were clipped or became convex are taken off the list when they are met.
            if !self.is_reflex[r as usize] {
                self.is_listed[r as usize] = false;
                self.reflex.swap_remove(i);
                continue;
            }
            self.budget = self.budget.saturating_sub(1);
            if !t.contains(&r) && self.blocks(r, t, tolerance) {
                return false;
            }
            i += 1;
        }
        true
    }

    /// Returns whether corner `r` forbids cutting the ear `t` off.
    fn blocks(&self, r: u32, t: [u32; 3], tolerance: Tolerance) -> bool {
        let point = self.points[r as usize];
        if t.iter().any(|&c| self.points[c as usize] == point) {
            return false; // the two sides of a slit to a hole meet there
        }
        let sides = [self.area(t[0], t[1], r), self.area(t[1], t[2], r), self.area(t[2], t[0], r)];
        if tolerance == Tolerance::Strict {
            sides.iter().all(|&s| s >= 0.0)
        } else {
            sides.iter().all(|&s| s > 0.0)
        }
    }
}

/// The normal of a polygon that need not be flat; its length is twice the area (Newell's method).
pub(super) fn newell(corners: &[[f32; 3]]) -> [f64; 3] {
    let mut normal = [0.0; 3];
    let Some(&origin) = corners.first() else { return normal };
    // Relative to a corner: far from the origin the products would lose the polygon's own size.
    let relative = |p: [f32; 3]| -> [f64; 3] {
        std::array::from_fn(|i| f64::from(p[i]) - f64::from(origin[i]))
    };
    for (i, &a) in corners.iter().enumerate() {
        let (a, b) = (relative(a), relative(corners[(i + 1) % corners.len()]));
        for (k, sum) in normal.iter_mut().enumerate() {
            let (u, v) = ((k + 1) % 3, (k + 2) % 3);
            *sum += (a[u] - b[u]) * (a[v] + b[v]);
        }
    }
    normal
}

#[cfg(test)]
#[path = "triangulate_tests.rs"]
mod tests;
