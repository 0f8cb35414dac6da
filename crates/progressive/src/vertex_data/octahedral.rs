//! Unit vectors as two integers: the octahedron |x| + |y| + |z| = 1, unfolded into a square grid
//! (Meyer et al. 2010).

use crate::vertex_data::number_system::round_half_up;

/// A grid on the unfolded octahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Octahedral {
    /// Bits of each of the two integers, from 2 to 24. From −1 to 1 there are 2^n − 2 grid steps,
    /// an even number, so that 0 is on the grid.
    pub bits: u8,
}

impl Octahedral {
    /// Grid steps from −1 to 1.
    fn steps(self) -> f64 {
        f64::from((1u32 << self.bits.clamp(2, 24)) - 2)
    }

    /// Returns the unit vector at a point of the grid.
    pub(crate) fn direction(self, point: [i32; 2]) -> [f64; 3] {
        let [x, y] = point.map(|i| f64::from(i) * 2.0 / self.steps() - 1.0);
        let z = 1.0 - x.abs() - y.abs();
        let [x, y] = if z < 0.0 { folded(x, y) } else { [x, y] };
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length, z / length]
    }

    /// Returns the grid point nearest to a direction of any length; that of +z for a zero vector or
    /// one that is not finite.
    pub(crate) fn indices(self, [x, y, z]: [f64; 3]) -> [i32; 2] {
        let size = x.abs() + y.abs() + z.abs();
        if !(size > 0.0 && size.is_finite()) {
            return [0.0; 2].map(|c| self.index(c));
        }
        let [x, y] = [x / size, y / size];
        (if z < 0.0 { folded(x, y) } else { [x, y] }).map(|c| self.index(c))
    }

    fn index(self, coordinate: f64) -> i32 {
        round_half_up((coordinate + 1.0) / 2.0 * self.steps())
    }
}

/// Folds a point of the lower half of the octahedron out into the square, over the edge of the
/// upper half, or back.
fn folded(x: f64, y: f64) -> [f64; 2] {
    let sign = |c: f64| if c < 0.0 { -1.0 } else { 1.0 };
    [(1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_the_grid_lead_to_directions_and_back() {
        for bits in [2, 5, 8] {
            let octahedral = Octahedral { bits };
            let steps = octahedral.steps() as i32;
            for u in 0..=steps {
                for v in 0..=steps {
                    let direction = octahedral.direction([u, v]);
                    let again = octahedral.direction(octahedral.indices(direction));
                    let difference: f64 = (0..3).map(|c| (direction[c] - again[c]).abs()).sum();
                    assert!(difference < 1e-9, "{u} {v} of {bits} bits: {direction:?}, {again:?}");
                }
            }
        }
        let up = Octahedral { bits: 10 }.indices([0.0; 3]);
        assert_eq!(Octahedral { bits: 10 }.direction(up), [0.0, 0.0, 1.0]);
    }
}
