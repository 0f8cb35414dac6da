//! Writing a stream: the head, then steps in the order of their errors, cut into blocks.

use super::block::{self, Block, FILE_HEADER};
use super::document::{EncodedDocument, SequenceFacts};
use super::head::Head;
use super::mesh_header;
use crate::lodc::{LodFile, LodObject};
use crate::{Fault, FormatError};
use lodc_mesh::Simplified;
use lodc_progressive::{
    BlockTarget, Contexts, EncodedSteps, ErrorBound, MeshEncoder, Quantize, VertexLayout,
    in_batches,
};
use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Options of a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PackOptions {
    /// Bits per value; lossless by default.
    pub quantize: Quantize,
    /// Steps keep their order, and each shows its level: batches would be smaller.
    pub exact: bool,
    /// The most bytes of a block, as far as whole steps allow; 0 for a block for each step.
    pub block_bytes: Option<u32>,
}

/// A stream and its statistics.
#[derive(Clone, Debug)]
pub struct Packed {
    /// The stream.
    pub bytes: Vec<u8>,
    /// Bytes of all that is not steps: the head, headers of objects, the document.
    pub head_bytes: u64,
    /// Its objects.
    pub objects: Vec<PackedObject>,
}

/// Statistics of one object of a stream.
#[derive(Clone, Debug)]
pub struct PackedObject {
    /// Bytes of its blocks, without its header.
    pub bytes: u64,
    /// Bytes that the same packages would take as plain words and bytes, positions only: the
    /// thesis's accounting (table 4.3), with what names the parent.
    pub package_bytes: u64,
    /// The same with normals: three words more for each vertex.
    pub package_bytes_with_normals: u64,
    /// Levels that are those of the file: the ends of batches, or all steps.
    pub exact_levels: u32,
    /// Bounds of the quantisation error.
    pub bounds: Vec<ErrorBound>,
}

/// Bytes of a block of steps unless something else is asked for. Early blocks are smaller.
const BLOCK_BYTES: u32 = 8192;
/// A block is not longer than this share of all before it ...
const GROWTH_SHARE: usize = 8;
/// ... or this many bytes.
const MIN_BLOCK_BYTES: usize = 96;
/// Bytes of a block of the document.
const MAX_DOCUMENT_BLOCK: usize = 1 << 20;

/// An object while it is written.
struct ObjectWriter<'a> {
    encoder: MeshEncoder<'a>,
    bounds: Vec<ErrorBound>,
    scale: f64,
    started: bool,
    bytes: u64,
    exact_levels: u32,
}

/// Packs a file.
///
/// # Errors
/// If something is larger than the format allows.
pub fn pack<M>(file: &LodFile<M>, options: &PackOptions) -> Result<Packed, FormatError> {
    let ordered: Vec<Cow<'_, Simplified>> =
        file.objects.iter().map(|o| in_stream_order(&o.simplified, options.exact)).collect();
    let writer = |(object, simplified)| ObjectWriter::new(object, simplified, options);
    let mut writers: Vec<_> =
        file.objects.iter().zip(ordered.iter().map(Cow::as_ref)).map(writer).collect();
    let names = file.objects.iter().map(|o| (&o.info, sequence_facts(o)));
    let document = EncodedDocument::new(&file.source, &file.document, names)
        .ok_or_else(|| too_large("the names and the JSON of the scene have more than 4 GiB"))?;
    let mut stream = StreamWriter::new(file, document);
    let block_bytes = options.block_bytes.unwrap_or(BLOCK_BYTES) as usize;
    let mut contexts = Box::new(Contexts::new());
    // The object that is farthest from its final mesh comes next, the first of equals.
    let mut queue: BinaryHeap<(u64, Reverse<usize>)> = BinaryHeap::new();
    queue.extend(
        (writers.iter().enumerate()).filter_map(|(i, w)| Some((w.priority()?, Reverse(i)))),
    );
    while let Some(&(priority, Reverse(next))) = queue.peek() {
        // Geometry first; then the document and the steps take turns.
        if priority < NOT_SHOWN && stream.put_document_if_due() {
            continue;
        }
        queue.pop();
        let writer = &mut writers[next];
        let before = stream.bytes.len();
        // The first block of an object ends as soon as it shows something.
        let is_first = priority == NOT_SHOWN && block_bytes > 0;
        let bytes = if is_first { 0 } else { stream.next_block_bytes().min(block_bytes) };
        let target = BlockTarget { bytes, before, until_triangle: is_first };
        let header = writer.start()?;
        let (steps, payload) = writer.encode(&mut contexts, target, &header)?;
        stream.put(Block { tag: next as u32 + 1, steps, payload: &payload });
        let bytes = (stream.bytes.len() - before - header.len()) as u64;
        (writer.bytes, stream.step_bytes) = (writer.bytes + bytes, stream.step_bytes + bytes);
        queue.extend(writer.priority().map(|priority| (priority, Reverse(next))));
    }
    while stream.put_document() {}
    stream.put(Block { tag: 0, steps: 0, payload: &[] });
    let head_bytes = stream.bytes.len() as u64 - stream.step_bytes - END_BYTES;
    let objects = writers.into_iter().map(ObjectWriter::finish).collect();
    Ok(Packed { bytes: stream.bytes, head_bytes, objects })
}

/// The priority of an object that has triangles, but none of them in the stream yet.
const NOT_SHOWN: u64 = u64::MAX;
/// Bytes of the block that ends a stream.
const END_BYTES: u64 = 9;

/// The mesh with its steps in the order in which they are packed.
fn in_stream_order(simplified: &Simplified, exact: bool) -> Cow<'_, Simplified> {
    let batches = if exact { None } else { in_batches(simplified) };
    batches.map_or(Cow::Borrowed(simplified), Cow::Owned)
}

fn sequence_facts<M>(object: &LodObject<M>) -> SequenceFacts {
    let parts = object.simplified.collapses().parts();
    SequenceFacts {
        last_legal_lod: parts.last_legal_lod.0,
        topology_changes: parts.topology_changes,
        first_topology_change: parts.first_topology_change.map(|lod| lod.0),
    }
}

/// The bytes of a stream so far.
struct StreamWriter<'a> {
    bytes: Vec<u8>,
    blocks: u64,
    document: EncodedDocument<'a>,
    /// Bytes of the document so far.
    document_bytes: usize,
    /// Bytes of all blocks of steps, without headers of objects.
    step_bytes: u64,
}

impl<'a> StreamWriter<'a> {
    /// Starts a stream with its first block.
    fn new<M>(file: &LodFile<M>, document: EncodedDocument<'a>) -> Self {
        let head = Head {
            format: file.source.format,
            objects: file.objects.len() as u32,
            text: document.text_bytes,
            stored: document.text.len() as u32,
            buffer: document.buffer.len() as u64,
        };
        let mut bytes = FILE_HEADER.start();
        FILE_HEADER.seal(&mut bytes);
        let mut stream = Self { bytes, blocks: 0, document, document_bytes: 0, step_bytes: 0 };
        stream.put(Block { tag: 0, steps: 0, payload: &head.to_bytes() });
        stream
    }

    /// Returns how long the next block may be: blocks grow with the stream.
    fn next_block_bytes(&self) -> usize {
        (self.bytes.len() / GROWTH_SHARE).max(MIN_BLOCK_BYTES)
    }

    fn put(&mut self, block: Block<'_>) {
        block::put(&mut self.bytes, self.blocks, block);
        self.blocks += 1;
    }

    /// Puts the next piece of the document unless it already has as many bytes as the steps.
    /// Returns whether there was one to put.
    fn put_document_if_due(&mut self) -> bool {
        (self.document_bytes as u64) < self.step_bytes && self.put_document()
    }

    /// Puts the next piece of the document. Returns whether there was one.
    fn put_document(&mut self) -> bool {
        let most = self.next_block_bytes().min(MAX_DOCUMENT_BLOCK);
        let piece = self.document.piece(self.document_bytes, most);
        let length = piece.len();
        if length > 0 {
            block::put(&mut self.bytes, self.blocks, Block { tag: 0, steps: 0, payload: piece });
            self.blocks += 1;
            self.document_bytes += length;
        }
        length > 0
    }
}

impl<'a> ObjectWriter<'a> {
    fn new<M>(object: &'a LodObject<M>, simplified: &'a Simplified, options: &PackOptions) -> Self {
        let mut layout = VertexLayout::choose(simplified);
        let bounds = options.quantize.apply(simplified.mesh(), &mut layout);
        let encoder = MeshEncoder::new(simplified, layout, options.exact);
        // A hub may keep what was put into batches from being coded so: of its levels only the
        // finest is sure to be one of the file.
        let in_vain = encoder.header().exact && !std::ptr::eq(simplified, &*object.simplified);
        let exact_levels = if in_vain { 1 } else { encoder.exact_levels() };
        let scale = object.info.world_scale;
        Self { encoder, bounds, scale, started: false, bytes: 0, exact_levels }
    }

    /// Returns a number that rises with the world error of the mesh so far; none if it is complete.
    fn priority(&self) -> Option<u64> {
        let encoder = &self.encoder;
        if !self.started || encoder.triangles() == 0 && encoder.header().triangles > 0 {
            Some(NOT_SHOWN)
        } else if encoder.is_complete() {
            None
        } else {
            Some((f64::from(encoder.error()) * self.scale + 0.0).to_bits())
        }
    }

    /// Returns the header if it is still to come, else nothing.
    fn start(&mut self) -> Result<Vec<u8>, FormatError> {
        if std::mem::replace(&mut self.started, true) {
            return Ok(Vec::new());
        }
        mesh_header::to_bytes(self.encoder.header())
            .ok_or_else(|| too_large("an object has too many submeshes and attributes"))
    }

    /// Encodes the next steps. Returns their number and a block's payload, which starts with
    /// `header`.
    fn encode(
        &mut self,
        contexts: &mut Contexts,
        target: BlockTarget,
        header: &[u8],
    ) -> Result<(u32, Vec<u8>), FormatError> {
        let mut payload = header.to_vec();
        // An object without vertices has no steps, only its header.
        let mut encoded = EncodedSteps::default();
        if !self.encoder.is_complete() {
            encoded = self.encoder.encode(contexts, target);
        }
        payload.extend(encoded.splits);
        if payload.len() > block::MAX_PAYLOAD {
            return Err(too_large("a single block has more than 16 MiB"));
        }
        Ok((encoded.steps, payload))
    }

    fn finish(self) -> PackedObject {
        let package_bytes = self.encoder.package_bytes();
        PackedObject {
            bytes: self.bytes,
            package_bytes,
            package_bytes_with_normals: package_bytes + 12 * u64::from(self.encoder.vertices()),
            exact_levels: self.exact_levels,
            bounds: self.bounds,
        }
    }
}

fn too_large(what: &str) -> FormatError {
    FormatError::new(Fault::Limit, "", what)
}
