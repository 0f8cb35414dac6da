//! Dequantisation of positions by nodes: a mesh with quantised positions moves to a new child node
//! whose translation and scale are those of its grid, so that the node's own transform, its
//! animations and its other children stay as they are. A mesh with a skin is not placed by its
//! node: there the grid goes into the inverse bind matrices of the skin.

use super::grid::Grid;
use super::skins;
use crate::gltf::extensions::{animation_pointer, of_node};
use crate::gltf::json::{Json, Object};
use std::collections::BTreeMap;

/// Lets the document undo the grids of its meshes, given by mesh.
pub(super) fn move_to_grids(root: &mut Object, blob: &mut [u8], grids: &BTreeMap<usize, Grid<3>>) {
    // By accessor of matrices. Meshes that share one have the same grid (`positions::groups`).
    let skinned: BTreeMap<usize, Grid<3>> = skins::skinned_meshes(root)
        .filter_map(|(mesh, accessor)| Some((accessor, *grids.get(&mesh)?)))
        .collect();
    for (accessor, grid) in &skinned {
        skins::transform(root, blob, *accessor, grid);
    }
    let mut children = BTreeMap::new();
    for node in 0..root.list("nodes").len() {
        let entry = &root["nodes"][node];
        let grid = entry["mesh"]
            .as_index()
            .and_then(|m| grids.get(&m))
            .filter(|_| entry.get("skin").is_none());
        if let Some(grid) = grid {
            children.insert(node, move_mesh(root, node, grid));
        }
    }
    redirect_weights(root, &children);
}

/// Moves a node's mesh, and the weights of its morph targets, to a new child; returns its number.
fn move_mesh(root: &mut Object, node: usize, grid: &Grid<3>) -> usize {
    let number = root.list("nodes").len();
    let node = root.object_mut("nodes", node).expect("the document has the node");
    let mut child = Object::default();
    for key in ["mesh", "weights"] {
        child.extend(node.shift_remove(key).map(|value| (key.to_owned(), value)));
    }
    child["translation"] = grid.offset.into();
    child["scale"] = [grid.step; 3].into();
    node.append("children", vec![number.into()]);
    root.append("nodes", vec![Json::Object(child)]);
    number
}

/// Lets animations of nodes' weights move those of their children that have the meshes.
fn redirect_weights(root: &mut Object, children: &BTreeMap<usize, usize>) {
    let channels = root.objects_mut("animations").flat_map(|a| a.objects_mut("channels"));
    for target in channels.filter_map(|channel| channel.get_mut("target")) {
        let child = target["node"].as_index().and_then(|node| children.get(&node));
        if let Some(&child) = child.filter(|_| target["path"].as_str() == Some("weights")) {
            target["node"] = child.into();
        }
        let Some(pointer) = animation_pointer(target) else { continue };
        let Some((node, property)) = of_node(pointer) else { continue };
        if let Some(child) = children.get(&node).filter(|_| property.starts_with("weights")) {
            *pointer = format!("/nodes/{child}/{property}");
        }
    }
}
