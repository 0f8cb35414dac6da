//! Parses some consecutive lines of an OBJ by themselves, so that chunks of a file can be parsed in
//! parallel.

use super::lines::{Lines, text};
use super::number::{integer, number};
use super::parsed::{NONE, Notes};
use crate::obj::mtl::unquoted;
use crate::{Fault, FormatError, Limits};

/// Contents of a chunk. Indices of vertices and lines count from where it starts.
#[derive(Debug, Default)]
pub(super) struct Chunk {
    pub(super) positions: Vec<[f32; 3]>,
    /// Empty, or one per position; white where there is none.
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) color_has_alpha: bool,
    pub(super) texcoords: Vec<[f32; 2]>,
    /// Empty, or the third components.
    pub(super) texcoords_w: Vec<f32>,
    pub(super) normals: Vec<[f32; 3]>,
    /// For each corner the indices of its position, texture coordinates and normal. The latter two
    /// are [`NONE`] where there are none, or the list is empty if no corner has any.
    pub(super) corners: [Vec<u32>; 3],
    /// The corners whose indices were negative, by the same three kinds. Such an index counts from
    /// the first vertex of the chunk, and may be before it (it wraps around); all other indices
    /// count from the first vertex of the file.
    pub(super) relative: [Vec<u32>; 3],
    /// The span of the indices of each kind.
    pub(super) spans: [IndexSpan; 3],
    /// For each face the number of corners up to its last.
    pub(super) face_ends: Vec<u32>,
    /// Points and lines.
    pub(super) elements: Vec<Element>,
    /// Names in order, each with the number of faces before it.
    pub(super) names: Vec<(u32, Name)>,
    /// Names of libraries, each with its line.
    pub(super) libraries: Vec<(u32, String)>,
    /// True if it has a statement of the OBJ format.
    pub(super) has_statement: bool,
    pub(super) notes: Notes,
    /// Number of line ends.
    pub(super) lines: u32,
}

/// Points, or a line.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) is_line: bool,
    /// Its vertices, each with true if its index was negative: then it counts from the chunk's
    /// first.
    pub(super) vertices: Vec<(i64, bool)>,
}

/// A name for the faces that follow.
#[derive(Debug)]
pub(super) enum Name {
    Material(String),
    Group(String),
    Object(String),
}

/// The outermost vertices of one kind that a chunk's corners refer to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct IndexSpan {
    /// The largest positive index, counted from 1; 0 without any.
    pub(super) highest: i64,
    /// How many vertices before the chunk's first the negative indices refer to, at most.
    pub(super) before: i64,
}

impl Chunk {
    /// Reads a chunk. Indices are not compared with the number of vertices, and lines of errors
    /// count from the chunk's first.
    ///
    /// # Errors
    /// If a statement breaks the rules or a limit is reached.
    pub(super) fn read(
        bytes: &[u8],
        limits: &Limits,
        ignored: [bool; 3],
    ) -> Result<Self, FormatError> {
        Self::read_within(bytes, limits, None, ignored)
    }

    /// Reads a whole file as one chunk, to name the first line with a fault.
    ///
    /// # Errors
    /// As [`Self::read`], and if an index is beyond the file's vertices.
    pub(super) fn read_file(
        bytes: &[u8],
        limits: &Limits,
        ignored: [bool; 3],
    ) -> Result<Self, FormatError> {
        // If a line cannot be read, that is the fault, and vertices after it are not known.
        let totals = vertices(bytes, limits).unwrap_or([u64::MAX; 3]);
        Self::read_within(bytes, limits, Some(totals), ignored)
    }

    fn read_within(
        bytes: &[u8],
        limits: &Limits,
        totals: Option<[u64; 3]>,
        ignored: [bool; 3],
    ) -> Result<Self, FormatError> {
        let lines = Lines::new(bytes, limits.line_bytes);
        let mut reader =
            Reader { lines, limits, totals, ignored, face: Vec::new(), chunk: Self::default() };
        let mut word = reader.lines.first_statement()?;
        while let Some(statement) = word {
            reader.statement(statement)?;
            word = reader.lines.next_statement()?;
        }
        let mut chunk = reader.chunk;
        chunk.lines = reader.lines.passed();
        chunk.fill();
        Ok(chunk)
    }

    /// Returns the numbers of positions, texture coordinates and normals.
    pub(super) fn counts(&self) -> [u64; 3] {
        [self.positions.len(), self.texcoords.len(), self.normals.len()].map(|n| n as u64)
    }

    /// Fills optional lists up to their full length: so far they end with their last given entry.
    fn fill(&mut self) {
        let corners = self.corners[0].len();
        for list in &mut self.corners[1..] {
            if !list.is_empty() {
                list.resize(corners, NONE);
            }
        }
        if !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), [1.0; 4]);
        }
        if !self.texcoords_w.is_empty() {
            self.texcoords_w.resize(self.texcoords.len(), 0.0);
        }
    }
}

struct Reader<'a> {
    lines: Lines<'a>,
    limits: &'a Limits,
    /// Positions, texture coordinates and normals of the file, if indices are compared with them.
    totals: Option<[u64; 3]>,
    /// Indices of these kinds are left out: the file has nothing that they could name.
    ignored: [bool; 3],
    /// The current face: for each corner the numbers as written, 0 for none.
    face: Vec<[i64; 3]>,
    chunk: Chunk,
}

impl<'a> Reader<'a> {
    /// Reads the statement that begins with this word.
    fn statement(&mut self, word: &[u8]) -> Result<(), FormatError> {
        let (line, notes) = (self.lines.number(), &mut self.chunk.notes);
        match word {
            b"v" => self.position()?,
            b"vt" => self.texcoord()?,
            b"vn" => self.normal()?,
            b"f" | b"fo" => self.face()?,
            b"usemtl" => self.name(|name| Name::Material(unquoted(&name).to_owned())),
            b"g" => self.name(Name::Group),
            b"o" => self.name(Name::Object),
            b"mtllib" => {
                let name = self.lines.rest();
                self.chunk.libraries.push((line, name));
            }
            b"l" | b"p" => self.element(word == b"l")?,
            b"curv" | b"curv2" | b"surf" => notes.free_form.add(line),
            b"s" | b"vp" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"mg"
            | b"shadow_obj" | b"trace_obj" | b"usemap" | b"maplib" | b"cstype" | b"deg"
            | b"bmat" | b"step" | b"ctech" | b"stech" | b"parm" | b"trim" | b"hole" | b"scrv"
            | b"sp" | b"end" | b"con" => {}
            other => {
                if notes.unknown.times == 0 {
                    notes.unknown_first = text(&other[..other.len().min(20)]);
                }
                notes.unknown.add(line);
                return Ok(());
            }
        }
        self.chunk.has_statement = true;
        self.lines.skip();
        Ok(())
    }

    fn malformed(&self, problem: impl Into<String>) -> FormatError {
        FormatError::new(Fault::Malformed, self.lines.location(), problem)
    }

    fn limit(&self, problem: String) -> FormatError {
        FormatError::new(Fault::Limit, self.lines.location(), problem)
    }

    fn name(&mut self, name: impl Fn(String) -> Name) {
        self.chunk.names.push((self.chunk.face_ends.len() as u32, name(self.lines.rest())));
    }

    /// Reads numbers to the end of the statement; those beyond `N` are only counted.
    fn numbers<const N: usize>(&mut self) -> Result<([f32; N], usize), FormatError> {
        let (mut numbers, mut count) = ([0.0; N], 0);
        while let Some(token) = self.lines.token() {
            if let Some(value) = numbers.get_mut(count) {
                *value = number(token).ok_or_else(|| {
                    self.malformed(format!("`{}` is not a number", quoted(token)))
                })?;
            }
            count += 1;
        }
        if count > N {
            self.chunk.notes.extra_values.add(self.lines.number());
        }
        Ok((numbers, count))
    }

    /// Refuses more vertices of a kind than limits allow.
    fn check_count(&self, count: usize) -> Result<(), FormatError> {
        if count as u64 > max_vertices(self.limits) {
            return Err(self.limit(format!("more than {} vertices", self.limits.vertices)));
        }
        Ok(())
    }

    fn position(&mut self) -> Result<(), FormatError> {
        let (numbers, count) = self.numbers::<7>()?;
        if count < 3 {
            return Err(self.malformed(format!("a position needs three numbers, here are {count}")));
        }
        let [x, y, z, r, g, b, a] = numbers;
        if ![x, y, z].iter().all(|c| c.is_finite()) {
            return Err(self.malformed(format!("the position ({x}, {y}, {z}) is not finite")));
        }
        let (chunk, line) = (&mut self.chunk, self.lines.number());
        match count {
            4 if r != 1.0 => chunk.notes.weights.add(line),
            5 => chunk.notes.extra_values.add(line),
            _ => {}
        }
        if count < 6 {
            chunk.notes.uncolored.add(line);
        } else {
            chunk.colors.resize(chunk.positions.len(), [1.0; 4]);
            chunk.colors.push([r, g, b, if count > 6 { a } else { 1.0 }]);
            chunk.color_has_alpha |= count > 6;
        }
        chunk.positions.push([x, y, z]);
        self.check_count(self.chunk.positions.len())
    }

    fn texcoord(&mut self) -> Result<(), FormatError> {
        let ([u, v, w], count) = self.numbers::<3>()?;
        if count == 0 {
            return Err(self.malformed("texture coordinates need at least one number"));
        }
        let chunk = &mut self.chunk;
        if w != 0.0 || !chunk.texcoords_w.is_empty() {
            chunk.texcoords_w.resize(chunk.texcoords.len(), 0.0);
            chunk.texcoords_w.push(w);
        }
        chunk.texcoords.push([u, v]);
        self.check_count(self.chunk.texcoords.len())
    }

    fn normal(&mut self) -> Result<(), FormatError> {
        let (normal, count) = self.numbers::<3>()?;
        if count < 3 {
            return Err(self.malformed(format!("a normal needs three numbers, here are {count}")));
        }
        self.chunk.normals.push(normal);
        self.check_count(self.chunk.normals.len())
    }

    fn face(&mut self) -> Result<(), FormatError> {
        self.face.clear();
        while let Some(token) = self.lines.token() {
            if (self.chunk.corners[0].len() + self.face.len()) as u64 >= max_corners(self.limits) {
                return Err(self.limit(format!("more than {} triangles", self.limits.triangles)));
            }
            let corner = self.corner(token)?;
            self.face.push(corner);
        }
        if self.face.len() < 3 {
            self.chunk.notes.small_faces.add(self.lines.number());
            return Ok(());
        }
        let counts = self.chunk.counts();
        for corner in &self.face {
            let number_of_corner = self.chunk.corners[0].len();
            for (kind, &number) in corner.iter().enumerate() {
                if number == 0 {
                    continue;
                }
                let list = &mut self.chunk.corners[kind];
                list.resize(number_of_corner, NONE);
                if number > 0 {
                    // Numbers that do not fit are refused later: `spans` has the highest.
                    list.push((number - 1) as u32);
                } else {
                    self.chunk.relative[kind].push(number_of_corner as u32);
                    list.push((counts[kind] as i64 + number) as u32);
                }
            }
        }
        self.chunk.face_ends.push(self.chunk.corners[0].len() as u32);
        Ok(())
    }

    /// Reads points or a line: positions, of which texture coordinates do not matter.
    fn element(&mut self, is_line: bool) -> Result<(), FormatError> {
        let mut vertices = Vec::new();
        let count = self.chunk.positions.len() as i64;
        while let Some(token) = self.lines.token() {
            let part = token.split(|&b| b == b'/').next().unwrap_or_default();
            let Some(number) = integer(part).filter(|number| *number != 0) else {
                return Err(self.malformed(format!("`{}` is not a vertex", quoted(token))));
            };
            let relative = number < 0;
            vertices.push((number + if relative { count } else { -1 }, relative));
        }
        let line = self.lines.number();
        let notes = &mut self.chunk.notes;
        if is_line {
            notes.lines.add(line);
        } else {
            notes.points.add(line);
        }
        self.chunk.elements.push(Element { is_line, vertices });
        Ok(())
    }

    /// The numbers of a corner as written, 0 for none.
    fn corner(&mut self, token: &[u8]) -> Result<[i64; 3], FormatError> {
        let mut corner = [0; 3];
        let mut parts = token.splitn(3, |&b| b == b'/');
        for (kind, number) in corner.iter_mut().enumerate() {
            let part = parts.next().unwrap_or_default();
            if kind == 0 || !part.is_empty() {
                *number = self.index(token, part, kind)?;
            }
        }
        Ok(corner)
    }

    /// An index of a corner as written; compared with the file's vertices if these are known.
    fn index(&mut self, token: &[u8], part: &[u8], kind: usize) -> Result<i64, FormatError> {
        let Some(number) = integer(part) else {
            return Err(self.malformed(format!("`{}` is not a corner of a face", quoted(token))));
        };
        if number == 0 && kind > 0 {
            self.chunk.notes.zeros.add(self.lines.number());
            return Ok(0);
        }
        if number == 0 {
            return Err(self.malformed(format!("`{}`: indices start at 1", quoted(token))));
        }
        if self.ignored[kind] {
            self.chunk.notes.dangling[kind].add(self.lines.number());
            return Ok(0);
        }
        let count_so_far = self.chunk.counts()[kind];
        let Some(totals) = self.totals else {
            let span = &mut self.chunk.spans[kind];
            span.highest = span.highest.max(number);
            span.before = span.before.max(-number - count_so_far as i64);
            return Ok(number);
        };
        let available = if number < 0 { count_so_far } else { totals[kind] };
        if number.unsigned_abs() > available {
            let element = ["position", "texture coordinate", "normal"][kind];
            let token = quoted(token);
            let problem =
                format!("`{token}`: {element} {number} does not exist (the file has {available})");
            return Err(self.malformed(problem));
        }
        Ok(number)
    }
}

/// The numbers of positions, texture coordinates and normals of a file.
pub(super) fn vertices(bytes: &[u8], limits: &Limits) -> Result<[u64; 3], FormatError> {
    let mut lines = Lines::new(bytes, limits.line_bytes);
    let mut counts = [0; 3];
    let mut word = lines.first_statement()?;
    while let Some(statement) = word {
        let kind = [b"v".as_slice(), b"vt", b"vn"].iter().position(|&kind| kind == statement);
        if let Some(kind) = kind {
            counts[kind] += 1;
        }
        lines.skip();
        word = lines.next_statement()?;
    }
    Ok(counts)
}

/// The positions of a file that was read without a fault, in double precision.
pub(super) fn exact_positions(bytes: &[u8], limits: &Limits) -> Result<Vec<[f64; 3]>, FormatError> {
    let mut lines = Lines::new(bytes, limits.line_bytes);
    let mut positions = Vec::new();
    let mut word = lines.first_statement()?;
    while let Some(statement) = word {
        if statement == b"v" {
            let mut coordinate = || lines.token().and_then(number::<f64>).unwrap_or_default();
            positions.push([coordinate(), coordinate(), coordinate()]);
        }
        lines.skip();
        word = lines.next_statement()?;
    }
    Ok(positions)
}

/// The largest number of positions, texture coordinates or normals that indices and limits allow.
pub(super) fn max_vertices(limits: &Limits) -> u64 {
    limits.vertices.min(u64::from(NONE) - 1)
}

/// The largest number of corners that indices and the limit on triangles allow.
pub(super) fn max_corners(limits: &Limits) -> u64 {
    limits.triangles.saturating_mul(3).min(u64::from(NONE) - 1)
}

/// A word for a message: short and without control characters.
fn quoted(token: &[u8]) -> String {
    let short = text(&token[..token.len().min(40)]);
    short.escape_debug().to_string()
}
