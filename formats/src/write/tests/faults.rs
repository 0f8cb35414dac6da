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

/// Files that are there, complete: `Some(true)` new, `Some(false)` old, none if there is none.
/// Nothing else may be, but for old files that could not be put back: the next run removes those.
fn state(scratch: &Scratch, files: usize, way_back_fails: bool, case: &str) -> Vec<Option<bool>> {
    let left = names(scratch);
    let known =
        |name: &String| name.ends_with(".out") || (way_back_fails && name.ends_with(".old"));
    assert!(left.iter().all(known), "{case}: {left:?}");
    let one = |i| {
        let name = format!("{i}.out");
        left.contains(&name).then(|| match read(scratch, &name) {
            bytes if bytes == format!("new {i}").as_bytes() => true,
            bytes if bytes == OLD => false,
            other => panic!("{case}: {name} is torn: {other:?}"),
        })
    };
    (0..files).map(one).collect()
}

/// One file, new or replaced; three of which some are.
const SITUATIONS: &[&[bool]] =
    &[&[false], &[true], &[true, true, true], &[false, true, false], &[false, false]];

#[test]
fn whichever_call_fails_all_old_files_stand_or_all_new_ones() {
    for existing in SITUATIONS {
        let scratch = Scratch::new("write-faults");
        let before: Vec<Option<bool>> =
            existing.iter().map(|&there| there.then_some(false)).collect();
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
                // Not every failure matters: a second name for the old file is a help, not a need.
                Ok(()) => {
                    assert_eq!(state(&scratch, existing.len(), false, &case), after, "{case}");
                }
            }
            if calls < n {
                break;
            }
        }
        // Create, write, sync and rename, and the mode where there was a file.
        let wanted: usize = existing.iter().map(|&there| 4 + usize::from(there)).sum();
        assert_eq!(failed, wanted, "{existing:?}");
    }
}

#[test]
fn whichever_two_calls_fail_no_file_is_torn_or_lost() {
    for existing in SITUATIONS {
        let scratch = Scratch::new("write-two-faults");
        let ((), most) =
            with_failing(&[], || write_all(&outputs(&scratch, existing)).expect("nothing fails"));
        for first in 1..=most {
            // The way back makes further calls.
            for second in first + 1..=2 * most {
                let files = outputs(&scratch, existing);
                let (result, _) = with_failing(&[first, second], || write_all(&files));
                let case = format!("{existing:?}, calls {first} and {second}");
                let now = state(&scratch, existing.len(), true, &case);
                for (now, &there) in now.iter().zip(*existing) {
                    assert!(now.is_some() || !there, "{case}: an old file is gone");
                    assert!(result.is_err() || *now == Some(true), "{case}: said to be written");
                }
            }
        }
    }
}

/// Results that are written together: with one call failing each is old or new, and told as it is.
#[test]
fn whichever_call_fails_of_several_results_each_is_what_is_told() {
    let scratch = Scratch::new("write-each-faults");
    for failing in 1.. {
        let files = outputs(&scratch, &[true, false, true, false, true]);
        let results = [&files[..1], &files[1..3], &files[3..]];
        let (written, calls) = with_failing(&[failing], || write_each(&results));
        let there = state(&scratch, files.len(), false, "several results");
        let mut at = 0;
        for (files, written) in results.iter().zip(&written) {
            let own = &there[at..at + files.len()];
            at += files.len();
            let is_new = own.iter().all(|&file| file == Some(true));
            assert_eq!(is_new, written.is_ok(), "call {failing}: {own:?}, {written:?}");
            assert!(is_new || own.iter().all(|&file| file != Some(true)), "{failing}: {own:?}");
        }
        if failing > calls {
            assert!(written.iter().all(Result::is_ok), "nothing failed");
            return;
        }
        assert!(written.iter().filter(|w| w.is_err()).count() <= 1, "call {failing}");
    }
}
