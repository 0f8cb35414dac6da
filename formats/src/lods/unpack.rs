//! Reading a stream as it comes in: fed with bytes, it shows at any time the mesh of the last whole
//! block.

use super::block::{self, Block, MAGIC, PREAMBLE, Parsed};
use super::coder::{Decoder, Runs};
use super::growth::Growth;
use super::head::{Head, Promise};
use super::record::{Models, Object};
use super::script::Unknown;
use super::{VERSION, error_value};
use crate::{Document, Fault, FormatError, Limits, ObjectInfo, Source};
use lodc_mesh::{Attribute, Cleaning, Mesh, MeshParts, Submesh};
use lodc_strip::StripSet;

/// Reads a stream from wherever its bytes come.
///
/// ```
/// use lodc_formats::{Limits, lods::Unpacker};
/// # fn main() -> Result<(), lodc_formats::FormatError> {
/// # let pieces: [&[u8]; 1] = [b"\x89LODS"];
/// let mut unpacker = Unpacker::new(Limits::DEFAULT);
/// for piece in pieces {
///     unpacker.feed(piece)?;
///     for object in 0..unpacker.objects() {
///         let coarse_first = unpacker.mesh(object)?;
///     }
/// }
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct Unpacker {
    limits: Limits,
    /// Bytes that are not a whole block yet, and how many of them are done with.
    waiting: Vec<u8>,
    done: usize,
    /// All bytes of whole blocks so far.
    taken: u64,
    blocks: u64,
    head: Option<Head>,
    growing: Vec<Growing>,
    models: Box<Models>,
    whole: bool,
    /// Whether strips are passed over.
    plain: bool,
    failed: Option<FormatError>,
}

#[derive(Debug)]
struct Growing {
    object: Object,
    steps: u32,
}

/// How far an object has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Vertices that have come, of how many.
    pub vertices: [u32; 2],
    /// Triangles that have come, of how many.
    pub triangles: [u32; 2],
    /// Steps that have come, of how many.
    pub steps: [u32; 2],
    /// Object-space error of the mesh that is there, in the mesh's units, rounded up by at most one
    /// sixteenth.
    pub error: f32,
}

impl Unpacker {
    /// One that has been fed nothing.
    #[must_use]
    pub fn new(limits: Limits) -> Self {
        Self {
            limits,
            waiting: Vec::new(),
            done: 0,
            taken: 0,
            blocks: 0,
            head: None,
            growing: Vec::new(),
            models: Box::new(Models::new()),
            whole: false,
            plain: false,
            failed: None,
        }
    }

    /// The same without strips, before it is fed anything: they are passed over, which is quicker.
    #[must_use]
    pub fn triangles_only(mut self) -> Self {
        self.plain = true;
        self
    }

    /// Takes the next bytes of the stream and all whole blocks that they complete. Not more than
    /// one block is kept besides the meshes.
    ///
    /// # Errors
    /// If the stream is damaged there, crafted or too new: then everything before stays, and every
    /// further call says the same.
    pub fn feed(&mut self, bytes: &[u8]) -> Result<(), FormatError> {
        if let Some(failed) = &self.failed {
            return Err(failed.clone());
        }
        self.waiting.drain(..std::mem::take(&mut self.done));
        self.waiting.extend_from_slice(bytes);
        let waiting = std::mem::take(&mut self.waiting);
        let result = self.blocks(&waiting);
        self.waiting = waiting;
        if let Err(e) = &result {
            self.failed = Some(e.clone());
            self.waiting = Vec::new();
            self.done = 0;
        }
        result
    }

    /// Whether the whole stream has come.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.whole
    }

    /// Bytes of the blocks that are shown.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.taken
    }

    /// Where the scene came from; none before the first block is there.
    #[must_use]
    pub fn source(&self) -> Option<&Source> {
        self.head.as_ref().map(|h| &h.source)
    }

    /// Everything that is not a triangle mesh; none before the first block is there.
    #[must_use]
    pub fn document(&self) -> Option<&Document> {
        self.head.as_ref().map(|h| &h.document)
    }

    /// How many objects there are; 0 before the first block is there.
    #[must_use]
    pub fn objects(&self) -> usize {
        self.growing.len()
    }

    /// What is known of an object.
    ///
    /// # Panics
    /// If there is no such object. So do all functions below.
    #[must_use]
    pub fn info(&self, object: usize) -> &ObjectInfo {
        &self.promise(object).info
    }

    /// How far an object has come.
    #[must_use]
    pub fn state(&self, object: usize) -> State {
        let (promise, growing) = (self.promise(object), &self.growing[object]);
        State {
            vertices: [growing.object.growth.vertices(), promise.vertices],
            triangles: [growing.object.growth.faces(), promise.triangles],
            steps: [growing.steps, promise.steps],
            error: error_value(growing.object.error),
        }
    }

    /// The triangles that an object shows now, in order of arrival: what is there stays in its
    /// place when more comes, only corners change. Vertices are numbered by arrival too: vertex `i`
    /// here is vertex `vertices − 1 − i` of the object in collapse order.
    #[must_use]
    pub fn triangles(&self, object: usize) -> impl ExactSizeIterator<Item = [u32; 3]> {
        let growth = &self.growing[object].object.growth;
        (0..growth.faces()).map(|f| growth.face(f))
    }

    /// The submesh of each vertex by arrival.
    #[must_use]
    pub fn vertex_submesh(&self, object: usize) -> &[u32] {
        &self.growing[object].object.growth.submesh
    }

    /// For each vertex by arrival the one that it came out of; 0 for the first.
    #[must_use]
    pub fn survivors(&self, object: usize) -> &[u32] {
        &self.growing[object].object.survivors
    }

    /// For each vertex by arrival whether its step goes on with the next.
    #[must_use]
    pub fn goes_on(&self, object: usize) -> &[bool] {
        &self.growing[object].object.goes_on
    }

    /// The strips that an object shows now, by arrival of their vertices, in the order of drawing;
    /// none if the stream does not tell strips. While triangles are missing a strip may be shown in
    /// several pieces.
    #[must_use]
    pub fn strips(&self, object: usize) -> Option<StripSet> {
        let growth = &self.growing[object].object.growth;
        self.growing[object]
            .object
            .order
            .as_ref()?
            .draw(growth, self.promise(object).submeshes.len())
    }

    /// The mesh that an object shows now: its vertices in collapse order, its triangles by arrival,
    /// as a mesh of its own without vertices that no triangle uses. [`Cleaning`] says what else was
    /// left out, which only quantising can make.
    ///
    /// # Errors
    /// If a crafted stream says something that is no mesh.
    pub fn mesh(&self, object: usize) -> Result<(Mesh, Cleaning), FormatError> {
        let mut parts = self.parts(object);
        let cleaning = parts.clean();
        let wrong =
            |what: String| FormatError::new(Fault::Malformed, format!("object {object}"), what);
        Ok((Mesh::try_from(parts).map_err(|e| wrong(e.to_string()))?, cleaning))
    }

    /// The mesh that an object shows now with all that has come, valid or not.
    pub(super) fn parts(&self, object: usize) -> MeshParts {
        parts(self.promise(object), &self.growing[object].object.growth)
    }

    fn promise(&self, object: usize) -> &Promise {
        &self.head.as_ref().expect("objects are known from the head on").objects[object]
    }

    fn blocks(&mut self, waiting: &[u8]) -> Result<(), FormatError> {
        if self.taken == 0 {
            if !preamble(waiting)? {
                return Ok(());
            }
            (self.done, self.taken) = (PREAMBLE, PREAMBLE as u64);
        }
        while self.done < waiting.len() {
            let number = self.blocks;
            let wrong =
                |what: &str| FormatError::new(Fault::Malformed, format!("block {number}"), what);
            if self.whole {
                return Err(wrong("follows the end of the stream"));
            }
            match block::parse(&waiting[self.done..], number) {
                Parsed::Part => return Ok(()),
                Parsed::Damaged(what) => return Err(wrong(what)),
                Parsed::Block(block, length) => {
                    if number == 0 {
                        self.begin(block)?;
                    } else {
                        self.steps(block).map_err(wrong)?;
                    }
                    self.blocks += 1;
                    self.done += length;
                    self.taken += length as u64;
                }
            }
        }
        Ok(())
    }

    fn begin(&mut self, block: Block<'_>) -> Result<(), FormatError> {
        if (block.subject, block.steps) != (0, 0) {
            return Err(FormatError::new(Fault::Malformed, "block 0", "is not a head"));
        }
        let head = Head::read(block.payload, &self.limits)?;
        let growing = |p: &Promise| {
            let growth = Growth::new(p.layout.systems.clone());
            Growing {
                object: Object::new(
                    growth,
                    p.layout.streams.clone(),
                    p.submeshes.len() as u32,
                    p.strips && !self.plain,
                ),
                steps: 0,
            }
        };
        self.growing = head.objects.iter().map(growing).collect();
        self.head = Some(head);
        Ok(())
    }

    fn steps(&mut self, block: Block<'_>) -> Result<(), &'static str> {
        let promises = self.head.as_ref().map(|h| &h.objects[..]).unwrap_or_default();
        let Some(number) = (block.subject as usize).checked_sub(1) else {
            let complete = |(g, p): (&Growing, &Promise)| {
                g.steps == p.steps
                    && g.object.growth.vertices() == p.vertices
                    && g.object.growth.faces() == p.triangles
            };
            if block.steps != 0
                || !block.payload.is_empty()
                || !self.growing.iter().zip(promises).all(complete)
            {
                return Err("ends the stream before all has come");
            }
            self.whole = true;
            return Ok(());
        };
        let Some((growing, promise)) = self.growing.get_mut(number).zip(promises.get(number))
        else {
            return Err("belongs to an object that is not there");
        };
        if block.steps == 0 || block.steps > promise.steps - growing.steps {
            return Err("has no steps, or more than were promised");
        }
        let bytes = self.taken as usize + block.payload.len();
        let (mesh, strips) =
            parted(block.payload, promise.strips).ok_or("has a part that is longer than it")?;
        let mut runs = Runs { mesh: Decoder::new(mesh), strips: Decoder::new(strips) };
        for i in 1..=block.steps {
            let step =
                growing.object.step(&mut runs, &Unknown, &mut self.models, promise.vertices, bytes);
            let what = match step {
                Err(broken) => Some(broken.0),
                Ok(()) if runs.mesh.is_lost() || runs.strips.is_lost() => {
                    Some("ends before its steps do")
                }
                Ok(())
                    if i == block.steps
                        && !(runs.mesh.is_done() && (self.plain || runs.strips.is_done())) =>
                {
                    Some("does not end with its steps")
                }
                Ok(()) if growing.object.growth.faces() > promise.triangles => {
                    Some("has more triangles than were promised")
                }
                Ok(()) => None,
            };
            if let Some(what) = what {
                growing.object.mend();
                return Err(what);
            }
            growing.steps += 1;
        }
        Ok(())
    }
}

/// The two runs of a payload; the second is empty if there are no strips.
fn parted(payload: &[u8], strips: bool) -> Option<(&[u8], &[u8])> {
    if !strips {
        return Some((payload, &[]));
    }
    let (mesh, length) = block::varint(payload)?.ok()?;
    payload[length..].split_at_checked(mesh as usize)
}

/// Whether the first bytes are all there, and those of a stream.
fn preamble(bytes: &[u8]) -> Result<bool, FormatError> {
    let malformed = |what: String| FormatError::new(Fault::Malformed, "header", what);
    let magic = bytes.len().min(MAGIC.len());
    if bytes[..magic] != MAGIC[..magic] {
        return Err(malformed("this is not a .lods stream".to_owned()));
    }
    let Some(version) = bytes.get(MAGIC.len()..PREAMBLE) else { return Ok(false) };
    match u32::from_le_bytes(version.try_into().expect("four bytes")) {
        VERSION => Ok(true),
        0 => Err(malformed("version 0 never was".to_owned())),
        v => {
            let what = format!(
                "version {v} is newer than this program, which reads up to version {VERSION}"
            );
            Err(FormatError::new(Fault::Unsupported, "header", what))
        }
    }
}

fn parts(promise: &Promise, growth: &Growth) -> MeshParts {
    let vertices = growth.vertices();
    let last = vertices.wrapping_sub(1);
    let channels = growth.channels();
    let at = |v: u32| last.wrapping_sub(v) as usize * channels;
    let attribute = |(a, stream): (&Attribute, &super::values::Stream)| {
        let mut bytes = Vec::with_capacity(vertices as usize * a.stride());
        for v in 0..vertices {
            for c in stream.first..stream.first + stream.channels {
                promise.layout.put(a.component, c, growth.numbers[at(v) + c], &mut bytes);
            }
        }
        Attribute { bytes, ..a.described() }
    };
    let mut sorted: Vec<Vec<[u32; 3]>> = vec![Vec::new(); promise.submeshes.len()];
    for t in (0..growth.faces()).map(|f| growth.face(f)) {
        sorted[growth.submesh[t[0] as usize] as usize].push([
            last - t[0],
            last - t[1],
            last - t[2],
        ]);
    }
    let mut first_triangle = 0;
    let submesh = |(s, triangles): (&Submesh, &Vec<[u32; 3]>)| {
        let submesh =
            Submesh { first_triangle, triangle_count: triangles.len() as u32, ..s.clone() };
        first_triangle += triangles.len() as u32;
        submesh
    };
    MeshParts {
        positions: (0..vertices)
            .map(|v| {
                std::array::from_fn(|c| promise.layout.systems[c].value(growth.numbers[at(v) + c]))
            })
            .collect(),
        vertex_submesh: growth.submesh.iter().rev().copied().collect(),
        attributes: promise
            .attributes
            .iter()
            .zip(&promise.layout.streams[1..])
            .map(attribute)
            .collect(),
        submeshes: promise.submeshes.iter().zip(&sorted).map(submesh).collect(),
        triangles: sorted.concat(),
    }
}
