//! Colours of vertices: sRGB values in OBJ, PLY and STL, linear light in glTF.

use crate::support::{Folder, glb_document, grid};

/// A grid whose vertices have a colour each, as `colour` says.
fn painted(colour: impl Fn(usize) -> String) -> String {
    let mut vertex = 0;
    let mut obj = String::new();
    for line in grid(15).lines() {
        obj += line;
        if line.starts_with("v ") {
            obj += &format!(" {}", colour(vertex));
            vertex += 1;
        }
        obj.push('\n');
    }
    obj
}

/// The colours of an OBJ's vertices as it has them, sorted.
fn colours(obj: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(obj).into_owned();
    let vertices = text.lines().filter_map(|l| l.strip_prefix("v "));
    let mut all: Vec<String> =
        vertices.map(|v| v.split(' ').skip(3).collect::<Vec<_>>().join(" ")).collect();
    all.sort();
    all
}

/// The values of COLOR_0 of the first primitive, which are floats or 16 bits.
fn color_0(f: &Folder, glb: &str) -> Vec<f64> {
    let (root, bin) = glb_document(&f.read(glb));
    let accessor = root["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"].as_u64();
    let accessor = &root["accessors"][accessor.expect("colours") as usize];
    let view = &root["bufferViews"][accessor["bufferView"].as_u64().expect("a view") as usize];
    let number = |v: &serde_json::Value| v.as_u64().unwrap_or(0) as usize;
    let short = accessor["componentType"] == 5123;
    let components = if accessor["type"] == "VEC4" { 4 } else { 3 };
    let size = if short { 2 } else { 4 };
    let stride = match number(&view["byteStride"]) {
        0 => size * components,
        stride => stride,
    };
    let start = number(&view["byteOffset"]) + number(&accessor["byteOffset"]);
    let value = |at: usize| match short {
        true => f64::from(u16::from_le_bytes([bin[at], bin[at + 1]])) / 65535.0,
        false => f64::from(f32::from_le_bytes(bin[at..at + 4].try_into().expect("four bytes"))),
    };
    let element = |i: usize| (0..3).map(move |c| value(start + i * stride + c * size));
    (0..number(&accessor["count"])).flat_map(element).collect()
}

#[test]
fn grey_of_an_obj_or_ply_is_linear_light_in_gltf() {
    let f = Folder::new();
    f.file("half.obj", painted(|_| "0.5 0.5 0.5".to_owned()));
    f.lodc(["extract", "half.obj", "--lod", "0", "-o", "half.ply"]).ends(0);
    for input in ["half.obj", "half.ply"] {
        f.lodc(["extract", input, "--lod", "0", "-o", "o.glb"]).ends(0);
        let expected = if input == "half.obj" { 0.214_041_14 } else { 0.215_860_5 };
        let values = color_0(&f, "o.glb");
        assert!(values.iter().all(|v| (v - expected).abs() < 1e-6), "{input}: {values:?}");
    }
}

#[test]
fn digits_survive_the_way_to_gltf_and_back_quantised_too() {
    let f = Folder::new();
    let byte = |v: usize| format!("{:.6}", (v % 256) as f64 / 255.0);
    let trimmed = |t: String| t.trim_end_matches('0').trim_end_matches('.').to_owned();
    let colour = |v: usize| [v, v * 7 + 3, 255 - v % 256].map(|v| trimmed(byte(v))).join(" ");
    f.file("a.obj", painted(colour));
    let before = colours(&f.read("a.obj"));
    for options in [&[][..], &["--quantize", "color=8"]] {
        let args = ["extract", "a.obj", "--lod", "0", "-o", "a.glb"];
        f.lodc(args.iter().chain(options)).ends(0);
        f.lodc(["extract", "a.glb", "--lod", "0", "-o", "b.obj"]).ends(0);
        assert_eq!(colours(&f.read("b.obj")), before, "{options:?}");
    }
    // Bytes of a PLY come back as they were.
    f.lodc(["extract", "a.obj", "--lod", "0", "-o", "a.ply"]).ends(0);
    f.lodc(["extract", "a.ply", "--lod", "0", "-o", "a.glb"]).ends(0);
    f.lodc(["extract", "a.glb", "--lod", "0", "--order", "file", "-o", "b.ply"]).ends(0);
    f.lodc(["extract", "a.ply", "--lod", "0", "--order", "file", "-o", "c.ply"]).ends(0);
    let mut bytes = [f.read("b.ply"), f.read("c.ply")].map(|ply| {
        let end = ply.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
        let mut rows: Vec<Vec<u8>> =
            ply[end..].chunks_exact(15).take(256).map(<[u8]>::to_vec).collect();
        rows.sort();
        rows
    });
    assert_eq!(std::mem::take(&mut bytes[0]), bytes[1]);
}

#[test]
fn numbers_up_to_255_and_polypaint_are_read() {
    let f = Folder::new();
    f.file("bytes.obj", painted(|v| format!("{} 128 30", v % 256)));
    let run = f.lodc(["extract", "bytes.obj", "--lod", "0", "-o", "o.obj"]).ends(0);
    assert!(run.err.contains("from 0 to 255"), "{}", run.err);
    assert!(colours(&f.read("o.obj")).iter().any(|c| c == "0 0.5019608 0.11764706"));
    let count = 256;
    let digits: String = (0..count).map(|v: i32| format!("ff{:02x}8020", v % 256)).collect();
    let lines: String = digits
        .as_bytes()
        .chunks(512)
        .map(|c| format!("#MRGB {}\n", String::from_utf8_lossy(c)))
        .collect();
    f.file("zbrush.obj", format!("{}{lines}", grid(15)));
    f.lodc(["extract", "zbrush.obj", "--lod", "0", "-o", "o.glb"]).ends(0);
    let values = color_0(&f, "o.glb");
    assert_eq!(values.len(), 3 * count as usize);
    assert!(values.chunks(3).all(|c| (c[1] - 0.215_860_5).abs() < 1e-6));
    f.file("short.obj", format!("{}#MRGB ff102030\n", grid(4)));
    let run = f.lodc(["extract", "short.obj", "--lod", "0", "-o", "o.glb"]).ends(0);
    assert!(run.err.contains("#MRGB lines have 1 colour for 25 positions: ignored"), "{}", run.err);
}

/// A binary STL of two triangles with these attributes.
fn stl(header: &[u8], attributes: [u16; 2]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(2u32.to_le_bytes());
    let corners = [[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 1]]];
    for (corners, attribute) in corners.iter().zip(attributes) {
        bytes.extend([0; 12]);
        bytes.extend(corners.as_flattened().iter().flat_map(|&c| (c as f32).to_le_bytes()));
        bytes.extend(attribute.to_le_bytes());
    }
    bytes
}

#[test]
fn facets_of_an_stl_have_colours_by_two_conventions() {
    let f = Folder::new();
    let magics = stl(b"COLOR=\x00\x00\xff\xff", [31, 0x8000]);
    let viscam = stl(b"made elsewhere", [0x8000 | 31 << 10, 0x8000 | 31]);
    for (name, bytes) in [("magics.stl", magics), ("viscam.stl", viscam)] {
        f.file(name, bytes);
        f.lodc(["extract", name, "--lod", "0", "-o", "o.obj"]).ends(0);
        let found = colours(&f.read("o.obj"));
        assert_eq!(found, ["0 0 1", "0 0 1", "0 0 1", "1 0 0", "1 0 0", "1 0 0"], "{name}");
    }
    for attributes in [[0, 0], [7, 9], [u16::MAX; 2]] {
        f.file("plain.stl", stl(b"plain", attributes));
        f.lodc(["extract", "plain.stl", "--lod", "0", "-o", "o.obj"]).ends(0);
        assert!(colours(&f.read("o.obj")).iter().all(String::is_empty), "{attributes:?}");
    }
}

#[test]
fn faces_of_a_ply_give_their_corners_colours() {
    let f = Folder::new();
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nelement face 2\nproperty list uchar int vertex_indices\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
    let body = "0 0 0\n1 0 0\n1 1 0\n0 1 1\n3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n";
    f.file("a.ply", format!("{header}{body}"));
    let run = f.lodc(["extract", "a.ply", "--lod", "0", "-o", "o.obj"]).ends(0);
    assert!(!run.err.contains("ignored"), "{}", run.err);
    let found = colours(&f.read("o.obj"));
    assert_eq!(found, ["0 0 1", "0 0 1", "0 0 1", "1 0 0", "1 0 0", "1 0 0"]);
}

#[test]
fn colours_of_a_ply_have_several_names_and_kinds() {
    let f = Folder::new();
    for (kind, names, values) in [
        ("uchar", ["red", "green", "blue", "alpha"], "255 0 51 102"),
        ("uint8", ["diffuse_red", "diffuse_green", "diffuse_blue", "alpha"], "255 0 51 102"),
        ("uchar", ["r", "g", "b", "a"], "255 0 51 102"),
        ("ushort", ["red", "green", "blue", "alpha"], "65535 0 13107 26214"),
        ("float", ["red", "green", "blue", "alpha"], "1 0 0.2 0.4"),
        ("double", ["r", "g", "b", "a"], "1 0 0.2 0.4"),
        ("float32", ["red", "green", "blue", "alpha"], "255 0 51 102"),
    ] {
        let properties = names.map(|name| format!("property {kind} {name}\n")).concat();
        let vertices = ["0 0 0", "1 0 0", "1 1 0"].map(|v| format!("{v} {values}\n")).concat();
        f.file(
            "a.ply",
            format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                 property float z\n{properties}element face 1\n\
                 property list uchar int vertex_indices\nend_header\n{vertices}3 0 1 2\n"
            ),
        );
        f.lodc(["extract", "a.ply", "--lod", "0", "-o", "o.obj"]).ends(0);
        assert_eq!(colours(&f.read("o.obj")), ["1 0 0.2 0.4"; 3], "{kind} {names:?}");
    }
}
