//! Streams of meshes with vertices of hundreds of triangles: a vertex repeats the target of its
//! parent, and where too much of a star is handed over piece by piece, the pieces are named.

use super::every_step::check_every_step;
use super::*;
use crate::testing::Random;
use lodc_fixtures as fixtures;
use lodc_mesh::{Mesh, MeshParts, Submesh};
use std::collections::BTreeSet;

/// Pages of a book in two submeshes: each has a spine of its own, at the same two positions.
fn book_of_two_parts(pages: u32) -> Mesh {
    let half = fixtures::book(pages);
    let vertices = half.vertex_count() as u32;
    let moved = |[x, y, z]: [f32; 3]| if z == 0.0 || z == 1.0 { [x, y, z] } else { [-x, y, z] };
    let both = half.triangles().iter().chain(half.triangles()).zip(0..);
    let triangles = both.map(|(t, i)| t.map(|v| if i < pages { v } else { v + vertices }));
    let part = |first_triangle| Submesh {
        first_triangle,
        triangle_count: pages,
        ..half.submeshes()[0].clone()
    };
    let parts = MeshParts {
        positions: half
            .positions()
            .iter()
            .copied()
            .chain(half.positions().iter().copied().map(moved))
            .collect(),
        vertex_submesh: (0..2 * vertices).map(|v| u32::from(v >= vertices)).collect(),
        attributes: Vec::new(),
        submeshes: vec![part(0), part(pages)],
        triangles: triangles.collect(),
    };
    Mesh::try_from(parts).expect("a mesh")
}

fn simplified(mesh: &Mesh) -> Simplified {
    lodc_simplify::simplify(mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {})
}

#[test]
fn hubs_are_decoded_at_every_step() {
    let book = obj(vec![object("book", simplified(&fixtures::book(700)))]);
    let parts = obj(vec![object("parts", simplified(&book_of_two_parts(400)))]);
    let fan = object("fan", simplified(&fixtures::fan(300)));
    let scene = obj(vec![fan, object("book", simplified(&fixtures::book(400)))]);
    for (name, file) in [("book", &book), ("parts", &parts), ("scene", &scene)] {
        check_every_step(file, name);
    }
}

#[test]
fn hubs_are_decoded_by_any_sequence() {
    for (name, mesh) in [
        ("book", fixtures::book(400)),
        ("pinwheel", fixtures::pinwheel(400)),
        ("fan", fixtures::fan(400)),
        ("parts", book_of_two_parts(300)),
    ] {
        for seed in 0..2 {
            let file = obj(vec![object(name, fixtures::random_collapse(&mesh, seed))]);
            check_every_step(&file, &format!("{name}, seed {seed}"));
        }
    }
}

/// Flaps in two submeshes, of which each has a high-valence vertex at the same position.
fn flaps_of_two_parts(flaps: u32) -> Mesh {
    let half = fixtures::flaps(flaps);
    let vertices = half.vertex_count() as u32;
    let both = half.triangles().iter().chain(half.triangles()).zip(0..);
    let triangles = both.map(|(t, i)| t.map(|v| if i < 3 * flaps { v } else { v + vertices }));
    let positions = half.positions().iter();
    let part = |first_triangle| Submesh {
        first_triangle,
        triangle_count: 3 * flaps,
        ..half.submeshes()[0].clone()
    };
    let parts = MeshParts {
        positions: positions.clone().chain(positions).copied().collect(),
        vertex_submesh: (0..2 * vertices).map(|v| u32::from(v >= vertices)).collect(),
        attributes: Vec::new(),
        submeshes: vec![part(0), part(3 * flaps)],
        triangles: triangles.collect(),
    };
    Mesh::try_from(parts).expect("a mesh")
}

#[test]
fn hubs_that_are_named_are_decoded_at_every_step() {
    let flaps = fixtures::flaps(600);
    let simple = obj(vec![object("flaps", simplified(&flaps))]);
    let random = obj(vec![object("flaps", fixtures::random_collapse(&flaps, 2))]);
    let parts = gltf(vec![object("parts", simplified(&flaps_of_two_parts(500)))]);
    let book = object("book", simplified(&fixtures::book(400)));
    let fan = object("fan", simplified(&fixtures::fan(300)));
    let scene = obj(vec![fan, object("flaps", simplified(&flaps)), book]);
    for (name, file) in
        [("simple", &simple), ("random", &random), ("parts", &parts), ("scene", &scene)]
    {
        check_every_step(file, name);
    }
}

/// The stream with a byte of this block changed and its checksums made right again.
fn forged(bytes: &[u8], number: usize, random: &mut Random) -> Vec<u8> {
    let mut out = bytes[..FILE_HEADER.length].to_vec();
    for (i, (_, found)) in (0..).zip(blocks(bytes)) {
        let mut payload = found.payload.to_vec();
        if i == number && !payload.is_empty() {
            payload[random.below(found.payload.len())] = random.next() as u8;
        }
        block::put(&mut out, i as u64, Block { payload: &payload, ..found });
    }
    out
}

#[test]
fn forged_hubs_do_no_harm() {
    let mut random = Random(17);
    let flaps = fixtures::random_collapse(&fixtures::flaps(600), 1);
    let bytes = stepwise(&obj(vec![object("flaps", flaps)])).bytes;
    let all = blocks(&bytes).len();
    let mut said = BTreeSet::new();
    for i in 0..600 {
        let mut unpacker = Unpacker::new(Limits::DEFAULT);
        if let Err(error) = unpacker.feed(&forged(&bytes, i % all, &mut random)) {
            said.insert(error.problem);
        }
        if unpacker.objects() > 0 {
            // It may show anything, but must not panic.
            let _ = (unpacker.mesh(0), unpacker.progress(0));
        }
    }
    assert!(said.iter().any(|problem| problem.contains("names a triangle")), "{said:?}");
}
