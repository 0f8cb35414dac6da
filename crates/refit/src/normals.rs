//! Fits the normals of a refitted level by least squares to those of the input, over the faces
//! around each.
//!
//! What counts is the normal that is interpolated between the corners of a face and scaled to unit
//! length. So the fit is repeated, each time to the input's normals scaled to the length that the
//! level's interpolated ones have there.

use crate::blend::store;
use crate::charts::{Continuity, charts};
use crate::guard::cross;
use crate::input::Input;
use crate::level::Level;
use crate::quadrature::SIX_POINTS;
use glam::DVec3;
use lodc_mesh::{Mesh, MeshParts, NONE, Semantic};
use lodc_nearest::{TriangleTree, point_at};
use rayon::prelude::*;

/// Number of fits. Chosen by hand.
const FITS: usize = 3;
/// Length below which a fitted normal has no direction worth following: the input's cancel out.
/// Chosen by hand.
const MIN_LENGTH: f64 = 0.1;
/// Pull towards the normals at the start, as a share of a normal's own weight. Chosen by hand.
const DAMPING: f64 = 0.02;
/// The least weight that this counts with, as a share of the mean one. Chosen by hand.
const MIN_WEIGHT_SHARE: f64 = 0.1;
/// The most steps of conjugate gradients, and the share of the first residual at which they end.
/// Chosen by hand.
const MAX_STEPS: usize = 30;
const END_RESIDUAL: f64 = 1e-4;
/// Samples, or faces, that one thread looks up one after the other. Chosen by hand.
const SAMPLES_PER_THREAD: usize = 1 << 8;

/// Replaces the normals in `parts`, a level with its points at `positions`, by those that fit the
/// input's best; tangents follow. Starts from the normals that are there. Without normals nothing
/// happens.
pub(crate) fn fit(
    mesh: &Mesh,
    input: &Input,
    level: &Level,
    positions: &[DVec3],
    parts: &mut MeshParts,
) {
    if !mesh.attributes().iter().any(|a| a.semantic == Semantic::Normal) {
        return;
    }
    let input_parts = mesh.clone().into_parts();
    let unknowns = Unknowns::new(level, parts);
    let normals = InputNormals { mesh, of_vertex: unit_normals(&input_parts), input };
    let ties = normals.ties(level, positions, &unknowns);
    let mut fitted = unknowns.first.clone();
    for _ in 0..FITS {
        let mut system = System::new(&unknowns.faces, fitted.len());
        ties.iter().for_each(|tie| system.add(tie, &fitted));
        let solved = system.solve(&fitted, &unknowns.first);
        for ((normal, solved), first) in fitted.iter_mut().zip(solved).zip(&unknowns.first) {
            if solved.length() > MIN_LENGTH && solved.dot(*first) > 0.0 {
                *normal = solved.normalize();
            }
        }
    }
    store_normals(&unknowns, &fitted, parts);
}

/// The normals of a level as unknowns: one for all vertices that share position and normal.
struct Unknowns {
    /// For each vertex its unknown; [`NONE`] without a normal.
    of_vertex: Vec<u32>,
    /// The same by the corners of faces.
    faces: Vec<[u32; 3]>,
    /// The unit normals at the start.
    first: Vec<DVec3>,
}

impl Unknowns {
    fn new(level: &Level, parts: &MeshParts) -> Self {
        let (level_normals, normals) =
            (unit_normals(&level.mesh.clone().into_parts()), unit_normals(parts));
        let key = |v: u32| {
            (
                level.point_of_vertex[v as usize],
                level_normals[v as usize].to_array().map(f64::to_bits),
            )
        };
        let has_normal = |v: &u32| level_normals[*v as usize] != DVec3::ZERO;
        let mut order: Vec<u32> = (0..level_normals.len() as u32).filter(has_normal).collect();
        order.sort_unstable_by_key(|&v| (key(v), v));
        let (mut of_vertex, mut first) = (vec![NONE; level_normals.len()], Vec::new());
        for equal in order.chunk_by(|&a, &b| key(a) == key(b)) {
            let sum: DVec3 = equal.iter().map(|&v| normals[v as usize]).sum();
            equal.iter().for_each(|&v| of_vertex[v as usize] = first.len() as u32);
            first.push(sum.try_normalize().unwrap_or(level_normals[equal[0] as usize]));
        }
        let faces =
            level.mesh.triangles().iter().map(|t| t.map(|v| of_vertex[v as usize])).collect();
        Self { of_vertex, faces, first }
    }
}

/// Returns the unit normal of each vertex; zero where it has none.
fn unit_normals(parts: &MeshParts) -> Vec<DVec3> {
    let normal = |v: usize| {
        let stream = direction_stream(parts, v, &Semantic::Normal);
        let Some(stream) = stream else { return DVec3::ZERO };
        direction(parts, stream, v).normalize_or_zero()
    };
    (0..parts.positions.len()).map(normal).collect()
}

/// Returns the first three components of a vertex in a stream.
fn direction(parts: &MeshParts, stream: usize, v: usize) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|k| f64::from(parts.attributes[stream].value(v as u32, k))))
}

/// Returns the stream of a vertex that has directions with a meaning.
fn direction_stream(parts: &MeshParts, v: usize, semantic: &Semantic) -> Option<usize> {
    let submesh = &parts.submeshes[parts.vertex_submesh[v] as usize];
    submesh.attributes.iter().map(|&a| a as usize).find(|&a| {
        let a = &parts.attributes[a];
        a.semantic == *semantic && a.morph_target.is_none() && a.components >= 3
    })
}

/// A unit normal of the input, tied to a point of the level.
#[derive(Clone, Copy, Debug)]
struct Tie {
    /// The face that the point is on, and its barycentric coordinates there.
    face: u32,
    barycentric: [f64; 3],
    normal: DVec3,
    /// Share of the whole area.
    weight: f64,
}

/// The input with its unit normals.
struct InputNormals<'a> {
    mesh: &'a Mesh,
    of_vertex: Vec<DVec3>,
    input: &'a Input,
}

impl InputNormals<'_> {
    /// Returns the normals at samples of the input, each tied to the nearest point of the level,
    /// and for points of the level those of the nearest point of the input. Only within a chart,
    /// and only where normal and face are on the same side.
    fn ties(&self, level: &Level, positions: &[DVec3], unknowns: &Unknowns) -> Vec<Tie> {
        let input = self.input;
        let charts = charts(self.mesh, Continuity::Shading);
        let corners = level.corners(positions);
        let crosses: Vec<DVec3> = corners.iter().map(|&t| cross(t)).collect();
        let area = crosses.iter().map(|c| c.length()).sum::<f64>().max(f64::MIN_POSITIVE);
        let tie = |face: u32, barycentric, triangle: usize, on_triangle, weight| {
            let normal = self.normal_at(triangle, on_triangle);
            let own_triangle = level.input_triangles[face as usize] as usize;
            let counts = charts[triangle] == charts[own_triangle]
                && normal.dot(crosses[face as usize]) > 0.0
                && !unknowns.faces[face as usize].contains(&NONE);
            counts.then_some(Tie { face, barycentric, normal, weight })
        };
        let tree = TriangleTree::new(&corners);
        let starts: Vec<usize> = (0..input.sample_count()).step_by(SAMPLES_PER_THREAD).collect();
        let from_input = starts.par_iter().flat_map_iter(|&start| {
            let (mut found, mut hint) = (Vec::with_capacity(SAMPLES_PER_THREAD), NONE);
            for i in start..(start + SAMPLES_PER_THREAD).min(input.sample_count()) {
                let (triangle, barycentric, weight) = input.sample_location(i);
                let p = input.surface_point(triangle, barycentric);
                let Some(nearest) = tree.nearest(p, hint) else { continue };
                hint = nearest.triangle;
                found.extend(tie(hint, nearest.barycentric, triangle, barycentric, weight));
            }
            found
        });
        let face_chunks = tree.spatial_order().par_chunks(SAMPLES_PER_THREAD);
        let from_level = face_chunks.flat_map_iter(|faces| {
            let mut found = Vec::with_capacity(SIX_POINTS.len() * SAMPLES_PER_THREAD);
            for &face in faces {
                let mut hint = level.input_triangles[face as usize];
                for &(barycentric, share) in SIX_POINTS {
                    let q = point_at(corners[face as usize], barycentric);
                    let Some(nearest) = input.tree.nearest(q, hint) else { continue };
                    hint = nearest.triangle;
                    let (triangle, on_triangle) = (hint as usize, nearest.barycentric);
                    let weight = crosses[face as usize].length() * share / area;
                    found.extend(tie(face, barycentric, triangle, on_triangle, weight));
                }
            }
            found
        });
        from_input.chain(from_level).collect()
    }

    fn normal_at(&self, triangle: usize, barycentric: [f64; 3]) -> DVec3 {
        let corners = self.mesh.triangles()[triangle].map(|v| self.of_vertex[v as usize]);
        point_at(corners, barycentric).normalize_or_zero()
    }
}

/// The normal equations: a block for each face, so that no edges are needed.
struct System<'a> {
    /// The unknowns at the corners of each face.
    faces: &'a [[u32; 3]],
    /// For each face the weighted sums of products of barycentric coordinates: 00, 11, 22, 01, 12,
    /// 20.
    blocks: Vec<[f64; 6]>,
    right_side: Vec<DVec3>,
}

impl<'a> System<'a> {
    fn new(faces: &'a [[u32; 3]], unknown_count: usize) -> Self {
        let (blocks, right_side) = (vec![[0.0; 6]; faces.len()], vec![DVec3::ZERO; unknown_count]);
        Self { faces, blocks, right_side }
    }

    /// Adds the squared distance of the level's interpolated normal from a tie's, which is scaled
    /// to the length that the interpolated normal has with `current` ones.
    fn add(&mut self, tie: &Tie, current: &[DVec3]) {
        let (face, [a, b, c]) = (tie.face as usize, tie.barycentric);
        let products = [a * a, b * b, c * c, a * b, b * c, c * a];
        self.blocks[face].iter_mut().zip(products).for_each(|(sum, p)| *sum += tie.weight * p);
        let corners = self.faces[face];
        let length = point_at(corners.map(|v| current[v as usize]), tie.barycentric).length();
        for (&v, share) in corners.iter().zip(tie.barycentric) {
            self.right_side[v as usize] += tie.normal * (tie.weight * share * length);
        }
    }

    /// Returns the normals with the least sum of squares, not of unit length, pulled towards
    /// `first` (conjugate gradients from `current`, preconditioned by the diagonal).
    fn solve(mut self, current: &[DVec3], first: &[DVec3]) -> Vec<DVec3> {
        let mut diagonal = vec![0.0; self.right_side.len()];
        for (f, block) in self.blocks_with_normals() {
            (0..3).for_each(|k| diagonal[f[k] as usize] += block[k]);
        }
        let mean = diagonal.iter().sum::<f64>() / diagonal.len().max(1) as f64;
        let min_diagonal = f64::max(MIN_WEIGHT_SHARE * mean, f64::MIN_POSITIVE);
        let damping: Vec<f64> = diagonal.iter().map(|d| DAMPING * d.max(min_diagonal)).collect();
        for v in 0..diagonal.len() {
            self.right_side[v] += first[v] * damping[v];
            diagonal[v] += damping[v];
        }
        let precondition = |r: &[DVec3]| -> Vec<DVec3> {
            r.iter().zip(&diagonal).map(|(&r, &d)| if d > 0.0 { r / d } else { r }).collect()
        };
        let mut x = current.to_vec();
        let product = self.times(&x, &damping);
        let mut r: Vec<DVec3> = self.right_side.iter().zip(product).map(|(&b, a)| b - a).collect();
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        let enough = END_RESIDUAL * END_RESIDUAL * rz;
        for _ in 0..MAX_STEPS {
            let q = self.times(&p, &damping);
            let pq = dot(&p, &q);
            if rz <= enough || pq <= 0.0 {
                break;
            }
            for i in 0..x.len() {
                x[i] += p[i] * (rz / pq);
                r[i] -= q[i] * (rz / pq);
            }
            z = precondition(&r);
            let next = dot(&r, &z);
            for i in 0..x.len() {
                p[i] = z[i] + p[i] * (next / rz);
            }
            rz = next;
        }
        x
    }

    /// Returns the faces whose corners all have normals, and their blocks.
    fn blocks_with_normals(&self) -> impl Iterator<Item = (&[u32; 3], &[f64; 6])> {
        self.faces.iter().zip(&self.blocks).filter(|(f, _)| !f.contains(&NONE))
    }

    /// Returns the product of the matrix and a vector.
    fn times(&self, p: &[DVec3], damping: &[f64]) -> Vec<DVec3> {
        let mut q: Vec<DVec3> = p.iter().zip(damping).map(|(&p, &d)| p * d).collect();
        for (f, m) in self.blocks_with_normals() {
            let [a, b, c] = f.map(|v| p[v as usize]);
            q[f[0] as usize] += a * m[0] + b * m[3] + c * m[5];
            q[f[1] as usize] += a * m[3] + b * m[1] + c * m[4];
            q[f[2] as usize] += a * m[5] + b * m[4] + c * m[2];
        }
        q
    }
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// Writes normals into their streams, and makes tangents perpendicular to them.
fn store_normals(unknowns: &Unknowns, fitted: &[DVec3], parts: &mut MeshParts) {
    for (v, &unknown) in unknowns.of_vertex.iter().enumerate().filter(|(_, u)| **u != NONE) {
        let normal = fitted[unknown as usize];
        if let Some(stream) = direction_stream(parts, v, &Semantic::Normal) {
            store(&mut parts.attributes[stream], v, &normal.to_array());
        }
        let Some(stream) = direction_stream(parts, v, &Semantic::Tangent) else { continue };
        let tangent = direction(parts, stream, v);
        if let Some(tangent) = (tangent - normal * tangent.dot(normal)).try_normalize() {
            store(&mut parts.attributes[stream], v, &tangent.to_array());
        }
    }
}
