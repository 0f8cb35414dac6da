//! Fits the normals of a refitted level by least squares to those of the input, over the faces
//! around each.
//!
//! What counts is the normal that is interpolated between the corners of a face and scaled to unit
//! length. So the fit is repeated, each time to the input's normals scaled to the length that the
//! level's interpolated ones have there.

use crate::blend::store;
use crate::guard::cross;
use crate::input::Input;
use crate::interpolation::{Interpolation, Target};
use crate::level::CoarseMesh;
use crate::ties::SurfaceTie;
use glam::DVec3;
use lodc_mesh::{Attribute, Mesh, MeshParts, NONE, Semantic, Submesh};
use lodc_nearest::point_at;

/// Number of fits. Chosen by hand.
const FITS: usize = 3;
/// Length below which a fitted normal has no direction worth following: the input's cancel out.
/// Chosen by hand.
const MIN_LENGTH: f64 = 0.1;
/// Cosine below which normals are perpendicular to a face, as far as can be told. Chosen by hand.
const PERPENDICULAR: f64 = 1e-3;

/// Replaces the normals in `parts`, a level with its points at `positions`, by those that fit the
/// input's best; tangents follow. Starts from the normals that are there. Without normals nothing
/// happens. Returns the faces that face away from a normal of theirs, whatever is done, and did not
/// where the simplifier left them.
pub(crate) fn fit(
    normals: &InputNormals<'_>,
    input: &Input,
    level: &CoarseMesh,
    positions: &[DVec3],
    ties: &[SurfaceTie],
    parts: &mut MeshParts,
) -> Vec<usize> {
    if normals.is_empty() {
        return Vec::new();
    }
    let unknowns = Unknowns::new(level, parts);
    let corners = level.corners(positions);
    let targets = normals.targets(input, level, &corners, ties, &unknowns);
    let mut fitted = unknowns.first.clone();
    for _ in 0..FITS {
        let mut system = Interpolation::new(&unknowns.faces, fitted.len());
        for target in &targets {
            // The length of what is interpolated now: so that directions count, not lengths.
            let length = system.interpolated(target, &fitted).length();
            system.add(&Target { value: target.value * length, ..*target });
        }
        let solved = system.solve(&fitted, &unknowns.first, |_| false);
        for ((normal, solved), first) in fitted.iter_mut().zip(solved).zip(&unknowns.first) {
            if solved.length() > MIN_LENGTH && solved.dot(*first) > 0.0 {
                *normal = solved.normalize();
            }
        }
    }
    for other in [&unknowns.first, &unknowns.unmoved] {
        refuse(&unknowns.faces, &corners, other, &mut fitted);
    }
    store_normals(&unknowns, &fitted, parts);
    let before = level.corners(&level.points);
    let is_refused = |&f: &usize| {
        let was = |u| faces_away(&unknowns.faces[f], before[f], &unknowns.unmoved).any(|b| b == u);
        faces_away(&unknowns.faces[f], corners[f], &fitted).any(|u| !was(u))
    };
    (0..corners.len()).filter(is_refused).collect()
}

/// Returns the unknowns of a face whose normals it faces away from.
fn faces_away<'n>(
    unknowns: &'n [u32; 3],
    corners: [DVec3; 3],
    normals: &'n [DVec3],
) -> impl Iterator<Item = usize> + 'n {
    let normal = cross(corners);
    let limit = -PERPENDICULAR * normal.length();
    let is_away = move |u: &usize| normals[*u].dot(normal) < limit;
    unknowns.iter().filter(|u| **u != NONE).map(|&u| u as usize).filter(is_away)
}

/// Replaces fitted normals that a face of theirs faces away from by others.
fn refuse(faces: &[[u32; 3]], corners: &[[DVec3; 3]], others: &[DVec3], fitted: &mut [DVec3]) {
    let mut refused: Vec<usize> = Vec::new();
    for (unknowns, &corners) in faces.iter().zip(corners) {
        refused.extend(faces_away(unknowns, corners, fitted));
    }
    for u in refused {
        fitted[u] = others[u];
    }
}

/// The normals of a level as unknowns: one for all vertices that share position and normal, and for
/// all of a flat face, whose corners share one normal, and of flat faces that meet there.
struct Unknowns {
    /// For each vertex its unknown; [`NONE`] without a normal.
    of_vertex: Vec<u32>,
    /// The same by the corners of faces.
    faces: Vec<[u32; 3]>,
    /// The unit normals at the start.
    first: Vec<DVec3>,
    /// The unit normals where the simplifier left the level.
    unmoved: Vec<DVec3>,
}

impl Unknowns {
    fn new(level: &CoarseMesh, parts: &MeshParts) -> Self {
        let submeshes = (&parts.submeshes[..], &parts.vertex_submesh[..]);
        let normals = unit_normals(&parts.attributes, submeshes);
        let level_submeshes = (level.mesh.submeshes(), level.mesh.vertex_submesh());
        let level_normals = unit_normals(level.mesh.attributes(), level_submeshes);
        let key = |v: u32| {
            (
                level.point_of_vertex[v as usize],
                level_normals[v as usize].to_array().map(f64::to_bits),
            )
        };
        let has_normal = |v: &u32| level_normals[*v as usize] != DVec3::ZERO;
        let mut order: Vec<u32> = (0..level_normals.len() as u32).filter(has_normal).collect();
        order.sort_unstable_by_key(|&v| (key(v), v));
        let mut of_vertex = vec![NONE; level_normals.len()];
        let (mut first, mut unmoved) = (Vec::new(), Vec::new());
        for equal in order.chunk_by(|&a, &b| key(a) == key(b)) {
            let sum: DVec3 = equal.iter().map(|&v| normals[v as usize]).sum();
            equal.iter().for_each(|&v| of_vertex[v as usize] = first.len() as u32);
            unmoved.push(level_normals[equal[0] as usize]);
            first.push(sum.try_normalize().unwrap_or(level_normals[equal[0] as usize]));
        }
        let mut faces: Vec<[u32; 3]> =
            level.mesh.triangles().iter().map(|t| t.map(|v| of_vertex[v as usize])).collect();
        let joined = joined_by_flat_faces(&faces, &unmoved);
        let mut sums = vec![DVec3::ZERO; unmoved.len()];
        joined.iter().zip(&first).for_each(|(&to, normal)| sums[to as usize] += normal);
        for (u, &to) in joined.iter().enumerate() {
            first[u] = sums[to as usize].try_normalize().unwrap_or(unmoved[u]);
        }
        let known = of_vertex.iter_mut().chain(faces.as_flattened_mut()).filter(|u| **u != NONE);
        known.for_each(|u| *u = joined[*u as usize]);
        Self { of_vertex, faces, first, unmoved }
    }
}

/// For each unknown the first of those that are one with it, since flat faces join them.
fn joined_by_flat_faces(faces: &[[u32; 3]], normals: &[DVec3]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..normals.len() as u32).collect();
    let root = |parent: &mut [u32], mut u: u32| {
        while parent[u as usize] != u {
            parent[u as usize] = parent[parent[u as usize] as usize];
            u = parent[u as usize];
        }
        u
    };
    for &[a, b, c] in faces.iter().filter(|f| !f.contains(&NONE)) {
        let [na, nb, nc] = [a, b, c].map(|u| normals[u as usize]);
        if na != nb || nb != nc {
            continue;
        }
        for other in [b, c] {
            let (x, y) = (root(&mut parent, a), root(&mut parent, other));
            parent[x.max(y) as usize] = x.min(y);
        }
    }
    (0..normals.len() as u32).map(|u| root(&mut parent, u)).collect()
}

/// Returns the unit normal of each vertex; zero where it has none. `submeshes` come with those of
/// the vertices.
fn unit_normals(attributes: &[Attribute], submeshes: (&[Submesh], &[u32])) -> Vec<DVec3> {
    let stream_of = |s: &Submesh| direction_stream(attributes, s, &Semantic::Normal);
    let streams: Vec<Option<usize>> = submeshes.0.iter().map(stream_of).collect();
    let normal = |(v, &submesh): (u32, &u32)| {
        streams[submesh as usize]
            .map_or(DVec3::ZERO, |stream| direction(&attributes[stream], v).normalize_or_zero())
    };
    (0..).zip(submeshes.1).map(normal).collect()
}

/// Returns the first three components of a vertex in a stream.
fn direction(stream: &Attribute, v: u32) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|k| f64::from(stream.value(v, k))))
}

/// Returns the stream of a submesh that has directions with a meaning.
fn direction_stream(
    attributes: &[Attribute],
    submesh: &Submesh,
    semantic: &Semantic,
) -> Option<usize> {
    submesh.attributes.iter().map(|&a| a as usize).find(|&a| {
        let a = &attributes[a];
        a.semantic == *semantic && a.morph_target.is_none() && a.components >= 3
    })
}

/// The input with its unit normals.
pub(crate) struct InputNormals<'a> {
    mesh: &'a Mesh,
    /// Empty if no vertex has one.
    of_vertex: Vec<DVec3>,
}

impl<'a> InputNormals<'a> {
    pub(crate) fn new(mesh: &'a Mesh) -> Self {
        let submeshes = (mesh.submeshes(), mesh.vertex_submesh());
        let has_normals = mesh.attributes().iter().any(|a| a.semantic == Semantic::Normal);
        let of_vertex =
            if has_normals { unit_normals(mesh.attributes(), submeshes) } else { Vec::new() };
        Self { mesh, of_vertex }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.of_vertex.is_empty()
    }

    /// Returns the input's normals at ties. Only within a chart, and only where normal and face are
    /// on the same side.
    fn targets(
        &self,
        input: &Input,
        level: &CoarseMesh,
        corners: &[[DVec3; 3]],
        ties: &[SurfaceTie],
        unknowns: &Unknowns,
    ) -> Vec<Target> {
        let charts = &input.shading_charts;
        let crosses: Vec<DVec3> = corners.iter().map(|&t| cross(t)).collect();
        let target = |tie: &SurfaceTie| {
            let (face, triangle) = (tie.face as usize, tie.triangle as usize);
            let value = self.normal_at(triangle, tie.on_triangle);
            let counts = charts[triangle] == charts[level.input_triangles[face] as usize]
                && value.dot(crosses[face]) > 0.0
                && !unknowns.faces[face].contains(&NONE);
            let (barycentric, weight) = (tie.on_face, tie.weight);
            counts.then_some(Target { face: tie.face, barycentric, value, weight })
        };
        ties.iter().filter_map(target).collect()
    }

    fn normal_at(&self, triangle: usize, barycentric: [f64; 3]) -> DVec3 {
        let corners = self.mesh.triangles()[triangle].map(|v| self.of_vertex[v as usize]);
        point_at(corners, barycentric).normalize_or_zero()
    }
}

/// Writes normals into their streams, and makes tangents perpendicular to them.
fn store_normals(unknowns: &Unknowns, fitted: &[DVec3], parts: &mut MeshParts) {
    let streams = |s: &Submesh| {
        [Semantic::Normal, Semantic::Tangent]
            .map(|semantic| direction_stream(&parts.attributes, s, &semantic))
    };
    let streams: Vec<[Option<usize>; 2]> = parts.submeshes.iter().map(streams).collect();
    for (v, &unknown) in unknowns.of_vertex.iter().enumerate().filter(|(_, u)| **u != NONE) {
        let normal = fitted[unknown as usize];
        let [normals, tangents] = streams[parts.vertex_submesh[v] as usize];
        if let Some(stream) = normals {
            store(&mut parts.attributes[stream], v, &normal.to_array());
        }
        let Some(stream) = tangents else { continue };
        let tangent = direction(&parts.attributes[stream], v as u32);
        if let Some(tangent) = (tangent - normal * tangent.dot(normal)).try_normalize() {
            store(&mut parts.attributes[stream], v, &tangent.to_array());
        }
    }
}
