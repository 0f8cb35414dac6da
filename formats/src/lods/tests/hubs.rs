//! Streams of meshes with vertices of hundreds of triangles: version 8 where a vertex repeats the
//! target of its parent.

use super::super::{HUB_VERSION, VERSION};
use super::every_step::{check_every_step, same_mesh};
use super::*;
use lodc_fixtures as fixtures;
use lodc_mesh::{Mesh, MeshParts, Submesh};
use std::path::PathBuf;

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

fn version(file: &LodFile) -> u32 {
    u32::from(stepwise(file).0.bytes[8])
}

#[test]
fn hubs_are_decoded_at_every_step_and_only_they_need_version_8() {
    let book = obj(vec![object("book", simplified(&fixtures::book(700)))]);
    let parts = obj(vec![object("parts", simplified(&book_of_two_parts(400)))]);
    let fan = object("fan", simplified(&fixtures::fan(300)));
    let scene = obj(vec![fan, object("book", simplified(&fixtures::book(400)))]);
    for (name, file) in [("book", &book), ("parts", &parts), ("scene", &scene)] {
        assert_eq!(version(file), HUB_VERSION, "{name}");
        check_every_step(file, name);
    }
    let small = obj(vec![object("book", simplified(&fixtures::book(200)))]);
    assert_eq!(version(&small), VERSION);
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

fn golden() -> (PathBuf, LodFile) {
    let path = format!("../fixtures/golden/lods{HUB_VERSION}/book.lods");
    let file = obj(vec![object("book", fixtures::random_collapse(&fixtures::book(400), 1))]);
    (PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(path), file)
}

/// Writes the golden stream of version 8.
pub(super) fn make_golden() {
    let (path, file) = golden();
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    std::fs::write(path, stepwise(&file).0.bytes).expect("a file");
}

#[test]
fn the_golden_stream_of_version_8_is_read_and_written_as_ever() {
    let (path, file) = golden();
    let bytes = std::fs::read(path).expect("a golden stream");
    let unpacker = fed(&bytes);
    assert!(unpacker.is_complete());
    assert_eq!(unpacker.version(), HUB_VERSION);
    check(&unpacker, 0, &file.objects[0].simplified, "book");
    same_mesh(&unpacker, 0, file.objects[0].simplified.mesh(), "book");
    assert!(stepwise(&file).0.bytes == bytes, "written otherwise than it was");
}
