//! The n-th call of the system fails, for every n until nothing fails any more; then every two of
//! them.

use super::{names, output, read};
use crate::Fault;
use crate::testing::Scratch;
use crate::write::{OutputFile, write_all, write_each};
use std::cell::RefCell;
use std::io;

thread_local! {
    /// Calls so far, and which of them fail.
    static CALLS: RefCell<(usize, Vec<usize>)> = const { RefCell::new((0, Vec::new())) };
}

/// Hook that `write.rs` calls before each call that can fail.
pub(in crate::write) fn system() -> io::Result<()> {
    CALLS.with_borrow_mut(|(calls, failing)| {
        *calls += 1;
        if failing.contains(calls) {
            Err(io::Error::other(format!("call {calls} fails")))
        } else {
            Ok(())
        }
    })
}

/// Runs with these calls failing; says how many calls there were.
fn with_failing<T>(calls: &[usize], run: impl FnOnce() -> T) -> (T, usize) {
    CALLS.set((0, calls.to_vec()));
    let result = run();
    (result, CALLS.take().0)
}

/// Content of the target of one file before the run.
const OLD: &[u8] = b"old";

/// Files to be written, the first of them over old ones.
fn outputs(scratch: &Scratch, existing: &[bool]) -> Vec<OutputFile> {
    let one = |(i, &there): (usize, &bool)| {
        let name = format!("{i}.out");
        if there {
            scratch.write(&name, OLD);
        } else {
            let _ = std::fs::remove_file(scratch.path(&name));
        }
        output(scratch.path(&name), format!("new {i}").as_bytes())
    };
    existing.iter().enumerate().map(one).collect()
}

/// For each file `Some(true)` if it is new, `Some(false)` if it is old, none if it is not there.
/// Nothing else may be there, except backups that could not be put back, which the next run
/// removes.
fn state(scratch: &Scratch, files: usize, undo_fails: bool, case: &str) -> Vec<Option<bool>> {
    let found = names(scratch);
    let is_allowed =
        |name: &String| name.ends_with(".out") || (undo_fails && name.ends_with(".old"));
    assert!(found.iter().all(is_allowed), "{case}: {found:?}");
    let is_new = |i| {
        let name = format!("{i}.out");
        found.contains(&name).then(|| match read(scratch, &name) {
            bytes if bytes == format!("new {i}").as_bytes() => true,
            bytes if bytes == OLD => false,
            other => panic!("{case}: {name} is torn: {other:?}"),
        })
    };
    (0..files).map(is_new).collect()
}

/// For each file of a result whether it replaces one.
const SITUATIONS: &[&[bool]] =
    &[&[false], &[true], &[true, true, true], &[false, true, false], &[false, false]];

#[test]
fn whichever_call_fails_all_old_files_stand_or_all_new_ones() {
    for existing in SITUATIONS {
        let scratch = Scratch::new("write-faults");
        let before: Vec<Option<bool>> =
            existing.iter().map(|&exists| exists.then_some(false)).collect();
        let after = vec![Some(true); existing.len()];
        let mut failed = 0;
        for n in 1.. {
            let files = outputs(&scratch, existing);
            let (result, calls) = with_failing(&[n], || write_all(&files));
            let case = format!("{existing:?}, call {n}");
            match result {
                Err(e) => {
                    assert_eq!(e.fault, Fault::NotWritten, "{case}: {e}");
                    assert_eq!(e.to_string().lines().count(), 1, "{case}: {e}");
                    assert!(
                        files.iter().any(|f| e.file == f.path.display().to_string()),
                        "{case}: {e}"
                    );
                    assert_eq!(
                        state(&scratch, existing.len(), false, &case),
                        before,
                        "{case}: {e}"
                    );
                    failed += 1;
                }
                // Not every failure matters: without a backup the file is still written.
                Ok(()) => {
                    assert_eq!(state(&scratch, existing.len(), false, &case), after, "{case}");
                }
            }
            if calls < n {
                break;
            }
        }
        // Create, write, sync and rename, and the mode where there was a file.
        let wanted: usize = existing.iter().map(|&exists| 4 + usize::from(exists)).sum();
        assert_eq!(failed, wanted, "{existing:?}");
    }
}

#[test]
fn whichever_two_calls_fail_no_file_is_torn_or_lost() {
    for existing in SITUATIONS {
        let scratch = Scratch::new("write-two-faults");
        let ((), calls) =
            with_failing(&[], || write_all(&outputs(&scratch, existing)).expect("nothing fails"));
        for first in 1..=calls {
            // Undoing makes further calls.
            for second in first + 1..=2 * calls {
                let files = outputs(&scratch, existing);
                let (result, _) = with_failing(&[first, second], || write_all(&files));
                let case = format!("{existing:?}, calls {first} and {second}");
                let now = state(&scratch, existing.len(), true, &case);
                for (now, &existed) in now.iter().zip(*existing) {
                    assert!(now.is_some() || !existed, "{case}: an old file is gone");
                    assert!(result.is_err() || *now == Some(true), "{case}: said to be written");
                }
            }
        }
    }
}

/// Results that are written together: if one call fails each is old or new, as its answer says.
#[test]
fn whichever_call_fails_of_several_results_each_is_what_is_told() {
    let scratch = Scratch::new("write-each-faults");
    for failing in 1.. {
        let files = outputs(&scratch, &[true, false, true, false, true]);
        let results = [&files[..1], &files[1..3], &files[3..]];
        let (written, calls) = with_failing(&[failing], || write_each(&results));
        let states = state(&scratch, files.len(), false, "several results");
        let mut unchecked = &states[..];
        for (files, written) in results.iter().zip(&written) {
            let (states, rest) = unchecked.split_at(files.len());
            unchecked = rest;
            let is_new = states.iter().all(|&file| file == Some(true));
            assert_eq!(is_new, written.is_ok(), "call {failing}: {states:?}, {written:?}");
            assert!(is_new || !states.contains(&Some(true)), "{failing}: {states:?}");
        }
        if failing > calls {
            assert!(written.iter().all(Result::is_ok), "nothing failed");
            return;
        }
        assert!(written.iter().filter(|w| w.is_err()).count() <= 1, "call {failing}");
    }
}
