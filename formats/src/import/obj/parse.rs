//! The statements of an OBJ as arrays.
//!
//! A parser of our own and not a crate: it reads the file's bytes in place (no normalised copy, no
//! line map), keeps indices as the file has them, and knows the line of everything it refuses.

use super::lines::Lines;
use super::notes::Notes;
use super::number::{float, integer};
use crate::{Fault, FormatError, Limits};
use std::collections::BTreeMap;

/// No index: a corner without texture coordinates or normal.
pub(super) const NONE: u32 = u32::MAX;

/// What an OBJ says, indices counted from 0 and in range.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    pub(super) positions: Vec<[f32; 3]>,
    /// Empty, or one per position; white where the file has none.
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) color_has_alpha: bool,
    pub(super) texcoords: Vec<[f32; 2]>,
    /// Empty, or the third components.
    pub(super) texcoords_w: Vec<f32>,
    pub(super) normals: Vec<[f32; 3]>,
    /// Of each corner: its position.
    pub(super) corner_v: Vec<u32>,
    /// Of each corner: its texture coordinates or [`NONE`]; empty if no corner has any.
    pub(super) corner_t: Vec<u32>,
    /// Of each corner: its normal or [`NONE`]; empty if no corner has any.
    pub(super) corner_n: Vec<u32>,
    /// Where the corners of each face end.
    pub(super) face_ends: Vec<u32>,
    /// Runs of faces with the same material and label.
    pub(super) runs: Vec<Run>,
    /// Names of materials in order of appearance.
    pub(super) materials: Vec<String>,
    /// Names of groups and objects in order of appearance.
    pub(super) labels: Vec<String>,
    /// The names of `o` statements: none, one, or several.
    pub(super) objects: Vec<String>,
    pub(super) libraries: Vec<String>,
    pub(super) notes: Notes,
}

/// Faces from `first_face` up to the next run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) first_face: u32,
    /// Index into the materials, or [`NONE`].
    pub(super) material: u32,
    /// Index into the labels, or [`NONE`].
    pub(super) label: u32,
}

/// The file may name this many libraries: each is a file to be opened.
const MAX_LIBRARIES: usize = 1000;

/// Reads all statements.
pub(super) fn parse(bytes: &[u8], limits: &Limits) -> Result<Parsed, FormatError> {
    let mut parser = Parser::new(bytes, limits, None);
    parser.run()?;
    let totals = parser.totals();
    let out_of_range = parser
        .largest
        .iter()
        .zip(totals)
        .any(|(&largest, total)| largest.is_some_and(|i| i >= total));
    if out_of_range {
        // A face may come before its vertices, so this shows at the end only. Rare enough to look
        // for the line anew.
        Parser::new(bytes, limits, Some(totals)).run()?;
        return Err(FormatError::new(
            Fault::Malformed,
            "",
            "a face uses a vertex that is not there",
        ));
    }
    let known = parser.known;
    let mut parsed = parser.parsed;
    if !parsed.colors.is_empty() {
        parsed.colors.resize(parsed.positions.len(), [1.0; 4]);
    }
    if !parsed.texcoords_w.is_empty() {
        parsed.texcoords_w.resize(parsed.texcoords.len(), 0.0);
    }
    if parsed.notes.unknown.times > 0 && known == 0 {
        let what = format!(
            "not an OBJ file: no line of it is an OBJ statement (the first is `{}`)",
            parsed.notes.unknown_first
        );
        return Err(FormatError::new(Fault::Malformed, "", what));
    }
    Ok(parsed)
}

struct Parser<'a> {
    lines: Lines<'a>,
    limits: &'a Limits,
    parsed: Parsed,
    known: u64,
    /// The largest index used of positions, texture coordinates and normals.
    largest: [Option<u32>; 3],
    /// How many there are in the whole file, if that is known already.
    expected: Option<[u32; 3]>,
    material_index: BTreeMap<String, u32>,
    label_index: BTreeMap<String, u32>,
    object: u32,
    material: u32,
    label: u32,
    /// Corners that the limit on triangles allows.
    max_corners: usize,
}

impl<'a> Parser<'a> {
    fn new(bytes: &'a [u8], limits: &'a Limits, expected: Option<[u32; 3]>) -> Self {
        let max_corners = limits.triangles.saturating_mul(3).min(u64::from(NONE) - 1);
        Self {
            lines: Lines::new(bytes, limits.line_bytes),
            limits,
            parsed: Parsed::default(),
            known: 0,
            largest: [None; 3],
            expected,
            material_index: BTreeMap::new(),
            label_index: BTreeMap::new(),
            object: NONE,
            material: NONE,
            label: NONE,
            max_corners: usize::try_from(max_corners).unwrap_or(usize::MAX),
        }
    }

    fn totals(&self) -> [u32; 3] {
        // Each list was kept below 2^32 - 1 by `vertex_limit`.
        let p = &self.parsed;
        [p.positions.len() as u32, p.texcoords.len() as u32, p.normals.len() as u32]
    }

    fn run(&mut self) -> Result<(), FormatError> {
        let mut word = self.lines.first_statement()?;
        while let Some(statement) = word {
            self.known += 1;
            match statement {
                b"v" => self.position()?,
                b"vt" => self.texcoord()?,
                b"vn" => self.normal()?,
                b"f" | b"fo" => self.face()?,
                b"usemtl" => self.use_material(),
                b"g" => self.group(),
                b"o" => self.object(),
                b"mtllib" => self.library()?,
                b"l" => self.parsed.notes.lines.add(self.lines.number()),
                b"p" => self.parsed.notes.points.add(self.lines.number()),
                b"s" | b"vp" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"mg"
                | b"shadow_obj" | b"trace_obj" | b"usemap" | b"maplib" | b"cstype" | b"deg"
                | b"bmat" | b"step" | b"ctech" | b"stech" | b"parm" | b"trim" | b"hole"
                | b"scrv" | b"sp" | b"end" | b"con" => {}
                b"curv" | b"curv2" | b"surf" => {
                    self.parsed.notes.free_form.add(self.lines.number())
                }
                other => {
                    self.known -= 1;
                    if self.parsed.notes.unknown.times == 0 {
                        self.parsed.notes.unknown_first =
                            super::lines::text(&other[..other.len().min(20)]);
                    }
                    self.parsed.notes.unknown.add(self.lines.number());
                }
            }
            word = self.lines.next_statement()?;
        }
        Ok(())
    }

    fn malformed(&self, what: impl Into<String>) -> FormatError {
        FormatError::new(Fault::Malformed, self.lines.place(), what)
    }

    fn limit(&self, what: String) -> FormatError {
        FormatError::new(Fault::Limit, self.lines.place(), what)
    }

    /// Reads numbers to the end of the statement; those beyond `N` are only counted.
    fn numbers<const N: usize>(&mut self) -> Result<([f32; N], usize), FormatError> {
        let (mut values, mut count) = ([0.0; N], 0);
        while let Some(token) = self.lines.token() {
            if let Some(value) = values.get_mut(count) {
                *value = float(token).ok_or_else(|| not_a_number(&self.lines, token))?;
            }
            count += 1;
        }
        if count > N {
            self.parsed.notes.extra_values.add(self.lines.number());
        }
        Ok((values, count))
    }

    fn vertex_limit(&self, count: usize) -> Result<(), FormatError> {
        if count as u64 >= self.limits.vertices.min(u64::from(NONE) - 1) {
            return Err(self.limit(format!("more than {} vertices", self.limits.vertices)));
        }
        Ok(())
    }

    fn position(&mut self) -> Result<(), FormatError> {
        let ([x, y, z, r, g, b, a], count) = self.numbers::<7>()?;
        if count < 3 {
            return Err(self.malformed(format!("a position needs three numbers, here are {count}")));
        }
        if ![x, y, z].iter().all(|c| c.is_finite()) {
            return Err(self.malformed(format!("the position ({x}, {y}, {z}) is not finite")));
        }
        let p = &mut self.parsed;
        if count == 4 && r != 1.0 {
            p.notes.weights.add(self.lines.number());
        }
        if count == 5 {
            p.notes.extra_values.add(self.lines.number());
        }
        if count >= 6 {
            p.colors.resize(p.positions.len(), [1.0; 4]);
            p.color_has_alpha |= count >= 7;
            p.colors.push([r, g, b, if count >= 7 { a } else { 1.0 }]);
        } else {
            p.notes.uncolored.add(self.lines.number());
        }
        p.positions.push([x, y, z]);
        self.vertex_limit(self.parsed.positions.len())
    }

    fn texcoord(&mut self) -> Result<(), FormatError> {
        let ([u, v, w], count) = self.numbers::<3>()?;
        if count == 0 {
            return Err(self.malformed("texture coordinates need at least one number"));
        }
        let p = &mut self.parsed;
        if count >= 3 && (w != 0.0 || !p.texcoords_w.is_empty()) {
            p.texcoords_w.resize(p.texcoords.len(), 0.0);
            p.texcoords_w.push(w);
        }
        p.texcoords.push([u, v]);
        self.vertex_limit(self.parsed.texcoords.len())
    }

    fn normal(&mut self) -> Result<(), FormatError> {
        let (normal, count) = self.numbers::<3>()?;
        if count < 3 {
            return Err(self.malformed(format!("a normal needs three numbers, here are {count}")));
        }
        self.parsed.normals.push(normal);
        self.vertex_limit(self.parsed.normals.len())
    }

    fn face(&mut self) -> Result<(), FormatError> {
        let first = self.parsed.corner_v.len();
        while let Some(token) = self.lines.token() {
            if self.parsed.corner_v.len() >= self.max_corners {
                return Err(self.limit(format!("more than {} triangles", self.limits.triangles)));
            }
            self.corner(token)?;
        }
        let p = &mut self.parsed;
        let end = p.corner_v.len();
        if end - first < 3 {
            p.notes.small_faces.add(self.lines.number());
            p.corner_v.truncate(first);
            p.corner_t.truncate(first);
            p.corner_n.truncate(first);
            return Ok(());
        }
        if p.runs.last().is_none_or(|r| (r.material, r.label) != (self.material, self.label)) {
            let run = Run {
                first_face: p.face_ends.len() as u32,
                material: self.material,
                label: self.label,
            };
            p.runs.push(run);
        }
        p.face_ends.push(end as u32);
        Ok(())
    }

    fn corner(&mut self, token: &[u8]) -> Result<(), FormatError> {
        let mut parts = token.splitn(3, |&b| b == b'/');
        let corner = self.parsed.corner_v.len();
        for (kind, so_far) in self.totals().into_iter().enumerate() {
            let part = parts.next().unwrap_or_default();
            let index = if part.is_empty() && kind > 0 {
                NONE
            } else {
                self.index(token, part, kind, so_far)?
            };
            let p = &mut self.parsed;
            let list = match kind {
                0 => &mut p.corner_v,
                1 => &mut p.corner_t,
                _ => &mut p.corner_n,
            };
            // The lists of texture coordinates and normals start with the first corner that has
            // one.
            if index != NONE || !list.is_empty() {
                if list.len() < corner {
                    list.resize(corner, NONE);
                }
                list.push(index);
            }
        }
        Ok(())
    }

    fn index(
        &mut self,
        token: &[u8],
        part: &[u8],
        kind: usize,
        so_far: u32,
    ) -> Result<u32, FormatError> {
        let what = ["position", "texture coordinates", "normal"][kind];
        let Some(number) = integer(part) else {
            return Err(self.malformed(format!("`{}` is not a corner of a face", shown(token))));
        };
        let index = match number {
            1.. => number - 1,
            0 => return Err(self.malformed(format!("`{}`: indices start at 1", shown(token)))),
            _ => number + i64::from(so_far),
        };
        let total = self.expected.map_or(NONE, |e| e[kind]);
        match u32::try_from(index) {
            Ok(index) if index < total => {
                self.largest[kind] = self.largest[kind].max(Some(index));
                Ok(index)
            }
            _ => {
                let there = if number < 0 { so_far } else { total };
                Err(self.malformed(match there {
                    NONE => format!("`{}`: there is no {what} {number}", shown(token)),
                    _ => format!(
                        "`{}`: there is no {what} {number}, only {there} of them",
                        shown(token)
                    ),
                }))
            }
        }
    }

    fn use_material(&mut self) {
        let name = self.lines.rest();
        self.material = if name.is_empty() {
            NONE
        } else {
            intern(&mut self.material_index, &mut self.parsed.materials, name)
        };
    }

    fn group(&mut self) {
        let name = self.lines.rest();
        self.label = if name.is_empty() {
            self.object
        } else {
            intern(&mut self.label_index, &mut self.parsed.labels, name)
        };
    }

    fn object(&mut self) {
        let name = self.lines.rest();
        if name.is_empty() {
            return;
        }
        if self.parsed.objects.len() < 2 && self.parsed.objects.last() != Some(&name) {
            self.parsed.objects.push(name.clone());
        }
        self.object = intern(&mut self.label_index, &mut self.parsed.labels, name);
        self.label = self.object;
    }

    fn library(&mut self) -> Result<(), FormatError> {
        let name = self.lines.rest();
        let libraries = &mut self.parsed.libraries;
        if !name.is_empty() && !libraries.contains(&name) {
            libraries.push(name);
        }
        if libraries.len() > MAX_LIBRARIES {
            return Err(self.limit(format!("more than {MAX_LIBRARIES} material libraries")));
        }
        Ok(())
    }
}

fn intern(index: &mut BTreeMap<String, u32>, names: &mut Vec<String>, name: String) -> u32 {
    if let Some(&i) = index.get(&name) {
        return i;
    }
    let i = names.len() as u32;
    names.push(name.clone());
    index.insert(name, i);
    i
}

fn not_a_number(lines: &Lines<'_>, token: &[u8]) -> FormatError {
    FormatError::new(Fault::Malformed, lines.place(), format!("`{}` is not a number", shown(token)))
}

/// A word for a message: short and without control characters.
fn shown(token: &[u8]) -> String {
    let short = super::lines::text(&token[..token.len().min(40)]);
    short.escape_debug().to_string()
}

#[cfg(test)]
#[path = "parse_tests.rs"]
mod tests;
