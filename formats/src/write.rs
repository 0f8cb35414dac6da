//! Writes output files, which appear whole or not at all.
//!
//! Each is written to a temporary file beside its target, synced, and renamed when all are
//! complete. The files of several results are synced together. A temporary file is locked for as
//! long as its writer lives, so a later run can tell files that a killed run has left behind (and
//! removes them) from those that another run is still writing.

use crate::{Fault, FormatError};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use xxhash_rust::xxh3::xxh3_64;

/// A file to be written.
#[derive(Clone, Debug)]
pub struct OutputFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Writes files beside their targets, syncs them, then renames them into place, the first file
/// last: it is the one that refers to the others. Their folders must exist. A target that is a link
/// is replaced where it leads; one that is a device or a pipe is written to directly.
///
/// # Errors
/// If one cannot be written; then none of the targets has changed where the system allows that.
pub fn write_all(files: &[OutputFile]) -> Result<(), FormatError> {
    write_each(&[files]).pop().expect("an answer for each result")
}

/// Writes several results, each as [`write_all`] does, with the files of all synced at one time: a
/// sync takes as long as a hundred small writes, and many at one time take little more than one.
/// Returns for each result whether it was written; a failure does not affect the others.
pub fn write_each(results: &[&[OutputFile]]) -> Vec<Result<(), FormatError>> {
    let write = |file: &OutputFile| {
        Pending::write(file).map_err(|e| not_written(&file.path, &e)).transpose()
    };
    let mut written: Vec<Result<Vec<Pending>, FormatError>> =
        results.iter().map(|files| files.iter().filter_map(write).collect()).collect();
    sync(&mut written);
    let mut folders = BTreeSet::new();
    let put_in_place = |pending: Result<Vec<Pending>, FormatError>| {
        let done = renamed(pending?)?;
        folders.extend(done.iter().filter_map(|d| d.target.parent().map(Path::to_owned)));
        Ok(())
    };
    let placed = written.into_iter().map(put_in_place).collect();
    for folder in folders {
        // The file is complete either way: this only makes its new name survive a power failure.
        let _ = File::open(folder).and_then(|f| f.sync_all());
    }
    placed
}

/// Threads that sync files at one time. Chosen by hand: they wait, and take no processor time.
const SYNC_THREADS: usize = 16;

/// Syncs the files of all results, several at one time. A result becomes the failure of one of its
/// files.
fn sync(written: &mut [Result<Vec<Pending>, FormatError>]) {
    let all = || written.iter().flatten().flatten();
    // On this thread, because a test plans faults for its own thread.
    let answers = all().map(|_| Mutex::new(system())).collect::<Vec<_>>();
    let files: Vec<Option<&File>> =
        all().map(|pending| pending.temporary.as_ref().map(|t| &t.file)).collect();
    let next = AtomicUsize::new(0);
    let work = || {
        while let Some((answer, file)) = {
            let number = next.fetch_add(1, Ordering::Relaxed);
            answers.get(number).zip(files.get(number))
        } {
            let mut answer = answer.lock().unwrap_or_else(PoisonError::into_inner);
            if let (Ok(()), Some(file)) = (&*answer, file) {
                *answer = file.sync_all();
            }
        }
    };
    thread::scope(|scope| {
        for _ in 1..files.len().min(SYNC_THREADS) {
            // If the system refuses a thread, the others do its part.
            let _ = thread::Builder::new().spawn_scoped(scope, work);
        }
        work();
    });
    let mut answers =
        answers.into_iter().map(|a| a.into_inner().unwrap_or_else(PoisonError::into_inner));
    for result in written {
        let Ok(pending) = result else { continue };
        let result_answers: Vec<_> = answers.by_ref().take(pending.len()).collect();
        let mut synced = result_answers.into_iter().zip(&*pending);
        let failed = synced.find_map(|(answer, file)| Some((answer.err()?, file)));
        if let Some((e, pending)) = failed {
            *result = Err(not_written(&pending.target, &e));
        }
    }
}

/// Renames the files of one result, which are complete.
fn renamed(pending: Vec<Pending>) -> Result<Vec<Pending>, FormatError> {
    // With one file the rename is all or nothing by itself.
    let several = pending.len() > 1;
    let mut done: Vec<Pending> = Vec::new();
    for mut next in pending.into_iter().rev() {
        if let Err(e) = next.commit(several) {
            let error = not_written(&next.target, &e);
            done.into_iter().rev().for_each(Pending::undo);
            return Err(error);
        }
        done.push(next);
    }
    Ok(done)
}

/// Called before each call of the system that can fail; in tests it can make the n-th one fail.
#[cfg(not(test))]
fn system() -> io::Result<()> {
    Ok(())
}
#[cfg(test)]
use tests::faults::system;

fn not_written(path: &Path, error: &io::Error) -> FormatError {
    FormatError::new(Fault::NotWritten, "", format!("cannot be written: {error}"))
        .in_file(&path.display().to_string())
}

/// A complete temporary file that waits for its rename. Dropping it removes the temporary file,
/// unless it was renamed, and the backup.
#[derive(Debug)]
struct Pending {
    target: PathBuf,
    temporary: Option<Temporary>,
    /// A second name of the file that was at the target before.
    backup: Option<PathBuf>,
    /// True if there was no file at the target.
    replaced_nothing: bool,
}

impl Pending {
    /// Writes one file, without syncing it; none if the target took the bytes directly.
    fn write(file: &OutputFile) -> io::Result<Option<Self>> {
        let (target, permissions) = match fs::metadata(&file.path) {
            Ok(m) if m.is_dir() => return Err(io::Error::other("there is a folder of that name")),
            Ok(m) if !m.is_file() => {
                OpenOptions::new().write(true).open(&file.path)?.write_all(&file.bytes)?;
                return Ok(None);
            }
            Ok(m) => (file.path.canonicalize()?, Some(m.permissions())),
            Err(_) => (file.path.clone(), None),
        };
        let name =
            target.file_name().ok_or_else(|| io::Error::other("that is not the name of a file"))?;
        let folder = match target.parent() {
            Some(p) if p != Path::new("") => p,
            _ => Path::new("."),
        };
        let prefix = format!(".lodc-{:016x}-", xxh3_64(name.as_encoded_bytes()));
        remove_stale(folder, &prefix);
        let mut temporary = Temporary::create(folder, &prefix)?;
        temporary.file.write_all(&file.bytes).and_then(|()| system())?;
        if let Some(p) = permissions {
            system().and_then(|()| temporary.file.set_permissions(p))?;
        }
        Ok(Some(Self { target, temporary: Some(temporary), backup: None, replaced_nothing: false }))
    }

    /// Puts the file in its place, keeping what was there if that may be needed again.
    fn commit(&mut self, keep_old: bool) -> io::Result<()> {
        let Some(temporary) = &self.temporary else { return Ok(()) };
        if keep_old {
            // A second name for the old file. Where there are no hard links there is no way back,
            // which is allowed.
            let backup = temporary.path.with_extension("old");
            match system().and_then(|()| fs::hard_link(&self.target, &backup)) {
                Ok(()) => self.backup = Some(backup),
                Err(e) => self.replaced_nothing = e.kind() == io::ErrorKind::NotFound,
            }
        }
        system().and_then(|()| fs::rename(&temporary.path, &self.target))?;
        if let Some(t) = &mut self.temporary {
            t.renamed = true;
        }
        Ok(())
    }

    /// Puts back what was at the target. Best effort: the failure that led here is the one to
    /// report.
    fn undo(mut self) {
        match self.backup.take() {
            Some(old) => drop(system().and_then(|()| fs::rename(old, &self.target))),
            None if self.replaced_nothing => {
                drop(system().and_then(|()| fs::remove_file(&self.target)));
            }
            None => {}
        }
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        if let Some(old) = self.backup.take() {
            let _ = fs::remove_file(old);
        }
    }
}

/// A locked temporary file, removed when dropped unless it was renamed.
#[derive(Debug)]
struct Temporary {
    file: File,
    path: PathBuf,
    renamed: bool,
}

impl Temporary {
    fn create(folder: &Path, prefix: &str) -> io::Result<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        loop {
            let n = NEXT.fetch_add(1, Ordering::Relaxed);
            let path = folder.join(format!("{prefix}{}-{n}.tmp", std::process::id()));
            match system()
                .and_then(|()| OpenOptions::new().write(true).create_new(true).open(&path))
            {
                Ok(file) => {
                    // Another run has the lock: it saw the file before it was locked and is about
                    // to remove it. Where locks are not supported, nothing is removed either.
                    if matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock)) {
                        continue;
                    }
                    let temporary = Self { file, path, renamed: false };
                    // Removed between its creation and its lock.
                    if temporary.path.exists() {
                        return Ok(temporary);
                    }
                }
                // Left by a killed run that had the same process number.
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.renamed {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Removes what killed runs left for the same target: temporary files and backups whose writer no
/// longer holds the lock.
fn remove_stale(folder: &Path, prefix: &str) {
    for path in leftovers(folder, prefix) {
        // The lock is held while the file is removed, so that its writer, should it live, cannot
        // lock it meanwhile. A backup has no lock itself; its writer's temporary file has.
        let is_backup = path.extension().is_some_and(|e| e == "old");
        let lock = if is_backup { path.with_extension("tmp") } else { path.clone() };
        match File::open(lock) {
            Ok(file) if file.try_lock().is_ok() => drop(fs::remove_file(path)),
            Err(e) if e.kind() == io::ErrorKind::NotFound => drop(fs::remove_file(path)),
            _ => {}
        }
    }
}

/// Temporary files and backups by the beginnings of their names, one for each target.
type Leftovers = BTreeMap<String, Vec<PathBuf>>;

/// The temporary files and backups of a target that were in the folder when this process first
/// wrote there. Each folder is listed once: listing it for each file would take quadratic time.
fn leftovers(folder: &Path, prefix: &str) -> Vec<PathBuf> {
    static LEFTOVERS: Mutex<BTreeMap<PathBuf, Leftovers>> = Mutex::new(BTreeMap::new());
    let mut by_folder = LEFTOVERS.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let leftovers = by_folder.entry(folder).or_insert_with_key(|folder| listed(folder));
    leftovers.remove(prefix).unwrap_or_default()
}

/// All files in a folder that are named as temporary files and backups are.
fn listed(folder: &Path) -> Leftovers {
    let mut found = Leftovers::new();
    let Ok(entries) = fs::read_dir(folder) else { return found };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        // `.lodc-`, sixteen digits, `-`, then numbers.
        let Some((prefix, rest)) = name.split_at_checked(PREFIX_BYTES) else { continue };
        let id = rest.strip_suffix(".tmp").or_else(|| rest.strip_suffix(".old"));
        let is_leftover = prefix.starts_with(".lodc-")
            && id.is_some_and(|id| id.bytes().all(|b| b.is_ascii_digit() || b == b'-'));
        if is_leftover && entry.file_type().is_ok_and(|t| t.is_file()) {
            found.entry(prefix.to_owned()).or_default().push(entry.path());
        }
    }
    found
}

/// Bytes of the beginning of a temporary file's name, which is the same for all of a target.
const PREFIX_BYTES: usize = ".lodc-".len() + 16 + 1;

#[cfg(test)]
mod tests;
