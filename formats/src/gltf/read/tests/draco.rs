//! Primitives that are compressed with Draco. `grid.drc` is by Google's encoder (draco3d 1.5.7,
//! edgebreaker, speed 3, positions of 14 bits, texture coordinates of 12): 5 × 5 vertices
//! (x, y, (7x + 3y) mod 5) with texture coordinates (x, y) / 4 and joints (x, y, 0, 300).

use super::{Builder, parsed, read, read_bytes, sound};
use crate::import::ImportOptions;
use crate::{Fault, Limits};
use lodc_mesh::{Semantic, SplitMix64};
use serde_json::{Value, json};

const GRID: &[u8] = include_bytes!("grid.drc");

/// A document with a stream; `change` may spoil its primitive.
fn document(stream: &[u8], change: impl FnOnce(&mut Value, &mut Builder)) -> Value {
    let mut b = Builder::default();
    let view = b.view(stream);
    let mut bare = |component: u32, count: u32, kind: &str| {
        b.accessor(json!({ "componentType": component, "count": count, "type": kind }))
    };
    let attributes = json!({
        "POSITION": bare(5126, 25, "VEC3"),
        "TEXCOORD_0": bare(5126, 25, "VEC2"),
        "JOINTS_0": bare(5123, 25, "VEC4"),
        "WEIGHTS_0": bare(5126, 25, "VEC4"),
    });
    let indices = bare(5123, 96, "SCALAR");
    let ids = json!({ "POSITION": 0, "TEXCOORD_0": 1, "JOINTS_0": 2 });
    let draco = json!({ "bufferView": view, "attributes": ids });
    let extensions = json!({ "KHR_draco_mesh_compression": draco });
    let mut primitive =
        json!({ "attributes": attributes, "indices": indices, "extensions": extensions });
    change(&mut primitive, &mut b);
    let mut root = b.with_meshes(&json!([{ "primitives": [primitive] }]));
    root["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    root["extensionsRequired"] = root["extensionsUsed"].clone();
    root
}

#[test]
fn a_stream_of_googles_encoder_is_read() {
    let scene = sound(&document(GRID, |_, _| ()));
    let mesh = &scene.objects[0].mesh;
    assert_eq!((mesh.triangles().len(), mesh.vertex_count()), (32, 25));
    let stream =
        |semantic| mesh.attributes().iter().find(|a| a.semantic == semantic).expect("an attribute");
    let (uv, joints) = (stream(Semantic::TexCoord(0)), stream(Semantic::Joints(0)));
    let mut places: Vec<[i32; 3]> = Vec::new();
    for (v, p) in (0..).zip(mesh.positions()) {
        let [x, y, z] = p.map(|c| c.round() as i32);
        assert!(p.iter().zip([x, y, z]).all(|(c, i)| (c - i as f32).abs() < 1e-3), "{p:?}");
        assert_eq!(z, (7 * x + 3 * y) % 5);
        let found = [uv.value(v, 0), uv.value(v, 1)];
        assert!((found[0] - p[0] / 4.0).abs() < 1e-3 && (found[1] - p[1] / 4.0).abs() < 1e-3);
        let found: [f32; 4] = std::array::from_fn(|i| joints.value(v, i));
        assert_eq!(found, [x as f32, y as f32, 0.0, 300.0]);
        places.push([x, y, z]);
    }
    // Two triangles to a square, both the same way round.
    for t in mesh.triangles() {
        let [a, b, c] = t.map(|v| places[v as usize]);
        assert_eq!((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]), 1);
    }
    let document = parsed(&scene).to_string();
    assert!(!document.contains("draco") && !document.contains("accessors"), "{document}");
}

#[test]
fn what_does_not_fit_is_refused_with_its_place() {
    let refused = |root: &Value| read(root).expect_err("it is spoilt");
    let ids = |p: &mut Value, ids: Value| {
        p["extensions"]["KHR_draco_mesh_compression"]["attributes"] = ids;
    };
    let bare = |b: &mut Builder, component: u32, count: u32| {
        b.accessor(json!({ "componentType": component, "count": count, "type": "VEC4" }))
    };
    let spoilt = [
        (document(&GRID[..200], |_, _| ()), "cannot be decoded"),
        (document(b"junk", |_, _| ()), "cannot be decoded"),
        (document(GRID, |p, _| ids(p, json!({ "POSITION": 7 }))), "names nothing"),
        (document(GRID, |p, b| p["indices"] = bare(b, 5123, 95).into()), "has 96 elements"),
        // 300 is no number of eight bits.
        (document(GRID, |p, b| p["attributes"]["JOINTS_0"] = bare(b, 5121, 25).into()), "type"),
        (document(GRID, |p, b| p["attributes"]["JOINTS_0"] = bare(b, 5123, 24).into()), "24"),
    ];
    for (root, words) in spoilt {
        let e = refused(&root);
        assert!(e.fault == Fault::Malformed && e.problem.contains(words), "{words}: {e}");
        assert!(e.location.contains("primitives[0]"), "{e}");
    }
    let e = refused(&document(GRID, |p, _| p["mode"] = 5.into()));
    assert!(e.fault == Fault::Unsupported && e.problem.contains("gltf-transform"), "{e}");
    let limits = Limits { triangles: 10, ..Limits::DEFAULT };
    let options = ImportOptions { limits, ..ImportOptions::default() };
    let root = document(GRID, |_, _| ()).to_string();
    let e = read_bytes(root.as_bytes(), &options).expect_err("more than ten triangles");
    assert_eq!(e.fault, Fault::Limit, "{e}");
}

#[test]
fn damaged_streams_are_read_or_refused() {
    let mut random = SplitMix64::new(1);
    let mut below = |n: usize| (random.unit() * n as f32) as usize % n;
    let mut read_anyway = 0;
    for _ in 0..2_000 {
        let mut stream = GRID.to_vec();
        for _ in 0..=below(3) {
            let offset = below(stream.len());
            stream[offset] = below(256) as u8;
        }
        read_anyway += u32::from(read(&document(&stream, |_, _| ())).is_ok());
    }
    assert!((1..2_000).contains(&read_anyway), "{read_anyway}");
}
