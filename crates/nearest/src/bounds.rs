//! Axis-aligned boxes in `f32`, rounded outwards: the nodes of the trees of this package.

use glam::DVec3;

/// A box; empty if `low` is above `high`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    low: [f32; 3],
    high: [f32; 3],
}

impl Bounds {
    /// The box of nothing.
    pub(crate) const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// Returns the least box with coordinates of `f32` around `low` and `high`.
    pub(crate) fn around(low: DVec3, high: DVec3) -> Self {
        let down = |x: f64| if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 };
        let up = |x: f64| if f64::from(x as f32) < x { (x as f32).next_up() } else { x as f32 };
        Self { low: low.to_array().map(down), high: high.to_array().map(up) }
    }

    /// Returns the squared distance from a point to the box; 0 inside, infinite if it is empty.
    #[inline]
    pub(crate) fn distance_squared(&self, p: DVec3) -> f64 {
        let outside = |x: f64, low: f32, high: f32| {
            let under = f64::from(low) - x;
            let over = x - f64::from(high);
            let excess = if under > over { under } else { over };
            if excess > 0.0 { excess } else { 0.0 }
        };
        let x = outside(p.x, self.low[0], self.high[0]);
        let y = outside(p.y, self.low[1], self.high[1]);
        let z = outside(p.z, self.low[2], self.high[2]);
        x * x + y * y + z * z
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.low[0] > self.high[0]
    }

    pub(crate) fn new(low: [f32; 3], high: [f32; 3]) -> Self {
        Self { low, high }
    }

    /// Returns the box of some points.
    #[inline]
    pub(crate) fn of(points: &[[f32; 3]]) -> Self {
        let mut bounds = Self::EMPTY;
        for &p in points {
            bounds.include(p);
        }
        bounds
    }

    #[inline]
    pub(crate) fn low(&self) -> [f32; 3] {
        self.low
    }

    #[inline]
    pub(crate) fn high(&self) -> [f32; 3] {
        self.high
    }

    /// Returns half the area of its sides; 0 if it is empty.
    #[inline]
    pub(crate) fn half_area(&self) -> f32 {
        let [x, y, z] = std::array::from_fn(|i| self.high[i] - self.low[i]);
        if x < 0.0 { 0.0 } else { x * y + y * z + z * x }
    }

    /// Returns the longest extent along an axis.
    pub(crate) fn extent(&self) -> f32 {
        (0..3).map(|i| self.high[i] - self.low[i]).fold(0.0, f32::max)
    }

    /// Returns the axis of the longest extent.
    pub(crate) fn longest_axis(&self) -> usize {
        let extent = |i: usize| self.high[i] - self.low[i];
        (0..3).max_by(|&i, &j| extent(i).total_cmp(&extent(j))).unwrap_or(0)
    }

    /// Returns the middle along an axis.
    #[inline]
    pub(crate) fn middle(&self, axis: usize) -> f32 {
        0.5 * self.low[axis] + 0.5 * self.high[axis]
    }

    /// Grows the box to include a point. Returns whether the box grew.
    pub(crate) fn include(&mut self, p: [f32; 3]) -> bool {
        let mut grew = false;
        for (axis, x) in p.into_iter().enumerate() {
            if x < self.low[axis] {
                (self.low[axis], grew) = (x, true);
            }
            if x > self.high[axis] {
                (self.high[axis], grew) = (x, true);
            }
        }
        grew
    }

    /// Returns the least box around two.
    pub(crate) fn union(a: &Self, b: &Self) -> Self {
        Self {
            low: std::array::from_fn(|i| a.low[i].min(b.low[i])),
            high: std::array::from_fn(|i| a.high[i].max(b.high[i])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_what_it_was_made_around() {
        let (low, high) = (DVec3::new(0.1, -0.1, 1.0 / 3.0), DVec3::new(0.7, 0.2, 1e-3 + 0.5));
        let bounds = Bounds::around(low, high);
        for p in [low, high, (low + high) * 0.5] {
            assert_eq!(bounds.distance_squared(p), 0.0);
        }
        let off = bounds.distance_squared(high + DVec3::new(0.0, 3.0, 4.0));
        assert!((off - 25.0).abs() < 1e-5, "{off}");
        assert!(Bounds::EMPTY.distance_squared(low).is_infinite());
    }
}
