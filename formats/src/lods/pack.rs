//! Writing a stream: the head, then steps in the order of their errors, cut into blocks.

use super::VERSION;
use super::block::{self, Block, MAGIC};
use super::head::{Head, ObjectHeader};
use crate::lodc::{LodFile, LodObject};
use crate::{Fault, FormatError};
use lodc_mesh::put_leb128;
use lodc_progressive::{BlockTarget, Contexts, ErrorBound, MeshEncoder, Quantize, VertexLayout};
use lodc_strip::StripSet;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Options of a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PackOptions {
    /// Bits per value; lossless by default.
    pub quantize: Quantize,
    /// The most bytes of a block, as far as whole steps allow; 0 for a block for each step.
    pub block_bytes: Option<u32>,
}

/// A stream and its statistics.
#[derive(Clone, Debug)]
pub struct Packed {
    /// The stream.
    pub bytes: Vec<u8>,
    /// Bytes up to the end of its first block.
    pub head_bytes: u64,
    /// Its objects.
    pub objects: Vec<PackedObject>,
}

/// Statistics of one object of a stream.
#[derive(Clone, Debug)]
pub struct PackedObject {
    /// Bytes of its blocks.
    pub bytes: u64,
    /// Bytes that the same packages would take as plain words and bytes, positions only: the
    /// thesis's accounting (table 4.3), with what names the parent and the strips.
    pub package_bytes: u64,
    /// The same with normals: three words more for each vertex.
    pub package_bytes_with_normals: u64,
    /// Bounds of the quantisation error.
    pub bounds: Vec<ErrorBound>,
}

/// Bytes of a block unless something else is asked for. Early blocks are smaller.
const BLOCK_BYTES: u32 = 8192;
/// A block is not longer than this share of all before it ...
const GROWTH_SHARE: usize = 8;
/// ... or this many bytes.
const MIN_BLOCK_BYTES: usize = 96;

/// An object while it is written.
struct ObjectWriter<'a> {
    encoder: MeshEncoder<'a>,
    bounds: Vec<ErrorBound>,
    scale: f64,
    bytes: u64,
}

/// Packs a file. `strips` are those of each object, where strip positions are to be coded.
///
/// # Errors
/// If strips do not draw their object, or something is larger than the format allows.
pub fn pack(
    file: &LodFile,
    strips: &[Option<&StripSet>],
    options: &PackOptions,
) -> Result<Packed, FormatError> {
    let mut writers = Vec::new();
    for (number, object) in file.objects.iter().enumerate() {
        let strips = strips.get(number).copied().flatten();
        writers.push(ObjectWriter::new(object, strips, options)?);
    }
    let header = |(o, w): (&LodObject, &ObjectWriter<'_>)| ObjectHeader {
        info: o.info.clone(),
        mesh: w.encoder.header().clone(),
    };
    let head = Head {
        source: file.source.clone(),
        document: file.document.clone(),
        objects: file.objects.iter().zip(&writers).map(header).collect(),
    };
    let head = head
        .to_bytes()
        .ok_or_else(|| too_large("the scene without its meshes has more than 4 GiB"))?;

    let mut stream = StreamWriter::new(&head);
    let head_bytes = stream.bytes.len();
    let block_bytes = options.block_bytes.unwrap_or(BLOCK_BYTES) as usize;
    let mut contexts = Box::new(Contexts::new());
    // The object that is farthest from its final mesh comes next, the first of equals.
    let mut queue: BinaryHeap<(u64, Reverse<usize>)> = BinaryHeap::new();
    queue.extend(
        (writers.iter().enumerate()).filter_map(|(i, w)| Some((w.priority()?, Reverse(i)))),
    );
    while let Some((_, Reverse(next))) = queue.pop() {
        let writer = &mut writers[next];
        let before = stream.bytes.len();
        let share = (before - head_bytes) / GROWTH_SHARE;
        let bytes = share.max(MIN_BLOCK_BYTES).min(block_bytes);
        let (steps, payload) = writer.encode(&mut contexts, BlockTarget { bytes, before })?;
        stream.put(Block { tag: next as u32 + 1, steps, payload: &payload });
        writer.bytes += (stream.bytes.len() - before) as u64;
        queue.extend(writer.priority().map(|priority| (priority, Reverse(next))));
    }
    stream.put(Block { tag: 0, steps: 0, payload: &[] });
    let objects = writers.into_iter().map(ObjectWriter::finish).collect();
    Ok(Packed { bytes: stream.bytes, head_bytes: head_bytes as u64, objects })
}

/// The bytes of a stream so far.
struct StreamWriter {
    bytes: Vec<u8>,
    blocks: u64,
}

impl StreamWriter {
    /// Starts a stream with the payload of its first block.
    fn new(head: &[u8]) -> Self {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        let mut stream = Self { bytes, blocks: 0 };
        stream.put(Block { tag: 0, steps: 0, payload: head });
        stream
    }

    fn put(&mut self, block: Block<'_>) {
        block::put(&mut self.bytes, self.blocks, block);
        self.blocks += 1;
    }
}

impl<'a> ObjectWriter<'a> {
    fn new(
        object: &'a LodObject,
        strips: Option<&StripSet>,
        options: &PackOptions,
    ) -> Result<Self, FormatError> {
        let simplified = &*object.simplified;
        let mut layout = VertexLayout::choose(simplified);
        let bounds = options.quantize.apply(simplified.mesh(), &mut layout);
        let encoder = MeshEncoder::new(simplified, layout, strips).map_err(|e| {
            let place = format!("object \"{}\"", object.info.name);
            FormatError::new(Fault::Malformed, place, e.to_string())
        })?;
        Ok(Self { encoder, bounds, scale: object.info.world_scale, bytes: 0 })
    }

    /// Returns a number that rises with the world error of the mesh so far; none if it is complete.
    fn priority(&self) -> Option<u64> {
        if self.encoder.is_complete() {
            None
        } else if self.encoder.vertices() == 0 {
            Some(u64::MAX)
        } else {
            Some((f64::from(self.encoder.error()) * self.scale + 0.0).to_bits())
        }
    }

    /// Encodes the next steps. Returns their number and a block's payload.
    fn encode(
        &mut self,
        contexts: &mut Contexts,
        target: BlockTarget,
    ) -> Result<(u32, Vec<u8>), FormatError> {
        let encoded = self.encoder.encode(contexts, target);
        let mut payload = Vec::with_capacity(encoded.splits.len() + encoded.strips.len() + 5);
        if self.encoder.header().strips {
            put_leb128(&mut payload, encoded.splits.len() as u64);
        }
        payload.extend(encoded.splits);
        payload.extend(encoded.strips);
        if payload.len() > block::MAX_PAYLOAD {
            return Err(too_large("a single step has more than 16 MiB"));
        }
        Ok((encoded.steps, payload))
    }

    fn finish(self) -> PackedObject {
        let package_bytes = self.encoder.package_bytes();
        PackedObject {
            bytes: self.bytes,
            package_bytes,
            package_bytes_with_normals: package_bytes + 12 * u64::from(self.encoder.vertices()),
            bounds: self.bounds,
        }
    }
}

fn too_large(what: &str) -> FormatError {
    FormatError::new(Fault::Limit, "", what)
}
