//! Skins: the inverse bind matrices take the transform of a grid.

use super::grid::Grid;
use crate::gltf::json::{Object, entries, integer, list};
use serde_json::Value;

/// The accessor of the inverse bind matrices of a node's skin.
pub(super) fn matrices(root: &Object, node: &Object) -> Option<u64> {
    let skin = node.get("skin").and_then(integer)?;
    let skin = entries(root, "skins").nth(usize::try_from(skin).ok()?)?;
    skin.get("inverseBindMatrices").and_then(integer)
}

/// Returns whether the matrices of a node's skin can take a transform: they have bytes of their
/// own, and all meshes that they move are written.
pub(super) fn is_movable(root: &Object, node: &Object, written: impl Fn(usize) -> bool) -> bool {
    let Some(accessor) = matrices(root, node) else { return false };
    let place = |a: &Object| (a.get("bufferView").cloned(), a.get("byteOffset").cloned());
    let Some(own) = entries(root, "accessors").nth(accessor as usize) else { return false };
    let twins = entries(root, "accessors").filter(|a| place(a) == place(own)).count();
    let moved = shown(root).filter(|(_, matrices)| *matrices == accessor);
    twins == 1 && bytes(root, accessor).is_some() && moved.map(|(mesh, _)| mesh).all(written)
}

/// The places of the matrices of an accessor, 16 floats each, in the document's bytes.
fn bytes(root: &Object, accessor: u64) -> Option<Vec<usize>> {
    let accessor = entries(root, "accessors").nth(usize::try_from(accessor).ok()?)?;
    let view = accessor.get("bufferView").and_then(integer)?;
    let view = entries(root, "bufferViews").nth(usize::try_from(view).ok()?)?;
    let number = |object: &Object, key: &str, default: usize| match object.get(key) {
        None => Some(default),
        Some(value) => integer(value).and_then(|n| usize::try_from(n).ok()),
    };
    let plain = accessor.get("componentType").and_then(integer) == Some(5126)
        && accessor.get("type").and_then(Value::as_str) == Some("MAT4")
        && !accessor.contains_key("sparse")
        && view.get("buffer").and_then(integer) == Some(0)
        && !view.contains_key("extensions");
    let first = number(view, "byteOffset", 0)? + number(accessor, "byteOffset", 0)?;
    let stride = number(view, "byteStride", 64)?;
    let count = number(accessor, "count", 0)?;
    plain.then(|| (0..count).map(|i| first + i * stride).collect())
}

/// Multiplies the matrices of an accessor by the transform of a grid.
pub(super) fn transform(root: &mut Object, blob: &mut [u8], accessor: u64, grid: &Grid<3>) {
    let places = bytes(root, accessor);
    if let Some(accessor) = root["accessors"][accessor as usize].as_object_mut() {
        // They are optional, and no longer true.
        ["min", "max"].iter().for_each(|key| drop(accessor.shift_remove(*key)));
    }
    for first in places.into_iter().flatten() {
        let Some(matrix) = blob.get_mut(first..first + 64) else { return };
        let number = |matrix: &[u8], column: usize, row: usize| {
            let at = 4 * (4 * column + row);
            f64::from(f32::from_le_bytes([
                matrix[at],
                matrix[at + 1],
                matrix[at + 2],
                matrix[at + 3],
            ]))
        };
        for row in 0..4 {
            let columns = [0, 1, 2, 3].map(|column| number(matrix, column, row));
            let [x, y, z] = grid.offset;
            let moved = columns[0] * x + columns[1] * y + columns[2] * z + columns[3];
            let [a, b, c] = [0, 1, 2].map(|k| columns[k] * grid.step);
            for (column, value) in [a, b, c, moved].into_iter().enumerate() {
                let at = 4 * (4 * column + row);
                matrix[at..at + 4].copy_from_slice(&(value as f32).to_le_bytes());
            }
        }
    }
}

/// The nodes that show a mesh with a skin: the mesh and the accessor of the matrices.
pub(super) fn shown(root: &Object) -> impl Iterator<Item = (usize, u64)> {
    list(root, "nodes").iter().filter_map(Value::as_object).filter_map(|node| {
        let mesh = usize::try_from(node.get("mesh").and_then(integer)?).ok()?;
        Some((mesh, matrices(root, node)?))
    })
}
