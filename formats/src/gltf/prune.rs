//! Leaving out what has no triangles at this level of detail, so that the document stays valid
//! glTF.

use super::extensions::animation_pointer;
use super::json::{Json, Object};
use super::schema::{Pool, references, renumbered, retain};
use std::collections::BTreeSet;

/// Drops primitives (mesh, primitive), then meshes without primitives. Nodes that showed such a
/// mesh stay, without mesh, skin and weights, and animation channels of those weights go.
pub(crate) fn without(root: &mut Object, empty: &[(usize, usize)]) {
    let empty: BTreeSet<(usize, usize)> = empty.iter().copied().collect();
    let mut kept = vec![true; Pool::Meshes.len(root)];
    for (m, mesh) in root.objects_mut("meshes").enumerate() {
        let Some(Json::Array(primitives)) = mesh.get_mut("primitives") else { continue };
        let before = primitives.len();
        let mut number = 0..;
        primitives.retain(|_| number.next().is_some_and(|p| !empty.contains(&(m, p))));
        kept[m] = before == 0 || !primitives.is_empty();
    }
    if !kept.contains(&false) {
        return;
    }
    let gone = |mesh: Option<u64>| mesh.is_some_and(|m| kept.get(m as usize) == Some(&false));
    let mut bare = BTreeSet::new();
    for (n, node) in root.objects_mut("nodes").enumerate() {
        if gone(node["mesh"].as_u64()) {
            for key in ["mesh", "skin", "weights"] {
                node.shift_remove(key);
            }
            node.remove_extension("EXT_mesh_gpu_instancing");
            bare.insert(n as u64);
        }
    }
    drop_channels(root, &kept, &bare);
    // Only nodes refer to meshes, and those that referred to these do so no more.
    debug_assert!({
        let mut dangling = false;
        references(root, Pool::Meshes, &mut |v, _| dangling |= gone(v.as_u64()));
        !dangling
    });
    retain(root, Pool::Meshes, &kept);
}

/// Drops animation channels that move something gone, and renumbers meshes in the pointers of the
/// others.
fn drop_channels(root: &mut Object, kept: &[bool], bare: &BTreeSet<u64>) {
    let numbers = renumbered(kept);
    let Some(Json::Array(animations)) = root.get_mut("animations") else { return };
    let before = animations.len();
    animations.retain_mut(|animation| {
        let Some(Json::Array(channels)) = animation.get_mut("channels") else { return true };
        channels.retain_mut(|channel| {
            channel.get_mut("target").is_none_or(|target| stays(target, (kept, &numbers), bare))
        });
        !channels.is_empty()
    });
    if animations.is_empty() && before > 0 {
        root.shift_remove("animations");
    }
}

/// `numbers` are those of the meshes that are kept.
fn stays(target: &mut Json, (kept, numbers): (&[bool], &[u64]), bare: &BTreeSet<u64>) -> bool {
    let node = target["node"].as_u64();
    if target["path"].as_str() == Some("weights") {
        return node.is_none_or(|n| !bare.contains(&n));
    }
    let Some(pointer) = animation_pointer(target) else { return true };
    let mut parts = pointer.splitn(4, '/').skip(1);
    let (pool, number, rest) =
        (parts.next(), parts.next().and_then(|n| n.parse::<usize>().ok()), parts.next());
    match (pool, number, rest) {
        (Some("nodes"), Some(n), Some(rest)) => {
            !(rest.starts_with("weights") && bare.contains(&(n as u64)))
        }
        (Some("meshes"), Some(m), rest) => {
            if kept.get(m) == Some(&false) {
                return false;
            }
            let Some(number) = numbers.get(m) else { return true };
            *pointer = format!("/meshes/{number}/{}", rest.unwrap_or(""));
            true
        }
        _ => true,
    }
}
