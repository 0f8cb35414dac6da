//! What is stated of every step: the proposals of the pass, held against levels that are measured.
//!
//! ```text
//!   error │                          ●          ● measured levels: bounds that hold
//!         │                 ● ┄┄┄┄┄┄┄           ┄ proposed by the pass, raised by what measured
//!         │        ● ┄┄┄┄┄┄┄                      levels beside exceed it, never above the coarser
//!         └────────┴────────┴────────┴── steps
//! ```
//!
//! Where a measured level is farther than the pass says, or the pass did not come to it, levels
//! between are measured, too, until neighbours are alike. Mean distances follow the proposals, too,
//! corrected by the ratio of measured to proposed ones.

use crate::Tick;
use crate::floor::{Floor, MARGIN};
use crate::level::Original;
use crate::rough::RoughSquare;
use crate::settings::{Limits, Settings};
use crate::step_errors::StepErrors;
use lodc_mesh::CollapseSequence;

/// Levels that are measured in any case have these shares of the triangles, in percent, and below
/// the last of them an eighth of the one before. Chosen by hand.
const PERCENTAGES: [u64; 10] = [99, 95, 85, 70, 50, 25, 15, 10, 5, 1];
const DIVISOR: u64 = 8;
/// The same of a mesh of a large scene: others follow from their errors. Chosen by hand.
const PERCENTAGES_IN_SCENE: [u64; 5] = [85, 50, 25, 10, 5];

/// Two measured levels are alike in their errors if these differ by no more than this factor; in
/// meshes of few triangles, where a few steps change much, by no more than the second. So are those
/// at which the pass proposed no less than is found, up to such factors. Chosen by hand.
const ALIKE: [f64; 2] = [1.15, 1.05];
const PROPOSED: [f64; 2] = [1.1, 1.0];

/// And in their mean distances if the ratios of measured to proposed ones differ by no more than
/// this factor. Chosen by hand.
const ALIKE_RATIOS: [f64; 2] = [1.35, 1.12];

/// No level is measured between two whose numbers of triangles differ by no more than this factor;
/// in meshes of few triangles the second, while so many are left: of fewer each step counts, those
/// that remove no triangle, too. Chosen by hand.
const NEIGHBOURS: [f64; 2] = [1.15, 1.02];
const NEIGHBOURS_TRIANGLES: u32 = 64;

/// Unless one of these neighbours is so many times as far as the other, or as far on average, and
/// the pass does not know where between them: less than what a check of what is stated allows.
/// Means that differ by no more than this share of the error are alike, too. Chosen by hand.
const JUMP: f64 = 1.7;
const JUMP_OF_MEANS: f64 = 1.25;
const MEANS_SHARE: f64 = 0.02;
/// The pass has few samples of a mesh of a large scene. There one of two neighbours is at most so
/// many times as far as the other, and between them the larger error is stated; at most [`JUMP`]
/// times where the pass proposed what was found at both. Chosen by hand.
const JUMP_IN_SCENE: f64 = 1.3;
/// Nor does it know, in meshes of few triangles, where means rise so many times: what a part that
/// goes leaves of them is in few samples. Chosen by hand.
const JUMP_OF_FEW: f64 = 2.0;
/// Such levels may be this many times as many as [`Limits::max_levels`](crate::settings::Limits).
const JUMPS_MAY_TAKE: usize = 2;

/// The pass knows mean distances from the input to the level. Where the other way is longer, so
/// that the measured ones are more than this many times the proposed, it does not know where they
/// rise. Chosen by hand.
const KNOWN_MEANS: f64 = 1.5;

/// A step after which the pass proposes so many times what it did before: a part has gone, and the
/// mean may rise with it in a way that the pass does not see. Chosen by hand.
const SUDDEN: f64 = 1.7;

/// Of meshes of few triangles every level that has no more than so many left is measured, and some
/// with up to four times as many.
const LAST_TRIANGLES: u64 = 16;
const BEFORE_LAST: [u64; 9] = [18, 21, 25, 29, 34, 40, 47, 55, 64];

/// Triangles of the input for each sample of a rung, within limits. Chosen by hand.
const TRIANGLES_PER_SAMPLE: usize = 4;
/// Most samples of a rung of a very small mesh: so many, and more for each triangle. Chosen by
/// hand.
const FEWEST_SAMPLES: usize = 256;
const RUNG_SAMPLES_PER_TRIANGLE: usize = 4;
/// The same of those of up to so many triangles, whose rungs are few. Chosen by hand.
const SAMPLES_OF_VERY_FEW: usize = 1280;
const VERY_FEW_TRIANGLES: usize = 64;
/// The same of those of large scenes.
const RUNG_SAMPLES_IN_SCENE: [usize; 2] = [128, 1];
/// The same of a rung whose mean distance is known from its neighbours, and the factor by which
/// they may differ from that. Chosen by hand.
const SAMPLES_OF_KNOWN: usize = 96;
const AS_EXPECTED: f64 = 1.2;

/// Where the largest distance is so many times the mean one, a part of a hundredth of the area or
/// less decides the mean, and in very small meshes so many samples tell it. Chosen by hand.
const SPARSE: f64 = 12.0;
const SAMPLES_OF_SPARSE: usize = 8_192;

/// Where the search for the farthest point of a rung met its limit with an upper bound of more than
/// so many times the lower one, it is made again so many times, in meshes of few triangles the
/// second, without what is nearer than their geometric mean; that is not far below the upper one.
/// Chosen by hand.
const UNFINISHED: f64 = 1.7;
const TRIES: [usize; 2] = [2, 6];
const NEARLY_ALL: f64 = 0.25;

/// Distances below this share of the diagonal are alike whatever they are: a check takes no more
/// for rounding.
const TINY_SHARE: f64 = 1e-7;

/// Distances that the pass proposes, in units of the input's coordinates: of each step that it has
/// followed the largest that it found so far, and the root mean square distance of its samples.
#[derive(Default)]
pub(crate) struct Proposals {
    pub(crate) largest: Vec<f32>,
    pub(crate) rms: Vec<f32>,
    /// After some numbers of steps, about how far each triangle of the input is.
    pub(crate) distances: Vec<(usize, Vec<RoughSquare>)>,
}

impl Proposals {
    /// About how far triangles of the input are after a number of steps, or after the next number
    /// that is known.
    fn distances_after(&self, steps: usize) -> Option<&[RoughSquare]> {
        let known = self.distances.partition_point(|known| known.0 < steps);
        self.distances.get(known).map(|known| &known.1[..])
    }

    fn after(distances: &[f32], steps: usize) -> f64 {
        let last = steps.min(distances.len());
        last.checked_sub(1).map_or(0.0, |i| f64::from(distances[i]))
    }
}

/// A measured level, with distances in units of the input's coordinates.
#[derive(Clone, Copy, Debug)]
struct Rung {
    /// Steps before it.
    steps: usize,
    triangles: u32,
    /// What is stated of it: the largest bound so far.
    upper: f64,
    /// The largest distance found so far.
    lower: f64,
    rms: f64,
    /// How many times the proposal the bound is, at least 1; and the ratio of mean distances.
    excess: f64,
    rms_ratio: f64,
}

/// Returns after how many steps levels are measured in any case, in rising order: the last is the
/// coarsest level that has triangles. Of meshes of few triangles they are more.
pub(crate) fn planned_steps(sequence: &CollapseSequence, settings: Settings) -> Vec<usize> {
    let all = u64::from(sequence.parts().triangles);
    let last = sequence.steps_at(sequence.last_visible());
    let percentages =
        if settings.is_in_scene { &PERCENTAGES_IN_SCENE[..] } else { &PERCENTAGES[..] };
    let shares: Vec<u64> = percentages.iter().map(|percent| all * percent / 100).collect();
    let below = std::iter::successors(shares.last().copied(), |t| Some(t / DIVISOR)).skip(1);
    // Where few triangles are left each counts.
    let few = if settings.few_triangles { &BEFORE_LAST[..] } else { &[] };
    let last_few = if settings.few_triangles { LAST_TRIANGLES } else { 0 };
    let mut planned: Vec<usize> = shares
        .into_iter()
        .chain(below.take_while(|&triangles| triangles > 0))
        .chain(1..=last_few)
        .chain(few.iter().copied())
        .map(|triangles| sequence.steps_at(sequence.lod_for_triangles(triangles as u32)))
        .filter(|steps| (1..last).contains(steps))
        .chain((last > 0).then_some(last))
        .collect();
    planned.sort_unstable();
    planned.dedup();
    planned
}

/// Measures levels of a sequence beside what a pass proposes for its steps.
pub(crate) struct Ladder<'a> {
    pub(crate) original: Original<'a>,
    pub(crate) sequence: &'a CollapseSequence,
    pub(crate) proposals: &'a Proposals,
    pub(crate) floor: Floor<'a>,
    pub(crate) settings: Settings,
    pub(crate) tick: &'a Tick<'a>,
}

impl Ladder<'_> {
    /// Returns the errors of all steps, in the mesh's units. Measures the levels after the numbers
    /// of steps in `planned`, which rise to that of the last level, and others between them.
    pub(crate) fn complete(&self, planned: &[usize]) -> StepErrors {
        let (sequence, input) = (self.sequence, self.original.input);
        let mut errors = StepErrors::with_capacity(sequence.steps());
        let last = planned.last().copied().unwrap_or(0);
        errors.ends_in_ladder = self.proposals.largest.len() < last;
        let all = input.triangles.len() as u32;
        let mut finer = Rung {
            steps: 0,
            triangles: all,
            upper: 0.0,
            lower: 0.0,
            rms: 0.0,
            excess: 1.0,
            rms_ratio: 1.0,
        };
        for (i, rung) in self.measure(planned).into_iter().enumerate() {
            if i == 0 {
                (finer.excess, finer.rms_ratio) = (rung.excess, rung.rms_ratio);
            }
            while errors.error.len() < rung.steps {
                let step = errors.error.len();
                let [error, rms] = self.between(&finer, &rung, step + 1);
                let [error, rms] = [error, rms].map(|d| d * input.mesh_scale);
                let error = error.max(self.floor.stated(step));
                errors.push(error, rms.min(error));
            }
            finer = rung;
        }
        let lost = if input.triangles.is_empty() { 0.0 } else { f64::INFINITY };
        while errors.error.len() < sequence.steps() {
            errors.push(lost, lost);
        }
        errors
    }

    /// Returns the error and the mean distance after a number of steps, between two rungs.
    fn between(&self, finer: &Rung, coarser: &Rung, steps: usize) -> [f64; 2] {
        if steps == coarser.steps {
            return [coarser.upper, coarser.rms];
        }
        let excess = finer.excess.max(coarser.excess);
        let proposed = Proposals::after(&self.proposals.largest, steps);
        let is_followed = steps <= self.proposals.largest.len();
        let is_in_scene = self.settings.is_in_scene;
        let error = if is_in_scene && coarser.upper <= JUMP_IN_SCENE * finer.upper {
            coarser.upper
        } else if is_followed && proposed > self.original.rounding() {
            proposed * MARGIN * excess
        } else if is_followed && excess <= PROPOSED[0] {
            0.0
        } else {
            // Nothing is known of it but that the coarser level is no nearer.
            coarser.upper
        };
        let proposed = Proposals::after(&self.proposals.rms, steps);
        let triangles = f64::from(self.sequence.step(steps - 1).triangles.max(1));
        let [from, to] = [finer, coarser].map(|rung| f64::from(rung.triangles.max(1)).ln());
        let share = if from > to { (from - triangles.ln()) / (from - to) } else { 1.0 };
        let rms = match [finer.rms_ratio, coarser.rms_ratio] {
            [0.0, 0.0] => finer.rms + (coarser.rms - finer.rms) * share,
            [0.0, ratio] | [ratio, 0.0] => proposed * ratio,
            ratios => {
                let [finer, coarser] = ratios.map(f64::ln);
                proposed * (finer * (1.0 - share) + coarser * share).exp()
            }
        };
        [error.clamp(finer.upper, coarser.upper), rms.clamp(finer.rms, coarser.rms)]
    }

    /// Measures the planned levels and those between them that it takes, fine to coarse.
    fn measure(&self, planned: &[usize]) -> Vec<Rung> {
        let mut work = Work { levels: planned.len(), boxes: 0 };
        let mut rungs: Vec<Rung> = Vec::with_capacity(planned.len());
        for &steps in planned {
            let rung = self.rung(steps, rungs.last(), None, &mut work);
            self.add_between(rungs.last().copied(), rung, &mut rungs, &mut work);
        }
        rungs
    }

    /// Adds a rung, and before it those between it and the finer one until neighbours are alike.
    fn add_between(
        &self,
        finer: Option<Rung>,
        mut coarser: Rung,
        rungs: &mut Vec<Rung>,
        work: &mut Work,
    ) {
        let most = self.limits().max_levels;
        if let Some((steps, ratio)) = self.middle(finer.as_ref(), &coarser, work.levels < most)
            && work.levels < JUMPS_MAY_TAKE * most
            && work.boxes < self.limits().max_boxes(self.original.input.triangles.len())
        {
            work.levels += 1;
            let middle = self.rung(steps, finer.as_ref(), ratio, work);
            self.add_between(finer, middle, rungs, work);
            let before = rungs.last().copied();
            coarser.follow(before.as_ref());
            self.add_between(before, coarser, rungs, work);
        } else {
            rungs.push(coarser);
        }
    }

    /// Returns the number of steps of the level to measure between two, if they are not alike;
    /// without `any`, only if there is a jump between them. Besides, in a mesh of a large scene,
    /// the ratio of its mean distance to the proposed one, if both neighbours have about the same.
    fn middle(
        &self,
        finer: Option<&Rung>,
        coarser: &Rung,
        any: bool,
    ) -> Option<(usize, Option<f64>)> {
        let all = self.sequence.parts().triangles;
        let (steps, triangles) = finer.map_or((0, all), |rung| (rung.steps, rung.triangles));
        let [from, to] = [triangles, coarser.triangles].map(f64::from);
        let Settings { few_triangles, is_in_scene, .. } = self.settings;
        let few = usize::from(few_triangles || is_in_scene);
        let are_neighbours =
            from <= NEIGHBOURS[few] * to && (few == 0 || coarser.triangles >= NEIGHBOURS_TRIANGLES);
        if coarser.steps <= steps + 1 {
            return None;
        }
        let tiny = TINY_SHARE * self.original.input.diagonal;
        let excess = coarser.excess.max(finer.map_or(1.0, |rung| rung.excess));
        let [error, rms] = finer.map_or([0.0; 2], |rung| [rung.upper, rung.rms]);
        let is_alike = |a: f64, b: f64, factor: f64| b.max(tiny) <= factor * a.max(tiny);
        let errors_are_alike =
            excess <= PROPOSED[few] || is_alike(error, coarser.upper, ALIKE[few]);
        let ratio = finer.map_or(coarser.rms_ratio, |rung| rung.rms_ratio);
        let ratios = [ratio, coarser.rms_ratio];
        // Without a ratio nothing is known of where a mean rises.
        let [low, high] = [ratios[0].min(ratios[1]), ratios[0].max(ratios[1])];
        let ratios_are_alike = low > 0.0 && high <= ALIKE_RATIOS[few] * low;
        let means_are_alike = ratios_are_alike || is_alike(rms, coarser.rms, ALIKE[few]);
        let means_jump = !is_alike(rms + MEANS_SHARE * error, coarser.rms, JUMP_OF_MEANS);
        // A part that goes may leave a mean that falls again: of few triangles that is seen.
        let errors_of_few_jump = few_triangles && !is_alike(error, coarser.upper, JUMP);
        if (means_jump || errors_of_few_jump)
            && !is_in_scene
            && let Some(sudden) = self.sudden(steps, coarser, tiny)
        {
            return Some((sudden, None));
        }
        let is_jump = || {
            let means_are_known = ratios_are_alike && high <= KNOWN_MEANS;
            let errors_jump = if is_in_scene {
                let factor = if excess > 1.0 { JUMP_IN_SCENE } else { JUMP };
                !is_alike(error, coarser.upper, factor)
            } else {
                !errors_are_alike && !is_alike(error, coarser.upper, JUMP)
            };
            let means_jump_far =
                few_triangles && !is_alike(rms + MEANS_SHARE * error, coarser.rms, JUMP_OF_FEW);
            errors_jump || (!means_are_known && means_jump) || means_jump_far
        };
        let are_alike = (is_in_scene || errors_are_alike) && means_are_alike;
        if (are_alike || are_neighbours || !any) && !is_jump() {
            return None;
        }
        let middle = (from * to.max(1.0)).sqrt() as u32;
        let sequence = self.sequence;
        let middle = sequence.steps_at(sequence.lod_for_triangles(middle));
        let known_ratio = (is_in_scene && ratios_are_alike).then_some((low * high).sqrt());
        Some((middle.clamp(steps + 1, coarser.steps - 1), known_ratio))
    }

    /// Returns after how many steps, more than `from` and fewer than those of a rung, the proposed
    /// error has risen most in one step, to about that of the rung; none if it has not risen
    /// suddenly.
    fn sudden(&self, from: usize, rung: &Rung, tiny: f64) -> Option<usize> {
        let proposed = &self.proposals.largest;
        let rise = |steps: usize| {
            let [before, after] = [steps - 2, steps - 1].map(|i| f64::from(proposed[i]));
            if SUDDEN * after >= rung.upper { after / before.max(tiny) } else { 0.0 }
        };
        let candidates = (from + 1).max(2)..rung.steps.min(proposed.len() + 1);
        let steepest = candidates.max_by(|&a, &b| rise(a).total_cmp(&rise(b)).then(b.cmp(&a)))?;
        (rise(steepest) >= SUDDEN).then_some(steepest)
    }

    fn limits(&self) -> &Limits {
        &self.settings.limits
    }

    /// Measures the level after some steps; `finer` is a rung before it. Where the ratio of the
    /// mean distance to the proposed one is known, few samples only tell whether it is so.
    fn rung(
        &self,
        steps: usize,
        finer: Option<&Rung>,
        known_ratio: Option<f64>,
        work: &mut Work,
    ) -> Rung {
        (self.tick)();
        let step = self.sequence.step(steps - 1);
        let proposed = Proposals::after(&self.proposals.largest, steps);
        let known = proposed.max(finer.map_or(0.0, |rung| rung.lower));
        let rough = self.proposals.distances_after(steps);
        let triangles = self.original.input.triangles.len();
        let [fewest, most] = self.limits().rung_samples;
        let samples = (triangles / TRIANGLES_PER_SAMPLE).clamp(fewest, most);
        let [besides, per_triangle] = RUNG_SAMPLES_IN_SCENE;
        let samples = samples.min(match triangles {
            _ if self.settings.is_in_scene => besides + per_triangle * triangles,
            0..=VERY_FEW_TRIANGLES => SAMPLES_OF_VERY_FEW,
            _ => FEWEST_SAMPLES + RUNG_SAMPLES_PER_TRIANGLE * triangles,
        });
        let proposed_rms = Proposals::after(&self.proposals.rms, steps);
        let expected = known_ratio.map(|ratio| proposed_rms * ratio);
        let first_samples = if expected.is_some() { SAMPLES_OF_KNOWN } else { samples };
        let mut found = self.original.measure(step.lod, known, first_samples, rough);
        work.boxes += found.boxes;
        if let Some(expected) = expected {
            let [low, high] = [expected.min(found.rms), expected.max(found.rms)];
            if high <= AS_EXPECTED * low {
                found.rms = expected.min(found.upper);
            } else {
                let closely = self.original.measure(step.lod, found.lower, samples, rough);
                work.boxes += closely.boxes;
                found.rms = closely.rms;
            }
        }
        if self.settings.is_very_small(triangles) && found.lower > SPARSE * found.rms {
            let closely = self.original.measure(step.lod, found.lower, SAMPLES_OF_SPARSE, None);
            work.boxes += closely.boxes;
            found.rms = closely.rms;
        }
        for _ in 0..TRIES[usize::from(self.settings.few_triangles)] {
            if found.upper <= UNFINISHED * found.lower || !found.upper.is_finite() {
                break;
            }
            let middle = (found.lower.max(NEARLY_ALL * found.upper) * found.upper).sqrt();
            let again = self.original.measure(step.lod, middle, FEWEST_SAMPLES, None);
            work.boxes += again.boxes;
            found.upper = found.upper.min(again.upper);
            if again.lower > middle {
                found.lower = again.lower;
            }
        }
        let accepted = self.original.accepted(known);
        // Rounding errors of a level without any distance tell nothing of those beside it.
        let rms = if found.upper > self.original.rounding() { found.rms } else { 0.0 };
        let mut rung = Rung {
            steps,
            triangles: step.triangles,
            upper: found.upper,
            lower: found.lower,
            rms,
            excess: if found.upper > accepted {
                found.upper / self.original.accepted(proposed)
            } else {
                1.0
            },
            rms_ratio: if proposed_rms > 0.0 { rms / proposed_rms } else { 0.0 },
        };
        rung.follow(finer);
        rung
    }
}

impl Rung {
    /// Raises what is stated to that of a finer level: it never falls.
    fn follow(&mut self, finer: Option<&Self>) {
        if let Some(finer) = finer {
            self.upper = self.upper.max(finer.upper);
            self.lower = self.lower.max(finer.lower);
            self.rms = self.rms.max(finer.rms);
        }
    }
}

/// Work done on levels.
struct Work {
    levels: usize,
    boxes: u64,
}
