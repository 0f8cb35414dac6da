//! Errors of the steps that are left where following all of them would take too long, as in ribbons
//! of slivers, whose samples go from face to face without end.
//!
//! Some levels are measured, each by itself. All steps between two of them are stated as the
//! coarser one; where its error is far above that of the finer one, one between them is measured,
//! too.

use crate::Tick;
use crate::floor::MARGIN;
use crate::input::Input;
use crate::levels::Original;
use crate::step_errors::StepErrors;
use lodc_mesh::Simplified;
use lodc_nearest::FarthestSearch;

/// Shares of the triangles, in percent, whose levels are measured in any case: those that people
/// ask for.
const PERCENTAGES: [u64; 6] = [50, 25, 10, 5, 2, 1];

/// A level between two is measured if the coarser one's error is more than this times the finer
/// one's: so steps between them state at most twice what is right, as long as [`MAX_LEVELS`]
/// allows.
const MAX_ERROR_RATIO: f64 = 2.0;

/// Most levels that are measured. Chosen by hand: each takes as long as a tree over its faces and
/// a search of all of them.
const MAX_LEVELS: usize = 40;

/// Boxes that may be opened in all: for each triangle of the input, and besides. After that no
/// further level is measured. Chosen by hand.
const BOXES: [u64; 2] = [3_000, 10_000_000];

/// The same for one search of one level.
const BOXES_PER_SEARCH: [u32; 2] = [200, 1_000_000];

/// Errors below this share of the diagonal count as this much in ratios of errors. Chosen by hand.
const TINY_SHARE: f64 = 1e-6;

/// States errors for all steps after those that have them. `posed` has the position of each vertex
/// that the input was made of.
pub(crate) fn complete(
    errors: &mut StepErrors,
    input: &Input,
    simplified: &Simplified,
    posed: &[[f32; 3]],
    tick: &Tick<'_>,
) {
    let sequence = simplified.collapses();
    let first = errors.error.len();
    let triangles_left = |step: usize| sequence.step(step).triangles;
    let last = sequence.steps_at(sequence.last_visible());
    if first < last {
        // Made again, since the pass has dropped them to save memory.
        let (_, corner_vertices) = Input::new(simplified, posed);
        let search =
            FarthestSearch { boxes: BOXES_PER_SEARCH, ..FarthestSearch::for_size(input.diagonal) };
        let original = Original { input, simplified, corner_vertices: &corner_vertices, search };
        let mut step_counts: Vec<usize> = (0..u32::BITS)
            .map(|halvings| u64::from(triangles_left(first)) >> halvings)
            .chain(PERCENTAGES.map(|p| u64::from(sequence.parts().triangles) * p / 100))
            .map(|triangles| sequence.steps_at(sequence.lod_for_triangles(triangles as u32)))
            .filter(|steps| (first + 1..=last).contains(steps))
            .chain([last])
            .collect();
        step_counts.sort_unstable();
        step_counts.dedup();
        let before = errors.error.last().map_or(0.0, |&e| f64::from(e));
        let levels = Levels { original, tick }.measure(first, before, &step_counts);
        for MeasuredLevel { steps, error, rms } in levels {
            while errors.error.len() < steps {
                errors.push(error * MARGIN, rms.min(error * MARGIN));
            }
        }
    }
    for step in errors.error.len()..sequence.steps() {
        debug_assert_eq!(triangles_left(step), 0, "all steps with triangles are measured");
        errors.push(f64::INFINITY, f64::INFINITY);
    }
}

/// A level after some number of steps, with its distances from LOD 0 in mesh units.
struct MeasuredLevel {
    steps: usize,
    error: f64,
    rms: f64,
}

/// Measures levels one after the other.
struct Levels<'a> {
    original: Original<'a>,
    tick: &'a Tick<'a>,
}

impl Levels<'_> {
    /// Measures the levels after the numbers of steps in `step_counts`, which rise, and others
    /// between them; returns all in order. After `first` steps the error is `before`.
    fn measure(&self, first: usize, before: f64, step_counts: &[usize]) -> Vec<MeasuredLevel> {
        let Some((&last, others)) = step_counts.split_last() else { return Vec::new() };
        let input = self.original.input;
        let max_boxes = BOXES[0] * input.triangles.len() as u64 + BOXES[1];
        // The coarsest one comes first: it is stated for all that are left when boxes run out.
        let (coarsest, mut boxes) = self.level(last);
        let mut measured = Vec::new();
        for &steps in others {
            if boxes < max_boxes {
                let (level, more) = self.level(steps);
                measured.push(level);
                boxes += more;
            }
        }
        measured.push(coarsest);
        let tiny = TINY_SHARE * input.diagonal * input.mesh_scale;
        let (mut finer_steps, mut finer_error) = (first, before);
        let mut i = 0;
        while i < measured.len() {
            let MeasuredLevel { steps, error, .. } = measured[i];
            let is_far_above =
                error > MAX_ERROR_RATIO * finer_error.max(tiny) && steps > finer_steps + 1;
            if is_far_above && measured.len() < MAX_LEVELS && boxes < max_boxes {
                let (level, more) = self.level(finer_steps + (steps - finer_steps) / 2);
                measured.insert(i, level);
                boxes += more;
            } else {
                (finer_steps, finer_error) = (steps, error.max(finer_error));
                i += 1;
            }
        }
        measured
    }

    /// Measures the level after `steps` steps. Returns how many boxes were opened for it, too.
    fn level(&self, steps: usize) -> (MeasuredLevel, u64) {
        (self.tick)();
        let Original { input, simplified, .. } = self.original;
        let lod = simplified.collapses().step(steps - 1).lod;
        let distances = self.original.measure(lod, 0.0);
        let [error, rms] = [distances.error, distances.rms].map(|d| d * input.mesh_scale);
        (MeasuredLevel { steps, error, rms }, distances.boxes)
    }
}
