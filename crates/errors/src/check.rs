//! Checks the errors that a collapse sequence states against levels that are measured, for `lodc
//! verify`.

use crate::input::Input;
use crate::level::{LevelDistances, Original};
use crate::settings::Limits;
use lodc_mesh::{CollapseSequence, Lod, Simplified, SplitMix64};
use rayon::prelude::*;

/// Levels that are measured: one in each of as many ranges of triangle counts.
const LEVELS: u32 = 16;

/// In every third range it is the level at which the error rises most; in the others any.
const RISING: u32 = 3;

// The following factors are chosen by hand.

/// A measured distance may be at most this many times the stated error.
const MAX_MEASURED: f64 = 1.05;

/// A stated error may be at most this many times the largest distance that is measured at the
/// level, or at the finer one where the error rose to that.
const MAX_STATED: f64 = 2.0;

/// Distances below this share of the one that decides are not searched closely: a margin for
/// bounds, which are up to about 2 % off.
const UNSEARCHED_SHARE: f64 = 0.95;

/// Of two root mean square distances, stated and measured, the larger may be at most this many
/// times the smaller; both are from samples.
const MAX_RMS_RATIO: f64 = 1.3;

/// Root mean square distances that differ by no more than this share of the error are not refused:
/// a small part of the surface decides them, and they are interpolated between measured levels.
const RMS_SLACK: f64 = 0.02;

/// Samples on either surface for each triangle of the input, for a root mean square distance.
const SAMPLES_PER_TRIANGLE: usize = 1;

/// The fewest and the most of them.
const SAMPLES: [usize; 2] = [64, 2_048];

/// Samples with which a root mean square distance is known closely.
pub(crate) const CLOSE_SAMPLES: usize = 32_768;

/// The samples that are taken instead, one number after the other, before one is refused.
const SAMPLES_BEFORE_REFUSAL: [usize; 2] = [4_096, CLOSE_SAMPLES];

/// What is measured may exceed what is stated by this share of the diagonal, too: single precision
/// rounds numbers as large as the diagonal by about as much.
const ROUNDING_SHARE: f64 = 1e-7;

/// What is stated is not refused for being too large below this share of the diagonal.
const NEGLIGIBLE_SHARE: f64 = 1e-6;

/// Compares the errors and root mean square distances of a sequence with measured ones. Returns the
/// number of levels that were measured, and the problem of the first level whose errors do not
/// hold. `shapes` are the surfaces that the errors are the maximum over, each with a position for
/// every vertex: the one at rest first. Which levels are measured follows from the errors.
///
/// # Panics
/// If there are not as many positions as vertices in a shape.
#[must_use]
pub fn check<S: AsRef<[[f32; 3]]>>(
    simplified: &Simplified,
    shapes: &[S],
) -> (usize, Option<String>) {
    let mut first = None;
    let count = examine(simplified, shapes, |lod, problem| {
        first = Some(format!("LOD {}: {problem}", lod.0));
        false
    });
    (count, first)
}

/// Returns the levels that [`check`] looks at whose errors do not hold.
pub(crate) fn refused(simplified: &Simplified, shape: &[[f32; 3]]) -> Vec<Lod> {
    let mut refused = Vec::new();
    examine(simplified, &[shape], |lod, _| {
        refused.push(lod);
        true
    });
    refused
}

/// Calls `found` with each level whose errors do not hold and its problem, while it returns true.
/// Returns the number of levels that were measured.
fn examine<S: AsRef<[[f32; 3]]>>(
    simplified: &Simplified,
    shapes: &[S],
    mut found: impl FnMut(Lod, String) -> bool,
) -> usize {
    let lods = chosen_lods(simplified.collapses());
    let mut levels: Vec<Checked> = lods.iter().map(|&lod| Checked::new(simplified, lod)).collect();
    let (mut rounding, mut negligible) = (0.0f64, 0.0f64);
    for (number, shape) in shapes.iter().enumerate() {
        let posed = shape.as_ref();
        assert_eq!(posed.len(), simplified.mesh().vertex_count(), "a position for each vertex");
        let (input, corner_vertices) = Input::new(simplified, posed);
        let original = Original::new(&input, simplified, &corner_vertices, Limits::DEFAULT);
        let diagonal = input.diagonal * input.mesh_scale;
        rounding = rounding.max(ROUNDING_SHARE * diagonal);
        negligible = negligible.max(NEGLIGIBLE_SHARE * diagonal);
        levels.par_iter_mut().with_max_len(1).for_each(|level| level.measure(&original, number));
    }
    for level in &levels {
        if let Some(problem) = level.problem(simplified, shapes, rounding, negligible)
            && !found(level.lod, problem)
        {
            break;
        }
    }
    lods.len()
}

/// Chooses levels with triangles, one from each of [`LEVELS`] ranges of triangle counts.
fn chosen_lods(collapses: &CollapseSequence) -> Vec<Lod> {
    // Whoever changes an error changes what is looked at.
    let parts = collapses.parts();
    let bits = parts.step_errors.iter().map(|error| u64::from(error.to_bits()));
    let seed = bits.fold(0, |seed: u64, bits| (seed ^ bits).wrapping_mul(0x0100_0000_01b3));
    let mut random = SplitMix64::new(seed);
    let mut upper = f64::from(parts.triangles);
    let ratio = upper.powf(1.0 / f64::from(LEVELS));
    let mut lods = Vec::new();
    for range in 0..LEVELS {
        let lower = upper / ratio;
        let triangles = lower + (upper - lower) * f64::from(random.unit());
        let lod = |triangles: f64| collapses.lod_for_triangles(triangles as u32);
        let mut chosen = lod(triangles);
        if range % RISING == 0 {
            let steps = [upper, lower].map(|triangles| collapses.steps_at(lod(triangles)));
            let rise = |step: usize| match step.checked_sub(1) {
                Some(before) => {
                    parts.step_errors[step] / parts.step_errors[before].max(f32::MIN_POSITIVE)
                }
                None => 0.0,
            };
            let most = (steps[0]..steps[1]).max_by(|&a, &b| rise(a).total_cmp(&rise(b)));
            chosen = most.map_or(chosen, |step| collapses.step(step).lod);
        }
        lods.push(chosen.min(collapses.last_visible()));
        upper = lower;
    }
    lods.sort_unstable();
    lods.dedup();
    lods.retain(|&lod| lod > Lod(0));
    lods
}

/// A level whose errors are compared, with the largest distances over the shapes so far, in the
/// mesh's units.
struct Checked {
    lod: Lod,
    stated: f64,
    stated_rms: Option<f64>,
    lower: f64,
    upper: f64,
    rms: f64,
    /// The shape in which it is farthest.
    shape: usize,
}

impl Checked {
    fn new(simplified: &Simplified, lod: Lod) -> Self {
        let collapses = simplified.collapses();
        let stated = f64::from(collapses.error_at(lod));
        let stated_rms = collapses.rms_at(lod).map(f64::from);
        Self { lod, stated, stated_rms, lower: 0.0, upper: 0.0, rms: 0.0, shape: 0 }
    }

    /// Measures the level in a shape. Where it is far enough in another one, only larger distances
    /// than are stated are searched for.
    fn measure(&mut self, original: &Original<'_>, shape: usize) {
        let share = if self.lower >= self.stated / MAX_STATED { 1.0 } else { 1.0 / MAX_STATED };
        let scale = original.input.mesh_scale;
        // An infinite error is that of a level without triangles.
        let known = if self.stated.is_finite() {
            UNSEARCHED_SHARE * share * self.stated / scale
        } else {
            0.0
        };
        let LevelDistances { lower, upper, rms, .. } =
            original.measure(self.lod, known, usual_samples(original.input.triangles.len()), None);
        // What was known is not what was found.
        if lower > known && lower * scale > self.lower {
            (self.lower, self.shape) = (lower * scale, shape);
        }
        self.upper = self.upper.max(upper * scale);
        self.rms = self.rms.max(rms * scale);
    }

    /// Returns what is wrong with what the level states.
    fn problem<S: AsRef<[[f32; 3]]>>(
        &self,
        simplified: &Simplified,
        shapes: &[S],
        rounding: f64,
        negligible: f64,
    ) -> Option<String> {
        let &Self { lod, stated, lower, .. } = self;
        if lower > MAX_MEASURED * stated + rounding {
            let pose =
                if self.shape > 0 { format!(" in pose {}", self.shape) } else { String::new() };
            return Some(format!("the error is {stated}, but {lower} was measured{pose}"));
        }
        let collapses = simplified.collapses();
        if stated > negligible && stated > MAX_STATED * lower {
            // Errors never fall: a finer level may be the one with that distance.
            let errors = &collapses.parts().step_errors;
            let first = errors.partition_point(|&e| f64::from(e) < stated);
            let few = usual_samples(simplified.mesh().triangles().len());
            let bound = measured(simplified, shapes, collapses.step(first).lod, few).upper;
            let bound = bound.max(self.upper.min(stated / MAX_STATED));
            if stated > MAX_STATED * bound {
                return Some(format!("the error is {stated}, no point is farther than {bound}"));
            }
        }
        let stated_rms = self.stated_rms?;
        let slack = RMS_SLACK * stated;
        let is_near = |rms: f64| {
            rms <= MAX_RMS_RATIO * stated_rms + rounding + slack
                && stated_rms <= MAX_RMS_RATIO * rms + negligible + slack
        };
        if is_near(self.rms) {
            return None;
        }
        let mut rms = 0.0;
        for samples in SAMPLES_BEFORE_REFUSAL {
            rms = measured(simplified, shapes, lod, samples).rms;
            if stated_rms > MAX_RMS_RATIO * rms {
                let means = &collapses.parts().step_rms;
                let first = means.partition_point(|&r| f64::from(r) < stated_rms);
                let finer = measured(simplified, shapes, collapses.step(first).lod, samples).rms;
                rms = rms.max(finer);
            }
            if is_near(rms) {
                return None;
            }
        }
        Some(format!("the root mean square distance is {stated_rms}, but {rms} was measured"))
    }
}

/// Samples on either of two surfaces of some triangles that tell a root mean square distance, as
/// long as it is not refused.
pub(crate) fn usual_samples(triangles: usize) -> usize {
    (SAMPLES_PER_TRIANGLE * triangles).clamp(SAMPLES[0], SAMPLES[1])
}

/// The largest distances over all shapes, in the mesh's units.
#[derive(Default)]
struct LargestDistances {
    /// An upper bound of the largest distance of a point.
    upper: f64,
    rms: f64,
}

/// Measures a level in all shapes, with `samples` on either surface.
fn measured<S: AsRef<[[f32; 3]]>>(
    simplified: &Simplified,
    shapes: &[S],
    lod: Lod,
    samples: usize,
) -> LargestDistances {
    let mut largest = LargestDistances::default();
    for shape in shapes {
        let (input, corner_vertices) = Input::new(simplified, shape.as_ref());
        let original = Original::new(&input, simplified, &corner_vertices, Limits::DEFAULT);
        let found = original.measure(lod, 0.0, samples, None);
        largest.upper = largest.upper.max(found.upper * input.mesh_scale);
        largest.rms = largest.rms.max(found.rms * input.mesh_scale);
    }
    largest
}
