//! Objects of a scene take turns inside blocks.

use super::*;
use crate::testing::Random;
use lodc_fixtures as fixtures;
use lodc_mesh::Mesh;

fn simplified(mesh: &Mesh) -> Simplified {
    lodc_simplify::simplify(mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {})
}

fn scene(meshes: impl IntoIterator<Item = Mesh>) -> LodFile {
    gltf(meshes.into_iter().map(|mesh| object("part", simplified(&mesh))).collect())
}

fn has_turns(bytes: &[u8]) -> bool {
    blocks(bytes).iter().any(|(_, block)| block.tag == 0 && block.steps > 0)
}

#[test]
fn every_block_of_a_scene_ends_with_levels_of_its_objects() {
    let names = [
        "torus",
        "empty",
        "coloured_cube",
        "triangle",
        "empty",
        "machine_part",
        "empty",
        "terrain",
    ];
    let scenes = [
        scene(names.map(|name| fixtures::named(name).expect("a shape"))),
        scene((0..40).map(fixtures::random)),
        scene([fixtures::empty(), fixtures::cube(), fixtures::empty()]),
        scene([fixtures::empty(), fixtures::empty()]),
    ];
    for (number, file) in scenes.iter().enumerate() {
        for block_bytes in [None, Some(1), Some(100)] {
            let options = PackOptions { block_bytes, ..PackOptions::default() };
            let packed = pack(file, &options).expect("a sound file");
            let visible = |o: &&LodObject| !o.simplified.mesh().triangles().is_empty();
            let several = file.objects.iter().filter(visible).count() > 1;
            assert!(!several || has_turns(&packed.bytes), "scene {number}");
            let ordered = in_stream_order(file);
            every_step::check_steps(&ordered, &packed, &format!("scene {number}"));
            let again = pack(&ordered, &options).expect("a sound file");
            assert!(again.bytes == packed.bytes, "scene {number}: packed again");
            let steps: u64 = packed.objects.iter().map(|o| o.bytes).sum();
            assert!(steps + packed.head_bytes < packed.bytes.len() as u64, "scene {number}");
        }
    }
}

#[test]
fn equal_objects_are_a_turn_apart() {
    let mesh = fixtures::icosphere(3);
    let errors: Vec<f32> = simplified(&mesh).collapses().parts().step_errors.clone();
    let file = scene(std::iter::repeat_n(mesh, 30));
    assert!(errors.iter().any(|&e| e > 0.0), "errors say whose turn it is");
    let packed = pack(&file, &PackOptions::default()).expect("a sound file");
    for end in ends(&packed.bytes).into_iter().skip(2) {
        let unpacker = fed(&packed.bytes[..end]);
        let triangles = |object| unpacker.progress(object).triangles[0];
        let shown: Vec<u32> = (0..unpacker.objects()).map(triangles).collect();
        let (least, most) = (shown.iter().min().expect("some"), shown.iter().max().expect("some"));
        assert!(*least == 0 || *most <= 2 * least + 8, "{end} bytes: {least} to {most} triangles");
    }
}

#[test]
fn damaged_and_forged_turns_do_no_harm() {
    let file = scene((0..12).map(fixtures::random));
    let bytes = pack(&file, &PackOptions::default()).expect("a sound file").bytes;
    assert!(has_turns(&bytes));
    let mut random = Random(21);
    let mut refused = 0;
    for case in 0..2000 {
        let forged = if case % 2 == 0 {
            damage::forged(&bytes, &mut random)
        } else {
            // What stands before a flipped bit stays.
            let bit = random.below(8 * bytes.len());
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            let whole = ends(&bytes).into_iter().rfind(|&end| end <= bit / 8).unwrap_or(0);
            let mut unpacker = Unpacker::new(Limits::DEFAULT);
            let is_refused = unpacker.feed(&damaged).is_err();
            assert!(is_refused || !unpacker.is_complete(), "bit {bit}");
            assert_eq!(unpacker.bytes(), if whole < FILE_HEADER.length { 0 } else { whole as u64 });
            damaged
        };
        let mut unpacker = Unpacker::new(Limits::DEFAULT);
        refused += usize::from(unpacker.feed(&forged).is_err());
        for object in 0..unpacker.objects() {
            let _ = unpacker.mesh(object);
            let _ = unpacker.progress(object);
        }
    }
    assert!(refused > 500, "only {refused} were noticed");
}
