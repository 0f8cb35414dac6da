//! `compare --baseline`: compares distances with those stored by an earlier run; fails where they
//! are worse, or stores the new ones.

use super::CompareArgs;
use crate::exit::{Failure, Outcome, Status};
use crate::output::{self, Target};
use lodc_measure::Recorded;
use lodc_report::SCHEMA_VERSION;

/// The numbers that an earlier run recorded, by asset and level.
pub(super) type Baseline = crate::jobs::Baseline<Recorded>;

/// Reads the baseline, if one is wanted.
///
/// # Errors
/// If it cannot be read, or does not exist and is not to be recorded.
pub(super) fn open(args: &CompareArgs) -> Outcome<Option<Baseline>> {
    let Some(path) = &args.baseline else { return Ok(None) };
    if output::is_standard_stream(path)
        || args.named().is_some_and(|named| named.contains(&&**path))
    {
        return Err(Failure::usage("--baseline needs a file or folder of its own"));
    }
    if !args.record && !path.exists() {
        let what = "there is no baseline yet: record one with --record";
        return Err(Failure::new(Status::Input, format!("{}: {what}", path.display())));
    }
    Ok(Some(Baseline::open(path)?))
}

/// Returns what was recorded of an asset; none if nothing was, or if it is to be recorded anew.
///
/// # Errors
/// If its file cannot be read, or it was recorded with other options.
pub(super) fn recorded(
    baseline: &Baseline,
    name: &str,
    args: &CompareArgs,
) -> Outcome<Option<Recorded>> {
    let recorded = if args.record { None } else { baseline.record(name)? };
    match recorded {
        Some(recorded) if recorded.options != options(args) => {
            let what = format!("{name} was recorded with {}", recorded.options);
            let path = baseline.path().display();
            Err(Failure::usage(format!("{path}: {what}: record it again (--record)")))
        }
        recorded => Ok(recorded),
    }
}

/// Records what was measured; the records of other assets stay.
///
/// # Errors
/// If it cannot be written.
pub(super) fn write(baseline: Baseline, measured: Vec<(String, Recorded)>) -> Outcome<()> {
    let is_folder = baseline.is_folder();
    for (path, text) in baseline.files(SCHEMA_VERSION, measured) {
        let target = Target::File(path);
        output::prepare_targets([&target], is_folder)?;
        output::write(&target, text.into_bytes())?;
    }
    Ok(())
}

/// The options that the numbers depend on, as text.
pub(super) fn options(args: &CompareArgs) -> String {
    let CompareArgs { samples, seed, views, size, .. } = args;
    let attributes = if args.no_attributes { " --no-attributes" } else { "" };
    format!("--samples {samples} --seed {seed} --views {views} --size {size}{attributes}")
}
