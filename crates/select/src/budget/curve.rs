//! The levels of one model as a table by the error that they may have, 128 entries per octave, so
//! that a level is found without a search.

/// Bits of an error's float that are dropped: the others number 128 steps in each octave. Chosen by
/// hand: steps of 0.8 % at most are not seen, and tables stay small.
const DROPPED_BITS: u32 = 16;

/// Number of the step that a positive error is in; equal on every machine, and monotone.
pub(super) fn step_of(error: f32) -> u32 {
    error.max(0.0).to_bits() >> DROPPED_BITS
}

/// The smallest error of a step.
pub(super) fn error_of(step: u32) -> f32 {
    f32::from_bits(step << DROPPED_BITS)
}

/// The last step of finite errors.
pub(super) const LAST_STEP: u32 = (0x7f80_0000 >> DROPPED_BITS) - 1;

/// One level of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveLevel {
    /// Its number in the list that the curve was made of.
    pub index: u32,
    /// Its triangles.
    pub triangles: u32,
    /// Its error, in the model's units.
    pub error: f32,
}

/// Levels of one model, found by an error without a search: a table with 128 steps in each octave
/// of the error, from the first level that errs to the last.
#[derive(Clone, Debug)]
pub struct LevelCurve {
    /// The step of the first entry.
    first_step: u32,
    /// The level of each step from there on.
    levels: Vec<CurveLevel>,
    /// The radius of a sphere around the model.
    radius: f32,
}

impl LevelCurve {
    /// The curve of levels from the finest to the coarsest: error and triangles of each. Errors
    /// never fall; levels from the first that has no finite error on are left out. `radius` is
    /// that of a sphere around the model, whose centre is the model's position.
    ///
    /// # Panics
    /// If there is no level.
    #[must_use]
    pub fn new(levels: &[(f64, u32)], radius: f32) -> Self {
        let all: Vec<CurveLevel> = (0..)
            .zip(levels)
            .map(|(index, &(error, triangles))| CurveLevel {
                index,
                triangles,
                // Rounded up, so that it stays a bound.
                error: if f64::from(error as f32) < error {
                    (error as f32).next_up()
                } else {
                    error as f32
                },
            })
            .take_while(|level| level.error.is_finite())
            .collect();
        let (Some(first), Some(last)) = (all.iter().find(|l| l.error > 0.0), all.last()) else {
            let coarsest = *all.last().expect("a curve has a level");
            return Self { first_step: 0, levels: vec![coarsest], radius };
        };
        let first_step = step_of(first.error);
        let mut table = Vec::new();
        let mut index = 0;
        for step in first_step..=step_of(last.error) + 1 {
            while index + 1 < all.len() && all[index + 1].error <= error_of(step) {
                index += 1;
            }
            table.push(all[index]);
        }
        Self { first_step, levels: table, radius }
    }

    /// The coarsest level whose error is at most that of a step.
    pub(super) fn at(&self, step: u32) -> &CurveLevel {
        &self.levels[(self.clamped(step) - self.first_step) as usize]
    }

    /// The nearest step that the table has, which has the same level.
    pub(super) fn clamped(&self, step: u32) -> u32 {
        step.clamp(self.first_step, self.first_step + self.levels.len() as u32 - 1)
    }

    pub(super) fn radius(&self) -> f32 {
        self.radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_gives_the_coarsest_level_within_its_error() {
        let levels = [(0.0, 100), (0.01, 60), (0.011, 50), (0.5, 8), (f64::INFINITY, 0)];
        let curve = LevelCurve::new(&levels, 1.0);
        for error in [0.0, 1e-9, 0.009, 0.0102, 0.0112, 0.3, 0.51, 7.0, 1e30] {
            let got = curve.at(step_of(error));
            let bound = f64::from(error_of(step_of(error)));
            let last = levels.iter().rposition(|l| l.0 <= bound).expect("the first has none");
            assert_eq!((got.index, got.triangles), (last as u32, levels[last].1), "{error}");
        }
    }

    #[test]
    fn a_model_that_never_errs_has_its_coarsest_level() {
        let curve = LevelCurve::new(&[(0.0, 12), (0.0, 2), (f64::INFINITY, 0)], 1.0);
        assert_eq!([0, 5, LAST_STEP].map(|step| curve.at(step).triangles), [2, 2, 2]);
    }

    #[test]
    fn steps_are_small() {
        for error in [1e-20_f32, 0.013, 1.0, 1.99, 4e9] {
            let (low, high) = (error_of(step_of(error)), error_of(step_of(error) + 1));
            assert!(low <= error && error < high && high / low < 1.008, "{error}");
        }
    }
}
