//! Removes primitives that have no triangles at a level of detail, and meshes, animation channels
//! and references that this leaves empty: glTF allows neither empty accessors nor dangling
//! references.

use super::extensions::{INSTANCING, animation_pointer};
use super::json::{Json, Object};
use super::schema::{Pool, forget_references, references, renumbered, retain};
use std::collections::BTreeSet;

/// Drops primitives (mesh, primitive), then meshes without primitives. Nodes that showed such a
/// mesh stay, without mesh, skin and weights, and animation channels of those weights go.
pub(crate) fn without(root: &mut Object, empty: &[(usize, usize)]) {
    let empty: BTreeSet<(usize, usize)> = empty.iter().copied().collect();
    let mut keep = vec![true; Pool::Meshes.len(root)];
    for (m, mesh) in root.objects_mut("meshes").enumerate() {
        let Some(Json::Array(primitives)) = mesh.get_mut("primitives") else { continue };
        let count_before = primitives.len();
        let mut number = 0..;
        primitives.retain(|_| number.next().is_some_and(|p| !empty.contains(&(m, p))));
        keep[m] = count_before == 0 || !primitives.is_empty();
    }
    if !keep.contains(&false) {
        return;
    }
    let is_dropped = |mesh: Option<u64>| mesh.is_some_and(|m| keep.get(m as usize) == Some(&false));
    let mut without_mesh = BTreeSet::new();
    for (n, node) in root.objects_mut("nodes").enumerate() {
        if is_dropped(node["mesh"].as_u64()) {
            for key in ["mesh", "skin", "weights"] {
                node.shift_remove(key);
            }
            node.remove_extension(INSTANCING);
            without_mesh.insert(n as u64);
        }
    }
    drop_channels(root, &keep, &without_mesh);
    forget_references(root, Pool::Meshes, &keep);
    // Nodes and extensions that referred to these do so no more.
    debug_assert!({
        let mut dangling = false;
        references(root, Pool::Meshes, &mut |v, _| dangling |= is_dropped(v.as_u64()));
        !dangling
    });
    retain(root, Pool::Meshes, &keep);
}

/// Drops animation channels that move something gone, and renumbers meshes in the pointers of the
/// others.
fn drop_channels(root: &mut Object, keep: &[bool], without_mesh: &BTreeSet<u64>) {
    let numbers = renumbered(keep);
    let Some(Json::Array(animations)) = root.get_mut("animations") else { return };
    let count_before = animations.len();
    animations.retain_mut(|animation| {
        let Some(Json::Array(channels)) = animation.get_mut("channels") else { return true };
        channels.retain_mut(|channel| {
            channel
                .get_mut("target")
                .is_none_or(|target| redirect(target, keep, &numbers, without_mesh))
        });
        !channels.is_empty()
    });
    if animations.is_empty() && count_before > 0 {
        root.shift_remove("animations");
    }
}

/// Renumbers the mesh in the pointer of a channel's target; false if what it moves is gone.
/// `numbers` are the new numbers of the meshes that are kept.
fn redirect(
    target: &mut Json,
    keep: &[bool],
    numbers: &[u64],
    without_mesh: &BTreeSet<u64>,
) -> bool {
    let node = target["node"].as_u64();
    if target["path"].as_str() == Some("weights") {
        return node.is_none_or(|n| !without_mesh.contains(&n));
    }
    let Some(pointer) = animation_pointer(target) else { return true };
    let mut parts = pointer.splitn(4, '/').skip(1);
    let (pool, number, rest) =
        (parts.next(), parts.next().and_then(|n| n.parse::<usize>().ok()), parts.next());
    match (pool, number, rest) {
        (Some("nodes"), Some(n), Some(rest)) => {
            !(rest.starts_with("weights") && without_mesh.contains(&(n as u64)))
        }
        (Some("meshes"), Some(m), rest) => {
            if keep.get(m) == Some(&false) {
                return false;
            }
            let Some(number) = numbers.get(m) else { return true };
            *pointer = format!("/meshes/{number}/{}", rest.unwrap_or(""));
            true
        }
        _ => true,
    }
}
