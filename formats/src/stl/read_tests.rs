use super::*;
use crate::testing::{Random, damage};
use std::path::Path;

fn import_bytes(bytes: &[u8]) -> Result<Scene, FormatError> {
    let assets = Assets::new(Path::new("dir/part.stl"), &[], Limits::DEFAULT);
    import(bytes.to_vec(), &assets, &ImportOptions::default())
}

/// Two triangles of a square.
const SQUARE: [[[f32; 3]; 3]; 2] = [
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
    [[-0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
];

fn text(name: &str) -> String {
    let mut text = format!("solid {name}\n");
    for corners in SQUARE {
        text += "  facet normal 0 0 1\n    outer loop\n";
        for [x, y, z] in corners {
            text += &format!("      vertex {x:e} {y:e} {z:e}\n");
        }
        text += "    endloop\n  endfacet\n";
    }
    text + &format!("endsolid {name}\n")
}

fn binary(header: &[u8]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend_from_slice(&2u32.to_le_bytes());
    for corners in SQUARE {
        for value in [[f32::NAN; 3]].iter().chain(&corners).flatten() {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
        bytes.extend_from_slice(&[7, 0]);
    }
    bytes
}

#[test]
fn text_and_binary_give_the_same_mesh_with_joined_corners() {
    for bytes in [
        text("square").into_bytes(),
        text("square").to_uppercase().into_bytes(),
        text("square").replace("normal 0 0 1", "normal nan -nan(ind) 0").into_bytes(),
        text("").replace("solid ", "solid").into_bytes(),
        binary(b"from a test"),
        binary(b"solid that is binary"),
    ] {
        let scene = import_bytes(&bytes).expect("valid");
        let mesh = &scene.objects[0].mesh;
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.positions()[3], [0.0, 1.0, 0.0]);
        assert!(mesh.attributes().is_empty());
        assert!(scene.warnings[0].starts_with("6 corners of loose triangles were joined to 4"));
        assert_eq!(scene.source.format, SourceFormat::Stl);
    }
}

#[test]
fn solids_are_parts_and_name_the_whole_if_there_is_one() {
    let one = import_bytes(text("Left Side").as_bytes()).expect("valid");
    assert_eq!(one.objects[0].info.name, "Left Side");
    assert_eq!(one.objects[0].info.submeshes[0].name, "");
    let two = import_bytes((text("a") + &text("b")).as_bytes()).expect("valid");
    assert_eq!(two.objects[0].info.name, "part");
    assert_eq!(two.objects[0].info.submeshes[0].name, "a b");
    assert_eq!(two.objects[0].mesh.triangles().len(), 4);
    assert_eq!(import_bytes(&binary(b"")).expect("valid").objects[0].info.name, "part");
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let mut cut = binary(b"");
    cut.truncate(150);
    let mut infinite = binary(b"");
    infinite[84 + 12..84 + 16].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let other = text("a b").replace("vertex 1e0 1e0 0e0", "vertex 1e0 1e0");
    for (bytes, message) in [
        (cut, "header: 2 facets do not fit into the file, which has room for 1"),
        (binary(b"")[..70].to_vec(), "the file ends within its header"),
        (infinite, "facet 1: the position (inf, 0, 0) is not finite"),
        (other.into_bytes(), "solid \\\"a b\\\", facet 1: vertex f32 f32 f32, got"),
        (text("x").replace("endsolid x\n", "").into_bytes(), "facet 3: the file is truncated"),
        (text("x").replace("outer loop", "loop").into_bytes(), "facet 1: expected"),
    ] {
        let error = import_bytes(&bytes).expect_err(message);
        assert!(error.to_string().contains(message), "{error}");
        assert_eq!(error.fault, Fault::Malformed);
    }
    let limits = Limits { triangles: 1, ..Limits::DEFAULT };
    let assets = Assets::new(Path::new("a.stl"), &[], limits);
    let error = import(binary(b""), &assets, &ImportOptions::default()).expect_err("a limit");
    assert_eq!(error.fault, Fault::Limit);
}

#[test]
fn damaged_files_end_in_a_scene_or_an_error() {
    let mut random = Random(11);
    let (mut good, mut bad) = (0, 0);
    for round in 0..4000 {
        let mut bytes = if round % 2 == 0 { text("a").into_bytes() } else { binary(b"x") };
        damage(&mut bytes, b's', &mut random);
        match import_bytes(&bytes) {
            Ok(_) => good += 1,
            Err(_) => bad += 1,
        }
    }
    assert!(good > 100 && bad > 100, "one-sided: {good} scenes, {bad} errors");
}
