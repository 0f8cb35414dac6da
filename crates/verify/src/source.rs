//! Compares LOD 0 of a file with the mesh that it was made from, as multisets of triangles of
//! attribute bytes.

use lodc_mesh::{Attribute, Mesh, OrientedTriangle};

/// Compares two meshes submesh by submesh as multisets of oriented triangles of attribute bytes;
/// the order of vertices and triangles does not matter. Returns what differs first.
#[must_use]
pub fn source_difference(source: &Mesh, stored: &Mesh) -> Option<String> {
    let submeshes = [source, stored].map(|mesh| mesh.submeshes().len());
    if submeshes[0] != submeshes[1] {
        return Some(format!(
            "the source has {} submeshes, the file {}",
            submeshes[0], submeshes[1]
        ));
    }
    (0..submeshes[0]).find_map(|submesh| {
        submesh_difference(source, stored, submesh).map(|what| format!("submesh {submesh}: {what}"))
    })
}

fn submesh_difference(source: &Mesh, stored: &Mesh, submesh: usize) -> Option<String> {
    let meshes = [source, stored];
    let streams = meshes.map(|mesh| streams(mesh, submesh));
    if streams[0].iter().map(|a| a.described()).ne(streams[1].iter().map(|a| a.described())) {
        let names = streams.map(|all| {
            all.iter().map(|a| format!("{:?}", a.semantic)).collect::<Vec<_>>().join(", ")
        });
        return Some(format!("the source has the streams [{}], the file [{}]", names[0], names[1]));
    }
    let counts = meshes.map(|mesh| mesh.submeshes()[submesh].triangle_count);
    if counts[0] != counts[1] {
        return Some(format!("the source has {} triangles, the file {}", counts[0], counts[1]));
    }
    let numbers = numbered(meshes, &streams, submesh);
    let triangles = [0, 1].map(|side| {
        let range = meshes[side].submeshes()[submesh].triangles();
        let all = meshes[side].triangles()[range].iter();
        let mut all: Vec<_> =
            all.map(|t| OrientedTriangle::new(0, t.map(|v| numbers[side][v as usize]))).collect();
        all.sort_unstable();
        all
    });
    let index = triangles[0].iter().zip(&triangles[1]).position(|(a, b)| a != b)?;
    // Of two sorted lists, the smaller element at the first difference is missing from the other.
    let missing = triangles[0][index] < triangles[1][index];
    let (side, triangle) =
        if missing { (0, triangles[0][index]) } else { (1, triangles[1][index]) };
    let corners = triangle.corners.map(|number| {
        let vertex = numbers[side]
            .iter()
            .position(|&n| n == number)
            .expect("every number is that of a vertex");
        meshes[side].positions()[vertex]
    });
    Some(format!(
        "the triangle {corners:?} is only in the {}",
        if missing { "source" } else { "file" }
    ))
}

/// The streams of a submesh, in an order that does not depend on how the mesh lists them.
fn streams(mesh: &Mesh, submesh: usize) -> Vec<&Attribute> {
    let listed = &mesh.submeshes()[submesh].attributes;
    let mut streams: Vec<_> = listed.iter().map(|&a| &mesh.attributes()[a as usize]).collect();
    streams.sort_by_key(|a| (a.morph_target, a.semantic.clone()));
    streams
}

/// Numbers for the vertices of both meshes: equal exactly if position and attribute bytes are.
fn numbered(meshes: [&Mesh; 2], streams: &[Vec<&Attribute>; 2], submesh: usize) -> [Vec<u32>; 2] {
    let mut records: Vec<(Vec<u8>, usize, usize)> = Vec::new();
    let mut numbers = meshes.map(|mesh| vec![u32::MAX; mesh.vertex_count()]);
    for side in [0, 1] {
        for (v, &owner) in meshes[side].vertex_submesh().iter().enumerate() {
            if owner as usize == submesh {
                records.push((vertex_bytes(meshes[side], &streams[side], v as u32), side, v));
            }
        }
    }
    records.sort_unstable();
    let mut number = 0;
    for i in 0..records.len() {
        if i > 0 && records[i].0 != records[i - 1].0 {
            number += 1;
        }
        let (_, side, v) = records[i];
        numbers[side][v] = number;
    }
    numbers
}

fn vertex_bytes(mesh: &Mesh, streams: &[&Attribute], vertex: u32) -> Vec<u8> {
    let size = 12 + streams.iter().map(|a| a.stride()).sum::<usize>();
    let mut bytes = Vec::with_capacity(size);
    bytes.extend(mesh.positions()[vertex as usize].iter().flat_map(|c| c.to_le_bytes()));
    for stream in streams {
        bytes.extend_from_slice(stream.at(vertex));
    }
    bytes
}

#[cfg(test)]
#[path = "source_tests.rs"]
mod tests;
