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
/// `input_tree` is the tree of the input's triangles.
///
/// A vertex takes them from the nearest point in its own chart, in which texture coordinates,
/// colours and normals are continuous. It keeps its own where that point is farther than it moved,
/// faces the other way (a thin sheet has two sides), or is beyond a seam. Positions come as `f32`:
/// a stream that held them quantised is left out.
pub(crate) fn resample(
    input: &Mesh,
    input_tree: &TriangleTree,
    level: &Level,
    positions: &[DVec3],
) -> MeshParts {
    let mut parts = level.mesh.clone().into_parts();
    for (p, &point) in parts.positions.iter_mut().zip(&level.point_of_vertex) {
        *p = positions[point as usize].as_vec3().to_array();
    }
    if input.attributes().is_empty() {
        return parts;
    }
    let charts = Charts::new(input, level);
    let mut sources = find_sources(input, input_tree, level, positions, &charts);
    seams::keep_to_own_side(input, level, &charts.of_vertex, &mut sources);
    for (stream, from) in parts.attributes.iter_mut().zip(input.attributes()) {
        blend(stream, from, &sources);
    }
    crate::skin::blend(&mut parts, input, &sources);
    drop_quantised_positions(&mut parts);
    parts
}

/// Charts in which all attributes are continuous. Each is named by one of the input's vertices.
struct Charts {
    /// The chart of each triangle of the input.
    of_triangle: Vec<u32>,
    /// The chart of each vertex of the level; [`NONE`] without triangles.
    of_vertex: Vec<u32>,
}

impl Charts {
    fn new(input: &Mesh, level: &Level) -> Self {
        let of_triangle = charts(input, Continuity::Shading);
        let mut of_vertex = vec![NONE; level.mesh.vertex_count()];
        for (vertices, &t) in level.mesh.triangles().iter().zip(&level.input_triangles) {
            for &v in vertices {
                let chart = &mut of_vertex[v as usize];
                *chart = (*chart).min(of_triangle[t as usize]);
            }
        }
        Self { of_triangle, of_vertex }
    }
}

/// Returns for each vertex of the level the point of the input that it takes its attributes from;
/// `None` where it keeps its own.
fn find_sources(
    input: &Mesh,
    input_tree: &TriangleTree,
    level: &Level,
    positions: &[DVec3],
    charts: &Charts,
) -> Vec<Option<Source>> {
    let moved_squared = |v: usize| {
        let point = level.point_of_vertex[v] as usize;
        positions[point].distance_squared(level.points[point])
    };
    let chart_count = input.vertex_count();
    let triangles_of_charts = charts.of_triangle.iter().zip(0..).map(|(&chart, t)| (chart, t));
    let triangles_of_charts = Csr::new(chart_count, triangles_of_charts);
    let moving_vertices: Vec<(u32, u32)> = (0..charts.of_vertex.len())
        .filter(|&v| moved_squared(v) > 0.0 && charts.of_vertex[v] != NONE)
        .map(|v| (charts.of_vertex[v], v as u32))
        .collect();
    let moving_vertices = Csr::new(chart_count, moving_vertices.into_iter());

    let normals = vertex_normals(level, positions);
    let position = |v: u32| DVec3::from_array(input.positions()[v as usize].map(f64::from));
    let find_in_chart = |chart: u32| -> Vec<(u32, Option<Source>)> {
        let triangles = triangles_of_charts.row(chart);
        let corners = triangles.iter().map(|&t| input.triangles()[t as usize].map(position));
        let corners: Vec<[DVec3; 3]> = corners.collect();
        let has_all_triangles = triangles.len() == input.triangles().len();
        let tree = if has_all_triangles { input_tree } else { &TriangleTree::new(&corners) };
        let find = |&v: &u32| {
            let p = positions[level.point_of_vertex[v as usize] as usize];
            let nearest = tree.nearest(p, NONE).filter(|nearest| {
                let normal = cross(corners[nearest.triangle as usize]);
                let faces_same_way = normal.dot(normals[v as usize]) >= 0.0;
                nearest.squared <= moved_squared(v as usize) && faces_same_way
            });
            let source = nearest.map(|nearest| {
                let t = triangles[nearest.triangle as usize];
                let vertices = input.triangles()[t as usize];
                Source { vertices, weights: nearest.barycentric }
            });
            (v, source)
        };
        moving_vertices.row(chart).par_iter().map(find).collect()
    };
    let is_used = |&chart: &u32| !moving_vertices.row(chart).is_empty();
    let used_charts: Vec<u32> = (0..chart_count as u32).filter(is_used).collect();
    let found: Vec<Vec<(u32, Option<Source>)>> =
        used_charts.into_par_iter().map(find_in_chart).collect();
    let mut sources = vec![None; level.mesh.vertex_count()];
    for (v, source) in found.into_iter().flatten() {
        sources[v as usize] = source;
    }
    sources
}

/// Returns for each vertex the sum of its triangles' normals, by area.
fn vertex_normals(level: &Level, positions: &[DVec3]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; level.mesh.vertex_count()];
    for (t, corners) in level.mesh.triangles().iter().zip(level.corners(positions)) {
        for &v in t {
            normals[v as usize] += cross(corners);
        }
    }
    normals
}

fn drop_quantised_positions(parts: &mut MeshParts) {
    let stays = |a: &Attribute| a.semantic != Semantic::Position || a.morph_target.is_some();
    let mut kept = 0..;
    let new_index: Vec<Option<u32>> =
        parts.attributes.iter().map(|a| if stays(a) { kept.next() } else { None }).collect();
    parts.attributes.retain(stays);
    for submesh in &mut parts.submeshes {
        let new_indices = submesh.attributes.iter().filter_map(|&a| new_index[a as usize]);
        submesh.attributes = new_indices.collect();
    }
}
