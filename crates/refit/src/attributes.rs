//! The attributes of a refitted level: each moved vertex takes them from the nearest point of the
//! input's surface within its own chart.

use crate::blend::{Source, blend};
use crate::charts::{Continuity, charts};
use crate::guard::cross;
use crate::level::Level;
use crate::seams;
use glam::DVec3;
use lodc_mesh::{Attribute, Csr, Mesh, MeshParts, NONE, Semantic};
use lodc_nearest::TriangleTree;
use rayon::prelude::*;

/// Returns the level with its points at `positions` and its attributes as the input has them there;
/// `whole` is the tree of the input's triangles.
///
/// A vertex searches the nearest point in its own chart, in which texture coordinates, colours and
/// normals are continuous. It keeps what it has where that is farther than it moved, faces the
/// other way (a thin sheet has two sides), or lies beyond a seam. Positions come as `f32`: a stream
/// that held them quantised is left out.
pub(crate) fn resample(
    input: &Mesh,
    whole: &TriangleTree,
    level: &Level,
    positions: &[DVec3],
) -> MeshParts {
    let mut parts = level.mesh.clone().into_parts();
    for (p, &point) in parts.positions.iter_mut().zip(&level.point_of) {
        *p = positions[point as usize].as_vec3().to_array();
    }
    if input.attributes().is_empty() {
        return parts;
    }
    let chart = charts(input, Continuity::Shading);
    let chart_of = charts_of_vertices(level, &chart);
    let mut sources = sources((input, whole), level, positions, &chart, &chart_of);
    seams::keep_to_own_side(input, level, &chart_of, &mut sources);
    for (stream, from) in parts.attributes.iter_mut().zip(input.attributes()) {
        blend(stream, from, &sources);
    }
    crate::skin::blend(&mut parts, input, &sources);
    drop_quantised_positions(&mut parts);
    parts
}

/// The chart of each vertex of the level; [`NONE`] without triangles.
fn charts_of_vertices(level: &Level, chart: &[u32]) -> Vec<u32> {
    let mut chart_of = vec![NONE; level.mesh.vertex_count()];
    for (t, &source) in level.mesh.triangles().iter().zip(&level.source) {
        for &v in t {
            let own = &mut chart_of[v as usize];
            *own = (*own).min(chart[source as usize]);
        }
    }
    chart_of
}

fn sources(
    (input, whole): (&Mesh, &TriangleTree),
    level: &Level,
    positions: &[DVec3],
    chart: &[u32],
    chart_of: &[u32],
) -> Vec<Source> {
    let moved = |v: usize| {
        let point = level.point_of[v] as usize;
        positions[point].distance_squared(level.points[point])
    };
    let rows = input.vertex_count();
    let triangles = Csr::new(rows, chart.iter().zip(0..).map(|(&c, t)| (c, t)));
    let moving_vertices = (0..chart_of.len()).filter(|&v| moved(v) > 0.0 && chart_of[v] != NONE);
    let moving_vertices: Vec<(u32, u32)> =
        moving_vertices.map(|v| (chart_of[v], v as u32)).collect();
    let moving_vertices = Csr::new(rows, moving_vertices.into_iter());

    let facing = facing(level, positions);
    let point = |v: u32| DVec3::from_array(input.positions()[v as usize].map(f64::from));
    let in_chart = |c: u32| -> Vec<(u32, Source)> {
        let own = triangles.row(c);
        let corners = own.iter().map(|&t| input.triangles()[t as usize].map(point));
        let corners: Vec<[DVec3; 3]> = corners.collect();
        let is_all = own.len() == input.triangles().len();
        let tree = if is_all { whole } else { &TriangleTree::new(&corners) };
        let find = |&v: &u32| {
            let p = positions[level.point_of[v as usize] as usize];
            let nearest_point = tree.nearest(p, NONE).filter(|n| {
                let faces_same_way =
                    cross(corners[n.triangle as usize]).dot(facing[v as usize]) >= 0.0;
                n.squared <= moved(v as usize) && faces_same_way
            });
            let corners = |t: u32| input.triangles()[own[t as usize] as usize];
            (v, nearest_point.map(|n| (corners(n.triangle), n.barycentric)))
        };
        moving_vertices.row(c).par_iter().map(find).collect()
    };
    let used: Vec<u32> = (0..rows as u32).filter(|&c| !moving_vertices.row(c).is_empty()).collect();
    let nearest_point: Vec<Vec<(u32, Source)>> = used.into_par_iter().map(in_chart).collect();
    let mut sources = vec![None; level.mesh.vertex_count()];
    for (v, source) in nearest_point.into_iter().flatten() {
        sources[v as usize] = source;
    }
    sources
}

/// For each vertex the sum of its triangles' normals, by area.
fn facing(level: &Level, positions: &[DVec3]) -> Vec<DVec3> {
    let mut facing = vec![DVec3::ZERO; level.mesh.vertex_count()];
    for (t, corners) in level.mesh.triangles().iter().zip(level.corners(positions)) {
        for &v in t {
            facing[v as usize] += cross(corners);
        }
    }
    facing
}

fn drop_quantised_positions(parts: &mut MeshParts) {
    let stays = |a: &Attribute| a.semantic != Semantic::Position || a.morph_target.is_some();
    let mut next = 0;
    let new_index: Vec<Option<u32>> = (parts.attributes.iter())
        .map(|a| {
            stays(a).then(|| {
                next += 1;
                next - 1
            })
        })
        .collect();
    parts.attributes.retain(stays);
    for submesh in &mut parts.submeshes {
        let new_indices = submesh.attributes.iter().filter_map(|&a| new_index[a as usize]);
        submesh.attributes = new_indices.collect();
    }
}
