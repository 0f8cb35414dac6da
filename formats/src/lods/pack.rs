//! Writing a stream: the head, then steps in the order of their errors, cut into blocks.

use super::block::{self, Block, MAGIC};
use super::coder::{Encoder, Runs};
use super::growth::Growth;
use super::head::{Head, Promise};
use super::layout::Layout;
use super::quantize::{Bound, Quantize};
use super::record::{Models, Object};
use super::script::Known;
use super::{VERSION, error_code, may_hold};
use crate::lodc::{LodFile, LodObject};
use crate::{Fault, FormatError};
use lodc_mesh::{Lod, Simplified};
use lodc_strip::StripSet;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// How a stream is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PackOptions {
    /// Bits for each number; all of them by default.
    pub quantize: Quantize,
    /// The most bytes of a block, as far as whole steps allow; 0 for a block to each step.
    pub block_bytes: Option<u32>,
}

/// A stream, and what is in it.
#[derive(Clone, Debug)]
pub struct Packed {
    /// The stream.
    pub bytes: Vec<u8>,
    /// Bytes of its first block, which is all that is not a growing mesh.
    pub head_bytes: u64,
    /// Its objects.
    pub objects: Vec<PackedObject>,
}

/// One object of a stream.
#[derive(Clone, Debug)]
pub struct PackedObject {
    /// Bytes of its blocks.
    pub bytes: u64,
    /// Bytes that the same packages would take as plain words and bytes, positions only: the
    /// thesis's accounting (table 4.3), what names the survivor and the strips included.
    pub package_bytes: u64,
    /// The same with normals: three words more for each vertex.
    pub package_bytes_with_normals: u64,
    /// What quantising may have changed.
    pub bounds: Vec<Bound>,
}

/// Bytes of a block unless something else is asked for. Early blocks are smaller.
const BLOCK: u32 = 8192;
/// A block is not longer than this share of all before it ...
const SHARE: usize = 8;
/// ... or this many bytes.
const SHORT: usize = 96;

/// An object while it is written.
struct Writing<'a> {
    simplified: &'a Simplified,
    script: Known,
    object: Object,
    scale: f64,
    bytes: u64,
}

/// Packs a file. `strips` are those of each object, where they are to be told.
///
/// # Errors
/// If strips do not draw their object, or something is larger than the format allows.
pub fn pack(
    file: &LodFile,
    strips: &[Option<&StripSet>],
    options: &PackOptions,
) -> Result<Packed, FormatError> {
    let mut objects = Vec::new();
    let mut promises = Vec::new();
    let mut bounds = Vec::new();
    for (number, o) in file.objects.iter().enumerate() {
        let strips = strips.get(number).copied().flatten();
        let (promise, writing, bound) = begin(o, strips, options)?;
        promises.push(promise);
        objects.push(writing);
        bounds.push(bound);
    }
    let head =
        Head { source: file.source.clone(), document: file.document.clone(), objects: promises };
    let payload = head
        .bytes()
        .ok_or_else(|| too_large("the scene without its meshes has more than 4 GiB"))?;

    let mut out = MAGIC.to_vec();
    out.extend(VERSION.to_le_bytes());
    let mut number = 0;
    let mut put = |out: &mut Vec<u8>, block: Block<'_>| {
        block::put(out, number, block);
        number += 1;
    };
    put(&mut out, Block { subject: 0, steps: 0, payload: &payload });
    let head_bytes = out.len() as u64;
    let most = options.block_bytes.unwrap_or(BLOCK) as usize;
    let mut models = Box::new(Models::new());
    // The object whose mesh is farthest from what it will be comes next, the first of those that
    // are alike.
    let mut queue: BinaryHeap<(u64, Reverse<usize>)> = BinaryHeap::new();
    queue.extend(objects.iter().enumerate().filter_map(|(i, w)| Some((w.error()?, Reverse(i)))));
    while let Some((_, Reverse(next))) = queue.pop() {
        let writing = &mut objects[next];
        let before = out.len();
        let target = ((before - head_bytes as usize) / SHARE).max(SHORT).min(most);
        let (steps, payload) = writing.block(&mut models, target, before)?;
        put(&mut out, Block { subject: next as u32 + 1, steps, payload: &payload });
        writing.bytes += (out.len() - before) as u64;
        queue.extend(writing.error().map(|error| (error, Reverse(next))));
    }
    put(&mut out, Block { subject: 0, steps: 0, payload: &[] });
    let objects = objects.into_iter().zip(bounds).map(|(w, bounds)| w.result(bounds)).collect();
    Ok(Packed { bytes: out, head_bytes, objects })
}

fn begin<'a>(
    o: &'a LodObject,
    strips: Option<&StripSet>,
    options: &PackOptions,
) -> Result<(Promise, Writing<'a>, Vec<Bound>), FormatError> {
    let simplified = &*o.simplified;
    let (mesh, sequence) = (simplified.mesh(), simplified.collapses());
    let mut layout = Layout::choose(simplified);
    let bounds = options.quantize.apply(mesh, &mut layout);
    let last = sequence.records();
    let errors = (0..=last).map(|new| error_code(sequence.error_at(Lod(last - new)))).collect();
    let (index, channels) = (layout.index(mesh), layout.systems.len());
    let script = Known::new(simplified, index, channels, errors, strips).ok_or_else(|| {
        FormatError::new(
            Fault::Malformed,
            format!("object \"{}\"", o.info.name),
            "its strips do not draw its mesh",
        )
    })?;
    let growth = Growth::new(layout.systems.clone());
    let object = Object::new(
        growth,
        layout.streams.clone(),
        mesh.submeshes().len() as u32,
        strips.is_some(),
    );
    let submesh = |s: &lodc_mesh::Submesh| lodc_mesh::Submesh {
        first_triangle: 0,
        triangle_count: 0,
        ..s.clone()
    };
    let vertices = mesh.vertex_count() as u32;
    let promise = Promise {
        info: o.info.clone(),
        submeshes: mesh.submeshes().iter().map(submesh).collect(),
        attributes: mesh.attributes().iter().map(lodc_mesh::Attribute::described).collect(),
        layout,
        vertices,
        triangles: mesh.triangles().len() as u32,
        // The first vertex is a step of its own here.
        steps: if vertices == 0 { 0 } else { sequence.steps() as u32 + 1 },
        strips: strips.is_some(),
    };
    Ok((
        promise,
        Writing { simplified, script, object, scale: o.info.world_scale, bytes: 0 },
        bounds,
    ))
}

impl Writing<'_> {
    fn vertices(&self) -> u32 {
        self.simplified.mesh().vertex_count() as u32
    }

    /// How far off the mesh that grew so far is, in the scene's units, as a number that rises with
    /// it; none if it is there.
    fn error(&self) -> Option<u64> {
        let here = self.object.growth.vertices();
        if here == self.vertices() {
            return None;
        }
        if here == 0 {
            return Some(u64::MAX);
        }
        let error = self.simplified.collapses().error_at(Lod(self.vertices() - here));
        Some((f64::from(error) * self.scale + 0.0).to_bits())
    }

    /// The next steps, about `target` bytes of them. `before` is how many bytes of the stream there
    /// are.
    fn block(
        &mut self,
        models: &mut Models,
        target: usize,
        before: usize,
    ) -> Result<(u32, Vec<u8>), FormatError> {
        let mut runs = Runs::<Encoder>::default();
        let mut steps = 0;
        loop {
            let vertices = self.vertices();
            let step = self.object.step(&mut runs, &self.script, models, vertices, usize::MAX);
            step.expect("the writer knows what it says");
            steps += 1;
            if runs.mesh.len() + runs.strips.len() >= target
                || self.object.growth.vertices() == vertices
            {
                break;
            }
        }
        let Runs { mesh, strips } = runs;
        let (mesh, strips) = (mesh.finish(), strips.finish());
        // What costs next to nothing is padded, so that a reader can refuse what would cost nothing
        // at all.
        let mut padding = 0;
        while !may_hold(before + mesh.len() + padding + strips.len(), &self.object) {
            padding += 64;
        }
        let mesh = mesh.bytes(padding);
        let mut payload = Vec::with_capacity(mesh.len() + strips.len() + 5);
        if self.object.order.is_some() {
            lodc_mesh::put_leb128(&mut payload, mesh.len() as u64);
        }
        payload.extend(mesh);
        payload.extend(strips.bytes(0));
        if payload.len() > block::LARGEST {
            return Err(too_large("a single step has more than 16 MiB"));
        }
        Ok((steps, payload))
    }

    fn result(&self, bounds: Vec<Bound>) -> PackedObject {
        let vertices = u64::from(self.vertices());
        let package_bytes = self.object.packages + 12 * vertices;
        PackedObject {
            bytes: self.bytes,
            package_bytes,
            package_bytes_with_normals: package_bytes + 12 * vertices,
            bounds,
        }
    }
}

fn too_large(what: &str) -> FormatError {
    FormatError::new(Fault::Limit, "", what)
}
