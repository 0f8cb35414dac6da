//! The triangles of a view-dependent level: their number, themselves, or a mesh of its own where
//! vertices morph.

use super::{State, select};
use lodc_mesh::{
    Mesh, MeshError, MeshParts, OrientedTriangle, PositionIds, Simplified, Submesh, is_degenerate,
};
use rayon::prelude::*;

/// Returns the number of triangles that are drawn.
#[must_use]
pub fn drawn_triangles(simplified: &Simplified, positions: &PositionIds, states: &[State]) -> u64 {
    let count = |position: &(dyn Fn(&u32) -> u32 + Sync)| {
        let live = |t: &&[u32; 3]| !is_degenerate(t.each_ref().map(position));
        simplified.mesh().triangles().par_iter().filter(live).count() as u64
    };
    if states.par_iter().all(|state| state.progress == 0) {
        return count(&|&v| positions.of_vertex[states[v as usize].entry as usize]);
    }
    let ids = match moved(simplified, states) {
        Ok(moved) => moved.position_ids(),
        Err(_) => PositionIds::new(&positions_of(simplified, states)),
    };
    count(&|&v| ids.of_vertex[v as usize])
}

/// Returns the triangles that are not degenerate, with every corner as the vertex that it is shown
/// as. Morphed positions do not count.
#[must_use]
pub fn live_triangles(
    simplified: &Simplified,
    positions: &PositionIds,
    states: &[State],
) -> Vec<OrientedTriangle> {
    let shown = |t: OrientedTriangle| {
        OrientedTriangle::new(t.submesh, t.corners.map(|v| states[v as usize].entry))
    };
    let live =
        |t: &OrientedTriangle| !is_degenerate(t.corners.map(|v| positions.of_vertex[v as usize]));
    oriented(simplified.mesh()).map(shown).filter(live).collect()
}

/// Returns the mesh of a view: every vertex of LOD 0 with the attributes of the one that it is
/// shown as, at its morphed position, and the triangles whose corners are at
/// three positions.
///
/// # Errors
/// If states are not those of the vertices of this mesh.
pub fn morphed_mesh(simplified: &Simplified, states: &[State]) -> Result<Mesh, MeshError> {
    let moved = moved(simplified, states)?;
    let (mesh, ids) = (simplified.mesh(), moved.position_ids());
    let live = |t: &OrientedTriangle| !is_degenerate(t.corners.map(|v| ids.of_vertex[v as usize]));
    moved.extract(&oriented(mesh).filter(live).collect::<Vec<_>>())
}

/// The vertices of a view, without triangles.
fn moved(simplified: &Simplified, states: &[State]) -> Result<Mesh, MeshError> {
    let mesh = simplified.mesh();
    let no_triangles = |s: &Submesh| Submesh { first_triangle: 0, triangle_count: 0, ..s.clone() };
    let entries = || states.iter().map(|state| state.entry);
    Mesh::try_from(MeshParts {
        positions: positions_of(simplified, states),
        vertex_submesh: mesh.vertex_submesh().to_vec(),
        attributes: mesh.attributes().iter().map(|a| a.gathered(entries())).collect(),
        triangles: Vec::new(),
        submeshes: mesh.submeshes().iter().map(no_triangles).collect(),
    })
}

/// The triangles of LOD 0.
fn oriented(mesh: &Mesh) -> impl Iterator<Item = OrientedTriangle> {
    let of = |(s, submesh): (u32, &Submesh)| {
        mesh.triangles()[submesh.triangles()].iter().map(move |&t| OrientedTriangle::new(s, t))
    };
    (0..).zip(mesh.submeshes()).flat_map(of)
}

/// The position of each vertex: morphed, or that of its entry bit for bit where it does not move.
fn positions_of(simplified: &Simplified, states: &[State]) -> Vec<[f32; 3]> {
    let positions = simplified.mesh().positions();
    let links = select::links(simplified.collapses());
    let position = |s: &State| match s.progress {
        0 => positions[s.entry as usize],
        _ => select::morphed_position(s.entry, s.lod, &links, |v| positions[v as usize]),
    };
    states.par_iter().map(position).collect()
}
