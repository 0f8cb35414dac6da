//! Repairs what real exporters write although glTF forbids it, and whose meaning is plain: each is
//! a warning.

use crate::gltf::extensions;
use crate::gltf::json::{Json, Object};
use crate::gltf::prune;
use crate::gltf::schema::{Pool, referenced, retain};
use crate::gltf::uri;
use crate::words::counted;

/// Repairs the addresses of buffers and images. The document has been checked.
pub(super) fn addresses(root: &mut Object, warnings: &mut Vec<String>) {
    let (mut backslashes, mut spaced) = (0, 0);
    for key in ["buffers", "images"] {
        for entry in root.objects_mut(key) {
            let Some(Json::String(text)) = entry.get_mut("uri") else { continue };
            if uri::is_data(text) {
                spaced += usize::from(uri::has_white_space(text));
            } else if text.contains('\\') {
                *text = text.replace('\\', "/");
                backslashes += 1;
            }
        }
    }
    if backslashes > 0 {
        let uris = counted(backslashes, "URI has", "URIs have");
        warnings.push(format!("{uris} backslashes, which are read as slashes"));
    }
    if spaced > 0 {
        let uris = counted(spaced, "data URI has", "data URIs have");
        warnings.push(format!("{uris} white space, which is ignored"));
    }
}

/// Repairs accessors, and drops primitives that have no vertex or no corner.
pub(super) fn accessors(root: &mut Object, warnings: &mut Vec<String>) {
    let mut lost = 0;
    for accessor in root.objects_mut("accessors") {
        if accessor.contains_key("byteOffset") && !accessor.contains_key("bufferView") {
            accessor.shift_remove("byteOffset");
            lost += 1;
        }
    }
    if lost > 0 {
        let accessors = counted(lost, "accessor has", "accessors have");
        warnings.push(format!("{accessors} a byteOffset but no bufferView: the offset is ignored"));
    }
    drop_empty_primitives(root, warnings);
}

fn drop_empty_primitives(root: &mut Object, warnings: &mut Vec<String>) {
    let accessors = zeros(root, "accessors", "count");
    let marked = |v: &Json| v.as_index().is_some_and(|a| accessors.get(a) == Some(&true));
    let mut empty = Vec::new();
    for (m, mesh) in root.entries("meshes").enumerate() {
        for (p, primitive) in mesh.list("primitives").iter().enumerate() {
            if marked(&primitive["attributes"]["POSITION"]) || marked(&primitive["indices"]) {
                empty.push((m, p));
            }
        }
    }
    if empty.is_empty() {
        return;
    }
    let (one, several) = ("primitive without a vertex was", "primitives without a vertex were");
    warnings.push(format!("{} dropped", counted(empty.len(), one, several)));
    prune::without(root, &empty);
    if extensions::unknown(root).is_some() {
        // Numbers stay as they are: an accessor without bytes stands for zeros.
        let unused: Vec<bool> =
            referenced(root, Pool::Accessors).iter().map(|used| !used).collect();
        for (accessor, _) in root.objects_mut("accessors").zip(unused).filter(|(_, u)| *u) {
            if accessor["count"].as_u64() == Some(0) {
                accessor["count"] = 1u32.into();
                accessor.shift_remove("bufferView");
            }
        }
        return;
    }
    for (pool, key) in [(Pool::Accessors, "count"), (Pool::BufferViews, "byteLength")] {
        let is_empty = zeros(root, pool.name(), key);
        let used = referenced(root, pool);
        let kept: Vec<bool> = used.iter().zip(is_empty).map(|(&used, e)| used || !e).collect();
        retain(root, pool, &kept);
    }
}

/// Which entries of a list have zero as this member.
fn zeros(root: &Object, list: &str, key: &str) -> Vec<bool> {
    root.entries(list).map(|entry| entry[key].as_u64() == Some(0)).collect()
}
