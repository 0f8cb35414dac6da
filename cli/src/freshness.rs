//! Whether a result is up to date: by the content of everything it was made from, never by times.

use crate::output::is_stream;
use lodc_formats::lodc::{self, MadeFrom, VERSION};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

/// Returns what a result is made from: its input, the other files that were read for it, and its
/// options as text. None if that cannot be told for sure: an input that came as a stream, a file
/// that has changed since `start`.
pub(crate) fn made_from(
    input: &Path,
    files: &[PathBuf],
    options: &str,
    start: SystemTime,
) -> Option<MadeFrom> {
    let settled =
        |file: &Path| file.metadata().and_then(|m| m.modified()).is_ok_and(|t| t <= start);
    if is_stream(input) || !settled(input) || !files.iter().all(|file| settled(file)) {
        return None;
    }
    let others = files.iter().filter(|file| *file != input);
    let names: Vec<String> = others
        .map(|file| file.strip_prefix(folder(input)).unwrap_or(file).to_string_lossy().into_owned())
        .collect();
    let key = key(input, &names, options)?;
    Some(MadeFrom { key, files: names })
}

/// Returns the files that an up-to-date result was made from; none if it has to be made: it is
/// not there, is damaged, does not say what it was made from, or that has changed.
pub(crate) fn up_to_date(output: &Path, input: &Path, options: &str) -> Option<Vec<PathBuf>> {
    let made = lodc::made_from(&fs::read(output).ok()?).ok()??;
    if key(input, &made.files, options)? != made.key {
        return None;
    }
    let others = made.files.iter().map(|name| folder(input).join(name));
    Some(std::iter::once(input.to_owned()).chain(others).collect())
}

/// A hash of program, format, options and the content of all files; none if one cannot be read.
fn key(input: &Path, names: &[String], options: &str) -> Option<u128> {
    let mut state = Xxh3::new();
    let mut part = |bytes: &[u8]| {
        state.update(&(bytes.len() as u64).to_le_bytes());
        state.update(bytes);
    };
    part(env!("CARGO_PKG_VERSION").as_bytes());
    part(&VERSION.to_le_bytes());
    part(options.as_bytes());
    part(&xxh3_128(&fs::read(input).ok()?).to_le_bytes());
    for name in names {
        part(name.as_bytes());
        part(&xxh3_128(&fs::read(folder(input).join(name)).ok()?).to_le_bytes());
    }
    Some(state.digest128())
}

fn folder(input: &Path) -> &Path {
    input.parent().unwrap_or(Path::new(""))
}
