use super::*;
use crate::Document;
use crate::testing::{Random, Scratch, damage};
use lodc_mesh::Semantic;
use std::path::Path;

fn import_bytes(bytes: &[u8]) -> Result<Scene, FormatError> {
    import(
        bytes,
        &Assets::new(Path::new("dir/scan.ply"), &[], Limits::DEFAULT),
        &ImportOptions::default(),
    )
}

fn floats(scene: &Scene, semantic: &Semantic) -> Vec<f32> {
    let mut streams = scene.objects[0].mesh.attributes().iter();
    let stream = streams.find(|a| a.semantic == *semantic).expect("the stream");
    stream.bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

const SQUARE: &str = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\n\
    property double y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
    property float s\nproperty float t\nproperty uchar red\nproperty uchar green\n\
    property uchar blue\nproperty float quality\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n\
    0 0 0 0 0 1 0 0 255 0 0 9\n1 0 0 0 0 1 1 0 0 255 0 9\n1 1 0 0 0 1 1 1 0 0 255 9\n\
    0 1 0 0 0 1 0 1 51 51 51 9\n4 0 1 2 3";

#[test]
fn attributes_of_vertices_are_kept_and_the_rest_is_named() {
    let scene = import_bytes(SQUARE.as_bytes()).expect("valid");
    let mesh = &scene.objects[0].mesh;
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(floats(&scene, &Semantic::Normal)[..3], [0.0, 0.0, 1.0]);
    assert_eq!(floats(&scene, &Semantic::TexCoord(0))[2..4], [1.0, 0.0]);
    assert_eq!(floats(&scene, &Semantic::Color(0))[..4], [1.0, 0.0, 0.0, 0.0]);
    // 51 of 255 as linear light.
    assert_eq!(floats(&scene, &Semantic::Color(0))[9], lodc_scene::to_linear(0.2));
    assert_eq!(
        scene.warnings,
        ["1 property of each vertex was ignored: `quality`", "1 polygon was triangulated"]
    );
    assert_eq!(
        (scene.objects[0].info.name.as_str(), scene.source.format),
        ("scan", SourceFormat::Ply)
    );
}

/// The same content as a binary file.
fn binary(big: bool) -> Vec<u8> {
    let (header, body) = SQUARE.split_once("end_header\n").expect("a header");
    let kind = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = format!("{}end_header\n", header.replace("ascii", kind)).into_bytes();
    let mut put = |little: &[u8]| {
        let mut value = little.to_vec();
        if big {
            value.reverse();
        }
        bytes.extend_from_slice(&value);
    };
    for line in body.lines() {
        let numbers: Vec<f64> = line.split(' ').map(|n| n.parse().expect("a number")).collect();
        for (column, &number) in numbers.iter().enumerate() {
            match (numbers.len(), column) {
                (5, 0) | (12, 8..=10) => put(&[number as u8]),
                (5, _) => put(&(number as i32).to_le_bytes()),
                (_, 1) => put(&number.to_le_bytes()),
                _ => put(&(number as f32).to_le_bytes()),
            }
        }
    }
    bytes
}

#[test]
fn binary_and_text_give_the_same_mesh() {
    let text = import_bytes(SQUARE.as_bytes()).expect("text");
    for big in [false, true] {
        let scene = import_bytes(&binary(big)).expect("binary");
        assert_eq!(scene.objects[0].mesh, text.objects[0].mesh);
        assert_eq!(scene.warnings, text.warnings);
    }
    let windows = import_bytes(SQUARE.replace('\n', "\r\n").as_bytes()).expect("other line ends");
    assert_eq!(windows.objects[0].mesh, text.objects[0].mesh);
}

const PLAIN: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\n";
const POINTS: &str = "end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

#[test]
fn faces_may_have_textures_and_coordinates_of_their_own() {
    let scratch = Scratch::new("ply-textures");
    let source = PLAIN
        .replace("element", "comment TextureFile a b.png\ncomment TextureFile c.png\nelement")
        + "element face 3\nproperty list uchar int vertex_index\n\
           property list uchar float texcoord\nproperty int texnumber\nproperty uchar flags\n"
        + POINTS
        + "3 0 1 2 6 0 0 1 0 1 1 1 7\n3 0 2 3 6 .5 0 1 1 0 1 0 7\n3 0 2 1 0 5 7\n";
    scratch.write("a.ply", source.as_bytes());
    let scene =
        crate::import::import(&scratch.path("a.ply"), &ImportOptions::default()).expect("valid");
    let materials: Vec<_> =
        scene.objects[0].info.submeshes.iter().map(|s| s.material.as_deref()).collect();
    assert_eq!(materials, [Some("texture1"), Some("texture0"), None]);
    let Document::Obj(document) = &scene.document else { panic!("a plain document") };
    assert_eq!(document.materials[0].lines, ["map_Kd a b.png"]);
    assert_eq!(floats(&scene, &Semantic::TexCoord(0))[6..8], [0.5, 0.0]);
    assert!(
        scene.warnings.contains(&"1 face names a texture that the file does not have".to_owned())
    );
    assert!(scene.warnings.contains(&"1 property of each face was ignored: `flags`".to_owned()));
}

#[test]
fn strips_become_triangles() {
    let source = PLAIN.to_owned()
        + "element tristrips 1\nproperty list int int vertex_indices\n"
        + POINTS
        + "8 0 1 3 2 -1 2 1 0\n";
    let scene = import_bytes(source.as_bytes()).expect("valid");
    assert_eq!(scene.objects[0].source_positions, [0, 1, 3, 2]);
    assert_eq!(scene.objects[0].mesh.triangles(), [[0, 1, 2], [2, 1, 3], [3, 1, 0]]);
}

#[test]
fn points_alone_are_refused_as_what_they_are() {
    let error = import_bytes((PLAIN.to_owned() + POINTS).as_bytes()).expect_err("no face");
    assert!(error.problem.contains("a point cloud, not a mesh: 4 vertices"), "{error}");
}

#[test]
fn vertices_that_nothing_uses_are_points_unless_there_are_too_many() {
    for (count, kept) in [(5, 2), (MAX_POINTS + 3, MAX_POINTS), (MAX_POINTS + 4, 0)] {
        let positions = vec![[0.5; 3]; count];
        let faces = Faces { positions, corner_v: vec![0, 1, 4], ..Faces::default() };
        let mut content = Content { faces, ..Content::default() };
        assert_eq!(content.loose(&[]).points.len(), kept);
        assert_eq!(content.warnings.len(), 1, "{:?}", content.warnings);
    }
}

#[test]
fn no_faces_need_no_properties() {
    let faces = PLAIN.to_owned() + "element face 0\n" + POINTS;
    let error = import_bytes(faces.as_bytes()).expect_err("no face");
    assert!(error.problem.contains("a point cloud"), "{error}");
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    let all = |face: &str| PLAIN.to_owned() + faces + POINTS + face;
    for (source, message) in [
        ("ply\nformat ascii 1.0\n".to_owned(), "header: the file is truncated"),
        ("ply\nend_header\n".to_owned(), "header: missing format specification"),
        (PLAIN.replace("float x", "half x"), "header: unknown scalar type: half"),
        (all("3 0 1 4\n"), "face 1: vertex 4 does not exist (the file has 4, counted from 0)"),
        (all("3 0 1 -1\n"), "face 1: -1 is not the number of a vertex"),
        (all("3 0 1\n"), "face 1: the file is truncated"),
        (all("3 0 1 x\n"), "face 1: failed to parse i32 from ASCII"),
        (
            all("3 0 1 2").replace("1 1 0\n", "1 inf 0\n"),
            "vertex 3: the coordinate inf is not finite",
        ),
        (
            all("").replace("vertex 4", "vertex 4000000000"),
            "header: 4000000000 `vertex` elements do not",
        ),
        (
            all("").replace("face 1\n", "face 1\nelement x 18446744073709551615\n"),
            "element `face` has no properties",
        ),
        (
            faces.replace("element", "ply\nformat ascii 1.0\nelement") + &PLAIN[21..] + POINTS,
            "comes before",
        ),
        (PLAIN.to_owned() + &PLAIN[21..] + POINTS, "element `vertex` is declared twice"),
    ] {
        let error = import_bytes(source.as_bytes()).expect_err(message);
        assert!(error.to_string().contains(message), "{error} instead of {message}");
    }
    let limits = Limits { vertices: 3, ..Limits::DEFAULT };
    let assets = Assets::new(Path::new("a.ply"), &[], limits);
    let error = import(SQUARE.as_bytes(), &assets, &ImportOptions::default()).expect_err("a limit");
    assert_eq!((error.fault, error.location.as_str()), (Fault::Limit, "header"));
}

#[test]
fn damaged_files_end_in_a_scene_or_an_error() {
    let mut random = Random(5);
    let (mut good, mut bad) = (0, 0);
    for round in 0..6000 {
        let mut bytes = match round % 3 {
            0 => SQUARE.as_bytes().to_vec(),
            kind => binary(kind == 1),
        };
        damage(&mut bytes, b'p', &mut random);
        match import_bytes(&bytes) {
            Ok(_) => good += 1,
            Err(_) => bad += 1,
        }
    }
    assert!(good > 200 && bad > 200, "one-sided: {good} scenes, {bad} errors");
}
