use super::*;
use crate::gltf::read::tests::{Builder, sound};
use serde_json::{Value, json};

/// A triangle whose node moves along x within a second; `times` are the keys'.
fn moving(times: &[f32]) -> Value {
    let mut b = Builder::default();
    let positions = b.floats("VEC3", 3, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let input = b.floats("SCALAR", 1, times);
    let output = b.floats("VEC3", 3, &[0.0, 0.0, 0.0, 10.0, 0.0, 0.0]);
    let primitive = json!({ "attributes": { "POSITION": positions } });
    let mut root = b.with_meshes(&json!([{ "primitives": [primitive] }]));
    root["nodes"] = json!([{ "mesh": 0 }]);
    root["scenes"] = json!([{ "nodes": [0] }]);
    let moves = json!({ "sampler": 0, "target": { "node": 0, "path": "translation" } });
    let other = json!({ "sampler": 0, "target": { "node": 0, "path": "pointer" } });
    root["animations"] = json!([
        { "channels": [], "samplers": [] },
        { "name": "go", "channels": [moves, other],
          "samplers": [{ "input": input, "output": output }] },
    ]);
    root
}

#[test]
fn animations_are_read_by_number_and_what_moves_no_node_is_left_out() {
    let scene = sound(&moving(&[0.0, 1.0]));
    let names = animation_names(&scene.document, &Limits::DEFAULT).expect("a sound document");
    assert_eq!(names, ["", "go"]);
    let found = animation(&scene.document, 1, &Limits::DEFAULT).expect("an animation");
    assert_eq!((found.channels.len(), found.duration()), (1, 1.0));
    assert_eq!(found.channels[0].at(0.25), Some(vec![2.5, 0.0, 0.0]));
    let missing = animation(&scene.document, 2, &Limits::DEFAULT).expect_err("no such animation");
    assert!(missing.to_string().contains("animations[2]"), "{missing}");
}

#[test]
fn keys_out_of_order_or_without_values_are_damage() {
    for times in [&[1.0, 1.0][..], &[1.0, 0.5], &[0.0, 1.0, 2.0], &[0.0, f32::NAN]] {
        let scene = sound(&moving(times));
        let wrong = animation(&scene.document, 1, &Limits::DEFAULT).expect_err("damage");
        assert!(wrong.to_string().contains("animations[1].channels[0]"), "{times:?}: {wrong}");
    }
}

#[test]
fn pointers_move_nodes_and_the_weights_of_meshes() {
    let mut root = moving(&[0.0, 1.0]);
    let mut pointing = |pointer: &str| {
        let extensions = json!({ "KHR_animation_pointer": { "pointer": pointer } });
        let target = json!({ "path": "pointer", "extensions": extensions });
        root["animations"][1]["channels"] = json!([{ "sampler": 0, "target": target }]);
        root["nodes"] = json!([
            { "mesh": 0 }, { "mesh": 0, "weights": [0.5] }, { "children": [] }, { "mesh": 0 },
        ]);
        let scene = sound(&root);
        let found = animation(&scene.document, 1, &Limits::DEFAULT);
        found.map(|found| found.channels.iter().map(|c| (c.node, c.property)).collect::<Vec<_>>())
    };
    assert_eq!(pointing("/nodes/2/scale").ok(), Some(vec![(2, Property::Scale)]));
    assert_eq!(pointing("/nodes/0/translation").ok(), Some(vec![(0, Property::Translation)]));
    for other in ["/nodes/02/scale", "/nodes/2/name", "/meshes/0/name", "/cameras/0/scale", "/"] {
        assert_eq!(pointing(other).ok(), Some(vec![]), "{other}");
    }
    // Vectors are no weights.
    assert!(pointing("/nodes/0/weights").is_err());
    // A node's own weights count instead of its mesh's.
    let values = root["animations"][1]["samplers"][0]["input"].clone();
    root["animations"][1]["samplers"][0]["output"] = values;
    let mut pointing = |pointer: &str| {
        root["animations"][1]["channels"][0]["target"]["extensions"]["KHR_animation_pointer"] =
            json!({ "pointer": pointer });
        let scene = sound(&root);
        let found = animation(&scene.document, 1, &Limits::DEFAULT).expect("an animation");
        found.channels.iter().map(|c| (c.node, c.property)).collect::<Vec<_>>()
    };
    let weights = Property::Weights;
    assert_eq!(pointing("/meshes/0/weights"), [(0, weights), (3, weights)]);
    assert_eq!(pointing("/nodes/1/weights"), [(1, weights)]);
    assert_eq!(pointing("/nodes/1/weights/2"), [(1, Property::Weight(2))]);
}
