//! Where the vertices of each level of a chain move as the next, coarser level takes over: the data
//! of its morph targets.

pub use crate::shapes::bends;

use crate::shapes::farthest_vertex;
use crate::{Error, LodObject, level_mesh::LevelMesh};
use lodc_mesh::{Attribute, Lod, Mesh, MeshParts, NONE, Semantic, Simplified, Submesh};
use lodc_scene::Shape;
use std::ops::Range;

/// A level as a mesh of its own, and where its vertices move as the next level takes over.
#[derive(Clone, Debug)]
pub struct MorphingLevel {
    /// The level; the vertices that disappear last come first.
    pub mesh: Mesh,
    /// The same vertices with the values that they have in the next level, without triangles.
    pub next: Mesh,
    /// The range of vertices that move.
    pub moving: Range<u32>,
}

impl MorphingLevel {
    /// Returns the level `now` of an object and its way to the level `next`. Both meshes have
    /// exactly the vertices that their triangles need, in the order of the object's mesh; refitted
    /// ones may have moved. `moves_all` says that every vertex may move, not only those that
    /// disappear.
    ///
    /// # Errors
    /// If a level has other vertices than its triangles need: a bug.
    pub fn new(
        simplified: &Simplified,
        (lod, now): (Lod, &Mesh),
        (next_lod, next): (Lod, &Mesh),
        moves_all: bool,
    ) -> Result<Self, Error> {
        let [vertices, next_vertices] = [lod, next_lod].map(|lod| used_vertices(simplified, lod));
        if vertices.len() != now.vertex_count() || next_vertices.len() != next.vertex_count() {
            return Err(Error::Bug("a level has other vertices than its triangles".to_owned()));
        }
        let becomes = simplified.collapses().resolve_all(simplified.collapses().floor(next_lod));
        let input = simplified.mesh();
        // For each vertex, the last to disappear first, where its values at the next level are: a
        // mesh and a vertex of it. If the next level does not use what it becomes, that is the
        // input.
        let goal = |&v: &u32| match next_vertices.binary_search(&becomes[v as usize]) {
            Ok(index) => (next, index as u32),
            Err(_) => (input, becomes[v as usize]),
        };
        let goals: Vec<(&Mesh, u32)> = vertices.iter().rev().map(goal).collect();
        let count = now.vertex_count() as u32;
        let order: Vec<u32> = (0..count).rev().collect();
        let reversed = |triangles: Vec<[u32; 3]>, submeshes: Vec<Submesh>| MeshParts {
            positions: order.iter().map(|&v| now.positions()[v as usize]).collect(),
            vertex_submesh: order.iter().map(|&v| now.vertex_submesh()[v as usize]).collect(),
            attributes: now
                .attributes()
                .iter()
                .map(|a| a.gathered(order.iter().copied()))
                .collect(),
            triangles,
            submeshes,
        };
        let renumbered = now.triangles().iter().map(|t| t.map(|v| count - 1 - v)).collect();
        let mesh = reversed(renumbered, now.submeshes().to_vec());
        let empty = |s: &Submesh| Submesh {
            first_triangle: 0,
            triangle_count: 0,
            attributes: s.attributes.clone(),
        };
        let mut moved = reversed(Vec::new(), now.submeshes().iter().map(empty).collect());
        // What a vertex becomes may be unused by the next level, but share its position in the
        // input with a vertex that is used and has been moved. It then goes where that one is, so
        // that triangles between the two have no area.
        let ids = input.position_ids();
        let mut next_vertex_at = vec![NONE; ids.len()];
        for (&v, index) in next_vertices.iter().zip(0..) {
            next_vertex_at[ids.of_vertex[v as usize] as usize] = index;
        }
        let position = |&(from, v): &(&Mesh, u32)| {
            let at_position = if std::ptr::eq(from, next) {
                NONE
            } else {
                next_vertex_at[ids.of_vertex[v as usize] as usize]
            };
            let (from, v) = if at_position == NONE { (from, v) } else { (next, at_position) };
            from.positions()[v as usize]
        };
        moved.positions = goals.iter().map(position).collect();
        for stream in &mut moved.attributes {
            let same = |a: &&Attribute| a.described() == stream.described();
            let sources = [next, input].map(|mesh| mesh.attributes().iter().find(same).cloned());
            let stride = stream.stride();
            for (v, &(from, goal)) in goals.iter().enumerate() {
                let source = if std::ptr::eq(from, next) { &sources[0] } else { &sources[1] };
                let submeshes = [from.vertex_submesh()[goal as usize], moved.vertex_submesh[v]];
                let is_taken = |a: &&Attribute| {
                    let [to, own] = submeshes.map(|s| &from.submeshes()[s as usize].attributes);
                    let is_normal = a.semantic == Semantic::Normal;
                    a.is_spatial() || submeshes[0] == submeshes[1] || is_normal && to == own
                };
                if let Some(source) = source.as_ref().filter(is_taken) {
                    stream.bytes[v * stride..][..stride].copy_from_slice(source.at(goal));
                }
            }
        }
        let first_remaining = simplified.collapses().floor(next_lod).0;
        let staying = vertices.len() - vertices.partition_point(|&v| v < first_remaining);
        let moving = if moves_all { 0 } else { staying as u32 }..count;
        let mesh_of = |parts| {
            Mesh::try_from(parts).map_err(|e| Error::Bug(format!("a level on its way: {e}")))
        };
        Ok(Self { mesh: mesh_of(mesh)?, next: mesh_of(moved)?, moving })
    }
}

/// The vertices that a level uses, in ascending order.
fn used_vertices(simplified: &Simplified, lod: Lod) -> Vec<u32> {
    let triangles = simplified.triangles_at(simplified.collapses().floor(lod));
    let mut vertices: Vec<u32> = triangles.iter().flat_map(|t| t.corners).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// Returns how far at most, in any of the shapes, vertices that a morph target has moved to `next`
/// are from those of the next level. They differ because joints and other morph targets move a
/// vertex after that: by its own joints and targets, or with `takes_joints` by the joints of the
/// vertex that it becomes. No point of the surface is farther off. 0 if nothing bends the mesh.
#[must_use]
pub fn pose_error(
    shapes: &[Shape],
    now: &Mesh,
    next: &Mesh,
    moving: &Range<u32>,
    takes_joints: bool,
) -> f64 {
    if !bends(now) {
        return 0.0;
    }
    farthest_vertex(shapes, &arrived(now, next, takes_joints), next, moving)
}

/// The vertices of `now` once a morph target has moved them to `next`. They keep their own deltas
/// of other morph targets and, unless they take those of what they become, their own joints.
pub(crate) fn arrived(now: &Mesh, next: &Mesh, takes_joints: bool) -> Mesh {
    let is_kept = |a: &Attribute| match a.semantic {
        Semantic::Joints(_) | Semantic::Weights(_) => !takes_joints,
        Semantic::Position => a.morph_target.is_some(),
        _ => false,
    };
    with_streams(next, now, is_kept)
}

/// A mesh with some of its streams those of another with the same vertices.
fn with_streams(mesh: &Mesh, other: &Mesh, taken: impl Fn(&Attribute) -> bool) -> Mesh {
    let mut parts = mesh.clone().into_parts();
    for (attribute, others) in parts.attributes.iter_mut().zip(other.attributes()) {
        if taken(attribute) && attribute.described() == others.described() {
            attribute.bytes.clone_from(&others.bytes);
        }
    }
    Mesh::try_from(parts).expect("other values of a mesh")
}

/// Returns where the vertices of `now` go if some of them stay where they are, given where each
/// would go.
#[must_use]
pub fn with_staying(now: &Mesh, next: Mesh, staying: &[u32]) -> Mesh {
    let mut parts = next.into_parts();
    for &v in staying {
        parts.positions[v as usize] = now.positions()[v as usize];
        for (attribute, own) in parts.attributes.iter_mut().zip(now.attributes()) {
            let stride = own.stride();
            attribute.bytes[v as usize * stride..][..stride].copy_from_slice(own.at(v));
        }
    }
    Mesh::try_from(parts).expect("values of vertices of a mesh")
}

/// Returns how far at most, in any of the shapes, vertices with the joints of what they become are
/// from where their own joints have them.
#[must_use]
pub fn joints_error(shapes: &[Shape], now: &Mesh, next: &Mesh, moving: &Range<u32>) -> f64 {
    farthest_vertex(shapes, &with_joints_of(now, next), now, moving)
}

/// The vertices of `now` with the joints of those that they become.
pub(crate) fn with_joints_of(now: &Mesh, next: &Mesh) -> Mesh {
    let of_skin = |a: &Attribute| matches!(a.semantic, Semantic::Joints(_) | Semantic::Weights(_));
    with_streams(now, next, of_skin)
}

/// Returns the [`MorphingLevel`] of each level of an object. The meshes have their vertices in the
/// order of the object's; the vertices of the last level do not move.
///
/// # Errors
/// As [`MorphingLevel::new`].
pub fn morphing_levels(
    object: &LodObject,
    levels: &[(Lod, &LevelMesh)],
    moves_all: bool,
) -> Result<Vec<MorphingLevel>, Error> {
    let next = |k: usize| levels.get(k + 1).unwrap_or(&levels[k]);
    let one = |k: usize| {
        let ((lod, now), (next_lod, next)) = (levels[k], *next(k));
        MorphingLevel::new(&object.simplified, (lod, &now.mesh), (next_lod, &next.mesh), moves_all)
    };
    (0..levels.len()).map(one).collect()
}
