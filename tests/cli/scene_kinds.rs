//! Small scenes of every kind: what `chain` makes of them in every way is accepted, and vertices
//! that primitives share stay shared.

use crate::placements::Scene;
use crate::scenes::{add_skin, add_targets, lathe, moving_weights, number_of, vertices};
use crate::support::{Folder, glb_document};
use serde_json::{Value, json};

/// A rock whose triangles belong to materials by turns, all over one vertex buffer.
fn scattered(rows: usize, materials: usize) -> Scene {
    let mut scene = Scene::of_rocks(&[rows]);
    let vertices = vertices(&scene, 0);
    let coordinates: Vec<f32> = (0..2 * vertices).map(|i| (i % 97) as f32 / 97.0).collect();
    let coordinates = scene.floats(&coordinates, "VEC2");
    let whole = scene.meshes[0]["primitives"][0].clone();
    let indices = whole["indices"].as_u64().expect("an accessor") as usize;
    let view = scene.accessors[indices]["bufferView"].as_u64().expect("a view") as usize;
    let start = scene.views[view]["byteOffset"].as_u64().expect("an offset") as usize;
    let corners = number_of(&scene, indices);
    let triangles: Vec<Vec<u8>> =
        scene.bytes[start..start + 4 * corners].chunks(12).map(<[u8]>::to_vec).collect();
    let of_material = |m: usize| -> Vec<u8> {
        let own = triangles.iter().enumerate().filter(|(t, _)| t * 7 % 11 % materials == m);
        own.flat_map(|(_, t)| t.clone()).collect()
    };
    let primitives: Vec<Value> = (0..materials)
        .map(|m| {
            let bytes = of_material(m);
            let mut primitive = whole.clone();
            primitive["attributes"]["TEXCOORD_0"] = coordinates.into();
            primitive["indices"] = scene.accessor(&bytes, 5125, bytes.len() / 4, "SCALAR").into();
            primitive["material"] = m.into();
            primitive
        })
        .collect();
    scene.meshes[0]["primitives"] = primitives.into();
    scene
}

fn materials(count: usize) -> Value {
    (0..count).map(|m| json!({"name": format!("m{m}")})).collect()
}

#[test]
fn primitives_over_one_vertex_buffer_stay_so() {
    let f = Folder::new();
    let more = json!({"nodes": [{"mesh": 0}], "materials": materials(6)});
    f.file("s.gltf", scattered(48, 6).file(&[0], &more));
    let extract = |ratio: &str| {
        let output = format!("{ratio}.glb");
        f.lodc(["extract", "s.gltf", "--ratio", ratio, "-o", &output, "-q"]).ends(0);
        f.lodc(["verify", &output, "--source", "s.gltf"]).ends(0);
        glb_document(&f.read(&output))
    };
    let (_, all) = extract("100%");
    for (ratio, share) in [("50%", 0.5), ("25%", 0.25), ("10%", 0.1)] {
        let (root, bytes) = extract(ratio);
        assert!(bytes.len() as f64 <= 1.1 * share * all.len() as f64, "{ratio}: {}", bytes.len());
        let primitives = root["meshes"][0]["primitives"].as_array().expect("primitives");
        assert_eq!(primitives.len(), 6);
        assert!(primitives.iter().all(|p| p["attributes"] == primitives[0]["attributes"]));
    }
    // A chain has the vertices of its finest level, and the triangles of all.
    f.lodc(["chain", "s.gltf", "--levels", "100%,50%,25%,10%", "-o", "c.glb", "-q"]).ends(0);
    f.lodc(["verify", "c.glb", "--source", "s.gltf"]).ends(0);
    let (_, chain) = glb_document(&f.read("c.glb"));
    assert!(chain.len() as f64 <= 1.8 * all.len() as f64, "{} of {}", chain.len(), all.len());
}

#[test]
fn meshes_over_the_same_accessors_stay_so() {
    let f = Folder::new();
    let mut scene = Scene::of_rocks(&[24]);
    let whole = scene.meshes[0].clone();
    for material in 0..4 {
        let mut mesh = whole.clone();
        mesh["primitives"][0]["material"] = material.into();
        scene.meshes.push(mesh);
    }
    let nodes: Vec<Value> =
        (0..5).map(|i| json!({"mesh": i, "translation": [3 * i, 0, 0]})).collect();
    let more = json!({"nodes": nodes, "materials": materials(4)});
    f.file("s.gltf", scene.file(&[0, 1, 2, 3, 4], &more));
    for (ratio, share) in [("100%", 1.0), ("25%", 0.25)] {
        f.lodc(["extract", "s.gltf", "--ratio", ratio, "-o", "x.glb", "-q"]).ends(0);
        f.lodc(["verify", "x.glb", "--source", "s.gltf"]).ends(0);
        let (_, bytes) = glb_document(&f.read("x.glb"));
        let wanted = 1.1 * share * scene.bytes.len() as f64;
        assert!(bytes.len() as f64 <= wanted, "{ratio}: {}", bytes.len());
    }
}

/// What every way of `chain` writes of a mesh of many materials has few more bytes than that of the
/// same mesh of one: also where each level moves to the next.
#[test]
fn chains_of_many_materials_are_as_small_as_those_of_one() {
    let ways: [&[&str]; 3] = [&[], &["--geomorph"], &["--geomorph", "--quantize", "pos=14"]];
    for way in ways {
        let [one, six] = [1, 6].map(|count| {
            let f = Folder::new();
            let more = json!({"nodes": [{"mesh": 0}], "materials": materials(count)});
            f.file("s.gltf", scattered(48, count).file(&[0], &more));
            let levels = ["--levels", "100%,50%,25%,10%", "-o", "c.glb", "-q"];
            f.lodc(["chain", "s.gltf"].iter().chain(&levels).chain(way)).ends(0);
            f.lodc(["verify", "c.glb", "--source", "s.gltf"]).ends(0);
            glb_document(&f.read("c.glb")).1.len()
        });
        assert!(six as f64 <= 1.1 * one as f64, "{way:?}: {six} bytes, {one} of one material");
    }
}

#[test]
fn levels_of_meshes_that_no_node_shows_are_not_carried_along() {
    let f = Folder::new();
    f.file("none.gltf", Scene::of_rocks(&[8]).file(&[], &json!({})).replace("\"nodes\":[]", ""));
    let refused = f.lodc(["chain", "none.gltf", "-o", "c.glb"]).ends(3);
    assert!(refused.err.contains("no node shows a mesh"), "{}", refused.err);
    f.lodc(["chain", "none.gltf", "--index-ranges", "-o", "c.glb", "-q"]).ends(0);
    f.lodc(["verify", "c.glb", "--source", "none.gltf"]).ends(0);
    f.file("s.gltf", Scene::of_rocks(&[8, 20]).file(&[0], &json!({"nodes": [{"mesh": 0}]})));
    for way in [&[][..], &["--geomorph"]] {
        f.lodc(["chain", "s.gltf", "-o", "c.glb", "-q"].iter().chain(way)).ends(0);
        f.lodc(["verify", "c.glb", "--source", "s.gltf"]).ends(0);
        let (root, _) = glb_document(&f.read("c.glb"));
        let accessors = root["accessors"].as_array().expect("accessors").len();
        let text = root["meshes"].to_string();
        let named =
            |a: usize| [",", "}", "]"].iter().any(|end| text.contains(&format!(":{a}{end}")));
        assert!((0..accessors).all(named), "{way:?}: {root}");
    }
}

/// Scenes of every kind, small.
fn kinds() -> Vec<(&'static str, String)> {
    let node = || json!({"nodes": [{"mesh": 0}]});
    let mut morphing = Scene::of_rocks(&[10]);
    add_targets(&mut morphing, 3);
    let animations = moving_weights(&mut morphing, 3);
    let mut skinned = Scene::of_rocks(&[10]);
    let skins = add_skin(&mut skinned, 4, 2);
    let joints = (0..4).map(|j| json!({"translation": [0.1 * f64::from(j), 0.0, 0.2]}));
    let bones: Vec<Value> = std::iter::once(json!({"mesh": 0, "skin": 0})).chain(joints).collect();
    let scales: Vec<Value> = [0.01, 1.0, 100.0]
        .iter()
        .enumerate()
        .map(|(i, &s)| json!({"mesh": i, "scale": [s, -s, s], "translation": [300 * i, 0, 0]}))
        .collect();
    let instances: Vec<Value> =
        (0..40).map(|i| json!({"mesh": 0, "translation": [3 * i, 0, 0]})).collect();
    let all: Vec<usize> = (0..40).collect();
    let hidden = json!({"nodes": [{"mesh": 0}, {"mesh": 1, "scale": [0, 0, 0]}]});
    let sheared = json!({"nodes": [{"scale": [1, 5, 1], "children": [1]},
        {"mesh": 0, "rotation": [0.0, 0.0, 0.382_683_4, 0.923_879_5]}]});
    vec![
        ("seam", lathe(14, 12)),
        ("cards", cards(200)),
        ("strips and fans", strips_and_fans()),
        ("materials", {
            let more = json!({"nodes": [{"mesh": 0}], "materials": materials(4)});
            scattered(12, 4).file(&[0], &more)
        }),
        ("morphing", {
            let more = json!({"nodes": [{"mesh": 0}], "animations": animations});
            morphing.file(&[0], &more)
        }),
        ("two weights", {
            let mut scene = Scene::of_rocks(&[10]);
            add_targets(&mut scene, 4);
            let nodes = json!([{"mesh": 0, "weights": [1, 1, 1, 1]},
                {"mesh": 0, "weights": [0, 0.2, 0, 0.2], "translation": [4, 0, 0]}]);
            scene.file(&[0, 1], &json!({"nodes": nodes}))
        }),
        ("skinned", { skinned.file(&[0, 1, 2, 3, 4], &json!({"nodes": bones, "skins": skins})) }),
        ("scales", Scene::of_rocks(&[6, 8, 10]).file(&[0, 1, 2], &json!({"nodes": scales}))),
        ("instances", Scene::of_rocks(&[8]).file(&all, &json!({"nodes": instances}))),
        ("hidden", Scene::of_rocks(&[8, 9]).file(&[0], &hidden)),
        ("no size", Scene::of_rocks(&[8, 9]).file(&[0, 1], &hidden)),
        ("sheared", Scene::of_rocks(&[10]).file(&[0], &sheared)),
        ("nothing shown", Scene::of_rocks(&[8]).file(&[1], &json!({"nodes": [{"mesh": 0}, {}]}))),
        ("many meshes", {
            let nodes: Vec<Value> = (0..30).map(|i| json!({"mesh": i})).collect();
            let roots: Vec<usize> = (0..30).collect();
            Scene::of_rocks(&[4; 30]).file(&roots, &json!({"nodes": nodes}))
        }),
        ("plain", Scene::of_rocks(&[16]).file(&[0], &node())),
    ]
}

/// A rock of a strip and two fans, with lines and points, all over the same vertices.
fn strips_and_fans() -> String {
    let mut scene = Scene::of_rocks(&[10]);
    let whole = scene.meshes[0]["primitives"][0].clone();
    // Rows have twenty vertices, behind the top.
    let row = |r: u32| (0..=20).map(move |c| 1 + 20 * r + c % 20);
    let mut strip: Vec<u32> = Vec::new();
    for r in 0..8 {
        let between: Vec<u32> = row(r + 1).zip(row(r)).flat_map(|(a, b)| [a, b]).collect();
        if let Some(&last) = strip.last() {
            strip.extend([last, between[0]]);
        }
        strip.extend(between);
    }
    let last = vertices(&scene, 0) as u32 - 1;
    let rim: Vec<u32> = row(0).collect();
    let top: Vec<u32> = std::iter::once(0).chain(rim.into_iter().rev()).collect();
    let bottom: Vec<u32> = std::iter::once(last).chain(row(8)).collect();
    let lines: Vec<u32> = row(3).collect();
    let mut primitives = Vec::new();
    for (mode, corners) in [(5, &strip), (6, &top), (6, &bottom), (3, &lines), (0, &lines)] {
        let bytes: Vec<u8> = corners.iter().flat_map(|i| i.to_le_bytes()).collect();
        let mut primitive = whole.clone();
        primitive["mode"] = mode.into();
        primitive["indices"] = scene.accessor(&bytes, 5125, corners.len(), "SCALAR").into();
        primitives.push(primitive);
    }
    scene.meshes[0]["primitives"] = primitives.into();
    scene.file(&[0], &json!({"nodes": [{"mesh": 0}]}))
}

/// Cards of two triangles each, turned anyhow.
fn cards(count: usize) -> String {
    let mut scene = Scene::default();
    let (mut points, mut corners): (Vec<f32>, Vec<u32>) = Default::default();
    for i in 0..count {
        let angle = i as f32 * 2.4;
        let radius = (i as f32 / count as f32).sqrt();
        let at = [radius * angle.cos(), radius * angle.sin(), (i % 7) as f32 * 0.1];
        let [right, up] = [[0.05, 0.0, 0.02], [0.02 * angle.sin(), 0.05, 0.05 * angle.cos()]];
        for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
            points.extend((0..3).map(|k| at[k] + x * right[k] + y * up[k]));
        }
        let first = 4 * i as u32;
        corners.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
    }
    scene.mesh("cards", &points, &corners);
    scene.file(&[0], &json!({"nodes": [{"mesh": 0}]}))
}

#[test]
fn chains_of_every_kind_made_in_every_way_are_accepted() {
    let ways: [&[&str]; 6] = [
        &[],
        &["--geomorph"],
        &["--separate"],
        &["--separate", "--geomorph"],
        &["--quantize", "pos=14,normal=8,uv=12,weight=8"],
        &["--compress", "meshopt", "--quantize", "pos=12"],
    ];
    for (kind, file) in kinds() {
        for way in ways {
            let f = Folder::new();
            f.file("s.gltf", &file);
            let run = f.lodc(["chain", "s.gltf", "-q", "-o", "c.glb"].iter().chain(way));
            assert_eq!(run.status, Some(0), "{kind} {way:?}: {}", run.err);
            for output in f.names().iter().filter(|name| name.ends_with(".glb")) {
                let run = f.lodc(["verify", output, "--source", "s.gltf"]);
                let said = run.text();
                assert_eq!(run.status, Some(0), "{kind} {way:?} {output}: {said}{}", run.err);
            }
        }
    }
}
