//! Flat faces: those that have one normal at all three corners.

use lodc_mesh::{Attribute, Mesh, Semantic, Submesh};

fn is_normal(attribute: &Attribute) -> bool {
    attribute.semantic == Semantic::Normal && attribute.morph_target.is_none()
}

/// The normals of a submesh's vertices.
pub(super) fn normals<'a>(
    mesh: &'a Mesh,
    submesh: &'a Submesh,
) -> impl Iterator<Item = &'a Attribute> {
    submesh.attributes.iter().map(|&a| &mesh.attributes()[a as usize]).filter(|a| is_normal(a))
}

/// By vertex: whether all its faces have one normal at all three corners; empty if none is such.
pub(super) fn flat_vertices(mesh: &Mesh) -> Vec<bool> {
    if !mesh.attributes().iter().any(is_normal) {
        return Vec::new();
    }
    let (mut is_flat, mut is_smooth) =
        (vec![false; mesh.vertex_count()], vec![false; mesh.vertex_count()]);
    for submesh in mesh.submeshes() {
        let own: Vec<&Attribute> = normals(mesh, submesh).collect();
        for t in &mesh.triangles()[submesh.triangles()] {
            let [a, b, c] = *t;
            let has_one =
                !own.is_empty() && own.iter().all(|n| n.at(a) == n.at(b) && n.at(b) == n.at(c));
            let list = if has_one { &mut is_flat } else { &mut is_smooth };
            t.iter().for_each(|&v| list[v as usize] = true);
        }
    }
    is_flat.iter_mut().zip(is_smooth).for_each(|(flat, smooth)| *flat &= !smooth);
    if is_flat.contains(&true) { is_flat } else { Vec::new() }
}
