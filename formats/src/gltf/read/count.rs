//! Counts triangles, vertices and bytes of a glTF by its accessors, without reading geometry: for
//! estimates before a build.

use crate::FormatError;
use crate::gltf::glb;
use crate::gltf::json::{self, Json, Object};
use crate::gltf::{extensions, uri};
use crate::options::ImportOptions;
use crate::scene::Counted;
use crate::words::without_mark;
use std::collections::BTreeSet;

/// Counts what a glTF or GLB holds, without the bytes of the file itself.
///
/// # Errors
/// If it is no document.
pub(crate) fn counted(bytes: &[u8], options: &ImportOptions) -> Result<Counted, FormatError> {
    let text = if glb::is_glb(bytes) { &bytes[glb::split(bytes)?.json] } else { bytes };
    let root = json::parse(without_mark(text), &options.limits)?;
    let accessors: Vec<u64> =
        root.entries("accessors").map(|a| a["count"].as_u64().unwrap_or(0)).collect();
    let count = |accessor: &Json| accessor.as_index().and_then(|a| accessors.get(a)).copied();
    let mut counted = Counted::default();
    let mut positions = BTreeSet::new();
    for mesh in root.entries("meshes") {
        for primitive in mesh.list("primitives").iter().filter_map(Json::as_object) {
            let position = &primitive["attributes"]["POSITION"];
            let vertices = count(position).unwrap_or(0);
            let corners = count(&primitive["indices"]).unwrap_or(vertices);
            counted.triangles += match primitive["mode"].as_u64().unwrap_or(4) {
                4 => corners / 3,
                5 | 6 => corners.saturating_sub(2),
                _ => 0,
            };
            // Primitives may share their vertices.
            if position.as_index().is_some_and(|position| positions.insert(position)) {
                counted.vertices += vertices;
            }
        }
    }
    let sum = |counts: &mut dyn Iterator<Item = Option<u64>>| -> u64 {
        counts.flatten().fold(0, u64::saturating_add)
    };
    let named = |b: &&Object| b["uri"].as_str().is_some_and(|uri| !uri::is_data(uri));
    let buffers = sum(&mut root.entries("buffers").filter(named).map(|b| b["byteLength"].as_u64()));
    let packed = root.entries("bufferViews").filter(|view| extensions::meshopt(view).is_some());
    let unpacked = sum(&mut packed.map(|view| view["byteLength"].as_u64()));
    counted.bytes = buffers.saturating_add(unpacked);
    Ok(counted)
}
