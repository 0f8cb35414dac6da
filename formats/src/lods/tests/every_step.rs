//! Every step of a stream shows its level of detail, for any shape and sequence.

use super::*;
use lodc_fixtures as fixtures;
use lodc_mesh::{CollapseSequence, Mesh, SequenceParts};

/// Decodes a file's objects step by step and compares everything, with the steps in their order and
/// in batches.
pub(super) fn check_every_step(file: &LodFile, case: &str) {
    check_steps(file, &stepwise(file), &format!("{case}, exact"));
    let ordered = in_stream_order(file);
    let options = PackOptions { block_bytes: Some(0), ..PackOptions::default() };
    let packed = pack(file, &options).expect("a sound file");
    check_steps(&ordered, &packed, case);
    check_levels(file, &ordered, case);
    check_repacked(&ordered, &packed, &options, case);
}

/// Every step of the stream shows its level of the file.
pub(super) fn check_steps(file: &LodFile, packed: &Packed, case: &str) {
    let mut unpacker = Unpacker::new(Limits::DEFAULT);
    let mut start = 0;
    for end in ends(&packed.bytes) {
        unpacker.feed(&packed.bytes[start..end]).expect("a sound stream");
        start = end;
        for (i, o) in file.objects.iter().enumerate().take(unpacker.objects()) {
            if unpacker.progress(i).vertices[1] as usize != o.simplified.mesh().vertex_count() {
                // Its name has come, but not its header.
                assert_eq!(unpacker.mesh(i).expect("a mesh").0.triangles().len(), 0, "{case}");
                continue;
            }
            check(&unpacker, i, &o.simplified, case);
            let decoder = unpacker.decoder(i);
            assert!(decoder.triangles().flatten().all(|v| decoder.has_come(v)), "{case}");
        }
    }
    assert!(unpacker.is_complete());
    assert_eq!(unpacker.document(), Some(&file.document));
    assert_eq!(unpacker.source(), Some(&file.source));
    for (i, o) in file.objects.iter().enumerate() {
        assert_eq!(unpacker.info(i), &o.info);
        same_sequence(&unpacker, i, &o.simplified);
        same_mesh(&unpacker, i, o.simplified.mesh(), case);
    }
}

/// A file in batches has as many levels of the file before as it says, with the same errors.
fn check_levels(file: &LodFile, ordered: &LodFile, case: &str) {
    for (before, now) in file.objects.iter().zip(&ordered.objects) {
        let [before, now] = [&before.simplified, &now.simplified];
        assert_eq!(now.mesh().vertex_count(), before.mesh().vertex_count(), "{case}");
        let facts = |s: &Simplified| {
            let parts = s.collapses().parts();
            (parts.last_legal_lod, parts.topology_changes, parts.first_topology_change)
        };
        assert_eq!(facts(now), facts(before), "{case}");
        let legal = before.collapses().parts().last_legal_lod;
        let [before, now] = [before, now].map(|s| by_position(s, legal));
        assert!(before == now, "{case}: the last legal level");
    }
}

/// What is unpacked is packed as it was: the errors are all that has to be measured.
fn check_repacked(ordered: &LodFile, packed: &Packed, options: &PackOptions, case: &str) {
    let unpacker = fed(&packed.bytes);
    let mut again = in_stream_order(ordered);
    for (i, o) in again.objects.iter_mut().enumerate() {
        let (mesh, sequence) = unpacker.rebuilt(i).expect("a sound stream").simplified.into_parts();
        let measured = o.simplified.collapses().parts();
        let parts = SequenceParts {
            step_errors: measured.step_errors.clone(),
            step_rms: measured.step_rms.clone(),
            ..sequence.into_parts()
        };
        let sequence = CollapseSequence::try_from(parts).expect("a sequence");
        o.simplified = Arc::new(Simplified::new(mesh, sequence).expect("a simplified mesh"));
    }
    let repacked = pack(&again, options).expect("a sound file");
    assert!(repacked.bytes == packed.bytes, "{case}: packed again it is another stream");
}

/// The object is a simplified mesh again: sequence, all vertices, triangle counts.
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
}

/// All that the mesh has and a triangle uses, bit for bit.
pub(super) fn same_mesh(unpacker: &Unpacker, object: usize, mesh: &Mesh, case: &str) {
    let (decoded, cleaning) = unpacker.mesh(object).expect("a mesh");
    assert_eq!(cleaning.degenerate_triangles, 0, "{case}");
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
    assert!(bits(&decoded) == bits(&wanted), "{case}: positions");
    assert!(decoded.attributes() == wanted.attributes(), "{case}: attributes");
    assert_eq!(decoded.submeshes(), wanted.submeshes(), "{case}");
    assert_eq!(decoded.vertex_submesh(), wanted.vertex_submesh(), "{case}");
    assert!(triangles(&decoded) == triangles(&wanted), "{case}: triangles");
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
        let options = PackOptions { block_bytes, ..PackOptions::default() };
        let packed = pack(&file, &options).expect("a sound file");
        for piece in [1, 2, 7, 1000] {
            let mut unpacker = Unpacker::new(Limits::DEFAULT);
            packed.bytes.chunks(piece).for_each(|p| unpacker.feed(p).expect("a sound stream"));
            assert!(unpacker.is_complete());
            let ordered = in_stream_order(&file);
            same_mesh(&unpacker, 0, ordered.objects[0].simplified.mesh(), "torus");
        }
    }
}

/// The triangles of a level by the positions of their corners.
fn by_position(simplified: &Simplified, lod: Lod) -> Vec<Option<[[u32; 3]; 3]>> {
    let bits = |v: u32| simplified.mesh().positions()[v as usize].map(f32::to_bits);
    let turned = |t: OrientedTriangle| {
        let [a, b, c] = t.corners.map(bits);
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().min()
    };
    let mut all: Vec<_> = simplified.triangles_at(lod).into_iter().map(turned).collect();
    all.sort_unstable();
    all
}

#[test]
fn levels_at_the_ends_of_batches_are_those_of_the_file() {
    for name in ["torus", "machine_part", "striped_sphere", "coloured_cube"] {
        let mesh = fixtures::named(name).expect("a shape");
        let options = lodc_simplify::Options::DEFAULT;
        let file = obj(vec![object(name, lodc_simplify::simplify(&mesh, &options, &|_, _| {}))]);
        let ordered = in_stream_order(&file);
        let packed = pack(&file, &PackOptions::default()).expect("a sound file");
        let [before, now] = [&file, &ordered].map(|f| &*f.objects[0].simplified);
        let ends = |s: &Simplified| s.collapses().parts().step_ends.clone();
        let same = |end: &&u32| {
            let lod = Lod(**end);
            ends(before).binary_search(end).is_ok()
                && by_position(before, lod) == by_position(now, lod)
        };
        let same = ends(now).iter().filter(same).count() as u32;
        let exact = packed.objects[0].exact_levels;
        assert!(exact <= same + 1, "{name}: {same} levels are as they were, not {exact}");
        assert!(same < before.collapses().steps() as u32 || name == "coloured_cube", "{name}");
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
        let packed = stepwise(&file);
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

/// Bytes are a contract: they change with STREAM.md, or because the sequences that go in are
/// others.
#[test]
fn the_bytes_are_those_of_the_page() {
    let objects = ["torus", "machine_part", "striped_sphere"].map(|name| {
        object(name, fixtures::random_collapse(&fixtures::named(name).expect("a shape"), 1))
    });
    let hash = xxhash_rust::xxh3::xxh3_64(&stepwise(&gltf(objects.into())).bytes);
    assert_eq!(hash, 0xa6b7_a7c0_324e_d5d1, "{hash:#x}");
}
