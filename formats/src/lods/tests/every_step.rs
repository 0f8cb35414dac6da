//! Every step of a stream shows its level of detail, for any shape and sequence.

use super::*;
use lodc_fixtures as fixtures;
use lodc_mesh::{Mesh, SequenceParts};
use lodc_strip::{StripSet, strip_triangles};

/// Decodes a file's objects step by step and compares everything.
pub(super) fn check_every_step(file: &LodFile, what: &str) {
    let (packed, strips) = stepwise(file);
    let mut unpacker = Unpacker::new(Limits::DEFAULT);
    let mut at = 0;
    for end in ends(&packed.bytes) {
        unpacker.feed(&packed.bytes[at..end]).expect("a sound stream");
        at = end;
        for (i, o) in file.objects.iter().enumerate().take(unpacker.objects()) {
            if unpacker.progress(i).vertices[1] as usize != o.simplified.mesh().vertex_count() {
                // Its name has come, but not its header.
                assert_eq!(unpacker.mesh(i).expect("a mesh").0.triangles().len(), 0, "{what}");
                continue;
            }
            check(&unpacker, i, &o.simplified, what);
            let decoder = unpacker.decoder(i);
            assert!(decoder.triangles().flatten().all(|v| decoder.has_come(v)), "{what}");
            let drawn = unpacker.strips(i).expect("strips are coded");
            let mut drawn: Vec<_> = drawn.triangles().collect();
            let last = unpacker.progress(i).vertices[1].saturating_sub(1);
            drawn
                .iter_mut()
                .for_each(|t| *t = OrientedTriangle::new(t.submesh, t.corners.map(|v| last - v)));
            drawn.sort_unstable();
            let mut shown = shown(&unpacker, i);
            shown.sort_unstable();
            assert!(
                drawn == shown,
                "{what}: strips draw {} of {} triangles",
                drawn.len(),
                shown.len()
            );
        }
    }
    assert!(unpacker.is_complete());
    assert_eq!(unpacker.document(), Some(&file.document));
    assert_eq!(unpacker.source(), Some(&file.source));
    for (i, o) in file.objects.iter().enumerate() {
        assert_eq!(unpacker.info(i), &o.info);
        same_sequence(&unpacker, i, &o.simplified);
        same_mesh(&unpacker, i, o.simplified.mesh(), what);
        same_strips(&unpacker, i, &strips[i].set, what);
    }
}

/// The object is a simplified mesh again: sequence, all vertices, triangle counts, strips.
fn same_sequence(unpacker: &Unpacker, object: usize, simplified: &Simplified) {
    let rebuilt = unpacker.rebuilt(object).expect("a sound stream");
    assert_eq!(rebuilt.degenerate_triangles, 0);
    let sequence = |s: &Simplified| {
        let parts = s.collapses().parts().clone();
        SequenceParts { step_errors: vec![], step_rms: vec![], ..parts }
    };
    assert_eq!(sequence(&rebuilt.simplified), sequence(simplified));
    let [again, mesh] = [rebuilt.simplified.mesh(), simplified.mesh()];
    assert_eq!(again.vertex_submesh(), mesh.vertex_submesh());
    let bits = |mesh: &Mesh| -> Vec<_> {
        mesh.positions().iter().map(|p| p.map(|c| (c + 0.0).to_bits())).collect()
    };
    assert_eq!(bits(again), bits(mesh));
    let strips = unpacker.rebuilt_strips(object).expect("strips are coded");
    assert_eq!(strips.check(again), Ok(()));
}

/// All that the mesh has and a triangle uses, bit for bit.
pub(super) fn same_mesh(unpacker: &Unpacker, object: usize, mesh: &Mesh, what: &str) {
    let (decoded, cleaning) = unpacker.mesh(object).expect("a mesh");
    assert_eq!(cleaning.degenerate_triangles, 0, "{what}");
    let triangles = |m: &Mesh| {
        let all = (0..).zip(m.submeshes()).flat_map(|(i, s)| s.triangles().map(move |t| (i, t)));
        let mut all: Vec<_> =
            all.map(|(i, t)| OrientedTriangle::new(i, m.triangles()[t])).collect();
        all.sort_unstable();
        all
    };
    let wanted = mesh.extract(&triangles(mesh)).expect("triangles of the mesh");
    let bits =
        |m: &Mesh| m.positions().as_flattened().iter().map(|c| c.to_bits()).collect::<Vec<_>>();
    assert!(bits(&decoded) == bits(&wanted), "{what}: positions");
    assert!(decoded.attributes() == wanted.attributes(), "{what}: attributes");
    assert_eq!(decoded.submeshes(), wanted.submeshes(), "{what}");
    assert_eq!(decoded.vertex_submesh(), wanted.vertex_submesh(), "{what}");
    assert!(triangles(&decoded) == triangles(&wanted), "{what}: triangles");
}

/// The same strips, each drawing the same triangles one after the other, in no more indices.
fn same_strips(unpacker: &Unpacker, object: usize, strips: &StripSet, what: &str) {
    let decoded = unpacker.strips(object).expect("strips are coded");
    let last = unpacker.progress(object).vertices[1].saturating_sub(1);
    assert_eq!(decoded.submesh_count(), strips.submesh_count(), "{what}");
    assert_eq!(decoded.len(), strips.len(), "{what}");
    for s in 0..strips.submesh_count() {
        assert_eq!(decoded.submesh(s), strips.submesh(s), "{what}");
    }
    for (i, (decoded, strip)) in decoded.iter().zip(strips.iter()).enumerate() {
        let was = strip_triangles(strip).map(|t| OrientedTriangle::new(0, t));
        let is = strip_triangles(decoded).map(|t| OrientedTriangle::new(0, t.map(|v| last - v)));
        assert!(was.eq(is), "{what}: strip {i}");
        assert!(
            decoded.len() <= strip.len(),
            "{what}: strip {i} takes {} indices, not {}",
            decoded.len(),
            strip.len()
        );
    }
}

#[test]
fn every_shape_is_decoded_by_any_sequence() {
    for (name, make) in fixtures::ALL {
        for seed in 0..3 {
            check_every_step(
                &obj(vec![object(name, fixtures::random_collapse(&make(), seed))]),
                &format!("{name}, seed {seed}"),
            );
        }
    }
}

#[test]
fn every_shape_is_decoded_as_it_was_simplified() {
    for (name, make) in fixtures::ALL {
        let simplified =
            lodc_simplify::simplify(&make(), &lodc_simplify::Options::DEFAULT, &|_, _| {});
        check_every_step(&obj(vec![object(name, simplified)]), name);
    }
}

#[test]
fn random_meshes_are_decoded() {
    for seed in 0..300 {
        let mesh = fixtures::random(seed);
        check_every_step(
            &obj(vec![object("random", fixtures::random_collapse(&mesh, seed))]),
            &format!("random {seed}"),
        );
        let simplified =
            lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {});
        check_every_step(
            &obj(vec![object("random", simplified)]),
            &format!("random {seed}, simplified"),
        );
    }
}

#[test]
fn objects_of_a_scene_take_turns() {
    let names = ["torus", "empty", "coloured_cube", "triangle", "machine_part"];
    let objects = names.iter().map(|name| {
        let mesh = fixtures::named(name).expect("a shape");
        object(name, lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {}))
    });
    let file = gltf(objects.collect());
    check_every_step(&file, "scene");
    check_every_step(&gltf(Vec::new()), "nothing");
}

#[test]
fn blocks_of_any_size_and_pieces_of_any_length_are_one_mesh() {
    let file = obj(vec![object("torus", fixtures::random_collapse(&fixtures::torus(), 1))]);
    for block_bytes in [Some(0), Some(100), None] {
        let packed = pack(&file, &[], &PackOptions { block_bytes, ..PackOptions::default() })
            .expect("a sound file");
        for piece in [1, 2, 7, 1000] {
            let mut unpacker = Unpacker::new(Limits::DEFAULT);
            packed.bytes.chunks(piece).for_each(|p| unpacker.feed(p).expect("a sound stream"));
            assert!(unpacker.is_complete());
            same_mesh(&unpacker, 0, file.objects[0].simplified.mesh(), "torus");
            assert!(unpacker.strips(0).is_none());
        }
    }
}

#[test]
fn errors_fall_and_are_rounded_up_a_little() {
    let simplified = lodc_simplify::simplify(
        &fixtures::icosphere(3),
        &lodc_simplify::Options::DEFAULT,
        &|_, _| {},
    );
    let largest = simplified.collapses().parts().step_errors.clone();
    let rms = largest.iter().map(|e| 0.3 * e).collect();
    let measured = simplified.clone().with_distances(largest, rms).expect("a pair for each step");
    for (simplified, has_rms) in [(simplified, false), (measured, true)] {
        let file = obj(vec![object("sphere", simplified)]);
        let (packed, _) = stepwise(&file);
        for end in ends(&packed.bytes) {
            let unpacker = fed(&packed.bytes[..end]);
            if unpacker.objects() == 0 || unpacker.progress(0).vertices[0] == 0 {
                continue;
            }
            let state = unpacker.progress(0);
            let lod = Lod(state.vertices[1] - state.vertices[0]);
            let collapses = file.objects[0].simplified.collapses();
            let exact = collapses.error_at(lod);
            let is_above = |x: f32, exact: f32| {
                assert!(x >= exact && x <= exact * 1.0625 + f32::MIN_POSITIVE, "{x} for {exact}");
            };
            is_above(state.error, exact);
            assert_eq!(state.rms.is_some(), has_rms);
            state.rms.zip(collapses.rms_at(lod)).into_iter().for_each(|(x, rms)| is_above(x, rms));
        }
    }
}

/// Bytes are a contract: they change with STREAM.md, or because the strips or sequences that go in
/// are others.
#[test]
fn the_bytes_are_those_of_the_page() {
    let objects = ["torus", "machine_part", "striped_sphere"].map(|name| {
        object(name, fixtures::random_collapse(&fixtures::named(name).expect("a shape"), 1))
    });
    let hash = xxhash_rust::xxh3::xxh3_64(&stepwise(&gltf(objects.into())).0.bytes);
    assert_eq!(hash, 0x5328_1e4f_3563_499d, "{hash:#x}");
}
