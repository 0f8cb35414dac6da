//! Nodes whose mesh stands on a grid: the mesh moves to a child that scales the grid, so that the
//! node's own transform, its animations and its other children stay as they are.

use super::grid::Grid;
use super::skins;
use crate::gltf::json::{Object, integer};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Places all meshes of the document that stand on a grid.
pub(super) fn place(root: &mut Object, blob: &mut [u8], grids: &BTreeMap<usize, Grid<3>>) {
    let skinned: BTreeMap<u64, Grid<3>> = skins::shown(root)
        .filter_map(|(mesh, matrices)| Some((matrices, *grids.get(&mesh)?)))
        .collect();
    for (matrices, grid) in &skinned {
        skins::transform(root, blob, *matrices, grid);
    }
    let nodes = root.get("nodes").and_then(Value::as_array).map_or(0, Vec::len);
    for node in 0..nodes {
        let shown = &root["nodes"][node];
        let mesh = shown.get("mesh").and_then(integer).and_then(|m| usize::try_from(m).ok());
        let grid = mesh.and_then(|m| grids.get(&m)).filter(|_| shown.get("skin").is_none());
        if let Some(grid) = grid {
            let child = move_mesh(root, node, grid);
            redirect_weights(root, node, child);
        }
    }
}

/// Moves a node's mesh, and the weights of its morph targets, to a new child; returns its number.
fn move_mesh(root: &mut Object, node: usize, grid: &Grid<3>) -> usize {
    let mut child = Object::new();
    if let Some(node) = root["nodes"][node].as_object_mut() {
        for key in ["mesh", "weights"] {
            child.extend(node.shift_remove(key).map(|value| (key.to_owned(), value)));
        }
    }
    child.insert("translation".to_owned(), json!(grid.offset));
    child.insert("scale".to_owned(), json!([grid.step, grid.step, grid.step]));
    let nodes = root["nodes"].as_array_mut().expect("the document has nodes");
    let number = nodes.len();
    match &mut nodes[node]["children"] {
        Value::Array(children) => children.push(number.into()),
        none => *none = json!([number]),
    }
    nodes.push(child.into());
    number
}

/// Lets animations of a node's weights move those of another one.
fn redirect_weights(root: &mut Object, from: usize, to: usize) {
    let animations = root.get_mut("animations").and_then(Value::as_array_mut);
    let channels = animations.into_iter().flatten().filter_map(|a| a["channels"].as_array_mut());
    for target in channels.flatten().map(|channel| &mut channel["target"]) {
        let own = target.get("node").and_then(integer) == Some(from as u64);
        if own && target["path"] == "weights" {
            target["node"] = to.into();
        }
        let pointer = target.pointer_mut("/extensions/KHR_animation_pointer/pointer");
        let Some(pointer) = pointer else { continue };
        let rest = pointer.as_str().and_then(|p| p.strip_prefix(&format!("/nodes/{from}/weights")));
        if let Some(moved) = rest.map(|rest| format!("/nodes/{to}/weights{rest}")) {
            *pointer = moved.into();
        }
    }
}
