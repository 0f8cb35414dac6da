//! Rasterises a triangle: visits the pixel centres that it covers, decided in integers (Pineda
//! 1988, with the top-left rule).

use crate::camera::{Point, SUBPIXELS};

/// A rectangle of pixels; right and bottom are not part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Window {
    /// First column.
    pub left: i32,
    /// First row.
    pub top: i32,
    /// After the last column.
    pub right: i32,
    /// After the last row.
    pub bottom: i32,
}

impl Window {
    /// A whole picture of `size` by `size` pixels.
    #[must_use]
    pub fn whole(size: u32) -> Self {
        Self { left: 0, top: 0, right: size as i32, bottom: size as i32 }
    }

    /// The pixels within this window whose centres may lie in the hull of points.
    #[must_use]
    pub fn around(self, points: impl Iterator<Item = Point>) -> Self {
        let (mut lo, mut hi) = ((i32::MAX, i32::MAX), (i32::MIN, i32::MIN));
        for p in points {
            lo = (lo.0.min(p.x), lo.1.min(p.y));
            hi = (hi.0.max(p.x), hi.1.max(p.y));
        }
        if lo.0 > hi.0 {
            return Self::default();
        }
        // The first centre at or after the least, and after the last centre at or before the
        // greatest.
        let half = SUBPIXELS / 2;
        Self {
            left: self.left.max((lo.0 + half - 1).div_euclid(SUBPIXELS)),
            top: self.top.max((lo.1 + half - 1).div_euclid(SUBPIXELS)),
            right: self.right.min((hi.0 + half).div_euclid(SUBPIXELS)),
            bottom: self.bottom.min((hi.1 + half).div_euclid(SUBPIXELS)),
        }
    }

    /// Returns whether there is no pixel in it.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.left >= self.right || self.top >= self.bottom
    }

    /// Pixels across.
    #[must_use]
    pub fn width(self) -> usize {
        (self.right - self.left).max(0) as usize
    }

    /// Pixels in all.
    #[must_use]
    pub fn len(self) -> usize {
        self.width() * (self.bottom - self.top).max(0) as usize
    }
}

/// Runs of up to this many pixels are tried column by column, which is quicker than a division.
/// Chosen by hand.
const MAX_TRIED_COLUMNS: i64 = 6;

/// Windows of at most this many pixels across, and its square in all, are tried pixel by pixel.
/// Chosen by hand.
const MAX_SMALL_SIDE: usize = 8;

/// If the corners are nearer to each other than this, across and down, 32 bits hold all products of
/// [`scan_small`]. In the unit of [`Point::x`].
const MAX_32_BIT_EXTENT: i64 = 1 << 13;

/// Added to depths before they are truncated, so that they are positive: 2^30.
const DEPTH_OFFSET: f64 = 1_073_741_824.0;

/// Rounds a depth by truncating, which is one instruction, while rounding may be a call.
#[inline]
fn rounded(depth: f64) -> i32 {
    ((depth + (DEPTH_OFFSET + 0.5)) as i64 - DEPTH_OFFSET as i64) as i32
}

/// One edge of a triangle as a function of the pixel: positive on the inner side.
#[derive(Clone, Copy)]
struct Edge<T> {
    /// At the first pixel of the present row.
    value: T,
    /// Change to the next pixel on the right.
    right: T,
    /// Change to the next row.
    down: T,
    /// Added before the test for `>= 0`: centres on edges that are not top or left are outside.
    bias: T,
}

impl Edge<i64> {
    /// The edge from `a` to `b`, at a pixel centre.
    fn new(a: Point, b: Point, x: i64, y: i64) -> Self {
        let (dx, dy) = (i64::from(b.x) - i64::from(a.x), i64::from(b.y) - i64::from(a.y));
        let value = dx * (y - i64::from(a.y)) - dy * (x - i64::from(a.x));
        // The inner side is on the right: an edge that goes up is a left edge, one that goes right
        // a top edge.
        let owns = dy < 0 || dy == 0 && dx > 0;
        let step = i64::from(SUBPIXELS);
        Self { value, right: -dy * step, down: dx * step, bias: if owns { 0 } else { -1 } }
    }

    /// The part of a run of columns, from the window's left, that is on the inner side.
    #[inline]
    fn clip_run(&self, mut first: i64, mut last: i64) -> (i64, i64) {
        let inside = |column: i64| self.value + column * self.right + self.bias >= 0;
        if last - first < MAX_TRIED_COLUMNS {
            while first <= last && !inside(first) {
                first += 1;
            }
            while first <= last && !inside(last) {
                last -= 1;
            }
            return (first, last);
        }
        let value = self.value + self.bias;
        match self.right {
            0 if value < 0 => (first, first - 1),
            0 => (first, last),
            right if right > 0 => (
                first.max((-value).div_euclid(right) + i64::from((-value).rem_euclid(right) > 0)),
                last,
            ),
            right => (first, last.min(value.div_euclid(-right))),
        }
    }
}

/// Calls `visit(column, row, depth)` for every pixel of `window` whose centre lies in the triangle,
/// whichever side of it is seen. Two triangles that share an edge share no pixel there and leave
/// none out. Depth is in [`Point::z`]'s unit.
#[inline]
pub fn scan(corners: [Point; 3], window: Window, visit: impl FnMut(i32, i32, i32)) {
    let [a, b, c] = corners;
    let window = window.around(corners.into_iter());
    if window.is_empty() {
        return;
    }
    let is_near = |p: i32, q: i32| (i64::from(p) - i64::from(q)).abs() < MAX_32_BIT_EXTENT;
    let all_near = [b, c].iter().all(|p| is_near(p.x, a.x) && is_near(p.y, a.y));
    if all_near
        && window.width() <= MAX_SMALL_SIDE
        && window.len() <= MAX_SMALL_SIDE * MAX_SMALL_SIDE
    {
        scan_small(corners, window, visit);
    } else {
        scan_rows(corners, window, visit);
    }
}

/// [`scan`] row by row of a window that lies around the corners.
fn scan_rows(corners: [Point; 3], window: Window, mut visit: impl FnMut(i32, i32, i32)) {
    let [a, mut b, mut c] = corners;
    let side = |p: Point, q: Point| {
        (i64::from(p.x) - i64::from(a.x)) * (i64::from(q.y) - i64::from(a.y))
            - (i64::from(p.y) - i64::from(a.y)) * (i64::from(q.x) - i64::from(a.x))
    };
    let mut area = side(b, c);
    if area == 0 {
        return;
    }
    if area < 0 {
        (b, c, area) = (c, b, -area);
    }
    let center = |pixel: i32| i64::from(pixel) * i64::from(SUBPIXELS) + i64::from(SUBPIXELS / 2);
    let (x, y) = (center(window.left), center(window.top));
    // Barycentric coordinates: the value of each edge is the weight of the corner opposite.
    let mut edges = [Edge::new(b, c, x, y), Edge::new(c, a, x, y), Edge::new(a, b, x, y)];
    // All sums are whole numbers less than 2^53 in pictures of up to 512 pixels, so no order of
    // terms matters.
    let share = 1.0 / area as f64;
    let depths = [a, b, c].map(|p| f64::from(p.z));
    let weighed =
        |w: [i64; 3]| w[0] as f64 * depths[0] + w[1] as f64 * depths[1] + w[2] as f64 * depths[2];
    let step = weighed(edges.map(|e| e.right));
    for row in window.top..window.bottom {
        let [mut first, mut last] = [0, i64::from(window.right) - i64::from(window.left) - 1];
        for e in &edges {
            (first, last) = e.clip_run(first, last);
        }
        let mut sum = weighed(edges.map(|e| e.value + first * e.right));
        for column in window.left + first as i32..=window.left + last as i32 {
            visit(column, row, rounded(sum * share));
            sum += step;
        }
        for e in &mut edges {
            e.value += e.down;
        }
    }
}

/// [`scan`] where the corners are near each other and the window around them has few pixels, as of
/// most triangles of dense meshes.
#[inline]
fn scan_small(corners: [Point; 3], window: Window, mut visit: impl FnMut(i32, i32, i32)) {
    let [a, mut b, mut c] = corners;
    let area_of = |b: Point, c: Point| (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    let mut area = area_of(b, c);
    if area == 0 {
        return;
    }
    if area < 0 {
        (b, c, area) = (c, b, -area);
    }
    let center = |pixel: i32| pixel * SUBPIXELS + SUBPIXELS / 2;
    let (x, y) = (center(window.left), center(window.top));
    // As [`Edge::new`] does, in 32 bits.
    let edge = |p: Point, q: Point| {
        let (dx, dy) = (q.x - p.x, q.y - p.y);
        let bias = if dy < 0 || dy == 0 && dx > 0 { 0 } else { -1 };
        let value = dx * (y - p.y) - dy * (x - p.x);
        Edge { value, right: -dy * SUBPIXELS, down: dx * SUBPIXELS, bias }
    };
    let mut edges = [edge(b, c), edge(c, a), edge(a, b)];
    let share = 1.0 / f64::from(area);
    let depths = (f64::from(a.z), f64::from(b.z), f64::from(c.z));
    for row in window.top..window.bottom {
        let [e, f, g] = edges;
        let (mut u, mut v, mut w) = (e.value, f.value, g.value);
        for column in window.left..window.right {
            if (u + e.bias) | (v + f.bias) | (w + g.bias) >= 0 {
                let sum =
                    f64::from(u) * depths.0 + f64::from(v) * depths.1 + f64::from(w) * depths.2;
                visit(column, row, rounded(sum * share));
            }
            (u, v, w) = (u + e.right, v + f.right, w + g.right);
        }
        for e in &mut edges {
            e.value += e.down;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_pixels_are_the_same_as_rows_of_them() {
        let mut state = 7u64;
        let mut coordinate = |below: u64| {
            // xorshift64
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % below) as i32
        };
        let mut visited = 0;
        for size in [100, 400, 2000, 8000] {
            for _ in 0..2000 {
                // Some hang over the edge of the picture.
                let at = [coordinate(4096) - 512, coordinate(4096) - 512];
                let corners = [(); 3].map(|()| Point {
                    x: at[0] + coordinate(size),
                    y: at[1] + coordinate(size),
                    z: coordinate(100_000) - 50_000,
                });
                let window = Window::whole(12).around(corners.into_iter());
                let (mut few, mut rows) = (vec![], vec![]);
                scan_small(corners, window, |x, y, z| few.push((x, y, z)));
                scan_rows(corners, window, |x, y, z| rows.push((x, y, z)));
                assert_eq!(few, rows, "{corners:?}");
                visited += few.len();
            }
        }
        assert!(visited > 5_000, "{visited}");
    }
}
