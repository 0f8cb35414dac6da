//! Damages sound files by seeds: an import ends quickly, with a scene or an error.

use super::{Builder, read_bytes};
use crate::export::{ExportFormat, ExportObject, export};
use crate::import::ImportOptions;
use crate::testing::Random;
use serde_json::{Value, json};
use std::path::Path;

/// Damaged files of each test. Chosen by hand: about a minute.
const CASES: u64 = 20_000;

/// A document with something of each kind that is read.
fn seed_document() -> Value {
    let mut b = Builder::default();
    let p = b.zigzag(6);
    let i = b.indices(&[0, 1, 2, 2, 1, 3, 3, 4, 5]);
    let uv = b.floats("VEC2", 2, &[0.5; 12]);
    let joints = b.data(5121, "VEC4", 6, &[0; 24]);
    let weights = b.floats("VEC4", 4, &[0.25; 24]);
    let sparse_at = b.view(&[1, 0, 4, 0]);
    let sparse_values = b.view(&[0; 24]);
    let morph = b.accessor(json!({ "componentType": 5126, "count": 6, "type": "VEC3", "sparse": {
        "count": 2, "indices": { "bufferView": sparse_at, "componentType": 5123 },
        "values": { "bufferView": sparse_values },
    } }));
    let inverse = b.floats("MAT4", 16, &[1.0; 16]);
    let times = b.floats("SCALAR", 1, &[0.0, 1.0]);
    let mut stream = vec![0xa0];
    stream.extend([0; 8 + 24]);
    stream.extend([1; 8]);
    let packed = b.view(&stream);
    let offset = b.views[packed]["byteOffset"].clone();
    let packing = json!({ "buffer": 0, "byteOffset": offset, "byteLength": stream.len(),
        "byteStride": 8, "count": 6, "mode": "ATTRIBUTES", "filter": "OCTAHEDRAL" });
    b.views[packed] = json!({ "buffer": 0, "byteLength": 48, "byteStride": 8,
        "extensions": { "EXT_meshopt_compression": packing } });
    let normal = b.accessor(json!({
        "bufferView": packed, "componentType": 5122, "normalized": true, "count": 6,
        "type": "VEC3",
    }));
    let attributes = json!({ "POSITION": p, "TEXCOORD_0": uv, "JOINTS_0": joints,
        "WEIGHTS_0": weights, "NORMAL": normal });
    let primitive =
        json!({ "attributes": attributes, "indices": i, "targets": [{ "POSITION": morph }] });
    let plain = json!({ "attributes": { "POSITION": p }, "mode": 5, "material": 0 });
    let mut root = b.with_meshes(
        &json!([{ "primitives": [primitive, plain], "weights": [0.5] }, { "primitives": [plain] }]),
    );
    root["nodes"] = json!([
        { "mesh": 0, "skin": 0, "children": [1, 2], "scale": [1, 2, 3] },
        { "mesh": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] },
        { "mesh": 1, "extensions":
            { "EXT_mesh_gpu_instancing": { "attributes": { "SCALE": p } } } },
    ]);
    root["skins"] = json!([{ "joints": [1], "inverseBindMatrices": inverse }]);
    root["animations"] = json!([{ "samplers": [{ "input": times, "output": times }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }] }]);
    root["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    root["textures"] = json!([{ "source": 0 }]);
    root["images"] = json!([{ "uri": "data:image/png;base64,AQID" }]);
    root["scenes"] = json!([{ "nodes": [0] }]);
    root["extensionsUsed"] = json!(["EXT_meshopt_compression", "X_other"]);
    root
}

/// Imports, exports what was imported, and imports that; false if the first import fails.
fn survives(bytes: &[u8], case: &str) -> bool {
    let result = read_bytes(bytes, &ImportOptions::default());
    let sound = result.is_ok();
    if let Ok(scene) = result {
        let objects: Vec<ExportObject<'_>> =
            scene.objects.iter().map(|o| ExportObject { info: &o.info, mesh: &o.mesh }).collect();
        let files = export(Path::new("x.glb"), ExportFormat::Glb, &scene.document, &objects);
        if let Ok(files) = files {
            let again = read_bytes(&files[0].bytes, &ImportOptions::default());
            assert!(again.is_ok(), "{case}: {:?}", again.err());
        }
    }
    sound
}

/// Appends the paths of all values in a value, as lists of keys.
fn paths(value: &Value, path: &mut Vec<String>, out: &mut Vec<Vec<String>>) {
    out.push(path.clone());
    let mut below = |key: String, v: &Value| {
        path.push(key);
        paths(v, path, out);
        path.pop();
    };
    match value {
        Value::Array(a) => a.iter().enumerate().for_each(|(i, v)| below(i.to_string(), v)),
        Value::Object(o) => {
            o.iter().for_each(|(k, v)| below(k.replace('~', "~0").replace('/', "~1"), v));
        }
        _ => {}
    }
}

/// Another value in place of an old one.
fn replacement(random: &mut Random, old: &Value) -> Value {
    let number = old.as_u64().unwrap_or(1);
    match random.below(14) {
        0 => json!(number.wrapping_add(1)),
        1 => json!(number.wrapping_sub(1)),
        2 => json!(0),
        3 => json!(u64::MAX),
        4 => json!(1u64 << random.below(63)),
        5 => json!(-1),
        6 => json!(0.5),
        7 => Value::Null,
        8 => json!([]),
        9 => json!({}),
        10 => json!("POSITION"),
        11 => json!(true),
        12 => json!([old, old]),
        _ => json!(random.below(20)),
    }
}

#[test]
fn damaged_json_values_never_panic() {
    let seed = seed_document();
    assert!(survives(seed.to_string().as_bytes(), "the seed itself"));
    let mut all = Vec::new();
    paths(&seed, &mut Vec::new(), &mut all);
    let mut sound = 0;
    for case in 0..CASES {
        let mut random = Random(case);
        let mut root = seed.clone();
        for _ in 0..=random.below(3) {
            let path = &all[random.below(all.len())];
            if let Some(value) =
                root.pointer_mut(&path.iter().map(|p| format!("/{p}")).collect::<String>())
            {
                *value = replacement(&mut random, value);
            }
        }
        sound += u64::from(survives(root.to_string().as_bytes(), &format!("case {case}")));
    }
    // Both outcomes must occur, or the damage is too weak or too strong to say anything.
    assert!(sound > CASES / 50 && sound < CASES * 9 / 10, "{sound} of {CASES} were sound");
}

#[test]
fn damaged_glb_bytes_never_panic() {
    let scene = read_bytes(seed_document().to_string().as_bytes(), &ImportOptions::default())
        .expect("sound");
    let objects: Vec<ExportObject<'_>> =
        scene.objects.iter().map(|o| ExportObject { info: &o.info, mesh: &o.mesh }).collect();
    let files =
        export(Path::new("x.glb"), ExportFormat::Glb, &scene.document, &objects).expect("sound");
    for case in 0..CASES {
        let mut random = Random(case ^ 0x5eed);
        let mut bytes = files[0].bytes.clone();
        for _ in 0..=random.below(4) {
            let offset = random.below(bytes.len());
            match random.below(5) {
                0 => bytes[offset] ^= 1 << random.below(8),
                1 => bytes[offset] = random.next() as u8,
                2 => bytes.truncate(offset.max(1)),
                3 => bytes.insert(offset, random.next() as u8),
                _ => drop(bytes.remove(offset)),
            }
            if bytes.is_empty() {
                bytes.push(0);
            }
        }
        // Mend the header often, so that the damage gets past it.
        if random.below(4) > 0 && bytes.len() >= 12 {
            let length = (bytes.len() as u32).to_le_bytes();
            bytes[8..12].copy_from_slice(&length);
        }
        survives(&bytes, &format!("case {case}"));
    }
}
