//! Parses an OBJ into arrays: chunks of lines in parallel, then relative indices and states
//! (material, group) resolved in order.

use super::chunk::{Chunk, Name, most_corners, most_vertices};
use super::parsed::{NONE, Parsed, Run};
use crate::{Fault, FormatError, Limits};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Bytes of a chunk, roughly: some thousand lines, a fraction of a millisecond.
const CHUNK: usize = 256 << 10;

/// Upper bound on the material libraries of a file: each is a file to be opened.
const MAX_LIBRARIES: usize = 1000;

/// Reads all statements.
///
/// # Errors
/// If a statement breaks the rules or a limit is reached: the first line that does.
pub(super) fn parse(bytes: &[u8], limits: &Limits) -> Result<Parsed, FormatError> {
    parse_chunks(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), CHUNK, limits)
}

fn parse_chunks(bytes: &[u8], size: usize, limits: &Limits) -> Result<Parsed, FormatError> {
    let texts = chunks(bytes, size);
    let read: Result<Vec<Chunk>, FormatError> =
        texts.par_iter().map(|text| Chunk::read(text, limits)).collect();
    // Which line of the file has the first fault only a walk over all of it tells.
    let fault = || {
        let again = Chunk::read_file(bytes, limits);
        again.expect_err("what is wrong in a chunk is wrong in the file")
    };
    let Ok(read) = read else { return Err(fault()) };
    let (mut joined, mut highest) = (Joined::default(), [0; 3]);
    for chunk in read {
        if !joined.base.takes(&chunk, limits) {
            return Err(fault());
        }
        highest = std::array::from_fn(|kind| chunk.reach[kind].highest.max(highest[kind]));
        joined.add(chunk)?;
    }
    if highest.iter().zip(joined.base.counts).any(|(&highest, count)| highest > count as i64) {
        return Err(fault());
    }
    joined.finish()
}

/// What precedes a chunk.
#[derive(Clone, Copy, Default)]
struct Base {
    /// Line ends.
    lines: u32,
    /// Positions, texture coordinates and normals.
    counts: [u64; 3],
    /// Corners of faces.
    corners: u64,
}

impl Base {
    /// Returns whether limits allow a chunk here, and no index goes back beyond the first vertex.
    fn takes(&self, chunk: &Chunk, limits: &Limits) -> bool {
        let counts = chunk.counts();
        let fits = |kind: usize| self.counts[kind] + counts[kind] <= most_vertices(limits);
        let goes_back = |kind: usize| chunk.reach[kind].back > self.counts[kind] as i64;
        self.corners + chunk.corners[0].len() as u64 <= most_corners(limits)
            && (0..3).all(|kind| fits(kind) && !goes_back(kind))
    }
}

/// Cuts a text behind line ends that end a statement.
fn chunks(bytes: &[u8], size: usize) -> Vec<&[u8]> {
    let mut chunks = Vec::with_capacity(bytes.len() / size + 1);
    let mut rest = bytes;
    while rest.len() > size {
        let ends = (size..rest.len()).find(|&at| ends_statement(rest, at));
        let (chunk, after) = rest.split_at(ends.map_or(rest.len(), |at| at + 1));
        chunks.push(chunk);
        rest = after;
    }
    chunks.push(rest);
    chunks
}

/// Returns whether the byte at a place is the last of a line end without a backslash before it.
fn ends_statement(bytes: &[u8], at: usize) -> bool {
    let before = match bytes[at] {
        b'\n' => bytes[..at].strip_suffix(b"\r").unwrap_or(&bytes[..at]),
        b'\r' if bytes.get(at + 1) != Some(&b'\n') => &bytes[..at],
        _ => return false,
    };
    !before.ends_with(b"\\")
}

/// Chunks one behind the other.
#[derive(Default)]
struct Joined {
    parsed: Parsed,
    base: Base,
    known: bool,
    names: Names,
}

impl Joined {
    fn add(&mut self, mut chunk: Chunk) -> Result<(), FormatError> {
        let (base, parsed) = (self.base, &mut self.parsed);
        for (&line, name) in chunk.libraries.iter().map(|(line, name)| (line, name)) {
            if !name.is_empty() && !parsed.libraries.contains(name) {
                parsed.libraries.push(name.clone());
            }
            if parsed.libraries.len() > MAX_LIBRARIES {
                let location = format!("line {}", base.lines + line);
                let problem = format!("more than {MAX_LIBRARIES} material libraries");
                return Err(FormatError::new(Fault::Limit, location, problem));
            }
        }
        for (kind, relative) in chunk.relative.iter().enumerate() {
            for &corner in relative {
                let index = &mut chunk.corners[kind][corner as usize];
                *index = index.wrapping_add(base.counts[kind] as u32);
            }
        }
        let [before, texcoords, _] = base.counts.map(|n| n as usize);
        append_filled(
            &mut parsed.faces.colors,
            &chunk.colors,
            before,
            chunk.positions.len(),
            [1.0; 4],
        );
        let count = chunk.texcoords.len();
        append_filled(&mut parsed.faces.texcoords_w, &chunk.texcoords_w, texcoords, count, 0.0);
        parsed.faces.color_has_alpha |= chunk.color_has_alpha;
        parsed.faces.positions.append(&mut chunk.positions);
        parsed.faces.texcoords.append(&mut chunk.texcoords);
        parsed.faces.normals.append(&mut chunk.normals);
        let (corners, [v, t, n]) = (parsed.faces.corner_v.len(), &chunk.corners);
        append_filled(&mut parsed.faces.corner_t, t, corners, v.len(), NONE);
        append_filled(&mut parsed.faces.corner_n, n, corners, v.len(), NONE);
        parsed.faces.corner_v.extend_from_slice(v);
        self.names.add(parsed, &chunk);
        parsed.faces.face_ends.extend(chunk.face_ends.iter().map(|end| corners as u32 + end));
        parsed.notes.add(&chunk.notes, base.lines);
        self.known |= chunk.known;
        self.base.lines += chunk.lines;
        self.base.corners = parsed.faces.corner_v.len() as u64;
        self.base.counts = [
            parsed.faces.positions.len(),
            parsed.faces.texcoords.len(),
            parsed.faces.normals.len(),
        ]
        .map(|n| n as u64);
        Ok(())
    }

    fn finish(self) -> Result<Parsed, FormatError> {
        let notes = &self.parsed.notes;
        if notes.unknown.times > 0 && !self.known {
            let problem = format!(
                "not an OBJ file: no line of it is an OBJ statement (the first is `{}`)",
                notes.unknown_first
            );
            return Err(FormatError::new(Fault::Malformed, "", problem));
        }
        Ok(self.parsed)
    }
}

/// Appends `count` values to a list that is empty or has `before`: it stays empty while no chunk
/// has any.
fn append_filled<T: Copy>(all: &mut Vec<T>, more: &[T], before: usize, count: usize, filling: T) {
    if all.is_empty() && more.is_empty() {
        return;
    }
    all.resize(before, filling);
    all.extend_from_slice(more);
    all.resize(before + count, filling);
}

/// The names that hold for the next face.
struct Names {
    material_index: BTreeMap<String, u32>,
    label_index: BTreeMap<String, u32>,
    object: u32,
    material: u32,
    label: u32,
}

impl Default for Names {
    fn default() -> Self {
        Self {
            material_index: BTreeMap::new(),
            label_index: BTreeMap::new(),
            object: NONE,
            material: NONE,
            label: NONE,
        }
    }
}

impl Names {
    /// Adds the runs of a chunk whose faces are to follow.
    fn add(&mut self, parsed: &mut Parsed, chunk: &Chunk) {
        let (first, mut done) = (parsed.faces.face_ends.len() as u32, 0);
        for (faces, name) in &chunk.names {
            self.begin_run(parsed, first + done, faces - done);
            done = *faces;
            self.set(parsed, name);
        }
        self.begin_run(parsed, first + done, chunk.face_ends.len() as u32 - done);
    }

    fn begin_run(&self, parsed: &mut Parsed, first_face: u32, faces: u32) {
        let (material, label) = (self.material, self.label);
        let runs = &mut parsed.faces.runs;
        if faces > 0 && runs.last().is_none_or(|r| (r.material, r.label) != (material, label)) {
            runs.push(Run { first_face, material, label });
        }
    }

    fn set(&mut self, parsed: &mut Parsed, name: &Name) {
        match name {
            Name::Material(name) => {
                let number = intern(&mut self.material_index, &mut parsed.faces.materials, name);
                self.material = number.unwrap_or(NONE);
            }
            Name::Group(name) => {
                let number = intern(&mut self.label_index, &mut parsed.faces.labels, name);
                self.label = number.unwrap_or(self.object);
            }
            Name::Object(name) => {
                let number = intern(&mut self.label_index, &mut parsed.faces.labels, name);
                let Some(number) = number else { return };
                if parsed.faces.objects.len() < 2 && parsed.faces.objects.last() != Some(name) {
                    parsed.faces.objects.push(name.clone());
                }
                (self.object, self.label) = (number, number);
            }
        }
    }
}

/// The number of a name, given to it now if it is new; none for no name.
fn intern(index: &mut BTreeMap<String, u32>, names: &mut Vec<String>, name: &str) -> Option<u32> {
    if name.is_empty() {
        return None;
    }
    if let Some(&i) = index.get(name) {
        return Some(i);
    }
    let i = names.len() as u32;
    names.push(name.to_owned());
    index.insert(name.to_owned(), i);
    Some(i)
}

#[cfg(test)]
#[path = "parse_tests.rs"]
mod tests;
