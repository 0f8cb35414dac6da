//! A level of detail as the unknowns of a refit: one point for all vertices that share a position,
//! with faces and edges between points.

use crate::input::Input;
use crate::sides::sides;
use glam::DVec3;
use lodc_mesh::{Lod, Mesh, NONE, OrientedTriangle, Simplified, is_degenerate};

/// The triangles of a level and the positions that a refit may move.
#[derive(Clone, Debug)]
pub(crate) struct CoarseMesh {
    /// The level as a mesh of its own, where the simplifier left it.
    pub(crate) mesh: Mesh,
    /// For each triangle of `mesh` the triangle of LOD 0 that it was.
    pub(crate) input_triangles: Vec<u32>,
    /// For each vertex of `mesh` its point.
    pub(crate) point_of_vertex: Vec<u32>,
    /// The positions of `mesh`, each once.
    pub(crate) points: Vec<DVec3>,
    /// The triangles by points.
    pub(crate) faces: Vec<[u32; 3]>,
    /// The edges by points, the smaller first.
    pub(crate) edges: Vec<[u32; 2]>,
    /// For each face the edges from its corners 0, 1 and 2 to the next.
    pub(crate) face_edges: Vec<[u32; 3]>,
    /// By point: whether it is locked. Empty if none is.
    pub(crate) locked: Vec<bool>,
    /// For each corner of the input's triangles the point that it has become; [`NONE`] where no
    /// face of the level is left.
    pub(crate) became: Vec<[u32; 3]>,
}

impl CoarseMesh {
    pub(crate) fn new(simplified: &Simplified, lod: Lod) -> Self {
        let (input, vertex_at_lod) = (simplified.mesh(), simplified.collapses().resolve_all(lod));
        let positions = input.position_ids();
        let (mut input_triangles, mut triangles) = (Vec::new(), Vec::new());
        for (submesh, s) in input.submeshes().iter().enumerate() {
            for t in s.triangles() {
                let corners = input.triangles()[t].map(|v| vertex_at_lod[v as usize]);
                if !is_degenerate(corners.map(|v| positions.of_vertex[v as usize])) {
                    input_triangles.push(t as u32);
                    triangles.push(OrientedTriangle::new(submesh as u32, corners));
                }
            }
        }
        let mesh = input.extract(&triangles).expect("triangles of a level are valid");
        let ids = mesh.position_ids();
        let mut points = vec![DVec3::ZERO; ids.len()];
        for (&id, &p) in ids.of_vertex.iter().zip(mesh.positions()) {
            points[id as usize] = DVec3::from_array(p.map(f64::from));
        }
        let point_of_vertex = ids.of_vertex;
        let faces: Vec<[u32; 3]> =
            mesh.triangles().iter().map(|t| t.map(|v| point_of_vertex[v as usize])).collect();
        let (edges, face_edges) = edges(&faces);
        let mut used: Vec<u32> = triangles.iter().flat_map(|t| t.corners).collect();
        used.sort_unstable();
        used.dedup();
        let locked = locked_points(simplified, &used, &point_of_vertex, points.len());
        let mut point_at_lod = vec![NONE; vertex_at_lod.len()];
        for (&v, &point) in used.iter().zip(&point_of_vertex) {
            point_at_lod[v as usize] = point;
        }
        let point = |v: u32| point_at_lod[vertex_at_lod[v as usize] as usize];
        let became = input.triangles().iter().map(|t| t.map(point)).collect();
        Self {
            mesh,
            input_triangles,
            point_of_vertex,
            points,
            faces,
            edges,
            face_edges,
            locked,
            became,
        }
    }

    /// Returns for each sample of the input a face that is probably near: one at a point that a
    /// corner of its triangle has become; [`NONE`] where none is left.
    pub(crate) fn first_hints(&self, input: &Input) -> Vec<u32> {
        let mut face_of_point = vec![NONE; self.points.len()];
        for (face, points) in (0..).zip(&self.faces) {
            points.iter().for_each(|&p| face_of_point[p as usize] = face);
        }
        let hint = |i: usize| {
            let (triangle, ..) = input.sample_location(i);
            let found = self.became[triangle].iter().find(|p| **p != NONE);
            found.map_or(NONE, |&p| face_of_point[p as usize])
        };
        (0..input.sample_count()).map(hint).collect()
    }

    /// Returns whether a point is locked.
    pub(crate) fn is_locked(&self, point: u32) -> bool {
        !self.locked.is_empty() && self.locked[point as usize]
    }

    /// Returns the corners of all faces with the points at `positions`.
    pub(crate) fn corners(&self, positions: &[DVec3]) -> Vec<[DVec3; 3]> {
        self.faces.iter().map(|f| f.map(|p| positions[p as usize])).collect()
    }

    /// Returns the mean length of the edges at each point, with the points at `positions`.
    pub(crate) fn edge_lengths(&self, positions: &[DVec3]) -> Vec<f64> {
        // The sum of lengths, and their number.
        let mut sums = vec![(0.0, 0.0); positions.len()];
        for &[a, b] in &self.edges {
            let length = positions[a as usize].distance(positions[b as usize]);
            for p in [a, b] {
                let sum: &mut (f64, f64) = &mut sums[p as usize];
                *sum = (sum.0 + length, sum.1 + 1.0);
            }
        }
        sums.into_iter().map(|(sum, n)| sum / f64::max(n, 1.0)).collect()
    }
}

/// Returns by point whether a vertex there is locked; nothing if none is. `used` are the vertices
/// of the level by their numbers in the input, in order.
fn locked_points(
    simplified: &Simplified,
    used: &[u32],
    point_of_vertex: &[u32],
    points: usize,
) -> Vec<bool> {
    if simplified.locked().is_empty() {
        return Vec::new();
    }
    let mut locked = vec![false; points];
    for (&v, &point) in used.iter().zip(point_of_vertex) {
        locked[point as usize] |= simplified.locked()[v as usize];
    }
    locked
}

/// Returns the undirected edges of faces, and for each face the indices of its three.
fn edges(faces: &[[u32; 3]]) -> (Vec<[u32; 2]>, Vec<[u32; 3]>) {
    let (mut edges, mut face_edges) = (Vec::new(), vec![[NONE; 3]; faces.len()]);
    for side in sides(faces) {
        if edges.last() != Some(&side.edge) {
            edges.push(side.edge);
        }
        face_edges[side.face()][side.corner()] = edges.len() as u32 - 1;
    }
    (edges, face_edges)
}
