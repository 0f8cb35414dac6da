//! Parses an OBJ into arrays: chunks of lines in parallel, then relative indices and states
//! (material, group) resolved in order.

use super::chunk::{Chunk, Name, max_corners, max_vertices, vertices};
use super::parsed::{NONE, Parsed, Run};
use crate::words::{counted, without_mark};
use crate::{Fault, FormatError, Limits};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Bytes of a chunk, roughly. Chosen by hand: some thousand lines are worth a task, and most files
/// have more chunks than a machine has threads.
const CHUNK_BYTES: usize = 256 << 10;

/// Largest number of material libraries of a file: each is a file to be opened. Chosen by hand.
const MAX_LIBRARIES: usize = 1000;

/// Reads all statements.
///
/// # Errors
/// If a statement breaks the rules or a limit is reached: the first line that does.
pub(super) fn parse(bytes: &[u8], limits: &Limits) -> Result<Parsed, FormatError> {
    let bytes = without_mark(bytes);
    let parsed = parse_chunks(bytes, CHUNK_BYTES, limits, [false; 3]);
    match parsed {
        Err(e) if e.fault == Fault::Malformed => {
            // Some writers number normals and texture coordinates that they do not write.
            let counts = vertices(bytes, limits).unwrap_or([1; 3]);
            match [false, counts[1] == 0, counts[2] == 0] {
                [_, false, false] => Err(e),
                ignored => parse_chunks(bytes, CHUNK_BYTES, limits, ignored),
            }
        }
        other => other,
    }
}

fn parse_chunks(
    bytes: &[u8],
    size: usize,
    limits: &Limits,
    ignored: [bool; 3],
) -> Result<Parsed, FormatError> {
    let texts = chunks(bytes, size);
    let read: Result<Vec<Chunk>, FormatError> =
        texts.par_iter().map(|text| Chunk::read(text, limits, ignored)).collect();
    // The file is read again as a whole to find the first line with a fault: a chunk may come after
    // it.
    let first_fault = || {
        let whole = Chunk::read_file(bytes, limits, ignored);
        whole.expect_err("what is wrong in a chunk is wrong in the file")
    };
    let Ok(read) = read else { return Err(first_fault()) };
    let (mut joined, mut highest) = (Joined::default(), [0; 3]);
    for chunk in read {
        if !joined.base.allows(&chunk, limits) {
            return Err(first_fault());
        }
        highest = std::array::from_fn(|kind| chunk.spans[kind].highest.max(highest[kind]));
        joined.add(chunk)?;
    }
    if highest.iter().zip(joined.base.counts).any(|(&highest, count)| highest > count as i64) {
        return Err(first_fault());
    }
    joined.finish()
}

/// Counts of what precedes a chunk in the file.
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
    /// Returns whether the chunk stays within the limits, and its negative indices within the file.
    fn allows(&self, chunk: &Chunk, limits: &Limits) -> bool {
        let counts = chunk.counts();
        let fits = |kind: usize| self.counts[kind] + counts[kind] <= max_vertices(limits);
        let in_file = |kind: usize| chunk.spans[kind].before <= self.counts[kind] as i64;
        self.corners + chunk.corners[0].len() as u64 <= max_corners(limits)
            && (0..3).all(|kind| fits(kind) && in_file(kind))
    }
}

/// Cuts a text into chunks of at least `size` bytes, after line ends that end a statement.
fn chunks(bytes: &[u8], size: usize) -> Vec<&[u8]> {
    let mut chunks = Vec::with_capacity(bytes.len() / size + 1);
    let mut rest = bytes;
    while rest.len() > size {
        let line_end = (size..rest.len()).find(|&offset| ends_statement(rest, offset));
        let (chunk, after) = rest.split_at(line_end.map_or(rest.len(), |offset| offset + 1));
        chunks.push(chunk);
        rest = after;
    }
    chunks.push(rest);
    chunks
}

/// Returns whether the byte at an offset is the last of a line end without a backslash before it.
fn ends_statement(bytes: &[u8], offset: usize) -> bool {
    let before = match bytes[offset] {
        b'\n' => bytes[..offset].strip_suffix(b"\r").unwrap_or(&bytes[..offset]),
        b'\r' if bytes.get(offset + 1) != Some(&b'\n') => &bytes[..offset],
        _ => return false,
    };
    !before.ends_with(b"\\")
}

/// The chunks so far, joined.
#[derive(Default)]
struct Joined {
    parsed: Parsed,
    base: Base,
    /// True if a chunk has a statement of the OBJ format.
    has_statement: bool,
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
        for element in std::mem::take(&mut chunk.elements) {
            let start = base.counts[0] as i64;
            let vertex = |(index, relative): (i64, bool)| index + if relative { start } else { 0 };
            let vertices = element.vertices.into_iter().map(vertex);
            match element.is_line {
                true => parsed.line_elements.push(vertices.collect()),
                false => parsed.points.extend(vertices),
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
        self.has_statement |= chunk.has_statement;
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
        if notes.unknown.times > 0 && !self.has_statement {
            let problem = format!(
                "not an OBJ file: no line of it is an OBJ statement (the first is `{}`)",
                notes.unknown_first
            );
            return Err(FormatError::new(Fault::Malformed, "", problem));
        }
        Ok(self.parsed)
    }
}

/// Refuses a file without faces, and says what it is instead.
pub(super) fn check_faces(parsed: &Parsed) -> Result<(), FormatError> {
    let (faces, notes) = (&parsed.faces, &parsed.notes);
    if !faces.face_ends.is_empty() || notes.small_faces.times > 0 {
        return Ok(());
    }
    let vertices = counted(faces.positions.len(), "vertex", "vertices");
    let problem = if notes.free_form.times > 0 {
        "free-form curves or surfaces, not a mesh: no face".to_owned()
    } else if faces.positions.is_empty() {
        "not a mesh: no vertex and no face".to_owned()
    } else {
        let kind = if notes.lines.times > 0 { "lines" } else { "a point cloud" };
        format!("{kind}, not a mesh: {vertices} and no face")
    };
    Err(FormatError::new(Fault::Unsupported, "", problem))
}

/// Appends the values of a chunk with `count` elements to those of `before` elements. Both lists
/// may be empty instead, which stands for `default` values; `all` stays empty while no chunk has
/// any.
fn append_filled<T: Copy>(all: &mut Vec<T>, more: &[T], before: usize, count: usize, default: T) {
    if all.is_empty() && more.is_empty() {
        return;
    }
    all.resize(before, default);
    all.extend_from_slice(more);
    all.resize(before + count, default);
}

/// Numbers of materials and labels by their names, and those that hold for the next face.
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
    /// Adds the runs of a chunk whose faces have not been added yet.
    fn add(&mut self, parsed: &mut Parsed, chunk: &Chunk) {
        let (first, mut run_start) = (parsed.faces.face_ends.len() as u32, 0);
        for (face, name) in &chunk.names {
            self.begin_run(parsed, first + run_start, face - run_start);
            run_start = *face;
            self.set(parsed, name);
        }
        self.begin_run(parsed, first + run_start, chunk.face_ends.len() as u32 - run_start);
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
