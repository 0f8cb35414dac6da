//! Triangles come right behind the head, and a prefix leaves out what has not come.

use super::*;
use crate::export::{ExportFormat, ExportObject, export};
use crate::gltf::read::tests::read_bytes;
use crate::import::ImportOptions;
use crate::lods::Progress;
use lodc_fixtures as fixtures;
use serde_json::{Value, json};
use std::path::Path;

/// Returns the end of a stream's head, and the bytes after which there are triangles.
pub(super) fn first_triangles(bytes: &[u8]) -> [usize; 2] {
    let mut unpacker = Unpacker::new(Limits::DEFAULT);
    let (mut start, mut head) = (0, 0);
    for end in ends(bytes) {
        unpacker.feed(&bytes[start..end]).expect("a sound stream");
        start = end;
        if unpacker.progress_of_all(|p| p.vertices[0]) == 0 {
            head = end;
        } else if unpacker.progress_of_all(|p| p.triangles[0]) > 0 {
            return [head, end];
        }
    }
    panic!("no triangles at all")
}

impl Unpacker {
    /// The sum of something over all objects so far.
    fn progress_of_all(&self, of: fn(Progress) -> u32) -> u32 {
        (0..self.objects()).map(|object| of(self.progress(object))).sum()
    }
}

#[test]
fn triangles_come_within_a_few_hundred_bytes_of_a_small_head() {
    for (name, make) in fixtures::ALL {
        let mesh = make();
        if mesh.triangles().is_empty() {
            continue;
        }
        let simplified =
            lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {});
        let mut file = gltf(vec![object(name, simplified)]);
        let Document::Gltf(document) = &mut file.document else { unreachable!("made above") };
        let blob = (0..40_000u32).map(|i| ((i * i) >> 7) as u8).collect();
        *document = GltfDocument::new(document.json().to_owned(), blob);
        let packed = pack(&file, &PackOptions::default()).expect("a sound file");
        let [head, first] = first_triangles(&packed.bytes);
        assert!(first <= head + 600, "{name}: {first} bytes before its first triangles");
        assert!(20 * head <= packed.bytes.len(), "{name}: {head} of {}", packed.bytes.len());
        assert!(fed(&packed.bytes).is_complete());
    }
}

/// A document whose texture, skin and animations lie one after the other in its buffer.
fn rigged(mesh: &lodc_mesh::Mesh) -> GltfDocument {
    let view =
        |start: usize, size: usize| json!({ "buffer": 0, "byteOffset": start, "byteLength": size });
    let accessor = |view: usize, count: usize, kind: &str| {
        let mut accessor = json!({ "componentType": 5126, "count": count, "type": kind });
        accessor["bufferView"] = view.into();
        accessor
    };
    let primitives: Vec<Value> =
        mesh.submeshes().iter().map(|_| json!({ "material": 0 })).collect();
    let channel = |path: &str| json!({ "sampler": 0, "target": { "node": 1, "path": path } });
    let animation = |output: usize, path: &str| {
        let samplers = json!([{ "input": 1, "output": output }]);
        json!({ "samplers": samplers, "channels": [channel(path)] })
    };
    let mut times = accessor(2, 10, "SCALAR");
    (times["min"], times["max"]) = (json!([0.0]), json!([9.0]));
    let root = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [{ "mesh": 0, "skin": 0 }, { "name": "joint" }],
        "meshes": [{ "primitives": primitives }],
        "materials": [{
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
            "extensions": { "KHR_materials_clearcoat": { "clearcoatTexture": { "index": 0 } } }
        }],
        "extensionsUsed": ["KHR_materials_clearcoat"],
        "textures": [{ "source": 0 }],
        "images": [{ "bufferView": 1, "mimeType": "image/png" }],
        "skins": [{ "joints": [1], "inverseBindMatrices": 0 }],
        "animations": [animation(2, "translation"), animation(3, "rotation")],
        "accessors": [
            accessor(0, 1, "MAT4"), times, accessor(3, 10, "VEC3"), accessor(4, 10, "VEC4")
        ],
        "bufferViews": [
            view(0, 64), view(64, 3000), view(3064, 40), view(3104, 120), view(3224, 160)
        ],
        "buffers": [{ "byteLength": 4000 }],
    });
    let blob = (0..4000u32).map(|i| ((i * i) >> 5) as u8).collect();
    GltfDocument::new(root.to_string(), blob)
}

/// A rigged tube.
fn tube() -> LodFile {
    let mesh = fixtures::skinned_tube(lodc_mesh::Component::U8);
    let mut file = gltf(vec![object("tube", fixtures::random_collapse(&mesh, 1))]);
    file.objects[0].info.document_mesh = 0;
    file.document = Document::Gltf(rigged(&mesh));
    file
}

#[test]
fn a_rig_shows_and_stands_early_is_painted_after_a_tenth_and_moves_in_the_end() {
    let packed = pack(&tube(), &PackOptions::default()).expect("a sound file");
    let [head, first] = first_triangles(&packed.bytes);
    assert!(head < 100 && first <= head + 300, "{head} {first}");
    // Behind a twentieth of the stream, the text at once.
    let named = |&end: &usize| fed(&packed.bytes[..end]).text().is_some();
    let named = ends(&packed.bytes).into_iter().find(named).expect("a text");
    let before = ends(&packed.bytes).into_iter().rfind(|&end| end < named).expect("triangles");
    assert!(before <= packed.bytes.len() / 20 + 200, "{before} {first} {named}");
    let (mut painted, mut moves) = (None, None);
    for end in ends(&packed.bytes).into_iter().filter(|&end| end >= named) {
        let unpacker = fed(&packed.bytes[..end]);
        let arrived = unpacker.arrived().expect("a sound document").expect("a head");
        let Document::Gltf(gltf) = &*arrived.document else { panic!("a glTF") };
        let root: Value = serde_json::from_str(gltf.json()).expect("JSON");
        assert_eq!(
            (&root["nodes"][0]["skin"], &root["nodes"][1]["name"]),
            (&json!(0), &json!("joint"))
        );
        // The matrix is at its place among the bytes that have come.
        let view = &root["bufferViews"][0];
        let offset = view["byteOffset"].as_u64().unwrap_or(0) as usize;
        let wanted: Vec<u8> = (0..64u32).map(|i| ((i * i) >> 5) as u8).collect();
        assert!(gltf.blob()[offset..offset + 64] == wanted, "{end} bytes");
        let triangles = unpacker.progress(0).triangles;
        if painted.is_none() && root["textures"][0]["source"].is_number() {
            painted = Some(triangles);
        }
        if moves.is_none() && root["animations"][0].is_object() {
            moves = Some(triangles);
        }
    }
    let [some, all] = painted.expect("a texture comes");
    assert!(10 * some >= all, "painted at {some} of {all}");
    assert_eq!(moves.expect("animations come"), [all, all], "they come last");
}

#[test]
fn a_scene_that_is_cut_anywhere_is_what_its_whole_blocks_are() {
    let packed = pack(&tube(), &PackOptions::default()).expect("a sound file");
    let state = |unpacker: &Unpacker| {
        let progress = (unpacker.objects() > 0).then(|| unpacker.progress(0));
        (unpacker.bytes(), unpacker.document_bytes(), progress, unpacker.is_complete())
    };
    let mut growing = Unpacker::new(Limits::DEFAULT);
    let (mut whole, mut states) = (0, Vec::new());
    for end in ends(&packed.bytes) {
        growing.feed(&packed.bytes[whole..end]).expect("a sound stream");
        whole = end;
        states.push((end, state(&growing)));
    }
    let mut by_byte = Unpacker::new(Limits::DEFAULT);
    for cut in 0..=packed.bytes.len() {
        let before = states.iter().rfind(|(end, _)| *end <= cut);
        let expected = before.map_or((0, [0; 2], None, false), |(_, state)| *state);
        if let Some(last) = cut.checked_sub(1) {
            by_byte.feed(&packed.bytes[last..cut]).expect("a sound stream");
        }
        assert_eq!(state(&by_byte), expected, "{cut} bytes, one at a time");
        if cut % 7 == 0 {
            assert_eq!(state(&fed(&packed.bytes[..cut])), expected, "{cut} bytes at once");
        }
    }
}

#[test]
fn a_prefix_leaves_out_what_has_not_come_and_is_valid() {
    let file = tube();
    let packed = pack(&file, &PackOptions::default()).expect("a sound file");
    let mut seen = Vec::new();
    for end in ends(&packed.bytes).into_iter().skip(1) {
        let unpacker = fed(&packed.bytes[..end]);
        let arrived = unpacker.arrived().expect("a sound document").expect("a head");
        assert!(unpacker.document().is_none() || arrived.left_out.is_empty());
        let meshes: Vec<_> =
            (0..unpacker.objects()).map(|i| unpacker.mesh(i).expect("a mesh").0).collect();
        let objects: Vec<_> = (arrived.infos.iter().zip(&meshes))
            .map(|(info, mesh)| ExportObject { info, mesh })
            .collect();
        let written = |name: &str, format| {
            let files = export(Path::new(name), format, &arrived.document, &objects);
            files.unwrap_or_else(|e| panic!("{end} bytes as {name}: {e}")).remove(0).bytes
        };
        let glb = written("a.glb", ExportFormat::Glb);
        // These show the rest pose, which asks for what the document says of skins.
        written("a.obj", ExportFormat::Obj);
        written("a.ply", ExportFormat::Ply);
        if meshes.iter().any(|m| !m.triangles().is_empty()) {
            read_bytes(&glb, &ImportOptions::default()).expect("it can be read again");
            gltf_crate(&glb);
        }
        if seen.last() != Some(&arrived.left_out) {
            seen.push(arrived.left_out);
        }
    }
    let all = ["names, nodes, materials, textures, skins and animations"];
    assert_eq!(seen.first().expect("at least one"), &all, "{seen:?}");
    for left_out in [&["1 texture", "2 animations"][..], &["2 animations"]] {
        let left_out: Vec<String> = left_out.iter().map(|&s| s.to_owned()).collect();
        assert!(seen.contains(&left_out), "{seen:?}");
    }
    assert_eq!(seen.last(), Some(&Vec::new()), "{seen:?}");
}

/// Asserts that an independent reader takes a file as valid.
fn gltf_crate(glb: &[u8]) {
    let document = ::gltf::Gltf::from_slice(glb).expect("valid glTF");
    let length = document.blob.as_ref().map_or(0, Vec::len);
    assert!(document.views().all(|v| v.offset() + v.length() <= length));
}
