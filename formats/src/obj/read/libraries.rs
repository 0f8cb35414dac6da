//! Material libraries (MTL) of an OBJ: their material names and lines, stored unchanged so that an
//! export can write them again.

use super::lines::text;
use crate::{Assets, Fault, FormatError, ObjMaterial};
use std::collections::BTreeSet;

/// Largest number of bytes of a library. Chosen by hand: real ones have a few kilobytes.
const MAX_BYTES: usize = 64 << 20;

/// The materials of some libraries, and warnings about them.
#[derive(Debug, Default)]
pub(super) struct Materials {
    pub(super) list: Vec<ObjMaterial>,
    pub(super) warnings: Vec<String>,
    names: BTreeSet<String>,
}

impl Materials {
    /// Reads the libraries that an OBJ names. One that is missing or may not be read is a warning:
    /// the shape does not depend on it.
    ///
    /// # Errors
    /// If a limit is reached.
    pub(super) fn read(libraries: &[String], assets: &mut Assets) -> Result<Self, FormatError> {
        let mut materials = Self::default();
        for library in libraries {
            match find(library, assets) {
                Ok(found) => {
                    for bytes in found {
                        materials.parse(library, &bytes)?;
                    }
                }
                Err(e) if e.fault == Fault::Limit => return Err(e),
                Err(e) => {
                    materials.warnings.push(format!("the material library was not read: {e}"));
                }
            }
        }
        Ok(materials)
    }

    /// Takes the materials of one library. The first definition of a name holds.
    fn parse(&mut self, library: &str, bytes: &[u8]) -> Result<(), FormatError> {
        if bytes.len() > MAX_BYTES {
            let problem = format!("a material library larger than {MAX_BYTES} bytes");
            return Err(FormatError::new(Fault::Limit, "", problem).in_file(library));
        }
        let (mut repeated, mut stray) = (0u64, 0u64);
        let mut current: Option<ObjMaterial> = None;
        for line in joined(bytes) {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            if word == "newmtl" {
                self.list.extend(current.take());
                let name = rest.trim().to_owned();
                if self.names.insert(name.clone()) {
                    current = Some(ObjMaterial { name, lines: Vec::new() });
                } else {
                    repeated += 1;
                }
            } else if let Some(material) = &mut current {
                material.lines.push(line.to_owned());
            } else if repeated == 0 {
                // Lines after a repeated `newmtl` are dropped with it.
                stray += 1;
            }
        }
        self.list.extend(current);
        if repeated > 0 {
            self.warnings.push(format!(
                "{library}: {repeated} materials are defined more than once, the first one holds"
            ));
        }
        if stray > 0 {
            self.warnings
                .push(format!("{library}: {stray} lines before the first material were left out"));
        }
        Ok(())
    }
}

/// Finds a library: under the name as written, with its backslashes as slashes, or else as a list
/// of names.
fn find(library: &str, assets: &mut Assets) -> Result<Vec<Vec<u8>>, FormatError> {
    let with_slashes = library.replace('\\', "/");
    let mut read = |name: &str| match assets.read_reference(name) {
        Err(e) if e.fault == Fault::Unreadable && name.contains('\\') => {
            let found = assets.read_reference(&name.replace('\\', "/"));
            if found.is_ok() {
                assets.set_replaced(name);
            }
            found
        }
        other => other,
    };
    let whole = read(library);
    let is_unreadable = matches!(&whole, Err(e) if e.fault == Fault::Unreadable);
    let names: Vec<&str> = with_slashes.split_whitespace().collect();
    if !is_unreadable || names.len() < 2 {
        return whole.map(|bytes| vec![bytes]);
    }
    // `mtllib a.mtl b.mtl`. If one of them is missing, the message is that about the whole.
    match names.into_iter().map(read).collect() {
        Ok(all) => {
            // Both spellings of the whole were looked for in vain, and count as missing no more.
            assets.set_replaced(library);
            assets.set_replaced(&with_slashes);
            Ok(all)
        }
        Err(_) => whole.map(|bytes| vec![bytes]),
    }
}

/// Lines as text; a backslash at the end of one joins the next to it.
fn joined(bytes: &[u8]) -> impl Iterator<Item = String> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut lines = bytes.split(|&b| b == b'\n' || b == b'\r');
    std::iter::from_fn(move || {
        let mut line = lines.next()?.to_vec();
        while line.last() == Some(&b'\\') {
            line.pop();
            line.push(b' ');
            match lines.next() {
                Some(more) => line.extend_from_slice(more),
                None => break,
            }
        }
        Some(text(&line))
    })
}

#[cfg(test)]
#[path = "libraries_tests.rs"]
mod tests;
