//! Fits the texture coordinates of a refitted level by least squares to the input's, over the faces
//! around each: what lies between vertices counts, where looking values up at the vertices alone
//! lets a texture slide inside of large triangles.

use crate::attributes::stays;
use crate::blend::store;
use crate::interpolation::{Interpolation, Target};
use crate::level::CoarseMesh;
use crate::sides::sides;
use crate::ties::SurfaceTie;
use glam::DVec3;
use lodc_mesh::{Attribute, Mesh, MeshParts, NONE, Semantic};
use lodc_nearest::point_at;

/// How far from a face's own coordinates those at a tie may be, in its extent in the texture: what
/// is farther lies beyond a seam. Chosen by hand.
const MAX_JUMP: f64 = 1.0;
/// The cosine of the angle from one edge of a border to the next above which both count as one
/// line, and the share of the shorter one by which coordinates move along it at most. Chosen by
/// hand.
const STRAIGHT: f64 = 0.95;
const MAX_MOVE: f64 = 0.5;

/// Returns whether a mesh has anything to be fitted.
pub(crate) fn is_there(mesh: &Mesh) -> bool {
    mesh.attributes().iter().any(is_fitted)
}

fn is_fitted(stream: &Attribute) -> bool {
    matches!(stream.semantic, Semantic::TexCoord(_)) && stream.morph_target.is_none()
}

/// Replaces the texture coordinates in `parts`, a level of `mesh`, by those that fit the mesh's
/// best at `ties`. Starts from those that are there. Vertices that shared position and coordinates
/// still do, so no seam opens.
pub(crate) fn fit(
    mesh: &Mesh,
    charts: &[u32],
    level: &CoarseMesh,
    ties: &[SurfaceTie],
    parts: &mut MeshParts,
) {
    let befores = level.mesh.attributes().iter();
    let streams = mesh.attributes().iter().zip(befores).filter(|(from, _)| stays(from));
    for ((from, before), now) in streams.zip(&mut parts.attributes) {
        if !is_fitted(from) {
            continue;
        }
        let (of_vertex, first) = unknowns(level, before, now);
        let faces: Vec<[u32; 3]> =
            level.mesh.triangles().iter().map(|t| t.map(|v| of_vertex[v as usize])).collect();
        let mut system = Interpolation::new(&faces, first.len());
        for tie in ties {
            let corners = faces[tie.face as usize].map(|u| first[u as usize]);
            let vertices = mesh.triangles()[tie.triangle as usize];
            let target = Target {
                face: tie.face,
                barycentric: tie.on_face,
                value: point_at(vertices.map(|v| coordinates(from, v)), tie.on_triangle),
                weight: tie.weight,
            };
            let extent = (0..3).map(|k| corners[k].distance(corners[(k + 1) % 3]));
            let jump = system.interpolated(&target, &first).distance(target.value);
            if jump <= MAX_JUMP * extent.fold(0.0, f64::max) {
                system.add(&target);
            }
        }
        // Of a border they move along it alone: across it lie other charts, and what is between.
        let borders = borders(&faces, &first);
        let free = system.clone().solve(&first, &first, |_| false);
        let along = first.iter().zip(free).zip(&borders).map(|((&first, free), border)| {
            border.map_or(free, |border| border.moved(first, free - first))
        });
        let along: Vec<DVec3> = along.collect();
        let solved = system.solve(&along, &along, |v| borders[v].is_some());
        let ranges = ranges(mesh, charts, from);
        let mut range_of = vec![[DVec3::MIN, DVec3::MAX]; first.len()];
        for (face, &triangle) in faces.iter().zip(&level.input_triangles) {
            face.iter()
                .for_each(|&u| range_of[u as usize] = ranges[charts[triangle as usize] as usize]);
        }
        for (v, &unknown) in of_vertex.iter().enumerate() {
            let unknown = unknown as usize;
            let value = if borders[unknown].is_some() { along[unknown] } else { solved[unknown] };
            let [least, most] = range_of[unknown];
            let value = value.max(least).min(most);
            if value.is_finite() {
                store(now, v, &[value.x, value.y]);
            }
        }
    }
}

/// The least and the largest coordinates in each chart of a mesh.
fn ranges(mesh: &Mesh, charts: &[u32], stream: &Attribute) -> Vec<[DVec3; 2]> {
    let count = charts.iter().max().map_or(0, |&last| last as usize + 1);
    let mut ranges = vec![[DVec3::MAX, DVec3::MIN]; count];
    for (triangle, &chart) in mesh.triangles().iter().zip(charts) {
        let [least, most] = &mut ranges[chart as usize];
        for value in triangle.map(|v| coordinates(stream, v)) {
            (*least, *most) = (least.min(value), most.max(value));
        }
    }
    ranges
}

/// Where the coordinates of a vertex are on the border of a chart.
#[derive(Clone, Copy, Debug)]
struct Border {
    /// Along the border; zero at a corner.
    direction: DVec3,
    /// The length of the shorter of both edges.
    shortest: f64,
}

impl Border {
    /// Coordinates moved along the border only.
    fn moved(&self, first: DVec3, by: DVec3) -> DVec3 {
        let most = MAX_MOVE * self.shortest;
        first + self.direction * self.direction.dot(by).clamp(-most, most)
    }
}

/// For each unknown of `faces` with its coordinates, whether it is on a border: at an edge of one
/// face.
fn borders(faces: &[[u32; 3]], coordinates: &[DVec3]) -> Vec<Option<Border>> {
    // The points before and behind each on its border, and how many there are.
    let mut neighbours = vec![([NONE; 2], [0; 2]); coordinates.len()];
    for of_edge in sides(faces).chunk_by(|a, b| a.edge == b.edge) {
        let &[side] = of_edge else { continue };
        let (face, k) = (faces[side.face()], side.corner());
        let (from, to) = (face[k], face[(k + 1) % 3]);
        for (at, other, end) in [(from, to, 1), (to, from, 0)] {
            let (found, counts) = &mut neighbours[at as usize];
            found[end] = other;
            counts[end] += 1;
        }
    }
    let border = |(v, (found, counts)): (usize, ([u32; 2], [u32; 2]))| {
        let corner = Border { direction: DVec3::ZERO, shortest: 0.0 };
        match counts {
            [0, 0] => return None,
            [1, 1] => {}
            _ => return Some(corner),
        }
        let [before, behind] = found.map(|u| coordinates[u as usize]);
        let edges = [coordinates[v] - before, behind - coordinates[v]];
        let [a, b] = edges.map(DVec3::normalize_or_zero);
        if a.dot(b) < STRAIGHT {
            return Some(corner);
        }
        let shortest = edges[0].length().min(edges[1].length());
        Some(Border { direction: (edges[0] + edges[1]).normalize_or_zero(), shortest })
    };
    neighbours.into_iter().enumerate().map(border).collect()
}

/// For each vertex of a level its unknown, one for all that share submesh, position and what the
/// simplifier left them of a stream; and the mean of what `now` has for each.
fn unknowns(level: &CoarseMesh, before: &Attribute, now: &Attribute) -> (Vec<u32>, Vec<DVec3>) {
    let key = |v: u32| {
        let submesh = level.mesh.vertex_submesh()[v as usize];
        (level.point_of_vertex[v as usize], submesh, before.at(v))
    };
    let mut order: Vec<u32> = (0..level.mesh.vertex_count() as u32).collect();
    order.sort_unstable_by(|&a, &b| key(a).cmp(&key(b)).then(a.cmp(&b)));
    let (mut of_vertex, mut first) = (vec![NONE; order.len()], Vec::new());
    for equal in order.chunk_by(|&a, &b| key(a) == key(b)) {
        equal.iter().for_each(|&v| of_vertex[v as usize] = first.len() as u32);
        let sum: DVec3 = equal.iter().map(|&v| coordinates(now, v)).sum();
        first.push(sum / equal.len() as f64);
    }
    (of_vertex, first)
}

fn coordinates(stream: &Attribute, v: u32) -> DVec3 {
    DVec3::new(stream.value(v, 0).into(), stream.value(v, 1).into(), 0.0)
}
