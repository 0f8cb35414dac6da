//! Reading a stream as it comes: after any piece it has the meshes of the last whole block.

use super::VERSION;
use super::block::{self, Block, MAGIC, PREAMBLE, Parsed};
use super::head::{Head, ObjectHeader};
use crate::{Document, Fault, FormatError, Limits, ObjectInfo, Source};
use lodc_mesh::{Cleaning, Mesh, MeshParts, take_leb128};
use lodc_progressive::{Contexts, MeshDecoder, StepBlock};
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
    /// Bytes that are no whole block yet, and how many of them are already read.
    waiting: Vec<u8>,
    read: usize,
    /// Bytes of all whole blocks so far.
    bytes: u64,
    blocks: u64,
    head: Option<Head>,
    decoders: Vec<MeshDecoder>,
    contexts: Box<Contexts>,
    complete: bool,
    triangles_only: bool,
    failed: Option<FormatError>,
}

/// The progress of an object: the parts so far, and in all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Vertices so far, and in all.
    pub vertices: [u32; 2],
    /// Triangles so far, and in all.
    pub triangles: [u32; 2],
    /// Steps so far, and in all.
    pub steps: [u32; 2],
    /// Object-space error of the mesh so far, in its units; at most 1/16 above the true one.
    pub error: f32,
}

impl Unpacker {
    /// An unpacker that has been fed nothing.
    #[must_use]
    pub fn new(limits: Limits) -> Self {
        Self {
            limits,
            waiting: Vec::new(),
            read: 0,
            bytes: 0,
            blocks: 0,
            head: None,
            decoders: Vec::new(),
            contexts: Box::new(Contexts::new()),
            complete: false,
            triangles_only: false,
            failed: None,
        }
    }

    /// Skips strips, which is faster. To be called before anything is fed.
    #[must_use]
    pub fn triangles_only(mut self) -> Self {
        self.triangles_only = true;
        self
    }

    /// Takes the next bytes of the stream and reads all blocks that they complete. Keeps at most
    /// one block besides the meshes.
    ///
    /// # Errors
    /// If the stream is damaged there, crafted or too new. Everything before stays, and every
    /// further call returns the same error.
    pub fn feed(&mut self, bytes: &[u8]) -> Result<(), FormatError> {
        if let Some(failed) = &self.failed {
            return Err(failed.clone());
        }
        self.waiting.drain(..std::mem::take(&mut self.read));
        self.waiting.extend_from_slice(bytes);
        let waiting = std::mem::take(&mut self.waiting);
        let result = self.read_blocks(&waiting);
        self.waiting = waiting;
        if let Err(e) = &result {
            self.failed = Some(e.clone());
            self.waiting = Vec::new();
            self.read = 0;
        }
        result
    }

    /// Returns whether the stream has come to its end.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Bytes up to the end of the last whole block.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The source of the scene; none before the first block.
    #[must_use]
    pub fn source(&self) -> Option<&Source> {
        self.head.as_ref().map(|h| &h.source)
    }

    /// Everything that is not a triangle mesh; none before the first block.
    #[must_use]
    pub fn document(&self) -> Option<&Document> {
        self.head.as_ref().map(|h| &h.document)
    }

    /// Number of objects; 0 before the first block.
    #[must_use]
    pub fn objects(&self) -> usize {
        self.decoders.len()
    }

    /// The names and scale of an object.
    ///
    /// # Panics
    /// If there is no such object. So do all functions below.
    #[must_use]
    pub fn info(&self, object: usize) -> &ObjectInfo {
        &self.head.as_ref().expect("objects are known from the head on").objects[object].info
    }

    /// The progress of an object.
    #[must_use]
    pub fn progress(&self, object: usize) -> Progress {
        let decoder = &self.decoders[object];
        let header = decoder.header();
        Progress {
            vertices: [decoder.vertex_count(), header.vertices],
            triangles: [decoder.triangle_count(), header.triangles],
            steps: [decoder.steps(), header.steps],
            error: decoder.error(),
        }
    }

    /// An object as it is decoded: its triangles, parents and steps in stream order.
    #[must_use]
    pub fn decoder(&self, object: usize) -> &MeshDecoder {
        &self.decoders[object]
    }

    /// The strips that draw an object so far, see [`MeshDecoder::strips`].
    #[must_use]
    pub fn strips(&self, object: usize) -> Option<StripSet> {
        self.decoders[object].strips()
    }

    /// The mesh of an object so far: vertices in collapse order, without those that no triangle
    /// uses, and triangles in stream order. [`Cleaning`] says what else was left out, which only
    /// quantisation can cause.
    ///
    /// # Errors
    /// If the mesh of a crafted stream is invalid.
    pub fn mesh(&self, object: usize) -> Result<(Mesh, Cleaning), FormatError> {
        let mut parts = self.mesh_parts(object);
        let cleaning = parts.clean();
        let mesh = Mesh::try_from(parts).map_err(|e| {
            FormatError::new(Fault::Malformed, format!("object {object}"), e.to_string())
        })?;
        Ok((mesh, cleaning))
    }

    /// The mesh of an object so far with all its vertices, valid or not.
    pub(super) fn mesh_parts(&self, object: usize) -> MeshParts {
        self.decoders[object].mesh_parts()
    }

    fn read_blocks(&mut self, waiting: &[u8]) -> Result<(), FormatError> {
        if self.bytes == 0 {
            if !check_preamble(waiting)? {
                return Ok(());
            }
            (self.read, self.bytes) = (PREAMBLE, PREAMBLE as u64);
        }
        while self.read < waiting.len() {
            let number = self.blocks;
            let malformed =
                |what: &str| FormatError::new(Fault::Malformed, format!("block {number}"), what);
            if self.complete {
                return Err(malformed("follows the end of the stream"));
            }
            match block::parse(&waiting[self.read..], number) {
                Parsed::Incomplete => return Ok(()),
                Parsed::Damaged(what) => return Err(malformed(what)),
                Parsed::Block(block, length) => {
                    match (number, block.tag) {
                        (0, _) => self.read_head(block)?,
                        (_, 0) => self.read_end(block).map_err(malformed)?,
                        _ => self.read_steps(block).map_err(malformed)?,
                    }
                    self.blocks += 1;
                    self.read += length;
                    self.bytes += length as u64;
                }
            }
        }
        Ok(())
    }

    fn read_head(&mut self, block: Block<'_>) -> Result<(), FormatError> {
        if (block.tag, block.steps) != (0, 0) {
            return Err(FormatError::new(Fault::Malformed, "block 0", "is not a head"));
        }
        let head = Head::parse(block.payload, &self.limits)?;
        let new = if self.triangles_only { MeshDecoder::triangles_only } else { MeshDecoder::new };
        let decoder = |o: &ObjectHeader| new(o.mesh.clone());
        self.decoders = head.objects.iter().map(decoder).collect();
        self.head = Some(head);
        Ok(())
    }

    fn read_end(&mut self, block: Block<'_>) -> Result<(), &'static str> {
        let is_end = block.steps == 0 && block.payload.is_empty();
        if !is_end || !self.decoders.iter().all(MeshDecoder::is_complete) {
            return Err("ends the stream before every object is complete");
        }
        self.complete = true;
        Ok(())
    }

    fn read_steps(&mut self, block: Block<'_>) -> Result<(), &'static str> {
        let decoder = self
            .decoders
            .get_mut(block.tag as usize - 1)
            .ok_or("belongs to an object that does not exist")?;
        let (splits, strips) = substreams(block.payload, decoder.header().strips)
            .ok_or("has a substream that is longer than it")?;
        let bytes = self.bytes as usize + block.payload.len();
        let steps = StepBlock { steps: block.steps, splits, strips, bytes };
        decoder.decode(&mut self.contexts, steps).map_err(|e| e.0)
    }
}

/// Returns the two substreams of a payload; the second is empty without strips.
fn substreams(payload: &[u8], strips: bool) -> Option<(&[u8], &[u8])> {
    if !strips {
        return Some((payload, &[]));
    }
    let mut rest = payload;
    let splits = take_leb128(&mut rest, u64::from(u32::MAX))?;
    rest.split_at_checked(splits as usize)
}

/// Returns whether the first bytes are all there, and those of a stream.
fn check_preamble(bytes: &[u8]) -> Result<bool, FormatError> {
    let malformed = |what: &str| FormatError::new(Fault::Malformed, "header", what);
    let magic = bytes.len().min(MAGIC.len());
    if bytes[..magic] != MAGIC[..magic] {
        return Err(malformed("this is not a .lods stream"));
    }
    let Some(version) = bytes.get(MAGIC.len()..PREAMBLE) else { return Ok(false) };
    match u32::from_le_bytes(version.try_into().expect("four bytes")) {
        VERSION => Ok(true),
        0 => Err(malformed("version 0 never existed")),
        v => {
            let what = format!(
                "version {v} is newer than this program, which reads up to version {VERSION}"
            );
            Err(FormatError::new(Fault::Unsupported, "header", what))
        }
    }
}
