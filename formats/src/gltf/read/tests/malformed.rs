//! Files made to exhaust memory, time or the stack, or to read what is not theirs.

use super::{Builder, read, read_bytes};
use crate::import::ImportOptions;
use crate::testing::Scratch;
use crate::{Fault, FormatError, Limits, Scene};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

fn refused(root: &Value) -> Fault {
    quickly(|| read(root)).expect_err("must be refused").fault
}

/// The promise is one second. What is slow here is what the machine is busy with: only work that
/// grows without bounds gets beyond ten minutes.
fn quickly(import: impl FnOnce() -> Result<Scene, FormatError>) -> Result<Scene, FormatError> {
    let start = Instant::now();
    let result = import();
    assert!(start.elapsed() < Duration::from_secs(600), "took {:?}", start.elapsed());
    result
}

fn one_primitive(mut b: Builder, accessor: Value) -> Value {
    let p = b.accessor(accessor);
    b.with_meshes(&json!([{ "primitives": [{ "attributes": { "POSITION": p } }] }]))
}

#[test]
fn counts_that_no_file_can_have_are_refused_before_memory_is_taken() {
    for count in [
        json!(1u64 << 62),
        json!(u64::MAX),
        json!(u32::MAX),
        json!(1e300),
        json!(3_000_000_000u64),
        json!(500_000_000),
    ] {
        for with_view in [false, true] {
            let mut b = Builder::default();
            let mut accessor = json!({ "componentType": 5126, "count": count, "type": "VEC3" });
            if with_view {
                accessor["bufferView"] = b.view(&[0; 64]).into();
            }
            let fault = refused(&one_primitive(b, accessor));
            assert!(matches!(fault, Fault::Malformed | Fault::Limit), "{count} {fault:?}");
        }
    }
}

#[test]
fn offsets_and_strides_that_overflow_are_refused() {
    for (key, value) in [
        ("byteOffset", u64::MAX),
        ("byteLength", u64::MAX),
        ("byteStride", 1 << 40),
        ("byteStride", 1),
        ("byteStride", 0),
        ("byteLength", 0),
    ] {
        let mut b = Builder::default();
        let view = b.view(&[0; 64]);
        b.views[view][key] = json!(value);
        let accessor =
            json!({ "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC3" });
        assert_eq!(refused(&one_primitive(b, accessor)), Fault::Malformed, "{key} {value}");
    }
    let mut b = Builder::default();
    let view = b.view(&[0; 64]);
    let accessor = json!({ "bufferView": view, "byteOffset": u64::MAX - 8, "componentType": 5126,
        "count": 3, "type": "VEC3" });
    assert_eq!(refused(&one_primitive(b, accessor)), Fault::Malformed);
}

#[test]
fn sparse_counts_and_indices_are_bounded_by_the_accessor() {
    let with = |count: u64, indices: &[u8]| {
        let mut b = Builder::default();
        let view = b.view(indices);
        let values = b.view(&[0; 64]);
        let indices = json!({ "bufferView": view, "componentType": 5121 });
        let sparse =
            json!({ "count": count, "indices": indices, "values": { "bufferView": values } });
        refused(&one_primitive(
            b,
            json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse }),
        ))
    };
    for (count, indices) in
        [(4, &[0, 1, 2, 3][..]), (u64::MAX, &[0]), (0, &[0]), (2, &[1, 1]), (2, &[2, 1]), (1, &[3])]
    {
        assert_eq!(with(count, indices), Fault::Malformed, "{count} {indices:?}");
    }
}

#[test]
fn many_primitives_over_the_same_bytes_reach_a_limit() {
    let mut b = Builder::default();
    let n = 20_000;
    let p = b.zigzag(n);
    let primitives: Vec<Value> =
        (0..2_000).map(|_| json!({ "attributes": { "POSITION": p }, "mode": 5 })).collect();
    let meshes: Vec<Value> = primitives.iter().map(|p| json!({ "primitives": [p] })).collect();
    assert_eq!(refused(&b.with_meshes(&json!(meshes))), Fault::Limit);

    let mut b = Builder::default();
    let p = b.zigzag(n);
    let attributes: serde_json::Map<String, Value> =
        (0..2_000).map(|i| (format!("_{i}"), json!(p))).collect();
    let mut primitive = json!({ "attributes": attributes, "mode": 5 });
    primitive["attributes"]["POSITION"] = json!(p);
    assert_eq!(refused(&b.with_meshes(&json!([{ "primitives": [primitive] }]))), Fault::Limit);
}

#[test]
fn compressed_views_cannot_unpack_to_more_than_their_bytes_allow() {
    for (mode, stride, count) in [
        ("ATTRIBUTES", 256, 1u64 << 40),
        ("TRIANGLES", 4, 3 << 40),
        ("INDICES", 4, 1 << 40),
        ("ATTRIBUTES", 256, 100_000),
    ] {
        let mut b = Builder::default();
        let mut stream = vec![0; 400];
        stream[0] = match mode {
            "ATTRIBUTES" => 0xa1,
            "TRIANGLES" => 0xe1,
            _ => 0xd1,
        };
        let view = b.view(&stream);
        let packed = json!({ "buffer": 0, "byteLength": 400, "byteStride": stride,
            "count": count, "mode": mode });
        b.views[view] = json!({ "buffer": 1, "byteLength": count * stride,
            "extensions": { "EXT_meshopt_compression": packed } });
        let mut root = one_primitive(
            b,
            json!({ "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC3" }),
        );
        let fallback = json!({ "byteLength": count * stride,
            "extensions": { "EXT_meshopt_compression": { "fallback": true } } });
        root["buffers"].as_array_mut().expect("buffers").push(fallback);
        let fault = refused(&root);
        assert!(matches!(fault, Fault::Malformed | Fault::Limit), "{mode} {fault:?}");
    }
}

#[test]
fn deep_and_wide_json_is_refused_before_it_is_parsed() {
    let options = ImportOptions::default();
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let deep = format!("{{\"a\":{}1{}}}", open.repeat(100_000), close.repeat(100_000));
        let e = quickly(|| read_bytes(deep.as_bytes(), &options)).expect_err("too deep");
        assert_eq!(e.fault, Fault::Limit);
    }
    let wide = format!("{{\"a\":[{}1]}}", "1,".repeat(5 << 20));
    assert_eq!(
        quickly(|| read_bytes(wide.as_bytes(), &options)).map(|_| ()).map_err(|e| e.fault),
        Err(Fault::Limit)
    );
    // As deep as the limit and the parser allow: no stack runs out, and brackets in strings do not
    // count.
    let fair = format!(
        r#"{{"asset":{{"version":"2.0"}},"x":{}{},"y":"{}\"["}}"#,
        "[".repeat(100),
        "]".repeat(100),
        "[".repeat(9999)
    );
    assert!(read_bytes(fair.as_bytes(), &options).is_ok());
}

#[test]
fn raised_limits_do_not_reach_the_stack() {
    let limits = Limits { json_depth: u32::MAX, ..Limits::DEFAULT };
    let options = ImportOptions { limits, ..ImportOptions::default() };
    let deep = format!("{{\"a\":{}{}}}", "[".repeat(50_000), "]".repeat(50_000));
    assert!(read_bytes(deep.as_bytes(), &options).is_err());
}

#[test]
fn node_loops_long_chains_and_crowds_end_quickly() {
    let chain: Vec<Value> =
        (0..100_000).map(|i| json!({ "children": [(i + 1) % 100_000] })).collect();
    let mut root = json!({ "asset": { "version": "2.0" }, "nodes": chain });
    assert_eq!(refused(&root), Fault::Malformed);
    root["nodes"][99_999] = json!({});
    assert!(quickly(|| read(&root)).is_ok());
}

#[test]
fn limits_on_vertices_and_triangles_are_kept() {
    let mut b = Builder::default();
    let p = b.zigzag(100);
    let root = b
        .with_meshes(&json!([{ "primitives": [{ "attributes": { "POSITION": p }, "mode": 5 }] }]))
        .to_string();
    for (vertices, triangles, sound) in [(100, 98, true), (99, 98, false), (100, 97, false)] {
        let limits = Limits { vertices, triangles, ..Limits::DEFAULT };
        let result =
            read_bytes(root.as_bytes(), &ImportOptions { limits, ..ImportOptions::default() });
        assert_eq!(
            result.map(|_| ()).map_err(|e| e.fault),
            if sound { Ok(()) } else { Err(Fault::Limit) }
        );
    }
}

#[test]
fn uris_lead_nowhere_but_beside_the_asset() {
    let scratch = Scratch::new("gltf-paths");
    scratch.write("secret.bin", &[0; 64]);
    scratch.write("asset/inside file.bin", &[0; 64]);
    let outside = scratch.path("secret.bin").display().to_string();
    let import = |uri: &str| {
        let root =
            json!({ "asset": { "version": "2.0" }, "buffers": [{ "byteLength": 64, "uri": uri }] });
        scratch.write("asset/test.gltf", root.to_string().as_bytes());
        quickly(|| {
            crate::import::import(&scratch.path("asset/test.gltf"), &ImportOptions::default())
        })
    };
    for uri in [
        "../secret.bin",
        "%2e%2e/secret.bin",
        "%2E%2E%2Fsecret.bin",
        "x/../../secret.bin",
        outside.as_str(),
        &format!("file://{outside}"),
        &format!("FILE:{outside}"),
        "http://127.0.0.1:9/secret.bin",
        "https:secret.bin",
        "ht%74p://127.0.0.1:9/x",
        "/dev/zero",
        "/etc/passwd",
        "%00",
        "inside%20file.bin%00",
        "%FF",
        "%zz",
        "",
        ".",
        "..",
    ] {
        let e = import(uri).expect_err(uri);
        assert!(
            matches!(e.fault, Fault::Forbidden | Fault::Malformed | Fault::Unreadable),
            "{uri}: {e}"
        );
    }
    let scene = import("inside%20file.bin").expect("beside the asset");
    assert_eq!(scene.files.read_files().len(), 2);
    assert!(import("inside file.bin").is_ok());
}

#[test]
fn the_content_hash_covers_the_main_file_and_every_buffer_file() {
    let scratch = Scratch::new("gltf-hash");
    let hash = |last: u8| {
        let buffers = json!([{ "byteLength": 2, "uri": "a.bin" }]);
        let root = json!({ "asset": { "version": "2.0" }, "buffers": buffers }).to_string();
        scratch.write("test.gltf", root.as_bytes());
        scratch.write("a.bin", &[1, 2, last]);
        let scene = crate::import::import(&scratch.path("test.gltf"), &ImportOptions::default())
            .expect("sound");
        let expected = xxhash_rust::xxh3::xxh3_128(&[root.as_bytes(), &[1, 2, last]].concat());
        assert_eq!(scene.source.content_hash, expected);
        expected
    };
    assert_ne!(hash(3), hash(4));
}
