//! Material libraries (MTL) of an OBJ: their material names and lines, stored unchanged so that an
//! export can write them again.

use super::lines::text;
use crate::obj::mtl::{QUOTES, unquoted};
use crate::words::{counted, without_mark};
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
            for (name, bytes) in materials.find(library, assets)? {
                materials.parse(name, &bytes)?;
            }
        }
        Ok(materials)
    }

    /// Reads the library that lies beside an OBJ under its name, which names none itself; says so.
    ///
    /// # Errors
    /// If a limit is reached.
    pub(super) fn beside(assets: &mut Assets) -> Result<Self, FormatError> {
        let (mut materials, name) = (Self::default(), format!("{}.mtl", assets.stem()));
        match assets.read_reference(&name) {
            Ok(bytes) => {
                materials.parse(&name, &bytes)?;
                materials.warnings.push(format!("no mtllib statement: materials are from {name}"));
            }
            Err(e) if e.fault == Fault::Limit => return Err(e),
            Err(_) => {}
        }
        Ok(materials)
    }

    /// Finds a library: under the name as written, or else as a list of names, of which those are
    /// read that are there. Names may be in quotes.
    fn find<'a>(
        &mut self,
        library: &'a str,
        assets: &mut Assets,
    ) -> Result<Vec<(&'a str, Vec<u8>)>, FormatError> {
        let whole_name = unquoted(library);
        let whole = match assets.read_name(whole_name) {
            Ok(bytes) => return Ok(vec![(whole_name, bytes)]),
            Err(e) if e.fault == Fault::Limit => return Err(e),
            Err(e) => e,
        };
        let (mut found, mut missing) = (Vec::new(), Vec::new());
        let names = quoted_words(library);
        for name in names.iter().copied().filter(|_| names.len() > 1) {
            match assets.read_name(name) {
                Ok(bytes) => found.push((name, bytes)),
                Err(e) if e.fault == Fault::Limit => return Err(e),
                Err(e) => missing.push(e),
            }
        }
        if found.is_empty() {
            missing = vec![whole];
        } else {
            // Both spellings of the whole were looked for in vain, and count as missing no more.
            assets.set_replaced(whole_name);
            assets.set_replaced(&whole_name.replace('\\', "/"));
        }
        let warning = |e| format!("material library not read: {e}");
        self.warnings.extend(missing.into_iter().map(warning));
        Ok(found)
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
                let name = unquoted(rest).to_owned();
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
            let materials = counted(repeated, "material is", "materials are");
            self.warnings.push(format!(
                "{library}: {materials} defined more than once: the first definition is used"
            ));
        }
        if stray > 0 {
            let lines = counted(stray, "line", "lines");
            self.warnings.push(format!("{library}: skipped {lines} before the first material"));
        }
        Ok(())
    }
}

/// The words of a list; one in quotes may have spaces.
fn quoted_words(list: &str) -> Vec<&str> {
    let mut words = Vec::new();
    let mut rest = list.trim_start();
    while !rest.is_empty() {
        let in_quotes = QUOTES.iter().find_map(|&q| rest.strip_prefix(q)?.split_once(q));
        let (word, after) = in_quotes.unwrap_or_else(|| {
            let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
            rest.split_at(end)
        });
        words.push(word);
        rest = after.trim_start();
    }
    words
}

/// Lines as text; a backslash at the end of one joins the next to it.
fn joined(bytes: &[u8]) -> impl Iterator<Item = String> {
    let bytes = without_mark(bytes);
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
