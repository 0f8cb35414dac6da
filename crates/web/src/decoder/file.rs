//! A complete `.lodc` as one message of typed arrays for the page.

use super::levels::{self, DecodedLevel};
use super::message::{Message, Tag};
use lodc_formats::lodc::{self, LodFile, LodObject};
use lodc_formats::{Document, FormatError};
use lodc_mesh::{Lod, PositionIds, Simplified, is_degenerate};

/// Reads a file and puts all of it into a message.
pub(super) fn message(bytes: &[u8]) -> Result<Message, FormatError> {
    let LodFile { document, objects, .. } = lodc::read(bytes, &[])?;
    let mut out = Message::default();
    let buffer = if let Document::Gltf(gltf) = &document { gltf.blob().len() } else { 0 };
    out.document(&document, objects.len() as u32, buffer as u32);
    if let Document::Gltf(gltf) = document {
        out.chunk(Tag::Buffer, |m| {
            m.word(0);
            m.bytes.extend_from_slice(gltf.blob());
        });
    }
    for (number, LodObject { info, simplified, .. }) in (0..).zip(objects) {
        let mesh = simplified.mesh();
        let counts = [mesh.vertex_count() as u32, mesh.triangles().len() as u32];
        out.object(number, &info, counts, mesh.attributes(), |s| &mesh.submeshes()[s].attributes);
        out.chunk(Tag::Vertices, |m| vertices(m, number, &simplified));
        levels::put(&mut out, number, 0, &all_levels(&simplified));
    }
    out.chunk(Tag::Complete, |_| ());
    Ok(out)
}

/// Appends all vertices in stream order, which is the reverse of the collapse order.
fn vertices(out: &mut Message, object: u32, simplified: &Simplified) {
    let mesh = simplified.mesh();
    out.words([object, 0, mesh.vertex_count() as u32]);
    for position in mesh.positions().iter().rev() {
        out.words(position.map(f32::to_bits));
    }
    for attribute in mesh.attributes() {
        for vertex in attribute.bytes.rchunks_exact(attribute.stride()) {
            out.bytes.extend_from_slice(vertex);
        }
        out.pad();
    }
}

/// The levels of an object, the coarsest first.
fn all_levels(simplified: &Simplified) -> Vec<DecodedLevel> {
    let collapses = simplified.collapses();
    let positions = simplified.mesh().position_ids();
    let all_triangles = collapses.triangles_at(Lod(0));
    let mut levels = Vec::new();
    let mut lod = Lod(0);
    loop {
        levels.push(level(simplified, &positions, lod));
        let triangles = collapses.triangles_at(lod);
        let next = collapses.lod_for_triangles(levels::max_coarser(triangles, all_triangles));
        if triangles == 0 || collapses.triangles_at(next) == 0 {
            break;
        }
        lod = next;
    }
    levels.reverse();
    levels
}

/// The triangles of a LOD, with vertices in stream order.
fn level(simplified: &Simplified, positions: &PositionIds, lod: Lod) -> DecodedLevel {
    let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
    let vertex_at_lod = collapses.resolve_all(lod);
    let last = collapses.records();
    let position = |v: u32| positions.of_vertex[v as usize];
    let live = (0..).zip(mesh.submeshes()).flat_map(|(number, submesh)| {
        // Triangles are in the order of their removal, the last first: after the first degenerate
        // one all are.
        let corners = mesh.triangles()[submesh.triangles()].iter();
        let corners = corners.map(|t| t.map(|v| vertex_at_lod[v as usize]));
        let live = corners.take_while(|t| !is_degenerate(t.map(position)));
        live.map(move |t| (number, t.map(|v| last - v)))
    });
    DecodedLevel::new(collapses.error_at(lod), mesh.submeshes().len(), live)
}
