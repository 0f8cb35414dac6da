//! Fits the normals of a refitted level by least squares to those of the input, over the faces
//! around each.
//!
//! What counts is the normal that is interpolated between the corners of a face and scaled to unit
//! length. So the fit is repeated, each time to the input's normals scaled to the length that the
//! level's interpolated ones have there.

use crate::blend::store;
use crate::fit::Fitted;
use crate::guard::cross;
use crate::level::CoarseMesh;
use crate::sheets::{Sheet, nearest_of_sheet};
use glam::DVec3;
use lodc_mesh::{Attribute, Mesh, MeshParts, NONE, Semantic, Submesh};
use lodc_nearest::{closest, point_at};
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
/// Cosine below which normals are perpendicular to a face, as far as can be told. Chosen by hand.
const PERPENDICULAR: f64 = 1e-3;
/// The most steps of conjugate gradients, and the share of the first residual at which they end.
/// Chosen by hand.
const MAX_STEPS: usize = 30;
const END_RESIDUAL: f64 = 1e-4;
/// Samples, or faces, that one thread looks up one after the other. Chosen by hand.
const SAMPLES_PER_THREAD: usize = 1 << 8;

/// Replaces the normals in `parts`, a level with its points at `positions`, by those that fit the
/// input's best; tangents follow. Starts from the normals that are there. Without normals nothing
/// happens. Returns the faces that face away from a normal of theirs, whatever is done, and did not
/// where the simplifier left them.
pub(crate) fn fit(
    normals: &InputNormals<'_>,
    level: &CoarseMesh,
    fitted: &Fitted,
    positions: &[DVec3],
    parts: &mut MeshParts,
) -> Vec<usize> {
    if normals.is_empty() {
        return Vec::new();
    }
    let unknowns = Unknowns::new(level, parts);
    let ties = normals.ties(level, fitted, positions, &unknowns);
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
    let corners = level.corners(positions);
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

    fn is_empty(&self) -> bool {
        self.of_vertex.is_empty()
    }

    /// Returns the normals at samples of the input, each tied to the nearest point of the level,
    /// and for points of the level those of the nearest point of the input. Only within a chart,
    /// and only where normal and face are on the same side. Faces that are where the fit looked
    /// them up last keep what was found there.
    fn ties(
        &self,
        level: &CoarseMesh,
        fitted: &Fitted,
        positions: &[DVec3],
        unknowns: &Unknowns,
    ) -> Vec<Tie> {
        let input = &fitted.input;
        let points = input.level_rule.len();
        let charts = &input.shading_charts;
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
        let face_sheet = |face: u32| Sheet {
            component: input.components[level.input_triangles[face as usize] as usize],
            normal: crosses[face as usize],
        };
        let stayed = fitted.stayed(level, positions);
        let mut tree = fitted.tree.clone();
        tree.move_to(&corners);
        let runs = fitted.hints.par_chunks(SAMPLES_PER_THREAD).enumerate();
        let from_input = runs.flat_map_iter(|(run, hints)| {
            let mut found = Vec::with_capacity(SAMPLES_PER_THREAD);
            for (i, &hint) in (SAMPLES_PER_THREAD * run..).zip(hints) {
                let (triangle, barycentric, weight) = input.sample_location(i);
                let p = input.surface_point(triangle, barycentric);
                let sheet = input.sheet(triangle);
                let is_own = |face: u32| sheet.goes_with(face_sheet(face));
                let nearest = if hint != NONE && stayed[hint as usize] {
                    Some((hint, closest(p, corners[hint as usize]).0))
                } else {
                    nearest_of_sheet(&tree, p, hint, fitted.reach, is_own)
                        .map(|(nearest, _)| (nearest.triangle, nearest.barycentric))
                };
                let Some((face, on_face)) = nearest else { continue };
                found.extend(tie(face, on_face, triangle, barycentric, weight));
            }
            found
        });
        let faces = fitted.tree.spatial_order().par_chunks(SAMPLES_PER_THREAD);
        let hints = fitted.backward_hints.par_chunks(SAMPLES_PER_THREAD * points);
        let from_level = faces.zip(hints).flat_map_iter(|(faces, hints)| {
            let mut found = Vec::with_capacity(points * SAMPLES_PER_THREAD);
            for (&face, hints) in faces.iter().zip(hints.chunks(points)) {
                for (&(barycentric, share), &hint) in input.level_rule.iter().zip(hints) {
                    let q = point_at(corners[face as usize], barycentric);
                    let sheet = face_sheet(face);
                    let is_own = |triangle: u32| sheet.goes_with(input.sheet(triangle as usize));
                    let nearest = if hint != NONE && stayed[face as usize] {
                        Some((hint, closest(q, input.tree.corners_of(hint)).0))
                    } else {
                        nearest_of_sheet(&input.tree, q, hint, fitted.reach, is_own)
                            .map(|(nearest, _)| (nearest.triangle, nearest.barycentric))
                    };
                    let Some((triangle, on_triangle)) = nearest else { continue };
                    let weight = crosses[face as usize].length() * share / area;
                    found.extend(tie(face, barycentric, triangle as usize, on_triangle, weight));
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
