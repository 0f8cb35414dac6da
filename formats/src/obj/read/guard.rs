//! The guard in front of tobj: it refuses with a line what breaks the rules, keeps what tobj has no
//! place for, and passes on plain vertices first, then plain faces.
//!
//! tobj 4.0.5 knows no line numbers, continued lines, comments behind numbers, weights that stay
//! out, colours with alpha or on some vertices only, or third texture coordinates; it overflows on
//! indices far out of range, gives a corner without an index that of the corner before, and splits
//! its result at groups and materials.

mod vertices;

use super::feed::Blocks;
use super::lines::{Lines, text};
use super::parsed::{NONE, Parsed, Run};
use crate::{Fault, FormatError, Limits};
use std::collections::BTreeMap;

/// Faces between two `g` lines, at which tobj empties its tables: they stay in the cache.
const FACES_PER_MODEL: u32 = 4096;

/// Contents of an OBJ besides the numbers that tobj reads.
#[derive(Debug, Default)]
pub(super) struct Guarded {
    /// Everything but the arrays that tobj fills.
    pub(super) parsed: Parsed,
    /// Numbers of positions, texture coordinates and normals.
    pub(super) counts: [u32; 3],
    /// Number of corners of all faces.
    pub(super) corners: u32,
    /// Of each kind: the indices in the order in which each of tobj's models first uses them.
    pub(super) first_uses: [Vec<u32>; 3],
    /// The fourth components of colours, one per position up to the last that has one.
    pub(super) alphas: Vec<f32>,
    /// True if tobj was given a colour for every position.
    pub(super) colored: bool,
    /// True if a colour came after positions without one: to be read again with all coloured.
    pub(super) colors_came_late: bool,
    /// From which corner on corners have texture coordinates, and normals, or not.
    shapes: Vec<(u32, [bool; 2])>,
}

impl Guarded {
    /// Takes the indices away that stood in for missing ones.
    pub(super) fn forget_missing(&self, parsed: &mut Parsed) {
        for (kind, list) in
            [&mut parsed.faces.corner_t, &mut parsed.faces.corner_n].into_iter().enumerate()
        {
            if !self.shapes.iter().any(|(_, has)| has[kind]) {
                list.clear();
                continue;
            }
            let ends = self.shapes.iter().skip(1).map(|s| s.0).chain([self.corners]);
            for (&(start, has), end) in self.shapes.iter().zip(ends) {
                if !has[kind] {
                    list[start as usize..end as usize].fill(NONE);
                }
            }
        }
    }
}

/// Walks over an OBJ twice: for its vertices, and for its faces.
pub(super) struct Guard<'a> {
    bytes: &'a [u8],
    lines: Lines<'a>,
    limits: &'a Limits,
    out: Blocks,
    got: Guarded,
    /// Numbers of positions, texture coordinates and normals before the current face.
    before: [u32; 3],
    /// Position, texture coordinates and normal of each corner of the current face.
    face: Vec<[u32; 3]>,
    /// Of each kind and index: the number of the last of tobj's models that uses it, from 1.
    used_in: [Vec<u32>; 3],
    model: u32,
    faces: u32,
    material_index: BTreeMap<String, u32>,
    label_index: BTreeMap<String, u32>,
    object: u32,
    material: u32,
    label: u32,
    /// Corners that the limit on triangles allows.
    max_corners: u64,
}

impl<'a> Guard<'a> {
    /// A guard that gives every position a colour if `colored`.
    pub(super) fn new(bytes: &'a [u8], limits: &'a Limits, colored: bool, out: Blocks) -> Self {
        Self {
            bytes,
            lines: Lines::new(bytes, limits.line_bytes),
            limits,
            out,
            got: Guarded { colored, ..Guarded::default() },
            before: [0; 3],
            face: Vec::new(),
            used_in: Default::default(),
            model: 1,
            faces: 0,
            material_index: BTreeMap::new(),
            label_index: BTreeMap::new(),
            object: NONE,
            material: NONE,
            label: NONE,
            max_corners: limits.triangles.saturating_mul(3).min(u64::from(NONE) - 1),
        }
    }

    /// Checks the file and passes it on.
    ///
    /// # Errors
    /// If a statement breaks the rules or a limit is reached.
    pub(super) fn run(mut self) -> Result<Guarded, FormatError> {
        self.vertices()?;
        if self.got.colors_came_late {
            return Ok(self.got);
        }
        self.lines = Lines::new(self.bytes, self.limits.line_bytes);
        self.used_in = self.got.counts.map(|count| vec![0; count as usize]);
        self.all_faces()?;
        self.unused();
        self.out.pass(1);
        Ok(self.got)
    }

    fn malformed(&self, what: impl Into<String>) -> FormatError {
        FormatError::new(Fault::Malformed, self.lines.place(), what)
    }

    fn limit(&self, what: String) -> FormatError {
        FormatError::new(Fault::Limit, self.lines.place(), what)
    }

    /// Passes the faces on, and notes what material and label they have.
    fn all_faces(&mut self) -> Result<(), FormatError> {
        let mut word = self.lines.first_statement()?;
        while let Some(statement) = word {
            match statement {
                b"v" => self.before[0] += 1,
                b"vt" => self.before[1] += 1,
                b"vn" => self.before[2] += 1,
                b"f" | b"fo" => self.face()?,
                b"usemtl" => {
                    let name = self.lines.rest();
                    let names = &mut self.got.parsed.faces.materials;
                    self.material = intern(&mut self.material_index, names, &name).unwrap_or(NONE);
                }
                b"g" => {
                    let name = self.lines.rest();
                    let names = &mut self.got.parsed.faces.labels;
                    self.label = intern(&mut self.label_index, names, &name).unwrap_or(self.object);
                }
                b"o" => self.object(),
                _ => {}
            }
            self.lines.skip();
            self.out.pass(usize::MAX);
            word = self.lines.next_statement()?;
        }
        Ok(())
    }

    fn object(&mut self) {
        let name = self.lines.rest();
        let parsed = &mut self.got.parsed;
        let Some(label) = intern(&mut self.label_index, &mut parsed.faces.labels, &name) else {
            return;
        };
        if parsed.faces.objects.len() < 2 && parsed.faces.objects.last() != Some(&name) {
            parsed.faces.objects.push(name);
        }
        (self.object, self.label) = (label, label);
    }

    fn face(&mut self) -> Result<(), FormatError> {
        self.face.clear();
        while let Some(token) = self.lines.token() {
            if u64::from(self.got.corners) + self.face.len() as u64 >= self.max_corners {
                return Err(self.limit(format!("more than {} triangles", self.limits.triangles)));
            }
            let corner = self.corner(token)?;
            self.face.push(corner);
        }
        if self.face.len() < 3 {
            self.got.parsed.notes.small_faces.add(self.lines.number());
            return Ok(());
        }
        let runs = &mut self.got.parsed.faces.runs;
        let (material, label) = (self.material, self.label);
        if runs.last().is_none_or(|r| (r.material, r.label) != (material, label)) {
            runs.push(Run { first_face: self.faces, material, label });
        }
        for i in 0..self.face.len() {
            let has = [1, 2].map(|kind| self.face[i][kind] != NONE);
            if self.got.shapes.last().is_none_or(|s| s.1 != has) {
                self.got.shapes.push((self.got.corners + i as u32, has));
            }
        }
        if self.faces > 0 && self.faces.is_multiple_of(FACES_PER_MODEL) {
            self.next_model();
        }
        self.faces += 1;
        self.got.corners += self.face.len() as u32;
        self.pass_face();
        Ok(())
    }

    fn corner(&self, token: &[u8]) -> Result<[u32; 3], FormatError> {
        let mut parts = token.splitn(3, |&b| b == b'/');
        let mut corner = [NONE; 3];
        for (kind, index) in corner.iter_mut().enumerate() {
            let part = parts.next().unwrap_or_default();
            if kind == 0 || !part.is_empty() {
                *index = self.index(token, part, kind)?;
            }
        }
        Ok(corner)
    }

    fn index(&self, token: &[u8], part: &[u8], kind: usize) -> Result<u32, FormatError> {
        let what = ["position", "texture coordinates", "normal"][kind];
        let (total, before) = (self.got.counts[kind], self.before[kind]);
        let Some(number) = super::number::integer(part) else {
            return Err(self.malformed(format!("`{}` is not a corner of a face", shown(token))));
        };
        let index = match number {
            1.. => number - 1,
            0 => return Err(self.malformed(format!("`{}`: indices start at 1", shown(token)))),
            _ => number + i64::from(before),
        };
        u32::try_from(index).ok().filter(|&index| index < total).ok_or_else(|| {
            let there = if number < 0 { before } else { total };
            let token = shown(token);
            self.malformed(format!("`{token}`: there is no {what} {number}, only {there} of them"))
        })
    }

    /// Ends tobj's model: it starts to number anew.
    fn next_model(&mut self) {
        self.out.text.extend_from_slice(b"g\n");
        self.model += 1;
    }

    /// Passes the corners in `face` on, each with every index that the file could give it: where
    /// one is missing, the first stands in.
    fn pass_face(&mut self) {
        self.out.text.push(b'f');
        for corner in &self.face {
            for (kind, &index) in corner.iter().enumerate() {
                self.out.text.push(if kind == 0 { b' ' } else { b'/' });
                let used_in = &mut self.used_in[kind];
                if kind > 0 && used_in.is_empty() {
                    continue;
                }
                let index = if index == NONE { 0 } else { index };
                self.out.decimal(index + 1);
                let last = &mut used_in[index as usize];
                if *last != self.model {
                    *last = self.model;
                    self.got.first_uses[kind].push(index);
                }
            }
        }
        self.out.text.push(b'\n');
    }

    /// Passes on what no face uses, as polygons behind all faces: tobj drops the rest.
    fn unused(&mut self) {
        if self.got.counts[0] == 0 {
            if self.got.counts == [0; 3] {
                return;
            }
            self.out.text.extend_from_slice(b"v 0 0 0\n");
            self.used_in[0].push(self.model);
        }
        let [mut v, mut t, mut n] = self.used_in.each_ref().map(|used_in| {
            let unused = |i: &usize| used_in[*i] == 0;
            (0..used_in.len()).filter(unused).map(|i| i as u32).collect::<Vec<u32>>().into_iter()
        });
        let size = FACES_PER_MODEL as usize;
        while v.len() + t.len() + n.len() > 0 {
            self.next_model();
            let count = size.min(v.len().max(t.len()).max(n.len()));
            let next = |list: &mut std::vec::IntoIter<u32>| list.next().unwrap_or(NONE);
            self.face.clear();
            self.face.extend((0..count).map(|_| [next(&mut v), next(&mut t), next(&mut n)]));
            self.pass_face();
            self.out.pass(usize::MAX);
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

/// A word for a message: short and without control characters.
fn shown(token: &[u8]) -> String {
    let short = text(&token[..token.len().min(40)]);
    short.escape_debug().to_string()
}
