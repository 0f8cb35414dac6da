//! Writes results to a file or standard output, complete or not at all, and Makefile dependency
//! files.

use crate::exit::{Failure, Outcome};
use crate::{console, interrupt};
use lodc_assets::AssetError;
use lodc_formats::{OutputFile, write_all, write_each};
use std::mem::take;
use std::path::Path;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

pub(crate) use lodc_assets::{
    DependencyRule, Target, is_folder, is_standard_stream, prepare_targets, single_target,
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
            made.map_err(|e| {
                AssetError::Output(format!("{}: not written: {e}", folder.display()))
            })?;
        }
    }
    // Opening a pipe without a reader waits for ever, so there an interruption must get through;
    // it leaves nothing behind either, since pipes and devices are written to directly.
    let commit_guard = (!files.iter().any(is_special)).then(interrupt::committing);
    write_all(files)?;
    commit_guard.into_iter().for_each(|mut placed| *placed = true);
    Ok(())
}

/// Returns whether a file is a pipe or a device.
fn is_special(file: &OutputFile) -> bool {
    file.path.metadata().is_ok_and(|m| !m.is_file())
}

/// Results that are written together.
const TOGETHER: usize = 64;
/// Bytes of results that wait to be written.
const WAITING: usize = 16 << 20;
/// How long a result waits at most while others come.
const PATIENCE: Duration = Duration::from_millis(500);

/// Results of many assets, written many at a time: syncing each by itself takes most of the time of
/// small ones. What became of a result is told once it is known.
pub(crate) struct Results<T, F> {
    told: F,
    waiting: Mutex<Waiting<T>>,
    ended: Condvar,
}

struct Waiting<T> {
    results: Vec<(OutputFile, T)>,
    is_over: bool,
}

impl<T: Send, F: Fn(T, Outcome<()>) + Sync> Results<T, F> {
    /// Lets `work` hand in results, and tells `told` what became of each.
    pub(crate) fn gather(told: F, work: impl FnOnce(&Self)) {
        let waiting = Mutex::new(Waiting { results: Vec::new(), is_over: false });
        let results = Self { told, waiting, ended: Condvar::new() };
        thread::scope(|scope| {
            // Without this thread results wait until there are enough of them.
            let _ = thread::Builder::new().spawn_scoped(scope, || results.write_now_and_then());
            let over = Over(&results);
            work(&results);
            drop(over);
            results.write(results.waiting());
        });
    }

    /// Takes a result, which may wait for others; without a file there is nothing to wait for.
    pub(crate) fn add(&self, file: Option<OutputFile>, what: T) {
        let Some(file) = file else { return (self.told)(what, Ok(())) };
        if is_special(&file) {
            return (self.told)(what, commit(&[file]));
        }
        let mut waiting = self.waiting();
        waiting.results.push((file, what));
        let bytes: usize = waiting.results.iter().map(|(file, _)| file.bytes.len()).sum();
        if waiting.results.len() >= TOGETHER || bytes >= WAITING {
            self.write(waiting);
        }
    }

    fn waiting(&self) -> MutexGuard<'_, Waiting<T>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn write_now_and_then(&self) {
        loop {
            let waited = self.ended.wait_timeout(self.waiting(), PATIENCE);
            let waiting = waited.unwrap_or_else(PoisonError::into_inner).0;
            if waiting.is_over {
                return;
            }
            self.write(waiting);
        }
    }

    /// Writes what waits.
    fn write(&self, mut waiting: MutexGuard<'_, Waiting<T>>) {
        let results = take(&mut waiting.results);
        drop(waiting);
        let (files, whats): (Vec<OutputFile>, Vec<T>) = results.into_iter().unzip();
        let each: Vec<&[OutputFile]> = files.iter().map(std::slice::from_ref).collect();
        let commit_guard = interrupt::committing();
        let written = write_each(&each);
        drop(commit_guard);
        for (what, written) in whats.into_iter().zip(written) {
            (self.told)(what, written.map_err(Failure::from));
        }
    }
}

/// Ends the thread that writes now and then, also when the work panics.
struct Over<'a, T, F>(&'a Results<T, F>);

impl<T, F> Drop for Over<'_, T, F> {
    fn drop(&mut self) {
        self.0.waiting.lock().unwrap_or_else(PoisonError::into_inner).is_over = true;
        self.0.ended.notify_all();
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
