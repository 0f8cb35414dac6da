//! Runs plans on a device, and reports for each the first word that differs from what it expects.

use crate::session::{STAGING_BYTES, WordRange};
use crate::{Device, GpuError, Session};
use lodc_plan::{BufferId, Expected, Plan, Step, Tolerance};
use std::fmt;

/// The result of a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Replayed {
    /// Number of LODs or views at which the device was compared.
    pub lods: u64,
    /// Words that were read back and compared.
    pub words: u64,
    /// The first thing that is wrong.
    pub difference: Option<String>,
}

/// A word that is not what it should be.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// At which step.
    pub at: String,
    /// The buffer's name.
    pub buffer: &'static str,
    /// The word of the buffer.
    pub word: usize,
    /// The part of the mesh that it belongs to, in words.
    pub location: String,
    /// The word on the CPU.
    pub expected: u32,
    /// The word on the device.
    pub found: u32,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at, buffer, word, location, expected, found } = self;
        write!(f, "{at}: {location}: word {word} of {buffer} is {found:#010x} on the device ")?;
        write!(f, "and {expected:#010x} on the CPU")
    }
}

/// Runs a plan on a device until something differs.
///
/// # Errors
/// If the device cannot run it. A difference is no error.
pub fn replay(device: &Device, plan: Plan<'_>) -> Result<Replayed, GpuError> {
    let mut replays = Replays::new(device);
    replays.add(plan)?;
    Ok(replays.finish()?.pop().unwrap_or_default())
}

/// Passes of a submission, about. Chosen by hand: submitting takes as long as some tens of them.
const MAX_PASSES: usize = 2048;

/// Plans that run on a device one after the other, many steps in one submission: each step's words
/// are copied before the next step overwrites them, and one submission is worked on while the words
/// of the one before it are compared.
pub struct Replays<'a> {
    device: Device,
    plans: Vec<Running<'a>>,
    /// What is submitted next.
    next: Batch,
    /// What was submitted last.
    submitted: Option<(wgpu::SubmissionIndex, Batch)>,
    /// For the next submission; there are two.
    staging: Vec<wgpu::Buffer>,
}

/// A plan whose steps are not all compared.
struct Running<'a> {
    done: Replayed,
    /// The device cannot run it.
    failed: bool,
    /// By buffer.
    names: Vec<&'static str>,
    locate: Option<Box<dyn Fn(BufferId, usize) -> String + 'a>>,
}

/// A submission.
#[derive(Default)]
struct Batch {
    encoder: Option<wgpu::CommandEncoder>,
    staging: Option<wgpu::Buffer>,
    /// Steps by the numbers of their plans.
    steps: Vec<(usize, Step)>,
    /// Words that are read back.
    words: usize,
    passes: usize,
}

impl Batch {
    /// Returns whether steps of so many words and passes fit.
    fn has_room(&self, words: usize, passes: usize) -> bool {
        4 * (self.words + words) as u64 <= STAGING_BYTES && self.passes + passes <= MAX_PASSES
    }
}

impl<'a> Replays<'a> {
    /// Prepares to run plans.
    #[must_use]
    pub fn new(device: &Device) -> Self {
        Self {
            device: device.clone(),
            plans: vec![],
            next: Batch::default(),
            submitted: None,
            staging: vec![],
        }
    }

    /// Runs a plan, or as much of it as shows a difference. What is submitted last may not be
    /// compared yet.
    ///
    /// # Errors
    /// If the device cannot run it: then it has no result.
    pub fn add(&mut self, plan: Plan<'a>) -> Result<(), GpuError> {
        let session = Session::new(&self.device, &plan.program)?;
        let number = self.plans.len();
        self.plans.push(Running {
            done: Replayed::default(),
            failed: false,
            names: plan.program.buffers.iter().map(|b| b.name).collect(),
            locate: Some(plan.locate),
        });
        let run = self.run(number, session, plan.steps);
        self.plans[number].failed = run.is_err();
        run
    }

    /// Waits for all plans. Returns the result of each that was added without an error, in order.
    ///
    /// # Errors
    /// If the device fails.
    pub fn finish(mut self) -> Result<Vec<Replayed>, GpuError> {
        self.compare_all()?;
        Ok(self.plans.into_iter().filter(|plan| !plan.failed).map(|plan| plan.done).collect())
    }

    fn run(
        &mut self,
        number: usize,
        mut session: Session,
        steps: impl Iterator<Item = Step>,
    ) -> Result<(), GpuError> {
        let (mut waiting, mut words, mut passes) = (Vec::new(), 0, 0);
        for step in steps {
            if let Some(failure) = &step.cpu_failure {
                self.encode(number, &session, waiting)?;
                self.compare_all()?;
                let difference = &mut self.plans[number].done.difference;
                difference.get_or_insert_with(|| {
                    format!("the CPU differs from the reference: {failure}")
                });
                return Ok(());
            }
            let (more_words, more_passes) = (words_of(&step), step.passes.len());
            if !self.next.has_room(words + more_words, passes + more_passes) {
                self.encode(number, &session, std::mem::take(&mut waiting))?;
                (words, passes) = (0, 0);
                self.submit()?;
                if self.plans[number].done.difference.is_some() {
                    return Ok(());
                }
                if !self.next.has_room(more_words, more_passes) {
                    self.run_alone(number, &mut session, &step)?;
                    continue;
                }
            }
            words += more_words;
            passes += more_passes;
            waiting.push(step);
        }
        self.encode(number, &session, waiting)
    }

    /// Adds steps of one plan to what is submitted next.
    fn encode(
        &mut self,
        number: usize,
        session: &Session,
        steps: Vec<Step>,
    ) -> Result<(), GpuError> {
        let batch = &mut self.next;
        let staging = batch.staging.get_or_insert_with(|| {
            self.staging.pop().unwrap_or_else(|| self.device.staging(STAGING_BYTES))
        });
        let encoder = batch.encoder.get_or_insert_with(|| self.device.encoder());
        session.send_parameters(encoder, steps.iter().flat_map(|step| &step.passes));
        let mut slot = 0;
        for step in steps {
            session.dispatch(encoder, &step.passes, slot, None)?;
            slot += step.passes.len();
            for range in step.checks.iter().map(range) {
                session.copy(encoder, range, staging, batch.words);
                batch.words += range.count;
            }
            batch.passes += step.passes.len();
            batch.steps.push((number, step));
        }
        Ok(())
    }

    /// Submits what is encoded, and meanwhile compares what was submitted before it.
    fn submit(&mut self) -> Result<(), GpuError> {
        let mut batch = std::mem::take(&mut self.next);
        let submitted = batch.encoder.take().map(|encoder| {
            let index = self.device.queue.submit([encoder.finish()]);
            (index, batch)
        });
        self.device.check()?;
        let before = std::mem::replace(&mut self.submitted, submitted);
        before.map_or(Ok(()), |(index, batch)| self.compare(index, batch))
    }

    fn compare_all(&mut self) -> Result<(), GpuError> {
        self.submit()?;
        self.submit()
    }

    /// Compares the words of a submission, once it is done.
    fn compare(&mut self, index: wgpu::SubmissionIndex, batch: Batch) -> Result<(), GpuError> {
        let Some(staging) = batch.staging else { return Ok(()) };
        let is_hardware = !self.device.adapter().software;
        self.device.map_when(Some(index), &staging, 4 * batch.words as u64, |bytes| {
            let mut words: &[u32] = bytemuck::cast_slice(bytes);
            for (number, step) in &batch.steps {
                let plan = &mut self.plans[*number];
                let mut difference = None;
                for (check, expected) in step.checks.iter().enumerate() {
                    let (found, further) = words.split_at(expected.words.len());
                    words = further;
                    if difference.is_none() {
                        difference = differs(expected, 0, found, is_hardware)
                            .map(|(word, found)| (check, word, found));
                    }
                }
                plan.judge(step, difference);
            }
        })?;
        self.staging.push(staging);
        // What names words is needed as long as steps are to be compared, or the plan runs.
        let later = self.submitted.iter().flat_map(|(_, batch)| &batch.steps);
        let first = later.chain(&self.next.steps).map(|(number, _)| *number).next();
        let first = first.unwrap_or(self.plans.len()).min(self.plans.len() - 1);
        self.plans[..first].iter_mut().for_each(|plan| plan.locate = None);
        Ok(())
    }

    /// A step of more words than are read back at once.
    fn run_alone(
        &mut self,
        number: usize,
        session: &mut Session,
        step: &Step,
    ) -> Result<(), GpuError> {
        self.compare_all()?;
        session.run(&step.passes)?;
        let is_hardware = !self.device.adapter().software;
        let ranges: Vec<_> = step.checks.iter().map(range).collect();
        let mut difference = None;
        session.read_ranges(&ranges, |check, start, found| {
            difference = differs(&step.checks[check], start, found, is_hardware)
                .map(|(word, found)| (check, word, found));
            difference.is_none()
        })?;
        self.plans[number].judge(step, difference);
        Ok(())
    }
}

impl Running<'_> {
    /// Notes that a step was compared: the number of the check, the word of it and what was found
    /// where something differs. Nothing counts after the first difference.
    fn judge(&mut self, step: &Step, difference: Option<(usize, usize, u32)>) {
        if self.done.difference.is_some() {
            return;
        }
        let Some((check, word, found)) = difference else {
            self.done.lods += u64::from(step.counts);
            self.done.words += words_of(step) as u64;
            return;
        };
        let Expected { buffer, first, ref words, .. } = step.checks[check];
        let at = first + word;
        let difference = Difference {
            at: step.at.clone(),
            buffer: self.names[buffer.0],
            word: at,
            location: self.locate.as_ref().map(|locate| locate(buffer, at)).unwrap_or_default(),
            expected: words[word],
            found,
        };
        self.done.difference = Some(difference.to_string());
    }
}

fn words_of(step: &Step) -> usize {
    step.checks.iter().map(|check| check.words.len()).sum()
}

fn range(expected: &Expected) -> WordRange {
    WordRange { buffer: expected.buffer, first: expected.first, count: expected.words.len() }
}

/// The first word of a check, counted from its start, that differs, and what was found. `found` are
/// the words from `start` on. [`Tolerance`] is for hardware only.
fn differs(
    check: &Expected,
    start: usize,
    found: &[u32],
    is_hardware: bool,
) -> Option<(usize, u32)> {
    let expected = &check.words[start..start + found.len()];
    // Comparing whole slices is much faster than word by word, and nearly all are equal.
    if expected == found {
        return None;
    }
    let tolerance = check.tolerance.filter(|_| is_hardware);
    let is_wrong = |i: usize| {
        expected[i] != found[i]
            && !tolerance.is_some_and(|t| is_tolerated(t, start + i, expected[i], found[i]))
    };
    (0..found.len()).find(|&i| is_wrong(i)).map(|i| (start + i, found[i]))
}

/// Returns whether a word is a computed float that is off by one unit in the last place.
fn is_tolerated(tolerance: Tolerance, word: usize, expected: u32, found: u32) -> bool {
    let same_sign = (expected ^ found) >> 31 == 0;
    word % tolerance.stride < tolerance.floats && same_sign && expected.abs_diff(found) <= 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_computed_floats_may_be_off_and_only_by_one() {
        let tolerance = Tolerance { stride: 5, floats: 3 };
        let one = 1.0f32.to_bits();
        assert!(is_tolerated(tolerance, 7, one, one + 1));
        assert!(!is_tolerated(tolerance, 7, one, one + 2));
        assert!(!is_tolerated(tolerance, 8, one, one + 1));
        assert!(!is_tolerated(tolerance, 5, one, one ^ 1 << 31));
    }
}
