//! Writes a `.lods` stream: the head, then the objects' steps from the coarsest to the finest in
//! the order of their errors, cut into blocks, with the document's pieces between them.

use super::block::{self, Block, FILE_HEADER};
use super::document::{EncodedDocument, LEADING_SHARE, SequenceFacts};
use super::head::Head;
use super::mesh_header;
use crate::lodc::{LodFile, LodObject};
use crate::{Fault, FormatError};
use lodc_mesh::{Simplified, put_leb128};
use lodc_progressive::{
    BlockTarget, Contexts, EncodedSteps, ErrorBound, MeshEncoder, Quantize, StepOrder, TextCodec,
    TurnsEncoder, VertexLayout, in_batches,
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
    /// The largest number of bytes of a block, as far as whole steps allow; 0 for a block for each
    /// step.
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
    /// Bytes that its steps would take as plain words and bytes, with positions and parents only:
    /// the update packages of the thesis (table 4.3).
    pub package_bytes: u64,
    /// The same with normals: three words more for each vertex.
    pub package_bytes_with_normals: u64,
    /// Levels that are those of the file: the ends of batches, or all steps.
    pub exact_levels: u32,
    /// Bounds of the quantisation error.
    pub bounds: Vec<ErrorBound>,
}

/// Bytes of a block of steps unless something else is asked for. Early blocks are smaller.
/// Chosen by hand.
const BLOCK_BYTES: u32 = 8192;
/// A block has at most one byte for this number of bytes of the stream before it, so that a reader
/// never waits long for more detail. Chosen by hand.
const BLOCK_SHARE: usize = 8;
/// Bytes that a block may have however short the stream before it is. Chosen by hand.
const MIN_BLOCK_BYTES: usize = 96;
/// Largest number of bytes of a block of the document. Chosen by hand.
const MAX_DOCUMENT_BLOCK: usize = 1 << 20;

/// A header that is coded after others like it takes about one part in so many of its bytes.
const HEADER_SHARE: usize = 3;

/// An object while it is written.
struct ObjectWriter<'a> {
    encoder: MeshEncoder<'a>,
    bounds: Vec<ErrorBound>,
    scale: f64,
    header_written: bool,
    /// Bytes of its blocks, without its header.
    bytes: u64,
    exact_levels: u32,
}

/// Packs a file.
///
/// # Errors
/// If something is larger than the format allows.
pub fn pack<M>(file: &LodFile<M>, options: &PackOptions) -> Result<Packed, FormatError> {
    let batches = StepOrder::batches(file.objects.len());
    let order = if options.exact { StepOrder::Exact } else { batches };
    let ordered: Vec<Cow<'_, Simplified>> =
        file.objects.iter().map(|o| in_stream_order(&o.simplified, order)).collect();
    let quantize = &options.quantize;
    let writer = |(object, simplified)| ObjectWriter::new(object, simplified, order, quantize);
    let mut writers: Vec<_> =
        file.objects.iter().zip(ordered.iter().map(Cow::as_ref)).map(writer).collect();
    let block_bytes = options.block_bytes.unwrap_or(BLOCK_BYTES) as usize;
    let blocks = step_blocks(&mut writers, block_bytes)?;
    let bytes_of = |blocks: &[StepsBlock]| -> u64 {
        blocks.iter().map(|block| (BLOCK_FIELDS + block.encoded.payload.len()) as u64).sum()
    };
    let first_picture = blocks.partition_point(|block| block.triangles == 0);
    let (step_bytes, first_bytes) = (bytes_of(&blocks), bytes_of(&blocks[..first_picture]));
    let descriptions =
        file.objects.iter().map(|o| (&o.info, SequenceFacts::of(o.simplified.collapses())));
    let document =
        EncodedDocument::new(&file.source, &file.document, descriptions, step_bytes, first_bytes)
            .ok_or_else(|| too_large("the names and the JSON of the scene have more than 4 GiB"))?;
    let all_bytes = step_bytes + document.bytes.len() as u64;
    let mut stream = StreamWriter::new(file, document);
    stream.put_document(stream.document.leading);
    let triangles: u64 = writers.iter().map(|w| u64::from(w.encoder.triangles())).sum();
    for block in blocks {
        // Triangles first; then what says where they are, and the document and steps take turns.
        let share_passed = LEADING_SHARE * stream.bytes.len() as u64 >= all_bytes;
        let are_apart = block.all_visible && writers.len() > 1;
        if block.triangles > 0 && (share_passed || are_apart) {
            stream.put_document(stream.document.prompt_end.saturating_sub(stream.document_bytes));
        }
        if block.all_visible && stream.document_bytes >= stream.document.prompt_end {
            let tenth_shown = 10 * block.triangles >= triangles;
            stream.put_due_document(tenth_shown);
        }
        let EncodedBlock { tag, steps, payload, shares } = &block.encoded;
        let (tag, steps) = (*tag, *steps);
        let fields = stream.put_steps(Block { tag, steps, payload }) - payload.len() as u64;
        if let [(first, _), ..] = shares[..] {
            writers[first].bytes += fields;
        }
        for &(object, bytes) in shares {
            writers[object].bytes += bytes;
        }
    }
    stream.put_document_up_to(stream.document.picture_end);
    stream.put_document_up_to(stream.document.bytes.len());
    stream.put(Block { tag: 0, steps: 0, payload: &[] });
    let step_bytes: u64 = writers.iter().map(|w| w.bytes).sum();
    let head_bytes = stream.bytes.len() as u64 - step_bytes - END_BYTES;
    let objects = writers.into_iter().map(ObjectWriter::finish).collect();
    Ok(Packed { bytes: stream.bytes, head_bytes, objects })
}

/// A block of steps, and what the blocks before it show.
struct StepsBlock {
    encoded: EncodedBlock,
    /// True if each object that has triangles shows some.
    all_visible: bool,
    /// Triangles of all objects.
    triangles: u64,
}

/// Encodes all steps, in blocks of at most `block_bytes`, as far as whole steps allow.
fn step_blocks(
    writers: &mut [ObjectWriter<'_>],
    block_bytes: usize,
) -> Result<Vec<StepsBlock>, FormatError> {
    // The object that is farthest from its final mesh comes next, the first of equals.
    let queued = |(i, w): (usize, &ObjectWriter<'_>)| Some((w.priority()?, Reverse(i)));
    let queue = writers.iter().enumerate().filter_map(queued).collect();
    let mut encoder = StepsEncoder {
        writers,
        queue,
        contexts: Box::new(Contexts::new()),
        header_codec: mesh_header::codec(),
        bytes: FILE_HEADER.length,
        triangles: 0,
    };
    let mut blocks = Vec::new();
    while let Some(&(priority, Reverse(object))) = encoder.queue.peek() {
        let has_steps = !encoder.writers[object].encoder.is_complete();
        let take_turns = encoder.queue.len() > 1 && block_bytes > 0 && has_steps;
        let (all_visible, triangles) = (priority < NO_TRIANGLE_YET, encoder.triangles);
        let encoded = if take_turns {
            encoder.turns(block_bytes)?
        } else {
            encoder.one_object(block_bytes)?
        };
        if encoded.payload.len() > block::MAX_PAYLOAD {
            return Err(too_large("a single block has more than 16 MiB"));
        }
        encoder.bytes += BLOCK_FIELDS + encoded.payload.len();
        blocks.push(StepsBlock { encoded, all_visible, triangles });
    }
    Ok(blocks)
}

/// A block of steps.
struct EncodedBlock {
    /// 0 if objects take turns, else one more than the number of the object.
    tag: u32,
    steps: u32,
    payload: Vec<u8>,
    /// Objects that have steps, and how many bytes of the payload are theirs.
    shares: Vec<(usize, u64)>,
}

/// Encodes steps block by block.
struct StepsEncoder<'w, 'a> {
    writers: &'w mut [ObjectWriter<'a>],
    /// Objects that are not complete, by priority.
    queue: BinaryHeap<(u64, Reverse<usize>)>,
    contexts: Box<Contexts>,
    header_codec: TextCodec,
    /// Bytes of the stream so far, without the document.
    bytes: usize,
    /// Triangles of all objects so far.
    triangles: u64,
}

impl StepsEncoder<'_, '_> {
    /// Encodes a block of the first object of the queue.
    fn one_object(&mut self, block_bytes: usize) -> Result<EncodedBlock, FormatError> {
        let (priority, Reverse(object)) = self.queue.pop().expect("an object in the queue");
        // The first block of an object ends as soon as it shows something.
        let until_triangle = priority == NO_TRIANGLE_YET && block_bytes > 0;
        let bytes = if until_triangle { 0 } else { next_block_bytes(self.bytes).min(block_bytes) };
        let target = BlockTarget { bytes, bytes_before: self.bytes, until_triangle };
        let writer = &mut self.writers[object];
        let (mut payload, header) = (Vec::new(), writer.start()?);
        if !header.is_empty() {
            mesh_header::put(&mut payload, &header, &mut self.header_codec);
        }
        // An object without vertices has no steps, only its header.
        let mut encoded = EncodedSteps::default();
        if !writer.encoder.is_complete() {
            let before = writer.encoder.triangles();
            encoded = writer.encoder.encode(&mut self.contexts, target);
            self.triangles += u64::from(writer.encoder.triangles() - before);
        }
        let shares = vec![(object, encoded.splits.len() as u64)];
        payload.append(&mut encoded.splits);
        self.queue.extend(writer.priority().map(|priority| (priority, Reverse(object))));
        Ok(EncodedBlock { tag: object as u32 + 1, steps: encoded.steps, payload, shares })
    }

    /// Encodes a block in which objects take turns, from the first of the queue on.
    fn turns(&mut self, block_bytes: usize) -> Result<EncodedBlock, FormatError> {
        let Self { writers, queue, .. } = self;
        let max_bytes = next_block_bytes(self.bytes).min(block_bytes);
        let (mut headers, mut header_count, mut shares) = (Vec::new(), 0, Vec::new());
        let mut turns = TurnsEncoder::new(&mut self.contexts, writers.len() as u32);
        let mut must_follow = false;
        let coded = |headers: &Vec<u8>| headers.len() / HEADER_SHARE;
        while must_follow || shares.is_empty() || coded(&headers) + turns.bytes() < max_bytes {
            let Some((_, Reverse(object))) = queue.pop() else { break };
            let writer = &mut writers[object];
            if !writer.header_written {
                headers.extend(writer.start()?);
                header_count += 1;
            }
            if !writer.encoder.is_complete() {
                let (bytes, triangles) = (turns.bytes(), writer.encoder.triangles());
                let (scale, next) = (writer.scale, queue.peek().map(|next| next.0));
                let goes_on =
                    |encoder: &MeshEncoder<'_>| stays_first(priority(encoder, scale), next);
                let max_bytes = max_bytes.saturating_sub(coded(&headers));
                must_follow = turns.turn(object as u32, &mut writer.encoder, max_bytes, goes_on);
                shares.push((object, (turns.bytes() - bytes) as u64));
                self.triangles += u64::from(writer.encoder.triangles() - triangles);
            }
            queue.extend(writer.priority().map(|priority| (priority, Reverse(object))));
        }
        let encoded = turns.finish(self.bytes);
        let mut payload = Vec::new();
        put_leb128(&mut payload, header_count);
        if header_count > 0 {
            mesh_header::put(&mut payload, &headers, &mut self.header_codec);
        }
        // Lengths of turns are estimates.
        let estimated: u64 = shares.iter().map(|(_, bytes)| bytes).sum();
        let all = encoded.splits.len() as u64;
        shares.iter_mut().for_each(|(_, bytes)| *bytes = *bytes * all / estimated.max(1));
        let rest = all - shares.iter().map(|(_, bytes)| bytes).sum::<u64>();
        shares.iter_mut().take(1).for_each(|(_, bytes)| *bytes += rest);
        payload.extend(encoded.splits);
        Ok(EncodedBlock { tag: 0, steps: encoded.steps, payload, shares })
    }
}

/// Returns whether an object of some priority goes on with its turn, given the next one's. It does
/// as long as its error is no more than 1/16 below that of the next, which is how precise errors in
/// streams are.
fn stays_first(priority: u64, next: Option<u64>) -> bool {
    let error = |priority| f64::from_bits(priority);
    match next {
        Some(NO_TRIANGLE_YET) => priority == NO_TRIANGLE_YET,
        Some(next) => priority == NO_TRIANGLE_YET || error(priority) * 1.0625 >= error(next),
        None => true,
    }
}

/// Returns a number that rises with the world error of an object so far that is not complete.
fn priority(encoder: &MeshEncoder<'_>, scale: f64) -> u64 {
    if encoder.triangles() == 0 && encoder.header().triangles > 0 {
        return NO_TRIANGLE_YET;
    }
    (f64::from(encoder.error()) * scale + 0.0).to_bits()
}

/// Returns how long the next block may be: blocks grow with the stream.
fn next_block_bytes(before: usize) -> usize {
    (before / BLOCK_SHARE).max(MIN_BLOCK_BYTES)
}

/// The priority of an object that has triangles, but none of them in the stream yet.
const NO_TRIANGLE_YET: u64 = u64::MAX;
/// Smallest number of bytes of a block without its payload: three numbers, two checksums.
const BLOCK_FIELDS: usize = 9;
/// Bytes of the block that ends a stream, which has no payload.
const END_BYTES: u64 = BLOCK_FIELDS as u64;

/// The mesh with its steps in the order in which they are packed.
fn in_stream_order(simplified: &Simplified, order: StepOrder) -> Cow<'_, Simplified> {
    in_batches(simplified, order).map_or(Cow::Borrowed(simplified), Cow::Owned)
}

/// The bytes of a stream so far.
struct StreamWriter {
    bytes: Vec<u8>,
    blocks: u64,
    document: EncodedDocument,
    /// Bytes of the document so far.
    document_bytes: usize,
    /// Bytes of all blocks of steps.
    step_bytes: u64,
    /// Bytes of the document and of steps when the first tenth of the triangles was in the stream.
    bytes_at_a_tenth: Option<(usize, u64)>,
}

impl StreamWriter {
    /// Starts a stream with its first block.
    fn new<M>(file: &LodFile<M>, document: EncodedDocument) -> Self {
        let head = Head {
            format: file.source.format,
            objects: file.objects.len() as u32,
            text: document.text_bytes,
            stored: document.stored,
            buffer: document.bytes.len() as u64 - u64::from(document.stored),
        };
        let mut bytes = FILE_HEADER.start();
        FILE_HEADER.seal(&mut bytes);
        let (blocks, document_bytes, step_bytes) = (0, 0, 0);
        let mut stream =
            Self { bytes, blocks, document, document_bytes, step_bytes, bytes_at_a_tenth: None };
        stream.put(Block { tag: 0, steps: 0, payload: &head.to_bytes() });
        stream
    }

    fn put(&mut self, block: Block<'_>) {
        block::put(&mut self.bytes, self.blocks, block);
        self.blocks += 1;
    }

    /// Puts a block of steps; returns its number of bytes.
    fn put_steps(&mut self, block: Block<'_>) -> u64 {
        let before = self.bytes.len();
        self.put(block);
        let bytes = (self.bytes.len() - before) as u64;
        self.step_bytes += bytes;
        bytes
    }

    /// Puts the part of the document that is due before the next steps: placements take turns with
    /// steps, byte for byte, and so do images after a tenth of the triangles.
    fn put_due_document(&mut self, tenth_shown: bool) {
        let EncodedDocument { prompt_end, placement_end, picture_end, .. } = self.document;
        while self.document_bytes < placement_end
            && ((self.document_bytes - prompt_end) as u64) < self.step_bytes
        {
            self.put_next_document(placement_end);
        }
        if tenth_shown && self.document_bytes >= placement_end {
            let bytes_now = (self.document_bytes, self.step_bytes);
            let (document_start, steps_start) = *self.bytes_at_a_tenth.get_or_insert(bytes_now);
            while self.document_bytes < picture_end
                && (self.document_bytes - document_start) as u64 <= self.step_bytes - steps_start
            {
                self.put_next_document(picture_end);
            }
        }
    }

    fn put_document_up_to(&mut self, end: usize) {
        while self.document_bytes < end {
            self.put_next_document(end);
        }
    }

    /// Puts a block of the document, which goes at most up to `end`.
    fn put_next_document(&mut self, end: usize) {
        let max_bytes = next_block_bytes(self.bytes.len()).min(MAX_DOCUMENT_BLOCK);
        self.put_document(max_bytes.min(end - self.document_bytes));
    }

    /// Puts the next bytes of the document, as one block if it can have them.
    fn put_document(&mut self, length: usize) {
        for payload in
            self.document.bytes[self.document_bytes..][..length].chunks(MAX_DOCUMENT_BLOCK)
        {
            block::put(&mut self.bytes, self.blocks, Block { tag: 0, steps: 0, payload });
            self.blocks += 1;
        }
        self.document_bytes += length;
    }
}

impl<'a> ObjectWriter<'a> {
    fn new<M>(
        object: &'a LodObject<M>,
        simplified: &'a Simplified,
        order: StepOrder,
        quantize: &Quantize,
    ) -> Self {
        let mut layout = VertexLayout::choose(simplified);
        let bounds = quantize.apply(simplified.mesh(), &mut layout);
        let encoder = MeshEncoder::new(simplified, layout, order);
        let is_as_in_file = std::ptr::eq(simplified, &*object.simplified);
        let exact_levels = match (is_as_in_file, encoder.header().exact) {
            (true, _) => simplified.collapses().steps() as u32,
            (false, false) => encoder.exact_levels(),
            // The steps were put into batches, but a high-valence vertex kept them from being coded
            // so: of the levels only the finest is sure to be one of the file.
            (false, true) => 1,
        };
        let scale = object.info.world_scale;
        Self { encoder, bounds, scale, header_written: false, bytes: 0, exact_levels }
    }

    /// Returns a number that rises with the world error of the mesh so far; none if it is complete.
    fn priority(&self) -> Option<u64> {
        if !self.header_written {
            return Some(NO_TRIANGLE_YET);
        }
        (!self.encoder.is_complete()).then(|| priority(&self.encoder, self.scale))
    }

    /// Returns the header before it is coded if it is still to come, else nothing.
    fn start(&mut self) -> Result<Vec<u8>, FormatError> {
        if std::mem::replace(&mut self.header_written, true) {
            return Ok(Vec::new());
        }
        mesh_header::plain(self.encoder.header())
            .ok_or_else(|| too_large("an object has too many submeshes and attributes"))
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

fn too_large(problem: &str) -> FormatError {
    FormatError::new(Fault::Limit, "", problem)
}
