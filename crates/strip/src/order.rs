//! Triangle order.

use lodc_mesh::Mesh;

/// The order.
#[must_use]
pub fn order(mesh: &Mesh) -> Vec<[u32; 3]> {
    mesh.triangles().to_vec()
}
