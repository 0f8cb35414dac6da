//! Writes results to a file or standard output, complete or not at all, and Makefile dependency
//! files.

use crate::exit::{Failure, Outcome};
use crate::jobs::JobError;
use crate::{console, interrupt};
use lodc_formats::{OutputFile, RequestedFiles, write_all, write_each};
use std::collections::BTreeSet;
use std::mem::take;
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

pub(crate) use crate::jobs::{
    DependencyRule, Target, is_folder, is_standard_stream, of_kind, path_identity, prepare_targets,
    single_target,
};

/// Writes files, all or none; an interruption waits until they are in place.
///
/// # Errors
/// If one cannot be written.
pub(crate) fn commit(files: &[OutputFile]) -> Outcome<()> {
    // Copies of image files may have folders of their own.
    for folder in files.iter().skip(1).filter_map(|f| f.path.parent()) {
        if folder != Path::new("") && !folder.exists() {
            let made = std::fs::create_dir_all(folder);
            made.map_err(|e| JobError::Output(format!("{}: not written: {e}", folder.display())))?;
        }
    }
    // Opening a pipe without a reader blocks, so there an interruption must get through; it leaves
    // no partial file either, since pipes and devices are written to directly.
    let commit_guard = (!files.iter().any(is_special)).then(interrupt::committing);
    write_all(files)?;
    commit_guard.into_iter().for_each(|mut placed| *placed = true);
    Ok(())
}

/// Refuses to write over a file that an input names and that was read: its buffers, materials,
/// images. A pipe or device replaces nothing.
///
/// # Errors
/// If one of `outputs` is such a file.
pub(crate) fn refuse_replacing<'a>(
    outputs: impl IntoIterator<Item = &'a Path>,
    read: &RequestedFiles,
) -> Outcome<()> {
    let read: BTreeSet<PathBuf> =
        read.read_files().iter().filter(|f| f.is_file()).map(|f| path_identity(f)).collect();
    match outputs.into_iter().find(|output| read.contains(&path_identity(output))) {
        Some(output) => {
            let output = output.display();
            Err(Failure::usage(format!("{output}: the output would replace a file of an input")))
        }
        None => Ok(()),
    }
}

/// Returns whether a file is a pipe or a device.
fn is_special(file: &OutputFile) -> bool {
    file.path.metadata().is_ok_and(|m| !m.is_file())
}

/// Results that wait to be written, at most. Chosen by hand, as are the next two: more at a time
/// saves time of syncing, but results are on the disk and reported later.
const MAX_WAITING_RESULTS: usize = 64;
/// Their bytes at most.
const MAX_WAITING_BYTES: usize = 16 << 20;
/// How long a result waits at most.
const MAX_WAIT: Duration = Duration::from_millis(500);

/// Writes the results of many assets, many at a time: syncing each by itself would take most of the
/// time of small ones.
pub(crate) struct Results<T, F> {
    /// Called with a result's context once it is written or could not be.
    on_written: F,
    waiting: Mutex<Waiting<T>>,
    all_added: Condvar,
}

struct Waiting<T> {
    /// Files with their contexts.
    results: Vec<(OutputFile, T)>,
    /// Whether no more results come.
    is_over: bool,
}

impl<T: Send, F: Fn(T, Outcome<()>) + Sync> Results<T, F> {
    /// Lets `work` add results, and calls `on_written` for each.
    pub(crate) fn gather(on_written: F, work: impl FnOnce(&Self)) {
        let waiting = Mutex::new(Waiting { results: Vec::new(), is_over: false });
        let results = Self { on_written, waiting, all_added: Condvar::new() };
        thread::scope(|scope| {
            // If this thread cannot be started, results wait until there are enough of them.
            let _ = thread::Builder::new().spawn_scoped(scope, || results.write_at_intervals());
            let ends_writer = EndsWriter(&results);
            work(&results);
            drop(ends_writer);
            results.write(results.waiting());
        });
    }

    /// Adds a result, which may wait for others; without a file it counts as written at once.
    pub(crate) fn add(&self, file: Option<OutputFile>, context: T) {
        let Some(file) = file else { return (self.on_written)(context, Ok(())) };
        if is_special(&file) {
            return (self.on_written)(context, commit(&[file]));
        }
        let mut waiting = self.waiting();
        waiting.results.push((file, context));
        let bytes: usize = waiting.results.iter().map(|(file, _)| file.bytes.len()).sum();
        if waiting.results.len() >= MAX_WAITING_RESULTS || bytes >= MAX_WAITING_BYTES {
            self.write(waiting);
        }
    }

    fn waiting(&self) -> MutexGuard<'_, Waiting<T>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn write_at_intervals(&self) {
        loop {
            let waited = self.all_added.wait_timeout(self.waiting(), MAX_WAIT);
            let waiting = waited.unwrap_or_else(PoisonError::into_inner).0;
            if waiting.is_over {
                return;
            }
            self.write(waiting);
        }
    }

    /// Writes the results that wait.
    fn write(&self, mut waiting: MutexGuard<'_, Waiting<T>>) {
        let results = take(&mut waiting.results);
        drop(waiting);
        let (files, contexts): (Vec<OutputFile>, Vec<T>) = results.into_iter().unzip();
        let single_files: Vec<&[OutputFile]> = files.iter().map(std::slice::from_ref).collect();
        let commit_guard = interrupt::committing();
        let written = write_each(&single_files);
        drop(commit_guard);
        for (context, written) in contexts.into_iter().zip(written) {
            (self.on_written)(context, written.map_err(Failure::from));
        }
    }
}

/// Ends the thread that writes at intervals, also when the work panics.
struct EndsWriter<'a, T, F>(&'a Results<T, F>);

impl<T, F> Drop for EndsWriter<'_, T, F> {
    fn drop(&mut self) {
        self.0.waiting.lock().unwrap_or_else(PoisonError::into_inner).is_over = true;
        self.0.all_added.notify_all();
    }
}

/// Writes one result.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(target: &Target, bytes: Vec<u8>) -> Outcome<()> {
    match target {
        Target::Stdout => console::bytes(&bytes),
        Target::File(path) => commit(&[OutputFile { path: path.clone(), bytes }]),
    }
}

/// Writes a Make/Ninja dependency file.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write_depfile(path: &Path, rules: &[DependencyRule]) -> Outcome<()> {
    rules.iter().try_for_each(DependencyRule::check)?;
    let text: String = rules.iter().map(DependencyRule::text).collect();
    write(&Target::File(path.to_owned()), text.into_bytes())
}
