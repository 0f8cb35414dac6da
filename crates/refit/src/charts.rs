//! Charts: connected regions of a surface over which attributes are continuous; and the curves
//! between them (seams, borders).

use crate::sides::{Side, sides};
use lodc_mesh::{DisjointSets, Mesh, NONE, PositionIds, Semantic};
use rayon::prelude::*;

/// Streams that have to agree at a position for two triangles to be of one chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Continuity {
    /// Texture coordinates and colours: what would show as a seam.
    Texture,
    /// Normals as well: a crease ends a chart.
    Shading,
}

impl Continuity {
    fn includes(self, semantic: &Semantic) -> bool {
        match semantic {
            Semantic::TexCoord(_) | Semantic::Color(_) => true,
            Semantic::Normal => self == Self::Shading,
            _ => false,
        }
    }
}

/// Returns the chart of each triangle, named by one of its vertices: triangles of one submesh are
/// connected by vertices whose position and streams are bit for bit the same.
pub(crate) fn charts(mesh: &Mesh, positions: &PositionIds, continuity: Continuity) -> Vec<u32> {
    let class_of = classes(mesh, positions, continuity);
    let mut sets = DisjointSets::new(mesh.vertex_count());
    for t in mesh.triangles() {
        let [a, b, c] = t.map(|v| class_of[v as usize]);
        sets.join(a, b);
        sets.join(a, c);
    }
    mesh.triangles().iter().map(|t| sets.find(class_of[t[0] as usize])).collect()
}

/// Returns for each vertex the first vertex that it is equal to.
fn classes(mesh: &Mesh, positions: &PositionIds, continuity: Continuity) -> Vec<u32> {
    let streams: Vec<_> = mesh
        .attributes()
        .iter()
        .filter(|a| a.morph_target.is_none() && continuity.includes(&a.semantic))
        .collect();
    let key = |v: u32| (mesh.vertex_submesh()[v as usize], positions.of_vertex[v as usize]);
    let mut order: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
    order.par_sort_unstable_by(|&a, &b| {
        let mut ordering = key(a).cmp(&key(b));
        for stream in &streams {
            ordering = ordering.then_with(|| stream.at(a).cmp(stream.at(b)));
        }
        ordering.then(a.cmp(&b))
    });
    let is_equal = |a: u32, b: u32| key(a) == key(b) && streams.iter().all(|s| s.at(a) == s.at(b));
    let mut class_of = vec![NONE; mesh.vertex_count()];
    for run in order.chunk_by(|&a, &b| is_equal(a, b)) {
        run.iter().for_each(|&v| class_of[v as usize] = run[0]);
    }
    class_of
}

/// Returns the curve edges of a surface as `3 * face + corner` of one side each: edges that one
/// face has alone, that more than two share, or where charts meet. Faces are given by positions;
/// `charts` has the chart of each.
pub(crate) fn curves(faces: &[[u32; 3]], charts: &[u32]) -> Vec<u32> {
    let sides = sides(faces);
    let is_inner =
        |edge: &[Side]| edge.len() == 2 && charts[edge[0].face()] == charts[edge[1].face()];
    let edges = sides.chunk_by(|a, b| a.edge == b.edge);
    let mut curves: Vec<u32> =
        edges.filter(|edge| !is_inner(edge)).map(|edge| edge[0].half_edge).collect();
    curves.sort_unstable();
    curves
}
