//! Runs a plan on a device step by step, and reports the first word that differs from what the plan
//! expects.

use crate::session::WordRange;
use crate::{Device, GpuError, Session};
use lodc_plan::{Expected, Plan, Tolerance};
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

/// Runs a plan on a device, step by step, until something differs.
///
/// # Errors
/// If the device cannot run it. A difference is no error.
pub fn replay(device: &Device, plan: Plan<'_>) -> Result<Replayed, GpuError> {
    let mut session = Session::new(device, &plan.program)?;
    let mut done = Replayed::default();
    for step in plan.steps {
        done.difference = step
            .cpu_failure
            .as_ref()
            .map(|failure| format!("the CPU differs from the reference: {failure}"));
        if done.difference.is_some() {
            break;
        }
        session.run(&step.passes)?;
        let is_hardware = !device.adapter().software;
        if let Some((check, word, found)) =
            first_difference(&mut session, &step.checks, is_hardware)?
        {
            let buffer = step.checks[check].buffer;
            let at = step.checks[check].first + word;
            let difference = Difference {
                at: step.at,
                buffer: session.name(buffer),
                word: at,
                location: (plan.locate)(buffer, at),
                expected: step.checks[check].words[word],
                found,
            };
            done.difference = Some(difference.to_string());
            break;
        }
        done.lods += u64::from(step.counts);
        done.words += step.checks.iter().map(|c| c.words.len() as u64).sum::<u64>();
    }
    Ok(done)
}

/// The first word that differs: the number of the check, the word of it, and what was found.
/// [`Tolerance`] is for hardware only.
fn first_difference(
    session: &mut Session,
    checks: &[Expected],
    is_hardware: bool,
) -> Result<Option<(usize, usize, u32)>, GpuError> {
    let range = |c: &Expected| WordRange { buffer: c.buffer, first: c.first, count: c.words.len() };
    let ranges: Vec<_> = checks.iter().map(range).collect();
    let mut difference = None;
    session.read_ranges(&ranges, |check, start, words| {
        let expected = &checks[check].words[start..start + words.len()];
        // Comparing whole slices is much faster than word by word, and nearly all are equal.
        if expected != words {
            let tolerance = checks[check].tolerance.filter(|_| is_hardware);
            let differs = |i: usize| {
                expected[i] != words[i]
                    && !tolerance.is_some_and(|t| is_tolerated(t, start + i, expected[i], words[i]))
            };
            difference =
                (0..words.len()).find(|&i| differs(i)).map(|i| (check, start + i, words[i]));
        }
        difference.is_none()
    })?;
    Ok(difference)
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
