//! Repeated timings of one thing: the best of them, their mean and their spread.

use average::Variance;
use serde::Serialize;

/// Timings of one thing in the order of the rounds, all in one unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Timings(Vec<f64>);

impl Timings {
    /// Adds the timing of one more round.
    pub(crate) fn add(&mut self, timing: f64) {
        self.0.push(timing);
    }

    /// The shortest one; infinite if there is none.
    pub(crate) fn best(&self) -> f64 {
        self.0.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Mean and spread over all rounds.
    pub(crate) fn spread(&self) -> Spread {
        let estimate: Variance = self.0.iter().collect();
        Spread {
            rounds: self.0.len() as u64,
            mean: estimate.mean(),
            deviation: (self.0.len() > 1).then(|| estimate.sample_variance().sqrt()),
        }
    }
}

impl FromIterator<f64> for Timings {
    fn from_iter<I: IntoIterator<Item = f64>>(timings: I) -> Self {
        Self(timings.into_iter().collect())
    }
}

/// Mean and spread of timings, in their unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Spread {
    /// Number of timings.
    pub(crate) rounds: u64,
    pub(crate) mean: f64,
    /// Sample standard deviation; null for a single timing.
    pub(crate) deviation: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_deviation_are_those_of_the_sample() {
        let timings: Timings = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0].into_iter().collect();
        let spread = timings.spread();
        assert_eq!((timings.best(), spread.rounds, spread.mean), (2.0, 8, 5.0));
        let deviation = spread.deviation.expect("more than one timing");
        assert!((deviation - (32.0f64 / 7.0).sqrt()).abs() < 1e-12, "{deviation}");
    }

    #[test]
    fn a_single_timing_has_no_spread() {
        let mut timings = Timings::default();
        timings.add(3.0);
        assert_eq!(timings.spread(), Spread { rounds: 1, mean: 3.0, deviation: None });
    }
}
