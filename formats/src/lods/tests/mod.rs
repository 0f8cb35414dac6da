//! Streams follow their sequence at every step; cut, damaged or crafted ones do no harm.

mod damage;
mod every_step;
mod geometry_first;
mod golden;
mod high_valence;
mod injected;
mod points;
mod prefixes;
mod quantize;
mod round_trip;
mod turns;

use super::block::{self, Block, FILE_HEADER, Parsed};
use super::{PackOptions, Packed, Unpacker, pack};
use crate::lodc::Layout;
use crate::testing::{LodFile, LodObject};
use crate::{
    Document, GltfDocument, Limits, ObjDocument, ObjectInfo, Source, SourceFormat, SubmeshInfo,
};
use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use lodc_progressive::{StepOrder, in_batches};
use std::sync::Arc;

fn object(name: &str, simplified: Simplified) -> LodObject {
    let submesh =
        |i| SubmeshInfo { name: format!("part{i}"), material: None, document_primitive: i };
    let info = ObjectInfo {
        name: name.to_owned(),
        submeshes: (0..simplified.mesh().submeshes().len() as u32).map(submesh).collect(),
        world_scale: 2.5,
        document_mesh: 3,
        poses: vec![],
    };
    LodObject { info, simplified: Arc::new(simplified), models: Vec::new() }
}

fn obj(objects: Vec<LodObject>) -> LodFile {
    LodFile {
        source: Source { format: SourceFormat::Obj, content_hash: 77 },
        document: Document::Obj(ObjDocument {
            libraries: vec!["a.mtl".to_owned()],
            ..ObjDocument::default()
        }),
        objects,
        made_from: None,
        layout: Layout::Packed,
        left_out: Vec::new(),
    }
}

fn gltf(objects: Vec<LodObject>) -> LodFile {
    let json = r#"{"asset":{"version":"2.0"}}"#.to_owned();
    let document = Document::Gltf(GltfDocument::new(json, (0..200).collect()));
    LodFile {
        source: Source { format: SourceFormat::Glb, content_hash: 5 },
        document,
        ..obj(objects)
    }
}

/// A stream that keeps the order of all steps, a block to each.
fn stepwise(file: &LodFile) -> Packed {
    let options = PackOptions { block_bytes: Some(0), exact: true, ..PackOptions::default() };
    pack(file, &options).expect("a sound file")
}

/// The file with its objects in the order in which a stream has them.
fn in_stream_order(file: &LodFile) -> LodFile {
    let ordered = |o: &LodObject| {
        let order = StepOrder::batches(file.objects.len());
        let simplified =
            in_batches(&o.simplified, order).map_or(Arc::clone(&o.simplified), Arc::new);
        LodObject { info: o.info.clone(), simplified, models: Vec::new() }
    };
    LodFile {
        source: file.source.clone(),
        document: file.document.clone(),
        objects: file.objects.iter().map(ordered).collect(),
        made_from: None,
        layout: file.layout,
        left_out: Vec::new(),
    }
}

fn fed(bytes: &[u8]) -> Unpacker {
    let mut unpacker = Unpacker::new(Limits::DEFAULT);
    unpacker.feed(bytes).expect("a sound stream");
    unpacker
}

/// The triangles of an object, with vertices in collapse order.
fn shown(unpacker: &Unpacker, object: usize) -> Vec<OrientedTriangle> {
    let last = unpacker.progress(object).vertices[1].saturating_sub(1);
    let submesh = |v: u32| unpacker.decoder(object).vertex_submesh()[v as usize];
    let triangles = unpacker.decoder(object).triangles();
    triangles
        .map(|t| OrientedTriangle::new(submesh(t[0]), [last - t[0], last - t[1], last - t[2]]))
        .collect()
}

/// Asserts that an object has exactly the triangles of the reference.
fn check(unpacker: &Unpacker, object: usize, simplified: &Simplified, case: &str) {
    let vertices = unpacker.progress(object).vertices[0];
    let all = simplified.mesh().vertex_count() as u32;
    let mut found = shown(unpacker, object);
    let mut wanted =
        if vertices == 0 { Vec::new() } else { simplified.triangles_at(Lod(all - vertices)) };
    found.sort_unstable();
    wanted.sort_unstable();
    assert!(
        found == wanted,
        "{case}: {} triangles instead of {} at {vertices} vertices",
        found.len(),
        wanted.len()
    );
    let lod = Lod(all.saturating_sub(vertices.max(1)));
    assert_eq!(simplified.collapses().floor(lod), lod, "{case}: not the end of a step");
}

/// Returns the end of the header and of each block of a stream.
fn ends(bytes: &[u8]) -> Vec<usize> {
    let ends = blocks(bytes).into_iter().map(|(end, _)| end);
    std::iter::once(FILE_HEADER.length).chain(ends).collect()
}

/// Returns the blocks of a stream, each with its end.
fn blocks(bytes: &[u8]) -> Vec<(usize, Block<'_>)> {
    let (mut blocks, mut at) = (Vec::new(), FILE_HEADER.length);
    for number in 0.. {
        let Parsed::Block(block, length) = block::parse(&bytes[at..], number) else { break };
        at += length;
        blocks.push((at, block));
    }
    assert_eq!(at, bytes.len(), "blocks to the end");
    blocks
}
