//! Runs a command on each of several inputs: one that fails is reported, and the others go on.

use crate::batch::{Budget, Job, OptionValues};
use crate::clock::{self, AtWork};
use crate::console;
use crate::exit::{Failure, Outcome, Status};
use crate::huge_pages;
use crate::jobs::{Queue, expected_bytes, locked};
use crate::output::{self, Target};
use crate::program::Program;
use crate::progress::BatchProgress;
use clap::FromArgMatches;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::thread;

/// The arguments of a command for each job, parsed once for every set of options.
#[derive(Debug)]
pub(crate) struct JobOptions<A>(BTreeMap<OptionValues, Result<A, String>>);

impl<A: FromArgMatches> JobOptions<A> {
    /// Reads the command line anew for every set of options that jobs have. `with_text` stores the
    /// options' text in the arguments, for the result's record.
    pub(crate) fn new(
        program: &Program,
        command: &str,
        jobs: &[Job],
        with_text: impl Fn(A, String) -> A,
    ) -> Self {
        let mut parsed = BTreeMap::new();
        for job in jobs {
            parsed.entry(job.options.clone()).or_insert_with(|| {
                let read = program.arguments::<A>(command, &job.options);
                read.map(|(args, text)| with_text(args, text))
            });
        }
        Self(parsed)
    }

    /// Returns the arguments for a job.
    ///
    /// # Errors
    /// If one is wrong.
    pub(crate) fn of(&self, job: &Job) -> Outcome<&A> {
        let args = self.0[&job.options].as_ref();
        args.map_err(|what| Failure::usage(job.with_line(what)))
    }

    /// Returns the arguments for a job and its target, and makes sure that its result can be
    /// written.
    ///
    /// # Errors
    /// If an option is wrong, the job has no target, or its result cannot be written.
    pub(crate) fn ready<'a>(&'a self, job: &'a Job) -> Outcome<(&'a A, &'a Target)> {
        let target = job.target.as_ref().map_err(|e| Failure::from(e.clone()))?;
        let args = self.of(job)?;
        output::prepare_targets([target], job.makes_folders)?;
        Ok((args, target))
    }
}

/// Does the work of every job, several at a time within a budget, first those that need most
/// memory. `need` says how many bytes a job needs, if that is known. `work` also gets the job's
/// number. The results are in the order of the jobs.
pub(crate) fn all<R: Send>(
    jobs: &[Job],
    budget: Budget,
    need: impl Fn(&Job) -> Option<u64>,
    work: impl Fn(usize, &Job, &BatchProgress) -> R + Sync,
) -> Vec<R> {
    let expected = |job: &Job| expected_bytes(&job.input);
    let needs: Vec<u64> = match jobs {
        // A single job shares memory with no other, so a rough number will do.
        [job] => vec![expected(job)],
        _ => jobs.iter().map(|job| need(job).unwrap_or_else(|| expected(job))).collect(),
    };
    if let [bytes] = needs[..] {
        huge_pages::allow_for(bytes);
    }
    clock::expect_several(jobs.len() > 1);
    let bar = BatchProgress::new(jobs.len());
    let queue = Queue::new(&needs, budget.bytes);
    let results: Vec<Mutex<Option<R>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let worker = || {
        while let Some(number) = queue.take() {
            let job = &jobs[number];
            // Inside the pool: else each parallel step waits until another thread wakes.
            let result = rayon::scope(|_| work(number, job, &bar));
            bar.done(&job.name);
            *locked(&results[number]) = Some(result);
            queue.release(number);
        }
    };
    thread::scope(|scope| {
        // The calling thread is a worker too.
        for _ in 1..budget.workers.clamp(1, jobs.len().max(1)) {
            scope.spawn(worker);
        }
        worker();
    });
    let all = results.into_iter().map(|r| r.into_inner().unwrap_or_else(PoisonError::into_inner));
    all.map(|result| result.expect("every job has had its turn")).collect()
}

/// The message of a panic's failure. The panic hook has already printed what happened and where.
const PANIC_MESSAGE: &str = "internal error";

/// Does the work on one input. A panic, or a clock that ends the work, is a failure of this input
/// alone. Its failures name it.
///
/// # Errors
/// If the work fails.
pub(crate) fn guarded<T>(input: &Path, work: impl FnOnce() -> Outcome<T>) -> Outcome<T> {
    let _at_work = AtWork::new();
    let done = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(done) => done,
        Err(payload) => Err(clock::time_limit_failure(&*payload).unwrap_or_else(internal_error)),
    };
    done.map_err(|failure| with_input_name(input, failure))
}

fn internal_error() -> Failure {
    Failure { status: Status::Bug, message: PANIC_MESSAGE.to_owned() }
}

/// Puts the input's name in front of a failure that names only a file that the input refers to.
fn with_input_name(input: &Path, failure: Failure) -> Failure {
    let name = input.display().to_string();
    let is_about_input = matches!(failure.status, Status::Input | Status::Usage);
    if !is_about_input || failure.message.contains(&name) || output::is_standard_stream(input) {
        return failure;
    }
    Failure::new(failure.status, format!("{name}: {}", failure.message))
}

/// Prints a failure, unless it is a panic, which has been reported.
pub(crate) fn print(failure: &Failure) {
    if failure.message != PANIC_MESSAGE {
        console::error(failure);
    }
}
