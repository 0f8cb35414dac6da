//! The triangles of a view-dependent level: their number, themselves, or a mesh of its own where
//! vertices morph.

use super::{State, select};
use lodc_mesh::{
    Mesh, MeshError, MeshParts, OrientedTriangle, PositionIds, Simplified, Submesh, is_degenerate,
};
use rayon::prelude::*;
use std::collections::BTreeMap;

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

/// Returns the mesh of a view without morphing: the triangles that [`live_triangles`] returns. A
/// corner that is shown as a vertex of another submesh becomes a vertex of its own there, with the
/// attributes of its submesh.
///
/// # Errors
/// If states are not those of the vertices of this mesh.
pub fn view_mesh(
    simplified: &Simplified,
    positions: &PositionIds,
    states: &[State],
) -> Result<Mesh, MeshError> {
    let mesh = simplified.mesh();
    let submesh_of = mesh.vertex_submesh();
    let own = OwnSubmesh::new(simplified);
    // Vertices besides those of the mesh: where each stands, and whose attributes it has.
    let mut added: Vec<(u32, u32)> = Vec::new();
    let mut number_of = BTreeMap::new();
    let mut corner = |submesh: u32, v: u32| {
        let entry = states[v as usize].entry;
        if submesh_of[entry as usize] == submesh {
            return entry;
        }
        let vertex = (entry, own.source(v, entry));
        *number_of.entry(vertex).or_insert_with(|| {
            added.push(vertex);
            (submesh_of.len() + added.len() - 1) as u32
        })
    };
    let at = |v: u32| positions.of_vertex[states[v as usize].entry as usize];
    let live: Vec<OrientedTriangle> = oriented(mesh)
        .filter(|t| !is_degenerate(t.corners.map(at)))
        .map(|t| OrientedTriangle::new(t.submesh, t.corners.map(|v| corner(t.submesh, v))))
        .collect();
    if added.is_empty() {
        return mesh.extract(&live);
    }
    let vertices = 0..submesh_of.len() as u32;
    let sources: Vec<u32> = vertices.clone().chain(added.iter().map(|a| a.1)).collect();
    let stands = vertices.chain(added.iter().map(|a| a.0));
    let stands = stands.map(|v| mesh.positions()[v as usize]).collect();
    with_vertices(mesh, stands, &sources)?.extract(&live)
}

/// Finds attributes for a corner that is shown as a vertex of another submesh.
struct OwnSubmesh<'a> {
    submesh_of: &'a [u32],
    links: Vec<[u32; 2]>,
}

impl<'a> OwnSubmesh<'a> {
    fn new(simplified: &'a Simplified) -> Self {
        let submesh_of = simplified.mesh().vertex_submesh();
        Self { submesh_of, links: select::links(simplified.collapses()) }
    }

    /// The last vertex of its submesh that `vertex` became on its way to `entry`; of long ways the
    /// last of the first collapses.
    fn source(&self, vertex: u32, entry: u32) -> u32 {
        let submesh = |v: u32| self.submesh_of[v as usize];
        let (mut at, mut source) = (vertex, vertex);
        for _ in 0..select::MAX_WALK {
            if submesh(at) == submesh(vertex) {
                source = at;
            }
            if at == entry {
                break;
            }
            at = self.links[at as usize][0];
        }
        source
    }
}

/// Returns the mesh of a view: every vertex of LOD 0 with the attributes of the one that it is
/// shown as, at its morphed position, and the triangles whose corners are at
/// three positions. One that is shown as a vertex of another submesh keeps attributes of its own.
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
    let own = OwnSubmesh::new(simplified);
    let source = |(v, state): (u32, &State)| {
        let is_own = own.submesh_of[v as usize] == own.submesh_of[state.entry as usize];
        if is_own { state.entry } else { own.source(v, state.entry) }
    };
    let sources: Vec<u32> = (0..).zip(states).map(source).collect();
    with_vertices(simplified.mesh(), positions_of(simplified, states), &sources)
}

/// The submeshes of a mesh, without triangles, with vertices at `positions` that have the
/// attributes of `sources`.
fn with_vertices(
    mesh: &Mesh,
    positions: Vec<[f32; 3]>,
    sources: &[u32],
) -> Result<Mesh, MeshError> {
    let no_triangles = |s: &Submesh| Submesh { first_triangle: 0, triangle_count: 0, ..s.clone() };
    let attributes = mesh.attributes().iter();
    Mesh::try_from(MeshParts {
        positions,
        vertex_submesh: sources.iter().map(|&v| mesh.vertex_submesh()[v as usize]).collect(),
        attributes: attributes.map(|a| a.gathered(sources.iter().copied())).collect(),
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
