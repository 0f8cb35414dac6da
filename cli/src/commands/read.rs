//! Reads a `.lodc` file and prints its warnings: shared by the commands that take one.

use crate::batch::{MESH_EXTENSIONS, has_extension};
use crate::console;
use crate::exit::Outcome;
use lodc::{LodFile, read};
use lodc_formats::{Assets, FormatError, Limits};
use std::path::Path;

/// Reads a container from a file, or from standard input if that is `-`. Warns of parts that this
/// version does not know. Also returns the bytes.
///
/// # Errors
/// If it cannot be read or is damaged.
pub(crate) fn read_lodc(path: &Path, limits: Limits) -> Outcome<(LodFile, Vec<u8>)> {
    let mut assets = Assets::new(path, &[], limits);
    let bytes = assets.read_main()?;
    let file = parse_lodc(&bytes, &assets.main_name())?;
    Ok((file, bytes))
}

/// Reads a container that is in memory; `name` is its file's. Warns of parts that this version
/// does not know.
///
/// # Errors
/// If it is damaged.
pub(crate) fn parse_lodc(bytes: &[u8], name: &str) -> Outcome<LodFile> {
    let file = read(bytes).map_err(|e| {
        if e.problem.starts_with("not a ") {
            return not_lodc(e, name);
        }
        e.in_file(name)
    })?;
    console::warnings(name, &file.left_out);
    Ok(file)
}

/// Says what to do with a file that is none of lodc's: of a mesh, make one.
fn not_lodc(mut error: FormatError, name: &str) -> FormatError {
    if has_extension(Path::new(name), &MESH_EXTENSIONS) {
        error.location.clear();
        error.problem = format!("a mesh, not a .lodc file; run `lodc build {name}` first");
    } else {
        error.problem += "; `lodc build` makes one of a mesh";
    }
    error.in_file(name)
}
