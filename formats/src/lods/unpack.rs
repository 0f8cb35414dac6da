//! Reads a `.lods` stream piece by piece: after each piece it has the meshes of the last complete
//! block.

use super::Arrived;
use super::block::{self, Block, FILE_HEADER, Parsed};
use super::document::SequenceFacts;
use super::mesh_header;
use super::rebuild::{self, Rebuilt};
use super::received::{Received, ReceivedObject};
use crate::{Document, Fault, FormatError, Limits, ObjectInfo, Source};
use lodc_mesh::{Cleaning, Mesh, MeshParts, take_leb128};
use lodc_progressive::{Contexts, MeshDecoder, StepBlock, TextCodec, decode_turns};

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
    /// The bytes fed last, with those before that had not made a whole block yet.
    waiting: Vec<u8>,
    /// How many of the waiting bytes are blocks that have been read.
    read_bytes: usize,
    /// Bytes of all whole blocks so far.
    bytes: u64,
    blocks: u64,
    /// Everything from the first block on.
    received: Option<Received>,
    /// Adaptive probabilities of the decoder of steps.
    contexts: Box<Contexts>,
    /// Decompresses the headers of objects.
    header_codec: TextCodec,
    complete: bool,
    /// The error that every further call returns.
    failure: Option<FormatError>,
}

/// How much of an object has arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Vertices so far, with points that are only announced ([`MeshDecoder::has_come`]), and in
    /// all.
    pub vertices: [u32; 2],
    /// Triangles so far, and in all.
    pub triangles: [u32; 2],
    /// Steps so far, and in all.
    pub steps: [u32; 2],
    /// Object-space error of the mesh so far, in its units; at most 1/16 above the true one.
    pub error: f32,
    /// Its root mean square distance, as precise; nothing if the stream has none.
    pub rms: Option<f32>,
}

impl Unpacker {
    /// An unpacker that has been fed nothing.
    #[must_use]
    pub fn new(limits: Limits) -> Self {
        Self {
            limits,
            waiting: Vec::new(),
            read_bytes: 0,
            bytes: 0,
            blocks: 0,
            received: None,
            contexts: Box::new(Contexts::new()),
            header_codec: mesh_header::codec(),
            complete: false,
            failure: None,
        }
    }

    /// Takes the next bytes of the stream and reads all blocks that they complete. Keeps at most
    /// one block besides the meshes.
    ///
    /// # Errors
    /// If the stream is damaged there, crafted or too new. Everything before stays, and every
    /// further call returns the same error.
    pub fn feed(&mut self, bytes: &[u8]) -> Result<(), FormatError> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        self.waiting.drain(..std::mem::take(&mut self.read_bytes));
        self.waiting.extend_from_slice(bytes);
        let waiting = std::mem::take(&mut self.waiting);
        let result = self.read_blocks(&waiting);
        self.waiting = waiting;
        if let Err(e) = &result {
            self.failure = Some(e.clone());
            self.waiting = Vec::new();
            self.read_bytes = 0;
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

    /// The source of the scene; none before the text of the document.
    #[must_use]
    pub fn source(&self) -> Option<&Source> {
        Some(&self.received.as_ref()?.document.parsed.as_ref()?.source)
    }

    /// Everything that is not a triangle mesh; none before all of it has come.
    #[must_use]
    pub fn document(&self) -> Option<&Document> {
        self.received.as_ref()?.complete_document()
    }

    /// The document without its buffer; none before its text.
    #[must_use]
    pub fn text(&self) -> Option<&Document> {
        Some(&self.received.as_ref()?.document.parsed.as_ref()?.document)
    }

    /// Bytes of the document's buffer that have come, without the first `from` of them: where each
    /// piece belongs, and the piece.
    pub fn buffer_pieces(&self, from: usize) -> impl Iterator<Item = (u64, &[u8])> {
        self.received.iter().flat_map(move |r| r.document.buffer_pieces(from))
    }

    /// The document and the names so far, fit to be written with the meshes so far.
    ///
    /// # Errors
    /// If the document of a crafted stream is malformed.
    pub fn arrived(&self) -> Result<Option<Arrived<'_>>, FormatError> {
        self.received.as_ref().map(Arrived::new).transpose()
    }

    /// Bytes of the document's buffer in all.
    #[must_use]
    pub fn buffer_bytes(&self) -> u64 {
        self.received.as_ref().map_or(0, |r| r.head.buffer)
    }

    /// Bytes of the document so far, and in all: its text as it is stored, and its buffer.
    #[must_use]
    pub fn document_bytes(&self) -> [u64; 2] {
        let received_and_total =
            |r: &Received| [r.document.bytes, u64::from(r.head.stored) + r.head.buffer];
        self.received.as_ref().map_or([0; 2], received_and_total)
    }

    /// Number of objects so far: those whose header has come, and once the text of the document has
    /// come, all.
    #[must_use]
    pub fn objects(&self) -> usize {
        self.received.as_ref().map_or(0, |r| r.objects.len())
    }

    /// Returns whether the header of an object has come, and with it how large it will be.
    #[must_use]
    pub fn has_header(&self, object: usize) -> bool {
        self.received.as_ref().is_some_and(|r| object < r.announced)
    }

    /// Number of objects in all; none before the first block.
    #[must_use]
    pub fn all_objects(&self) -> Option<u32> {
        self.received.as_ref().map(|r| r.head.objects)
    }

    /// The names and scale of an object: `mesh0`, `mesh1`, … and 1 before the text of the document
    /// has come.
    ///
    /// # Panics
    /// If there is no such object. So do all functions below.
    #[must_use]
    pub fn info(&self, object: usize) -> &ObjectInfo {
        &self.object(object).info
    }

    /// Facts of an object's collapse sequence that its steps do not say.
    #[must_use]
    pub fn facts(&self, object: usize) -> SequenceFacts {
        self.object(object).facts
    }

    fn object(&self, object: usize) -> &ReceivedObject {
        &self.received.as_ref().expect("objects come after the first block").objects[object]
    }

    /// The progress of an object.
    #[must_use]
    pub fn progress(&self, object: usize) -> Progress {
        let decoder = &self.object(object).decoder;
        let header = decoder.header();
        Progress {
            vertices: [decoder.vertex_count(), header.vertices],
            triangles: [decoder.triangle_count(), header.triangles],
            steps: [decoder.steps(), header.steps],
            error: decoder.error(),
            rms: decoder.rms(),
        }
    }

    /// An object as it is decoded: its triangles, parents and steps in stream order.
    #[must_use]
    pub fn decoder(&self, object: usize) -> &MeshDecoder {
        &self.object(object).decoder
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
            FormatError::new(Fault::Malformed, format!("object {object}"), format!("{e}"))
        })?;
        Ok((mesh, cleaning))
    }

    /// A complete object as a simplified mesh with the levels that were packed. Its errors are 0: a
    /// stream has them rounded, so they are to be measured. After quantising, levels may be wrong
    /// in other ways: whoever takes them verifies them.
    ///
    /// # Errors
    /// If the stream is a crafted one.
    ///
    /// # Panics
    /// If the stream is not complete.
    pub fn rebuilt(&self, object: usize) -> Result<Rebuilt, FormatError> {
        assert!(self.complete, "only a complete stream has all levels");
        let ReceivedObject { info, facts, decoder, .. } = self.object(object);
        rebuild::rebuild(decoder, *facts).map_err(|mut e| {
            e.location = format!("object \"{}\"", info.name);
            e
        })
    }

    /// The mesh of an object so far with all its vertices, valid or not.
    pub(super) fn mesh_parts(&self, object: usize) -> MeshParts {
        self.object(object).decoder.mesh_parts()
    }

    fn read_blocks(&mut self, waiting: &[u8]) -> Result<(), FormatError> {
        if self.bytes == 0 {
            if !FILE_HEADER.check(waiting)? {
                return Ok(());
            }
            (self.read_bytes, self.bytes) = (FILE_HEADER.length, FILE_HEADER.length as u64);
        }
        while self.read_bytes < waiting.len() {
            let number = self.blocks;
            let malformed = |problem: &str| {
                FormatError::new(Fault::Malformed, format!("block {number}"), problem)
            };
            if self.complete {
                return Err(malformed("follows the end of the stream"));
            }
            match block::parse(&waiting[self.read_bytes..], number) {
                Parsed::Incomplete => return Ok(()),
                Parsed::Damaged(problem) => return Err(malformed(problem)),
                Parsed::Block(block, length) => {
                    let read = if number == 0 { self.read_head(block) } else { self.read(block) };
                    read.map_err(|e| in_block(e, number))?;
                    self.blocks += 1;
                    self.read_bytes += length;
                    self.bytes += length as u64;
                }
            }
        }
        Ok(())
    }

    fn read_head(&mut self, block: Block<'_>) -> Result<(), FormatError> {
        if (block.tag, block.steps) != (0, 0) {
            return Err(malformed("is not a head"));
        }
        self.received = Some(Received::new(block.payload)?);
        Ok(())
    }

    fn read(&mut self, block: Block<'_>) -> Result<(), FormatError> {
        let received = self.received.as_mut().expect("block 0 was read");
        match (block.tag, block.payload) {
            (0, []) if block.steps == 0 && received.is_complete() => self.complete = true,
            (0, piece) if block.steps == 0 && !piece.is_empty() => received.read_document(piece)?,
            (0, _) if block.steps > 0 => return self.read_turns(block),
            (0, _) => return Err(malformed("ends the stream before everything is complete")),
            _ => return self.read_steps(block),
        }
        Ok(())
    }

    /// Reads a block in which objects take turns: headers of objects, then the steps.
    fn read_turns(&mut self, block: Block<'_>) -> Result<(), FormatError> {
        let received = self.received.as_mut().expect("block 0 was read");
        let mut payload = block.payload;
        let count = take_leb128(&mut payload, u64::from(u32::MAX));
        let count = count.ok_or_else(|| malformed("has no number of headers"))?;
        read_headers(count, &mut payload, received, &mut self.header_codec, &self.limits)?;
        let bytes = self.bytes as usize + block.payload.len();
        let steps = StepBlock { steps: block.steps, splits: payload, bytes };
        decode_turns(&mut received.objects, received.head.objects, &mut self.contexts, steps)
            .map_err(|e| malformed(e.0))
    }

    fn read_steps(&mut self, block: Block<'_>) -> Result<(), FormatError> {
        let received = self.received.as_mut().expect("block 0 was read");
        let (object, mut payload) = (block.tag as usize - 1, block.payload);
        let is_first = received.awaits_header(object);
        if is_first {
            read_headers(1, &mut payload, received, &mut self.header_codec, &self.limits)?;
        }
        let decoder = &mut received
            .objects
            .get_mut(object)
            .ok_or_else(|| malformed("belongs to an object that does not exist"))?
            .decoder;
        if is_first && block.steps == 0 && payload.is_empty() && decoder.header().steps == 0 {
            return Ok(());
        }
        let bytes = self.bytes as usize + block.payload.len();
        let steps = StepBlock { steps: block.steps, splits: payload, bytes };
        decoder.decode(&mut self.contexts, steps).map_err(|e| malformed(e.0))
    }
}

/// Reads the headers of the next objects off the front of a payload.
fn read_headers(
    count: u64,
    payload: &mut &[u8],
    received: &mut Received,
    codec: &mut TextCodec,
    limits: &Limits,
) -> Result<(), FormatError> {
    if count == 0 {
        return Ok(());
    }
    let headers = mesh_header::take(payload, codec)?;
    let mut unread = &headers[..];
    for _ in 0..count {
        if !received.awaits_header(received.announced) {
            return Err(malformed("has a header of an object that does not exist"));
        }
        received.announce(mesh_header::parse(&mut unread)?, limits)?;
    }
    mesh_header::check_end(unread)
}

fn malformed(problem: &str) -> FormatError {
    FormatError::new(Fault::Malformed, "", problem)
}

/// The error with the number of its block.
fn in_block(mut error: FormatError, number: u64) -> FormatError {
    let location = std::mem::take(&mut error.location);
    error.location = format!("block {number}");
    if !location.is_empty() {
        error.problem = format!("{location}: {}", error.problem);
    }
    error
}
