//! Where the vertices of each level of a chain move as the next, coarser level takes over: the data
//! of its morph targets.

use crate::{Error, LodObject, level_mesh::LevelMesh};
use lodc_mesh::{
    Attribute, Lod, Mesh, MeshParts, NONE, PositionIds, Semantic, Simplified, Submesh,
};
use lodc_scene::Shape;
use std::ops::Range;

/// A level as a mesh of its own, and where its vertices go.
#[derive(Clone, Debug)]
pub struct GlidingLevel {
    /// The level, vertices that disappear last first.
    pub mesh: Mesh,
    /// The same vertices where the next level has them, without triangles.
    pub next: Mesh,
    /// The vertices that move.
    pub moving: Range<u32>,
}

impl GlidingLevel {
    /// Returns the level `now` of an object on its way to the level `next`. Both are meshes of
    /// their own with the vertices in the order of the object's mesh, moved or not.
    ///
    /// # Errors
    /// If a level has other vertices than its triangles need: a bug.
    pub fn new(
        simplified: &Simplified,
        (lod, now): (Lod, &Mesh),
        (next_lod, next): (Lod, &Mesh),
        moves_all: bool,
    ) -> Result<Self, Error> {
        let [own, others] = [lod, next_lod].map(|lod| used(simplified, lod));
        if own.len() != now.vertex_count() || others.len() != next.vertex_count() {
            return Err(Error::Bug("a level has other vertices than its triangles".to_owned()));
        }
        let becomes = simplified.collapses().resolve_all(simplified.collapses().floor(next_lod));
        let input = simplified.mesh();
        // The values of each vertex, the last to disappear first, at the next level; of one that
        // nothing of it uses, in the input.
        let goal = |&v: &u32| match others.binary_search(&becomes[v as usize]) {
            Ok(place) => (next, place as u32),
            Err(_) => (input, becomes[v as usize]),
        };
        let goals: Vec<(&Mesh, u32)> = own.iter().rev().map(goal).collect();
        let last = now.vertex_count() as u32;
        let order: Vec<u32> = (0..last).rev().collect();
        let gathered = |triangles: Vec<[u32; 3]>, submeshes: Vec<Submesh>| MeshParts {
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
        let turned = now.triangles().iter().map(|t| t.map(|v| last - 1 - v)).collect();
        let mesh = gathered(turned, now.submeshes().to_vec());
        let none = |s: &Submesh| Submesh {
            first_triangle: 0,
            triangle_count: 0,
            attributes: s.attributes.clone(),
        };
        let mut moved = gathered(Vec::new(), now.submeshes().iter().map(none).collect());
        // A vertex that no triangle of the next level uses may share its place with one that is
        // used, and has moved: triangles between the two have no area.
        let ids = PositionIds::new(input.positions());
        let mut shown = vec![NONE; ids.len()];
        for (&v, place) in others.iter().zip(0..) {
            shown[ids.of_vertex[v as usize] as usize] = place;
        }
        let place = |&(from, v): &(&Mesh, u32)| {
            let there = if std::ptr::eq(from, next) {
                NONE
            } else {
                shown[ids.of_vertex[v as usize] as usize]
            };
            let (from, v) = if there == NONE { (from, v) } else { (next, there) };
            from.positions()[v as usize]
        };
        moved.positions = goals.iter().map(place).collect();
        for stream in &mut moved.attributes {
            let same = |a: &&Attribute| a.described() == stream.described();
            let sources = [next, input].map(|mesh| mesh.attributes().iter().find(same).cloned());
            let stride = stream.stride();
            for (v, &(from, goal)) in goals.iter().enumerate() {
                let source = if std::ptr::eq(from, next) { &sources[0] } else { &sources[1] };
                let is_own = from.vertex_submesh()[goal as usize] == moved.vertex_submesh[v];
                if let Some(source) = source.as_ref().filter(|a| a.is_spatial() || is_own) {
                    stream.bytes[v * stride..][..stride].copy_from_slice(source.at(goal));
                }
            }
        }
        let gone = simplified.collapses().floor(next_lod).0;
        let first = own.len() - own.partition_point(|&v| v < gone);
        let moving = if moves_all { 0 } else { first as u32 }..last;
        let of = |parts| {
            Mesh::try_from(parts).map_err(|e| Error::Bug(format!("a level on its way: {e}")))
        };
        Ok(Self { mesh: of(mesh)?, next: of(moved)?, moving })
    }
}

/// The vertices that a level uses, rising.
fn used(simplified: &Simplified, lod: Lod) -> Vec<u32> {
    let triangles = simplified.triangles_at(simplified.collapses().floor(lod));
    let mut used: Vec<u32> = triangles.iter().flat_map(|t| t.corners).collect();
    used.sort_unstable();
    used.dedup();
    used
}

/// Returns how far, in some shapes, vertices that have moved to where `next` has them are from
/// those of the next level: morph targets move what joints and other targets move afterwards, each
/// vertex by its own, or with `joints` by the joints of the one that it becomes. Above it no point
/// of the surface is off. 0 where nothing bends.
#[must_use]
pub fn pose_error(
    shapes: &[Shape],
    now: &Mesh,
    next: &Mesh,
    moving: &Range<u32>,
    joints: bool,
) -> f64 {
    if !bends(now) {
        return 0.0;
    }
    let is_kept = |a: &Attribute| match a.semantic {
        Semantic::Joints(_) | Semantic::Weights(_) => !joints,
        Semantic::Position => a.morph_target.is_some(),
        _ => false,
    };
    let mut parts = next.clone().into_parts();
    for (own, before) in parts.attributes.iter_mut().zip(now.attributes()) {
        if is_kept(own) && own.described() == before.described() {
            own.bytes.clone_from(&before.bytes);
        }
    }
    farthest(shapes, &Mesh::try_from(parts).expect("other values of a mesh"), next, moving)
}

/// Returns how far, in some shapes, vertices with the joints of what they become are from where
/// they belong.
#[must_use]
pub fn joints_error(shapes: &[Shape], now: &Mesh, next: &Mesh, moving: &Range<u32>) -> f64 {
    let mut parts = now.clone().into_parts();
    for (own, after) in parts.attributes.iter_mut().zip(next.attributes()) {
        let is_taken = matches!(own.semantic, Semantic::Joints(_) | Semantic::Weights(_));
        if is_taken && own.described() == after.described() {
            own.bytes.clone_from(&after.bytes);
        }
    }
    farthest(shapes, &Mesh::try_from(parts).expect("other values of a mesh"), now, moving)
}

fn farthest(shapes: &[Shape], a: &Mesh, b: &Mesh, moving: &Range<u32>) -> f64 {
    let in_shape = |shape: &Shape| {
        let (a, b) = (shape.of(a), shape.of(b));
        let between = |v: u32| {
            let [p, q] = [a[v as usize], b[v as usize]].map(|p| p.map(f64::from));
            (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
        };
        moving.clone().map(between).fold(0.0, f64::max)
    };
    shapes.iter().map(in_shape).fold(0.0, f64::max)
}

/// Returns whether joints or morph targets move a mesh.
#[must_use]
pub fn bends(mesh: &Mesh) -> bool {
    let moves =
        |a: &Attribute| matches!(a.semantic, Semantic::Joints(_)) || a.morph_target.is_some();
    mesh.attributes().iter().any(moves)
}

/// Returns the levels of an object, each as [`GlidingLevel`] has it, of meshes in the order of the
/// object's; the last moves nowhere.
///
/// # Errors
/// As [`GlidingLevel::new`].
pub fn gliding_levels(
    object: &LodObject,
    levels: &[(Lod, &LevelMesh)],
    moves_all: bool,
) -> Result<Vec<GlidingLevel>, Error> {
    let next = |k: usize| levels.get(k + 1).unwrap_or(&levels[k]);
    let one = |k: usize| {
        let ((lod, now), (next_lod, next)) = (levels[k], *next(k));
        GlidingLevel::new(&object.simplified, (lod, &now.mesh), (next_lod, &next.mesh), moves_all)
    };
    (0..levels.len()).map(one).collect()
}
