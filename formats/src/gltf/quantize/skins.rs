//! Dequantisation of skinned meshes: their nodes' transforms are ignored, so the grid's transform
//! is multiplied into the inverse bind matrices.

use super::grid::Grid;
use crate::gltf::floats::Floats;
use crate::gltf::json::Object;

/// The accessor of the inverse bind matrices of a node's skin.
pub(super) fn matrices(root: &Object, node: &Object) -> Option<usize> {
    root["skins"][node["skin"].as_index()?]["inverseBindMatrices"].as_index()
}

/// Returns whether the matrices of a node's skin can take a transform: they have bytes of their
/// own, and all meshes that they move are written.
pub(super) fn is_movable(root: &Object, node: &Object, is_written: impl Fn(usize) -> bool) -> bool {
    let Some(accessor) = matrices(root, node) else { return false };
    let all = root.list("accessors");
    let bytes_at = |i: usize| (&all[i]["bufferView"], &all[i]["byteOffset"]);
    let same_bytes = (0..all.len()).filter(|&i| bytes_at(i) == bytes_at(accessor)).count();
    let mut moved = skinned_meshes(root).filter(|(_, matrices)| *matrices == accessor);
    same_bytes == 1
        && matrix_floats(root, accessor).is_some()
        && moved.all(|(mesh, _)| is_written(mesh))
}

/// Where an accessor's matrices, 16 floats each, are in the document's bytes.
fn matrix_floats(root: &Object, accessor: usize) -> Option<Floats> {
    Floats::of(root, accessor).filter(|floats| floats.size == 64)
}

/// Multiplies the matrices of an accessor by the transform of a grid.
pub(super) fn transform(root: &mut Object, blob: &mut [u8], accessor: usize, grid: &Grid<3>) {
    let floats = matrix_floats(root, accessor);
    if let Some(accessor) = root.object_mut("accessors", accessor) {
        // They are optional, and no longer true.
        ["min", "max"].iter().for_each(|key| drop(accessor.shift_remove(*key)));
    }
    for bytes_at in floats.into_iter().flat_map(Floats::byte_ranges) {
        let Some(matrix) = blob.get_mut(bytes_at) else { return };
        let number = |matrix: &[u8], column: usize, row: usize| {
            let bytes = matrix.as_chunks::<4>().0[4 * column + row];
            f64::from(f32::from_le_bytes(bytes))
        };
        for row in 0..4 {
            let columns = [0, 1, 2, 3].map(|column| number(matrix, column, row));
            let [x, y, z] = grid.offset;
            let moved = columns[0] * x + columns[1] * y + columns[2] * z + columns[3];
            let [a, b, c] = [0, 1, 2].map(|k| columns[k] * grid.step);
            for (column, value) in [a, b, c, moved].into_iter().enumerate() {
                let offset = 4 * (4 * column + row);
                matrix[offset..offset + 4].copy_from_slice(&(value as f32).to_le_bytes());
            }
        }
    }
}

/// For each node with a skin, its mesh and the accessor of the skin's inverse bind matrices.
pub(super) fn skinned_meshes(root: &Object) -> impl Iterator<Item = (usize, usize)> {
    root.entries("nodes").filter_map(|node| Some((node["mesh"].as_index()?, matrices(root, node)?)))
}
