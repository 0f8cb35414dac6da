//! Leaving out what has no triangles at this level of detail, so that the document stays valid
//! glTF.

use crate::gltf::json::{self, Object, integer};
use crate::gltf::schema::{Pool, references, retain};
use serde_json::Value;

/// Drops primitives (mesh, primitive), then meshes without primitives. Nodes that showed such a
/// mesh stay, without mesh, skin and weights, and animation channels of those weights go.
pub(super) fn without(root: &mut Object, empty: &[(usize, usize)]) {
    let mut kept = vec![true; Pool::Meshes.len(root)];
    for (m, mesh) in
        root.get_mut("meshes").and_then(Value::as_array_mut).into_iter().flatten().enumerate()
    {
        let Some(primitives) = mesh.get_mut("primitives").and_then(Value::as_array_mut) else {
            continue;
        };
        let before = primitives.len();
        let mut number = 0..;
        primitives.retain(|_| number.next().is_some_and(|p| !empty.contains(&(m, p))));
        kept[m] = before == 0 || !primitives.is_empty();
    }
    if !kept.contains(&false) {
        return;
    }
    let gone = |mesh: Option<u64>| mesh.is_some_and(|m| kept.get(m as usize) == Some(&false));
    let mut bare = Vec::new();
    for (n, node) in
        root.get_mut("nodes").and_then(Value::as_array_mut).into_iter().flatten().enumerate()
    {
        let Some(node) = node.as_object_mut() else { continue };
        if gone(node.get("mesh").and_then(integer)) {
            for key in ["mesh", "skin", "weights"] {
                node.shift_remove(key);
            }
            json::remove_extension(node, "EXT_mesh_gpu_instancing");
            bare.push(n as u64);
        }
    }
    drop_channels(root, &kept, &bare);
    // Only nodes refer to meshes, and those that referred to these do so no more.
    debug_assert!({
        let mut dangling = false;
        references(root, Pool::Meshes, &mut |v, _| dangling |= gone(integer(v)));
        !dangling
    });
    retain(root, Pool::Meshes, &kept);
}

/// Drops animation channels that move something gone, and renumbers meshes in the pointers of the
/// others.
fn drop_channels(root: &mut Object, kept: &[bool], bare: &[u64]) {
    let Some(Value::Array(animations)) = root.get_mut("animations") else { return };
    let before = animations.len();
    animations.retain_mut(|animation| {
        let Some(Value::Array(channels)) = animation.get_mut("channels") else { return true };
        channels.retain_mut(|channel| {
            channel.get_mut("target").is_none_or(|target| stays(target, kept, bare))
        });
        !channels.is_empty()
    });
    if animations.is_empty() && before > 0 {
        root.shift_remove("animations");
    }
}

fn stays(target: &mut Value, kept: &[bool], bare: &[u64]) -> bool {
    let node = target.get("node").and_then(integer);
    if target.get("path").and_then(Value::as_str) == Some("weights") {
        return node.is_none_or(|n| !bare.contains(&n));
    }
    let pointer = target
        .get_mut("extensions")
        .and_then(|e| e.get_mut("KHR_animation_pointer")?.get_mut("pointer"));
    let Some(Value::String(pointer)) = pointer else { return true };
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
            let number = kept.iter().take(m).filter(|k| **k).count();
            *pointer = format!("/meshes/{number}/{}", rest.unwrap_or(""));
            true
        }
        _ => true,
    }
}
