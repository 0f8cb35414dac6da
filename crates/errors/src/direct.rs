//! Levels measured one by one: for the steps that are left where following all of them would take
//! too long, as in ribbons of slivers, whose samples go from face to face without end.
//!
//! Some levels are measured as two surfaces that know nothing of each other. All steps between two
//! of them are stated as the coarser one; where it is far more than the finer one, one between them
//! is measured, too.

use crate::Tick;
use crate::floor::MARGIN;
use crate::input::Input;
use crate::levels::Original;
use crate::step_errors::StepErrors;
use lodc_mesh::Simplified;
use lodc_nearest::Search;

/// Shares of the triangles, in percent, whose levels are measured in any case: those that people
/// ask for.
const SHARES: [u64; 6] = [50, 25, 10, 5, 2, 1];

/// A level between two is measured if the coarser one's error is more than this times the finer
/// one's: steps between them state no more than twice what is right, as long as [`MOST`] allows.
const LEAP: f64 = 2.0;

/// Most levels that are measured.
const MOST: usize = 40;

/// Boxes that may be opened for each triangle of the input, and besides: then the last level is
/// stated for all that are left.
const BOXES: [u64; 2] = [3_000, 10_000_000];

/// The same for one search, for each triangle and besides.
const EACH: [u32; 2] = [200, 1_000_000];

/// States errors for all steps after those that have them.
pub(crate) fn complete(
    errors: &mut StepErrors,
    input: &Input,
    (simplified, shown): (&Simplified, &[[f32; 3]]),
    tick: &Tick<'_>,
) {
    let sequence = simplified.collapses();
    let first = errors.error.len();
    let left = |step: usize| sequence.step(step).triangles;
    let last = sequence.steps_at(sequence.last_visible());
    if first < last {
        // Numbered again: the pass saves the memory.
        let (_, wedges) = Input::new(simplified, shown);
        let direct = Direct::new(input, simplified, &wedges, tick);
        let mut ends: Vec<usize> = (0..u32::BITS)
            .map(|halving| u64::from(left(first)) >> halving)
            .chain(SHARES.map(|share| u64::from(sequence.parts().triangles) * share / 100))
            .map(|wanted| sequence.steps_at(sequence.lod_for_triangles(wanted as u32)))
            .filter(|&end| (first + 1..=last).contains(&end))
            .chain([last])
            .collect();
        ends.sort_unstable();
        ends.dedup();
        let before = errors.error.last().map_or(0.0, |&e| f64::from(e));
        for (end, [error, rms]) in direct.measure(first, before, &ends) {
            while errors.error.len() < end {
                errors.push(error * MARGIN, rms.min(error * MARGIN));
            }
        }
    }
    for step in errors.error.len()..sequence.steps() {
        debug_assert_eq!(left(step), 0, "all steps with triangles are measured");
        errors.push(f64::INFINITY, f64::INFINITY);
    }
}

/// Levels that are measured one after the other.
struct Direct<'a> {
    input: &'a Input,
    simplified: &'a Simplified,
    original: Original<'a>,
    tick: &'a Tick<'a>,
}

impl<'a> Direct<'a> {
    fn new(
        input: &'a Input,
        simplified: &'a Simplified,
        wedges: &'a [[u32; 3]],
        tick: &'a Tick<'a>,
    ) -> Self {
        let search = Search { boxes: EACH, ..Search::within(input.diagonal) };
        Self { input, simplified, original: Original { input, simplified, wedges, search }, tick }
    }

    /// Measures the levels after the steps in `ends`, and others between them. Returns them in
    /// order, with error and root mean square distance in mesh units.
    fn measure(&self, first: usize, before: f64, ends: &[usize]) -> Vec<(usize, [f64; 2])> {
        let Some((&last, others)) = ends.split_last() else { return Vec::new() };
        let most = BOXES[0] * self.input.triangles.len() as u64 + BOXES[1];
        let (coarsest, mut opened) = self.level(last);
        let mut measured = Vec::new();
        for &end in others {
            if opened < most {
                let (level, more) = self.level(end);
                measured.push((end, level));
                opened += more;
            }
        }
        measured.push((last, coarsest));
        let tiny = 1e-6 * self.input.diagonal * self.input.unit;
        let mut finest = (first, before);
        let mut i = 0;
        while i < measured.len() {
            let (end, [error, _]) = measured[i];
            let leaps = error > LEAP * finest.1.max(tiny) && end > finest.0 + 1;
            if leaps && measured.len() < MOST && opened < most {
                let middle = finest.0 + (end - finest.0) / 2;
                let (level, more) = self.level(middle);
                measured.insert(i, (middle, level));
                opened += more;
            } else {
                finest = (end, error.max(finest.1));
                i += 1;
            }
        }
        measured
    }

    /// Measures the level after `steps` steps. Returns the boxes that were opened for it, too.
    fn level(&self, steps: usize) -> ([f64; 2], u64) {
        (self.tick)();
        let lod = self.simplified.collapses().step(steps - 1).lod;
        let (distances, opened) = self.original.measure(lod, 0.0);
        (distances.map(|distance| distance * self.input.unit), opened)
    }
}
