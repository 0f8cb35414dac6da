//! Runs a command on each of several inputs: one that fails is reported, and the others go on.

use crate::batch::{self, Asset, Budget, OptionValues};
use crate::clock::{self, AtWork};
use crate::console;
use crate::exit::{Failure, Outcome, Status};
use crate::huge_pages;
use crate::limits::ImportArgs;
use crate::output::{self, Target};
use crate::program::Program;
use crate::progress::BatchProgress;
use clap::FromArgMatches;
use lodc::build::{Need, Size};
use lodc_assets::expected_bytes;
use lodc_formats::import;
use lodc_formats::import::Counted;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Bytes of memory that may be kept although they are free: those of a file of half a megabyte.
const SMALL: u64 = 8_000_000;

/// Options of a command by asset, parsed once for every set of them.
#[derive(Debug)]
pub(crate) struct AssetOptions<A>(BTreeMap<OptionValues, Result<A, String>>);

impl<A: FromArgMatches> AssetOptions<A> {
    /// Reads the command line anew for every set of options that assets have. `finished` also gets
    /// all options as text.
    pub(crate) fn new(
        program: &Program,
        command: &str,
        assets: &[Asset],
        finished: impl Fn(A, String) -> A,
    ) -> Self {
        let mut parsed = BTreeMap::new();
        for asset in assets {
            parsed.entry(asset.options.clone()).or_insert_with(|| {
                let read = program.arguments::<A>(command, &asset.options);
                read.map(|(args, resolved)| finished(args, resolved))
            });
        }
        Self(parsed)
    }

    /// Returns an asset's options.
    ///
    /// # Errors
    /// If one is wrong.
    pub(crate) fn of(&self, asset: &Asset) -> Outcome<&A> {
        let args = self.0[&asset.options].as_ref();
        args.map_err(|what| Failure::usage(asset.with_line(what)))
    }

    /// Returns an asset's options and its target, once its result could be written.
    ///
    /// # Errors
    /// If an option is wrong, the asset has no target, or there is no place for the result.
    pub(crate) fn ready<'a>(&'a self, asset: &'a Asset) -> Outcome<(&'a A, &'a Target)> {
        let target = asset.target.as_ref().map_err(|e| Failure::from(e.clone()))?;
        let args = self.of(asset)?;
        output::prepare_targets([target], asset.makes_folders)?;
        Ok((args, target))
    }
}

/// Does the work on every asset, several at a time, those first that need most, within a budget.
/// `need` says how many bytes that is, if it is known. Work is given the asset's number. The
/// results are in the order of the assets.
pub(crate) fn all<R: Send>(
    assets: &[Asset],
    budget: Budget,
    need: impl Fn(&Asset) -> Option<u64>,
    work: impl Fn(usize, &Asset, &BatchProgress) -> R + Sync,
) -> Vec<R> {
    let expected = |asset: &Asset| expected_bytes(&asset.input);
    let needs: Vec<u64> = match assets {
        // One is in nobody's way.
        [asset] => vec![expected(asset)],
        _ => assets.iter().map(|a| need(a).unwrap_or_else(|| expected(a))).collect(),
    };
    if let [bytes] = needs[..] {
        huge_pages::allow_for(bytes);
    }
    clock::expect_several(assets.len() > 1);
    let bar = BatchProgress::new(assets.len());
    batch::run_queue(&needs, budget, |number| {
        let asset = &assets[number];
        // Inside the pool: else every piece of work in parallel waits for another thread to wake.
        let result = rayon::scope(|_| work(number, asset, &bar));
        bar.done(&asset.name);
        result
    })
}

/// Bytes that a byte of an input comes to: itself, what it decodes to, the document that the result
/// holds, and the result.
const OF_BYTE: u64 = 4;

/// Counts what a mesh holds, and estimates the bytes of memory that work on it needs beside the
/// program's own. `needs` says what the stages do.
///
/// # Errors
/// If it cannot be read, or cannot be read twice.
pub(crate) fn estimate<const N: usize>(
    input: &Path,
    import: &ImportArgs,
    needs: impl FnOnce(Size) -> [Need; N],
) -> Outcome<(Counted, u64)> {
    if output::is_standard_stream(input) {
        let what = "standard input cannot be estimated: it can be read once only";
        return Err(Failure::usage(what));
    }
    let counted = import::count(input, &import.options())?;
    let of = Size { triangles: counted.triangles, vertices: counted.vertices };
    let most = needs(of).iter().map(|need| need.bytes).max().unwrap_or(0);
    Ok((counted, most.saturating_add(counted.bytes.saturating_mul(OF_BYTE))))
}

/// Returns whether an input is a file whose work is done before memory has to come back.
pub(crate) fn is_small(input: &Path) -> bool {
    (1..=SMALL).contains(&expected_bytes(input))
}

/// The message of a panic. The panic hook has said what and where.
const PANIC: &str = "internal error";

/// Does the work on one input. A panic is a failure of this input alone, as is work that its clock
/// ends, and a failure names it.
///
/// # Errors
/// If the work fails.
pub(crate) fn guarded<T>(input: &Path, work: impl FnOnce() -> Outcome<T>) -> Outcome<T> {
    let _turn = AtWork::new();
    let done = catch_unwind(AssertUnwindSafe(work));
    let panic = || Failure::new(Status::Bug, PANIC);
    let done = done
        .unwrap_or_else(|payload| Err(clock::time_limit_failure(&*payload).unwrap_or_else(panic)));
    done.map_err(|failure| naming(input, failure))
}

/// An error in a file that the input refers to names that file; with several inputs both are
/// needed.
fn naming(input: &Path, failure: Failure) -> Failure {
    let name = input.display().to_string();
    let of_input = matches!(failure.status, Status::Input | Status::Usage);
    if !of_input || failure.message.contains(&name) || output::is_standard_stream(input) {
        return failure;
    }
    Failure::new(failure.status, format!("{name}: {}", failure.message))
}

/// Prints a failure, unless it is a panic, which has been reported.
pub(crate) fn print(failure: &Failure) {
    if failure.message != PANIC {
        console::error(failure);
    }
}
