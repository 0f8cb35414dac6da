//! Primitives, accessors and attributes.

use super::{Builder, corners, data_uri, parsed, read, read_bytes, sound};
use crate::Fault;
use crate::import::ImportOptions;
use lodc_mesh::{Component, Semantic};
use serde_json::{Value, json};

fn location(root: &Value) -> (Fault, String) {
    let e = read(root).expect_err("must be refused");
    (e.fault, e.location)
}

#[test]
fn strips_turn_every_other_triangle_and_fans_share_their_first_corner() {
    let x = |root: &Value| -> Vec<[f32; 3]> {
        corners(&sound(root).objects[0].mesh).iter().map(|t| t.map(|p| p[0])).collect()
    };
    let with_mode = |mode: u32| {
        let mut b = Builder::default();
        let p = b.zigzag(5);
        b.with_meshes(
            &json!([{ "primitives": [{ "attributes": { "POSITION": p }, "mode": mode }] }]),
        )
    };
    assert_eq!(x(&with_mode(5)), [[0.0, 1.0, 2.0], [1.0, 3.0, 2.0], [2.0, 3.0, 4.0]]);
    assert_eq!(x(&with_mode(4)), [[0.0, 1.0, 2.0]]);
    // The first and third corner of the fan's last triangle lie on the line through all even ones,
    // but none coincide.
    assert_eq!(x(&with_mode(6)), [[1.0, 2.0, 0.0], [2.0, 3.0, 0.0], [3.0, 4.0, 0.0]]);
}

#[test]
fn indices_of_every_width_read_the_same_and_stitches_are_dropped() {
    for (component, size) in [(5121, 1), (5123, 2), (5125, 4)] {
        let mut b = Builder::default();
        let p = b.zigzag(6);
        let bytes: Vec<u8> = [0u32, 1, 2, 2, 3, 3, 4, 5]
            .iter()
            .flat_map(|i| i.to_le_bytes().into_iter().take(size))
            .collect();
        let i = b.data(component, "SCALAR", 8, &bytes);
        let primitive = json!({ "attributes": { "POSITION": p }, "indices": i, "mode": 5 });
        let root = b.with_meshes(&json!([{ "primitives": [primitive] }]));
        let scene = sound(&root);
        assert_eq!(corners(&scene.objects[0].mesh).len(), 2);
        assert_eq!(scene.warnings, ["4 triangles with two corners at one position were dropped"]);
    }
}

#[test]
fn restart_values_and_indices_out_of_range_are_errors_with_a_place() {
    for bad in [3, 255] {
        let mut b = Builder::default();
        let p = b.zigzag(3);
        let i = b.data(5121, "SCALAR", 3, &[0, 1, bad]);
        let good = json!({ "attributes": { "POSITION": p } });
        let root = b.with_meshes(&json!([
            { "primitives": [good] }, { "primitives": [good] },
            { "primitives": [{ "attributes": { "POSITION": p }, "indices": i }] },
        ]));
        assert_eq!(
            location(&root),
            (Fault::Malformed, "meshes[2].primitives[0].indices".to_owned())
        );
    }
}

#[test]
fn interleaved_and_offset_data_are_read_at_their_stride() {
    let mut b = Builder::default();
    let rows: Vec<u8> = (0..3u8)
        .flat_map(|i| {
            let p = [f32::from(i), f32::from(i % 2), 0.0];
            [vec![9; 4], p.iter().flat_map(|c| c.to_le_bytes()).collect(), vec![i, i + 10, 0, 0]]
                .concat()
        })
        .collect();
    let view = b.view(&rows);
    b.views[view]["byteStride"] = json!(20);
    let p = b.accessor(json!({
        "bufferView": view, "byteOffset": 4, "componentType": 5126, "count": 3, "type": "VEC3",
    }));
    let uv = b.accessor(
        json!({ "bufferView": view, "byteOffset": 16, "componentType": 5121, "normalized": true,
            "count": 3, "type": "VEC2" }),
    );
    let scene = sound(&b.with_meshes(
        &json!([{ "primitives": [{ "attributes": { "POSITION": p, "TEXCOORD_0": uv } }] }]),
    ));
    let mesh = &scene.objects[0].mesh;
    assert_eq!(mesh.positions()[2], [2.0, 0.0, 0.0]);
    let a = &mesh.attributes()[0];
    assert_eq!(
        (&a.semantic, a.component, a.components, a.normalized),
        (&Semantic::TexCoord(0), Component::U8, 2, true)
    );
    assert_eq!(a.bytes, [0, 10, 1, 11, 2, 12]);
}

#[test]
fn sparse_accessors_replace_elements_with_and_without_a_view_below() {
    for below in [true, false] {
        let mut b = Builder::default();
        let p = if below {
            b.zigzag(4)
        } else {
            b.accessor(json!({ "componentType": 5126, "count": 4, "type": "VEC3" }))
        };
        let view = b.view(&[1, 2, 3]);
        let values: Vec<u8> = [7.0f32, 0.0, 0.0, 7.0, 1.0, 0.0, 8.0, 1.0, 0.0]
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let values = b.view(&values);
        b.accessors[p]["sparse"] = json!({
            "count": 3, "indices": { "bufferView": view, "componentType": 5121 },
            "values": { "bufferView": values },
        });
        let i = b.indices(&[1, 2, 3, 0, 1, 2]);
        let scene = sound(&b.with_meshes(
            &json!([{ "primitives": [{ "attributes": { "POSITION": p }, "indices": i }] }]),
        ));
        let expected = [[7.0, 0.0, 0.0], [7.0, 1.0, 0.0], [8.0, 1.0, 0.0]];
        assert_eq!(corners(&scene.objects[0].mesh)[0], expected);
        assert_eq!(corners(&scene.objects[0].mesh)[1][0], [0.0; 3]);
    }
}

#[test]
fn quantised_positions_are_kept_as_they_are_and_read_as_numbers() {
    let mut b = Builder::default();
    let bytes: Vec<u8> = [0i16, 0, 0, 0, 32767, 0, 0, 0, -32768, 0, 0, 0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let view = b.view(&bytes);
    b.views[view]["byteStride"] = json!(8);
    let p = b.accessor(json!({
        "bufferView": view, "componentType": 5122, "normalized": true, "count": 3, "type": "VEC3",
    }));
    let mut root = b.with_meshes(&json!([{ "primitives": [{ "attributes": { "POSITION": p } }] }]));
    root["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    root["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let scene = sound(&root);
    let mesh = &scene.objects[0].mesh;
    assert_eq!(mesh.positions(), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]);
    let a = &mesh.attributes()[0];
    assert_eq!(
        (&a.semantic, a.component, a.normalized, a.at(2)),
        (&Semantic::Position, Component::I16, true, &[0, 128, 0, 0, 0, 0][..])
    );
    assert_eq!(parsed(&scene)["extensionsRequired"], json!(["KHR_mesh_quantization"]));
}

#[test]
fn primitives_share_streams_of_one_format_and_morph_targets_are_streams() {
    let mut b = Builder::default();
    let p = b.zigzag(3);
    let uv = b.floats("VEC2", 2, &[0.0, 0.5, 1.0, 0.5, 0.0, 1.0]);
    let short = b.data(5123, "VEC2", 3, &[1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0]);
    b.accessors[short]["normalized"] = json!(true);
    let primitive = |uv: usize| {
        let attributes = json!({ "POSITION": p, "TEXCOORD_3": uv, "_PART": p });
        json!({ "attributes": attributes, "targets": [{ "POSITION": p }, { "POSITION": p }] })
    };
    let root =
        b.with_meshes(&json!([{ "primitives": [primitive(uv), primitive(short), primitive(uv)] }]));
    let scene = sound(&root);
    let mesh = &scene.objects[0].mesh;
    let streams: Vec<_> = mesh
        .attributes()
        .iter()
        .map(|a| (a.semantic.clone(), a.morph_target, a.component))
        .collect();
    let custom = Semantic::Custom("_PART".to_owned());
    assert_eq!(
        streams,
        [
            (Semantic::TexCoord(3), None, Component::F32),
            (custom, None, Component::F32),
            (Semantic::Position, Some(0), Component::F32),
            (Semantic::Position, Some(1), Component::F32),
            (Semantic::TexCoord(3), None, Component::U16),
        ]
    );
    let used: Vec<_> = mesh.submeshes().iter().map(|s| s.attributes.clone()).collect();
    assert_eq!(used, [vec![0, 1, 2, 3], vec![4, 1, 2, 3], vec![0, 1, 2, 3]]);
    assert_eq!(
        (mesh.vertex_count(), mesh.attributes()[4].at(3), mesh.attributes()[4].at(0)),
        (9, &[1, 0, 2, 0][..], &[0; 4][..])
    );
    assert_eq!(parsed(&scene)["meshes"][0]["primitives"][0]["targets"], json!([{}, {}]));
}

#[test]
fn vertices_shared_by_primitives_are_split_and_only_unused_ones_counted() {
    let mut b = Builder::default();
    let p = b.zigzag(10);
    let (i, j) = (b.indices(&[0, 1, 2]), b.indices(&[2, 1, 3]));
    let primitive = |i: usize| json!({ "attributes": { "POSITION": p }, "indices": i });
    let scene = sound(&b.with_meshes(&json!([{ "primitives": [primitive(i), primitive(j)] }])));
    assert_eq!(scene.objects[0].mesh.vertex_count(), 6);
    assert_eq!(scene.warnings, ["6 vertices that no triangle uses were dropped"]);
}

#[test]
fn coordinates_that_are_not_finite_are_refused_only_where_they_are_used() {
    let with_last = |used: u16| {
        let mut b = Builder::default();
        let p =
            b.floats("VEC3", 3, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, f32::NAN, 0.0, 0.0]);
        let i = b.indices(&[0, 1, used]);
        b.with_meshes(
            &json!([{ "primitives": [{ "attributes": { "POSITION": p }, "indices": i }] }]),
        )
    };
    assert_eq!(
        location(&with_last(3)),
        (Fault::Malformed, "meshes[0].primitives[0].attributes.POSITION".to_owned())
    );
    assert_eq!(sound(&with_last(2)).objects.len(), 1);
}

#[test]
fn welding_joins_near_positions_and_says_so() {
    let mut b = Builder::default();
    let p = b.floats(
        "VEC3",
        3,
        &[
            0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1e-6, 0.0, 1.0, 1e-6, 0.0, 1.0, 1.0,
            0.0,
        ],
    );
    let root = b.with_meshes(&json!([{ "primitives": [{ "attributes": { "POSITION": p } }] }]));
    let options = ImportOptions { weld: 1e-3, ..ImportOptions::default() };
    let scene = read_bytes(root.to_string().as_bytes(), &options).expect("sound");
    assert_eq!(scene.warnings, ["2 vertices were welded to a neighbour"]);
    assert_eq!(scene.objects[0].mesh.positions()[3], [0.0; 3]);
}

#[test]
fn compressed_streams_decode_to_what_the_extension_says() {
    // A version 0 attribute stream of four equal elements: a zero header per byte plane, then the
    // tail.
    let element = [0, 0, 128, 63, 0, 0, 0, 0, 0, 0, 0, 0];
    let mut stream = vec![0xa0];
    stream.extend([0; 12]);
    stream.extend([0; 32 - 12]);
    stream.extend(element);
    let mut b = Builder::default();
    let packed = b.view(&stream);
    let offset = b.views[packed]["byteOffset"].clone();
    b.views[packed] = json!({ "buffer": 0, "byteLength": 48, "byteStride": 12,
        "extensions": { "EXT_meshopt_compression": {
        "buffer": 0, "byteOffset": offset, "byteLength": stream.len(), "byteStride": 12,
        "count": 4, "mode": "ATTRIBUTES",
    } } });
    let uv = b.accessor(
        json!({ "bufferView": packed, "componentType": 5126, "count": 4, "type": "VEC3" }),
    );
    let p = b.zigzag(4);
    let mut root = b.with_meshes(
        &json!([{ "primitives": [{ "attributes": { "POSITION": p, "_X": uv }, "mode": 5 }] }]),
    );
    root["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    let scene = sound(&root);
    assert_eq!(scene.objects[0].mesh.attributes()[0].at(3), element);
    assert_eq!(parsed(&scene).get("extensionsRequired"), None);
}

#[test]
fn plain_data_goes_before_what_is_compressed_with_draco() {
    let draco = |plain: bool| {
        let mut b = Builder::default();
        let p = if plain {
            b.zigzag(3)
        } else {
            b.accessor(json!({ "componentType": 5126, "count": 3, "type": "VEC3" }))
        };
        let packed = b.view(&[1, 2, 3, 4]);
        let draco = json!({ "bufferView": packed, "attributes": { "POSITION": 0 } });
        let extensions = json!({ "KHR_draco_mesh_compression": draco });
        let primitive = json!({ "attributes": { "POSITION": p }, "extensions": extensions });
        let mut root = b.with_meshes(&json!([{ "primitives": [primitive] }]));
        root["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
        root
    };
    let e = read(&draco(false)).expect_err("no data");
    assert!(
        e.fault == Fault::Malformed && e.location.contains("KHR_draco_mesh_compression"),
        "{e}"
    );
    let scene = sound(&draco(true));
    assert_eq!(scene.objects.len(), 1);
    assert!(!parsed(&scene).to_string().contains("draco"));
}

#[test]
fn known_attributes_of_the_wrong_shape_are_refused() {
    for (name, kind) in [
        ("NORMAL", "VEC2"),
        ("TANGENT", "VEC3"),
        ("TEXCOORD_0", "VEC4"),
        ("JOINTS_0", "VEC4"),
        ("WEIGHTS_0", "VEC2"),
    ] {
        let mut b = Builder::default();
        let p = b.zigzag(3);
        let a = b.accessor(json!({ "componentType": 5126, "count": 3, "type": kind }));
        let root = b.with_meshes(
            &json!([{ "primitives": [{ "attributes": { "POSITION": p, name: a } }] }]),
        );
        assert_eq!(
            location(&root),
            (Fault::Malformed, format!("meshes[0].primitives[0].attributes.{name}"))
        );
    }
}

#[test]
fn the_world_scale_is_the_largest_over_nodes_skins_and_instances() {
    let mut b = Builder::default();
    let p = b.zigzag(3);
    let scales = b.floats("VEC3", 3, &[1.0, 1.0, 1.0, 1.0, 5.0, 1.0]);
    let mesh = json!({ "primitives": [{ "attributes": { "POSITION": p } }] });
    let mut root = b.with_meshes(&json!([mesh, mesh, mesh, mesh]));
    root["nodes"] = json!([
        { "scale": [2, 2, 2], "children": [1, 2] },
        { "mesh": 0, "scale": [1, -3, 1] },
        { "mesh": 1, "extensions":
            { "EXT_mesh_gpu_instancing": { "attributes": { "SCALE": scales } } } },
        { "mesh": 0, "scale": [100, 1, 1] },
        { "mesh": 2, "skin": 0, "scale": [9, 9, 9] },
    ]);
    root["skins"] = json!([{ "joints": [0] }]);
    root["scenes"] = json!([{ "nodes": [0, 4] }, { "nodes": [3] }]);
    root["scene"] = json!(0);
    let scales = |root: &Value| -> Vec<f64> {
        sound(root).objects.iter().map(|o| o.info.world_scale).collect()
    };
    let near = |a: Vec<f64>, b: [f64; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
    // Nothing weights the third mesh to a joint, so that it follows its node.
    assert!(near(scales(&root), [6.0, 10.0, 9.0, 1.0]));
    root["scene"] = json!(1);
    assert!(near(scales(&root), [100.0, 1.0, 1.0, 1.0]));
    // Without a default scene the first one is shown.
    root.as_object_mut().expect("an object").remove("scene");
    assert!(near(scales(&root), [6.0, 10.0, 9.0, 1.0]));
}

#[test]
fn buffers_come_from_data_uris_of_either_kind() {
    let mut b = Builder::default();
    let p = b.zigzag(3);
    let bytes = b.buffer.clone();
    let mut root = b.with_meshes(&json!([{ "primitives": [{ "attributes": { "POSITION": p } }] }]));
    let percent: String = bytes.iter().map(|b| format!("%{b:02x}")).collect();
    for uri in [data_uri(&bytes), format!("data:,{percent}"), format!("DATA:;x=y,{percent}")] {
        root["buffers"][0]["uri"] = json!(uri);
        assert_eq!(sound(&root).objects.len(), 1, "{uri}");
    }
    root["buffers"][0]["uri"] = json!(data_uri(&bytes[1..]));
    assert_eq!(location(&root), (Fault::Malformed, "buffers[0]".to_owned()));
}
