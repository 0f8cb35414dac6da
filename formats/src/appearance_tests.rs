use super::*;
use crate::export::{ExportFormat, export};
use crate::images::png;
use crate::options::{ExportObject, ImportOptions};
use crate::testing::Scratch;
use crate::{Fault, GltfDocument, Limits, ObjDocument, ObjMaterial, SubmeshInfo, scene_graph};
use lodc_scene::{AlphaMode, Arrangement, Coordinates, Image, Placement, Texture, Wrap};

fn info(mesh: u32, material: Option<&str>) -> ObjectInfo {
    let submesh = SubmeshInfo {
        name: String::new(),
        material: material.map(str::to_owned),
        document_primitive: 0,
    };
    ObjectInfo {
        name: "o".to_owned(),
        submeshes: vec![submesh],
        world_scale: 1.0,
        document_mesh: mesh,
        poses: vec![],
    }
}

fn red() -> Vec<u8> {
    png(&Image { width: 2, height: 1, bytes: vec![255, 0, 0, 255, 0, 0, 0, 255] })
}

fn of_mtl(lines: &[&str], folder: &Scratch) -> Appearance {
    let material = ObjMaterial {
        name: "m".to_owned(),
        lines: lines.iter().map(|l| (*l).to_owned()).collect(),
    };
    let document =
        Document::Obj(ObjDocument { materials: vec![material], ..ObjDocument::default() });
    let mut assets = Assets::new(&folder.path("a.obj"), &[], Limits::DEFAULT);
    appearance(&document, &[&info(0, Some("m"))], &mut assets).expect("nothing can fail")
}

fn of_gltf(
    json: &str,
    blob: Vec<u8>,
    meshes: &[u32],
    folder: &Scratch,
) -> Result<Appearance, FormatError> {
    let document = Document::Gltf(GltfDocument::new(json.to_owned(), blob));
    let infos: Vec<ObjectInfo> = meshes.iter().map(|&m| info(m, None)).collect();
    let mut assets = Assets::new(&folder.path("a.gltf"), &[], Limits::DEFAULT);
    appearance(&document, &infos.iter().collect::<Vec<_>>(), &mut assets)
}

/// The objects of some meshes where a document shows them.
fn arranged(json: &str, blob: Vec<u8>, meshes: &[u32]) -> Result<Arrangement, FormatError> {
    let document = Document::Gltf(GltfDocument::new(json.to_owned(), blob));
    let infos: Vec<ObjectInfo> = meshes.iter().map(|&m| info(m, None)).collect();
    let infos: Vec<&ObjectInfo> = infos.iter().collect();
    let graph = scene_graph(&document, &infos, &Limits::DEFAULT)?;
    Ok(Arrangement::new(&graph, &graph.rest_pose(), infos.len()))
}

#[test]
fn an_mtl_gives_colours_opacity_and_textures() {
    let folder = Scratch::new("appearance-mtl");
    folder.write("in a/te xture.png", &red());
    let appearance = of_mtl(&["Kd 1 0.5 0", "d 0.25"], &folder);
    let material = &appearance.materials[appearance.of_submesh[0][0]];
    assert!(
        material.colour[0] == 1.0
            && (material.colour[1] - 0.214).abs() < 1e-3
            && material.colour[3] == 0.25
    );
    assert!(
        material.alpha == AlphaMode::Blend && material.double_sided && material.texture.is_none()
    );

    let appearance =
        of_mtl(&["Kd 0 0 0", "map_Kd -s 2 3 -clamp on -o 0.5 0 0 in a\\te xture.png"], &folder);
    let material = &appearance.materials[appearance.of_submesh[0][0]];
    let texture = material.texture.expect("a texture");
    assert_eq!(material.colour, [1.0; 4], "a black that a texture paints over");
    assert_eq!((texture.image, texture.wrap), (0, [Wrap::Clamp; 2]));
    // The bottom left corner of the coordinates is the bottom left of the picture.
    assert_eq!(texture.transform, [[2.0, 0.0, 0.5], [0.0, -3.0, 1.0]]);
    assert_eq!(material.coordinates, Coordinates { set: 0, transform: texture.transform });
    assert_eq!((appearance.images[0].width, appearance.images[0].height), (2, 1));
    assert!(appearance.warnings.is_empty(), "{:?}", appearance.warnings);
}

/// Exports the triangle of an OBJ with this material as another format, and reads that file.
fn exported(lines: &[&str], to: ExportFormat, folder: &Scratch) -> crate::Scene {
    folder.write("m.mtl", format!("newmtl m\n{}\n", lines.join("\n")).as_bytes());
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
    let text = format!("mtllib m.mtl\n{vertices}usemtl m\nf 1/1 2/2 3/3\n");
    folder.write("a.obj", text.as_bytes());
    let mut path = folder.path("a.obj");
    for (name, format) in [("b.gltf", ExportFormat::Gltf), ("c.obj", ExportFormat::Obj)] {
        let scene = crate::import::import(&path, &ImportOptions::default()).expect("sound");
        let objects = [ExportObject { info: &scene.objects[0].info, mesh: &scene.objects[0].mesh }];
        path = folder.path(name);
        for file in export(&path, format, &scene.document, &objects).expect("it can be written") {
            std::fs::write(&file.path, &file.bytes).expect("written");
        }
        if format == to {
            break;
        }
    }
    crate::import::import(&path, &ImportOptions::default()).expect("sound")
}

/// Where a corner of the triangle shows its picture, from the top left.
fn shown_at(scene: &crate::Scene, texture: &Texture, vertex: u32) -> [f32; 2] {
    let streams = scene.objects[0].mesh.attributes();
    let uv = streams.iter().find(|a| a.semantic == lodc_mesh::Semantic::TexCoord(0)).expect("uv");
    let [u, v] = [0, 1].map(|c| uv.value(vertex, c));
    texture.transform.map(|[by_u, by_v, moved]| by_u * u + by_v * v + moved)
}

#[test]
fn what_an_obj_shows_is_what_its_gltf_shows_and_an_obj_made_of_that() {
    let folder = Scratch::new("appearance-export");
    folder.write("a b.png", &red());
    folder.write("c.png", &red());
    for lines in [
        &["Kd 0.5 0.25 1", "map_Kd -s 2 3 -o 0.25 0.125 -clamp on a b.png"][..],
        &["map_Kd a b.png", "d 0.5"],
        &["Kd 0 0 0", "map_Kd -s -1 1 c.png", "d 0"],
        &["Kd 0.2 0.4 0.6"],
        &["Ks 1 1 1"],
    ] {
        let appearance = [None, Some(ExportFormat::Gltf), Some(ExportFormat::Obj)].map(|format| {
            let first = || crate::import::import(&folder.path("a.obj"), &ImportOptions::default());
            let written = exported(lines, format.unwrap_or(ExportFormat::Gltf), &folder);
            let scene = if format.is_some() { written } else { first().expect("sound") };
            let mut assets = Assets::new(&folder.path("a.obj"), &[], Limits::DEFAULT);
            let infos = [&scene.objects[0].info];
            let appearance = appearance(&scene.document, &infos, &mut assets).expect("sound");
            let material = appearance.materials[appearance.of_submesh[0][0]];
            let corners =
                material.texture.map(|t| (t.wrap, [0, 1, 2].map(|v| shown_at(&scene, &t, v))));
            (material.colour, material.alpha, corners)
        });
        let named = lines.iter().any(|line| line.starts_with("map_Kd"));
        assert_eq!(appearance[0].2.is_some(), named, "{lines:?}");
        for other in &appearance[1..] {
            let near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-5;
            assert!(appearance[0].0.iter().zip(&other.0).all(near), "{lines:?}: {appearance:?}");
            assert_eq!((appearance[0].1, &appearance[0].2), (other.1, &other.2), "{lines:?}");
        }
    }
}

#[test]
fn textures_that_cannot_be_had_are_warnings_and_none_is_read_from_elsewhere() {
    let folder = Scratch::new("appearance-missing");
    folder.write("outside.png", &red());
    folder.write("in/broken.png", b"\x89PNG but no picture");
    let inner = Scratch::new("appearance-missing/in");
    for (line, word) in [
        ("map_Kd missing.png", "missing.png"),
        ("map_Kd ../outside.png", "outside"),
        ("map_Kd http://127.0.0.1/x.png", "http"),
        ("map_Kd broken.png", "damaged"),
    ] {
        let appearance = of_mtl(&[line], &inner);
        assert!(
            appearance.images.is_empty() && appearance.materials[1].texture.is_none(),
            "{line}"
        );
        assert!(
            appearance.warnings.len() == 1 && appearance.warnings[0].contains(word),
            "{line}: {:?}",
            appearance.warnings
        );
    }
}

#[test]
fn a_gltf_material_is_read_with_its_sampler_and_transform() {
    let folder = Scratch::new("appearance-gltf");
    let blob = red();
    let json = serde_json::json!({
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [{"attributes": {}, "material": 1}]}],
        "materials": [{}, {
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.25, 1, 0.75],
                "baseColorTexture": {"index": 0, "texCoord": 3,
                    "extensions": {"KHR_texture_transform": {
                    "offset": [0.5, 0.25], "scale": [2, 4], "texCoord": 1}}}
            },
            "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
            "extensions": {"KHR_materials_unlit": {}}
        }],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}],
        "images": [{"bufferView": 0, "mimeType": "image/png"}],
        "bufferViews": [{"buffer": 0, "byteLength": blob.len()}],
        "buffers": [{"byteLength": blob.len()}]
    });
    let appearance = of_gltf(&json.to_string(), blob, &[0], &folder).expect("a document");
    let material = &appearance.materials[appearance.of_submesh[0][0]];
    assert_eq!(material.colour, [0.5, 0.25, 1.0, 0.75]);
    assert_eq!(
        (material.alpha, material.double_sided, material.unlit),
        (AlphaMode::Mask(0.25), true, true)
    );
    let wanted = Texture {
        image: 0,
        set: 1,
        transform: [[2.0, 0.0, 0.5], [0.0, 4.0, 0.25]],
        wrap: [Wrap::Clamp, Wrap::Mirror],
        nearest: true,
    };
    assert_eq!(material.texture, Some(wanted));
}

#[test]
fn nodes_joints_weights_and_instances_say_where_objects_are() {
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let mut bind = [0.0f32; 16];
    (0..4).for_each(|i| bind[5 * i] = 1.0);
    bind[12] = -1.0;
    let mut blob = floats(&bind);
    blob.extend(floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 2.0]));
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,4]}],
        "nodes":[{"translation":[1,0,0],"children":[1,2]},{"mesh":0,"weights":[0.5]},
            {"mesh":1,"skin":0},{"translation":[0,7,0]},{"mesh":2,"scale":[2,2,2],
                "extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":1}}}}],
        "skins":[{"joints":[3],"inverseBindMatrices":0}],
        "meshes":[{"primitives":[{"attributes":{}}]},{"primitives":[{"attributes":{}}]},
            {"primitives":[{"attributes":{}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":1,"type":"MAT4"},
            {"bufferView":1,"componentType":5126,"count":2,"type":"VEC3"}],
        "bufferViews":[{"buffer":0,"byteLength":64},{"buffer":0,"byteOffset":64,"byteLength":24}],
        "buffers":[{"byteLength":88}]}"#;
    let placements = arranged(json, blob, &[0, 1, 2]).expect("a document");
    let placements = placements.placements();
    let moved = |p: &Placement| p.transform.translation.to_array();
    let objects: Vec<usize> = placements.iter().map(|p| p.object).collect();
    assert_eq!(objects, [0, 1, 2, 2]);
    assert_eq!((moved(&placements[0]), &placements[0].weights[..]), ([1.0, 0.0, 0.0], &[0.5][..]));
    assert_eq!(
        placements[1].joints[0].translation.to_array(),
        [-1.0, 7.0, 0.0],
        "the joint, whatever the node says"
    );
    assert_eq!((moved(&placements[2]), moved(&placements[3])), ([0.0, 0.0, 2.0], [0.0, 0.0, 4.0]));
}

#[test]
fn a_document_that_lies_is_refused_without_a_panic() {
    let folder = Scratch::new("appearance-lies");
    for json in [
        "",
        "[]",
        r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":9}],
            "bufferViews":[{"buffer":0,"byteLength":9}]}"#,
        r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[7]}],"scene":0}"#,
        r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":3}]}"#,
    ] {
        assert!(of_gltf(json, Vec::new(), &[0], &folder).is_err(), "{json}");
        assert!(arranged(json, Vec::new(), &[0]).is_err(), "{json}");
    }
    // Loops of nodes end.
    let loops = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "meshes":[{"primitives":[{"attributes":{}}]}],
        "nodes":[{"mesh":0,"children":[1]},{"children":[0]}]}"#;
    assert_eq!(arranged(loops, Vec::new(), &[0]).map(|a| a.placements().len()), Ok(1));
}

#[test]
fn an_image_is_decoded_once_however_often_it_is_there_and_pixels_have_a_limit() {
    let folder = Scratch::new("appearance-shared");
    let one = red();
    let blob = [one.as_slice(), &png(&Image { width: 1, height: 1, bytes: vec![9; 4] })].concat();
    let texture =
        |i: usize| serde_json::json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}});
    let primitive = |m: usize| serde_json::json!({"attributes": {}, "material": m});
    let image = |view: usize| serde_json::json!({"bufferView": view, "mimeType": "image/png"});
    let list = |of: &dyn Fn(usize) -> serde_json::Value| (0..4).map(of).collect::<Vec<_>>();
    let json = serde_json::json!({
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": (list(&primitive))}],
        "materials": (list(&texture)),
        "textures": (list(&|i| serde_json::json!({"source": i}))),
        "images": (list(&|i| image(usize::from(i == 2)))),
        "bufferViews": [
            {"buffer": 0, "byteLength": one.len()},
            {"buffer": 0, "byteOffset": one.len(), "byteLength": blob.len() - one.len()}
        ],
        "buffers": [{"byteLength": blob.len()}]
    });
    let object = ObjectInfo {
        submeshes: (0..4)
            .map(|p| SubmeshInfo { document_primitive: p, ..info(0, None).submeshes[0].clone() })
            .collect(),
        ..info(0, None)
    };
    let document = Document::Gltf(GltfDocument::new(json.to_string(), blob));
    let within = |pixels| {
        let limits = Limits { pixels, ..Limits::DEFAULT };
        let mut assets = Assets::new(&folder.path("a.gltf"), &[], limits);
        appearance(&document, &[&object], &mut assets)
    };
    // Two pixels and one.
    let appearance = within(3).expect("as many as are allowed");
    assert!(
        appearance.warnings.is_empty() && appearance.images.len() == 2,
        "{:?}",
        appearance.warnings
    );
    let shown =
        appearance.of_submesh[0].iter().map(|&m| appearance.materials[m].texture.map(|t| t.image));
    assert_eq!(shown.collect::<Vec<_>>(), [Some(0), Some(0), Some(1), Some(0)]);
    for pixels in [0, 2] {
        let error = within(pixels).expect_err("more pixels than are allowed");
        assert_eq!((error.fault, error.location.is_empty()), (Fault::Limit, false), "{error}");
    }
}
