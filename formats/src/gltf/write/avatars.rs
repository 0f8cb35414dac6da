//! What avatars say about meshes and the nodes that show them holds for their coarser levels, too:
//! morph targets of expressions, and what the first person sees.

use crate::gltf::extension_table::LISTS_OF_BINDS;
use crate::gltf::json::{Json, Object};
use std::collections::BTreeMap;

/// The coarser levels of meshes and of nodes, by the number of the finest.
#[derive(Default)]
pub(super) struct Copies {
    pub(super) meshes: BTreeMap<usize, Vec<usize>>,
    pub(super) nodes: BTreeMap<usize, Vec<usize>>,
}

/// Repeats the entries of lists that are about one mesh (VRM 0.x) or node (VRM 1.0).
pub(super) fn repeat_binds(root: &mut Object, copies: &Copies) {
    let Some(extensions) = root.get_mut("extensions") else { return };
    for (name, key, copies) in
        [("VRM", "mesh", &copies.meshes), ("VRMC_vrm", "node", &copies.nodes)]
    {
        if let Some(avatar) = extensions.get_mut(name) {
            repeat_below(avatar, key, copies);
        }
    }
}

// The document's depth is bounded, so recursion is.
fn repeat_below(value: &mut Json, key: &str, copies: &BTreeMap<usize, Vec<usize>>) {
    match value {
        Json::Object(members) => {
            for (name, member) in members.iter_mut() {
                match member {
                    Json::Array(binds) if LISTS_OF_BINDS.contains(&name.as_str()) => {
                        let of_level = |bind: &Json| -> Vec<Json> {
                            let number = bind[key].as_index();
                            let levels = number.and_then(|n| copies.get(&n));
                            let copy = |&level: &usize| {
                                let mut copy = bind.clone();
                                copy[key] = level.into();
                                copy
                            };
                            levels.into_iter().flatten().map(copy).collect()
                        };
                        let added: Vec<Json> = binds.iter().flat_map(of_level).collect();
                        binds.extend(added);
                    }
                    other => repeat_below(other, key, copies),
                }
            }
        }
        Json::Array(elements) => elements.iter_mut().for_each(|e| repeat_below(e, key, copies)),
        _ => {}
    }
}
