//! The attributes of a refitted level: each moved vertex takes them from the nearest point of the
//! input's surface within its own chart.

use crate::blend::{Source, blend};
use crate::guard::cross;
use crate::input::Input;
use crate::level::CoarseMesh;
use crate::seams;
use glam::DVec3;
use lodc_mesh::{Attribute, Mesh, MeshParts, NONE, Semantic};
use rayon::prelude::*;

/// Vertices that one thread looks up one after the other, at least. Chosen by hand.
const MIN_VERTICES: usize = 1 << 8;

/// Returns the level with its points at `positions` and its attributes as `mesh`, LOD 0, has them
/// there.
///
/// A vertex takes them from the nearest point in its own chart, in which texture coordinates,
/// colours and normals are continuous. It keeps its own where that point is farther than it moved,
/// faces the other way (a thin sheet has two sides), or is beyond a seam. Positions come as `f32`:
/// a stream that held them quantised is left out.
pub(crate) fn resample(
    mesh: &Mesh,
    input: &Input,
    level: &CoarseMesh,
    positions: &[DVec3],
) -> MeshParts {
    let mut parts = level.mesh.clone().into_parts();
    for (p, &point) in parts.positions.iter_mut().zip(&level.point_of_vertex) {
        *p = positions[point as usize].as_vec3().to_array();
    }
    if mesh.attributes().is_empty() {
        return parts;
    }
    let chart_of_vertex = chart_of_vertex(input, level);
    let mut sources = find_sources(mesh, input, level, positions, &chart_of_vertex);
    seams::keep_to_own_side(mesh, level, &chart_of_vertex, &mut sources);
    // What moves a point in motion is one for all of its vertices, or a seam would open there.
    let spatial_sources = of_points(level, &sources);
    for (stream, from) in parts.attributes.iter_mut().zip(mesh.attributes()) {
        blend(stream, from, if from.is_spatial() { &spatial_sources } else { &sources });
    }
    crate::skin::blend(&mut parts, mesh, &spatial_sources);
    drop_quantised_positions(&mut parts);
    parts
}

/// Returns for each vertex of the level its chart, in which all attributes are continuous; [`NONE`]
/// without triangles.
fn chart_of_vertex(input: &Input, level: &CoarseMesh) -> Vec<u32> {
    let mut of_vertex = vec![NONE; level.mesh.vertex_count()];
    for (vertices, &t) in level.mesh.triangles().iter().zip(&level.input_triangles) {
        for &v in vertices {
            let chart = &mut of_vertex[v as usize];
            *chart = (*chart).min(input.shading_charts[t as usize]);
        }
    }
    of_vertex
}

/// Returns for each vertex of the level the point of LOD 0 that it takes its attributes from;
/// `None` where it keeps its own.
fn find_sources(
    mesh: &Mesh,
    input: &Input,
    level: &CoarseMesh,
    positions: &[DVec3],
    chart_of_vertex: &[u32],
) -> Vec<Option<Source>> {
    let normals = vertex_normals(level, positions);
    let find = |v: usize| {
        let (point, chart) = (level.point_of_vertex[v] as usize, chart_of_vertex[v]);
        let moved_squared = positions[point].distance_squared(level.points[point]);
        if moved_squared <= 0.0 || chart == NONE {
            return None;
        }
        let in_chart = |t: u32| input.shading_charts[t as usize] == chart;
        let nearest = input.tree.nearest_of(positions[point], moved_squared, in_chart)?;
        let faces_same_way = cross(input.tree.corners_of(nearest.triangle)).dot(normals[v]) >= 0.0;
        let vertices = mesh.triangles()[nearest.triangle as usize];
        faces_same_way.then_some(Source { vertices, weights: nearest.barycentric })
    };
    (0..level.mesh.vertex_count()).into_par_iter().with_min_len(MIN_VERTICES).map(find).collect()
}

/// Returns for each vertex the source of the first one at its point that has any.
fn of_points(level: &CoarseMesh, sources: &[Option<Source>]) -> Vec<Option<Source>> {
    let mut of_point: Vec<Option<Source>> = vec![None; level.points.len()];
    for (source, &point) in sources.iter().zip(&level.point_of_vertex) {
        let first = &mut of_point[point as usize];
        *first = first.or(*source);
    }
    level.point_of_vertex.iter().map(|&point| of_point[point as usize]).collect()
}

/// Returns for each vertex the sum of its triangles' normals, by area.
fn vertex_normals(level: &CoarseMesh, positions: &[DVec3]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; level.mesh.vertex_count()];
    for (t, corners) in level.mesh.triangles().iter().zip(level.corners(positions)) {
        for &v in t {
            normals[v as usize] += cross(corners);
        }
    }
    normals
}

/// Returns whether a stream of the input is one of a refitted level, too: positions that it held
/// quantised are not.
pub(crate) fn stays(stream: &Attribute) -> bool {
    stream.semantic != Semantic::Position || stream.morph_target.is_some()
}

fn drop_quantised_positions(parts: &mut MeshParts) {
    let mut kept = 0..;
    let new_index: Vec<Option<u32>> =
        parts.attributes.iter().map(|a| if stays(a) { kept.next() } else { None }).collect();
    parts.attributes.retain(stays);
    for submesh in &mut parts.submeshes {
        let new_indices = submesh.attributes.iter().filter_map(|&a| new_index[a as usize]);
        submesh.attributes = new_indices.collect();
    }
}
