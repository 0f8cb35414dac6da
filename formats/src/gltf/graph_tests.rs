use super::*;
use crate::Scene;
use crate::export::{ExportFormat, ExportObject, export};
use crate::gltf::read::tests::{Builder, sound};
use lodc_scene::{Motion, posed_positions};
use serde_json::json;
use std::path::Path;

/// A rig as game models have them: modelled 100 times too large, bound to bones that bring it back,
/// with a control bone 105 times as large to which nothing is weighted, under a node that joints
/// make meaningless. A morph target lifts it by default.
fn rigged() -> Scene {
    let mut b = Builder::default();
    let triangle = [0.0, 0.0, 0.0, 100.0, 0.0, 0.0, 0.0, 100.0, 0.0];
    let positions = b.floats("VEC3", 3, &triangle);
    let lift = b.floats("VEC3", 3, &[0.0, 0.0, 100.0].repeat(3));
    let joints = b.data(5121, "VEC4", 3, &[0, 1, 2, 2].repeat(3));
    let weights = [0.75, 0.25, 0.0, 0.0].repeat(3);
    let weights = b.floats("VEC4", 4, &weights);
    let mut bind = [0.0f32; 16];
    (0..4).for_each(|i| bind[5 * i] = 1.0);
    let bind = b.floats("MAT4", 16, &bind.repeat(3));
    let attributes = json!({ "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights });
    let primitive = json!({ "attributes": attributes, "targets": [{ "POSITION": lift }] });
    let mut root = b.with_meshes(&json!([{ "primitives": [primitive], "weights": [0.5] }]));
    root["nodes"] = json!([
        { "mesh": 0, "skin": 0, "scale": [7, 7, 7], "name": "figure" },
        { "scale": [0.01, 0.01, 0.01], "translation": [2, 0, 0] },
        { "scale": [0.01, 0.01, 0.01], "translation": [6, 0, 0] },
        { "scale": [1.05, 1.05, 1.05] },
    ]);
    root["skins"] = json!([{ "joints": [1, 2, 3], "inverseBindMatrices": bind }]);
    root["scenes"] = json!([{ "nodes": [0, 1, 2, 3] }]);
    sound(&root)
}

/// Corners of the triangle as the rig shows it: moved by a blend of both bones, lifted by half.
const SHOWN: [[f64; 3]; 3] = [[3.0, 0.0, 0.5], [4.0, 0.0, 0.5], [3.0, 1.0, 0.5]];

#[test]
fn a_rigged_object_has_the_scale_of_the_joints_that_move_it() {
    let scene = rigged();
    let object = &scene.objects[0];
    assert!((object.info.world_scale - 0.01).abs() < 1e-12, "{}", object.info.world_scale);
    // The stored document says the same as the one that was read.
    let graph = scene_graph(&scene.document, &[&object.info], &Limits::DEFAULT);
    let graph = graph.expect("a sound document");
    let motion = Motion::new(graph, Vec::new(), 1);
    let measured = motion.measured_placements(&object.mesh, 0);
    assert_eq!(measured.scale, object.info.world_scale);
    let positions = posed_positions(&object.mesh, &measured.placements[0].placement);
    for (found, wanted) in positions.iter().zip(SHOWN) {
        assert!(found.abs_diff_eq(wanted.into(), 1e-6), "{found} {wanted:?}");
    }
}

#[test]
fn formats_without_nodes_get_the_object_as_the_scene_shows_it() {
    let scene = rigged();
    let object = ExportObject { info: &scene.objects[0].info, mesh: &scene.objects[0].mesh };
    let files = export(Path::new("a.obj"), ExportFormat::Obj, &scene.document, &[object]);
    let text = String::from_utf8(files.expect("an OBJ")[0].bytes.clone()).expect("text");
    let vertices = text.lines().filter_map(|l| l.strip_prefix("v "));
    let found: Vec<Vec<f64>> =
        vertices.map(|l| l.split(' ').map(|n| n.parse().expect("a number")).collect()).collect();
    assert!(text.contains("o figure"), "{text}");
    assert_eq!(found.len(), 3);
    for (found, wanted) in found.iter().zip(SHOWN) {
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
}
