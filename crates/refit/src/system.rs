//! The normal equations of one least-squares step of a refit, a 3 × 3 block per vertex and edge,
//! solved by conjugate gradients.

use glam::DVec3;

/// A symmetric 3 × 3 matrix: xx, xy, xz, yy, yz, zz.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Symmetric([f64; 6]);

impl Symmetric {
    /// Returns `share` times the projection onto the unit vector `u`, plus `identity` times the
    /// identity.
    pub(crate) fn projection(u: DVec3, share: f64, identity: f64) -> Self {
        let s = u * share;
        Self([
            s.x * u.x + identity,
            s.x * u.y,
            s.x * u.z,
            s.y * u.y + identity,
            s.y * u.z,
            s.z * u.z + identity,
        ])
    }

    fn add(&mut self, other: &Self, factor: f64) {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a += factor * b;
        }
    }

    fn add_diagonal(&mut self, value: f64) {
        for i in [0, 3, 5] {
            self.0[i] += value;
        }
    }

    fn trace(&self) -> f64 {
        self.0[0] + self.0[3] + self.0[5]
    }

    pub(crate) fn times(&self, v: DVec3) -> DVec3 {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        DVec3::new(
            xx * v.x + xy * v.y + xz * v.z,
            xy * v.x + yy * v.y + yz * v.z,
            xz * v.x + yz * v.y + zz * v.z,
        )
    }

    /// Returns the inverse, or zero for a matrix that has none.
    fn inverse(&self) -> Self {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        let (c0, c1, c2) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
        let determinant = xx * c0 + xy * c1 + xz * c2;
        if determinant <= 0.0 || !determinant.is_finite() {
            return Self::default();
        }
        let cofactors = [c0, c1, c2, xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy];
        Self(cofactors.map(|c| c / determinant))
    }
}

/// A point of one surface tied to a point of the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tie {
    /// The face of the level that the level's point is on.
    pub(crate) face: u32,
    /// Barycentric coordinates of the level's point on it.
    pub(crate) barycentric: [f64; 3],
    /// From the input's point to the level's.
    pub(crate) residual: DVec3,
    /// Unit direction in which the distance counts in full.
    pub(crate) direction: DVec3,
    /// Share of the whole area.
    pub(crate) weight: f64,
}

impl Tie {
    /// A tie to a face that counts towards its distances, but pulls no vertex.
    pub(crate) fn of_face(face: u32, weight: f64) -> Self {
        let (barycentric, residual, direction) = ([0.0; 3], DVec3::ZERO, DVec3::ZERO);
        Self { face, barycentric, residual, direction, weight }
    }
}

/// Weight of distances along the surface, of 1 for those across it: so vertices do not drift.
/// Chosen by hand.
const TANGENTIAL_WEIGHT: f64 = 0.01;
/// Damping, as a share of a vertex's stiffness: the mean of its diagonal block's diagonal. Chosen
/// by hand.
const DAMPING: f64 = 0.01;
/// The least stiffness that damping counts with, as a share of the mean one. Chosen by hand.
const MIN_STIFFNESS_SHARE: f64 = 0.1;
/// The most steps of conjugate gradients, and the share of the first residual at which they end.
/// Chosen by hand.
const MAX_STEPS: usize = 20;
const END_RESIDUAL: f64 = 1e-3;

/// A sparse symmetric system of one 3 × 3 block per vertex and per edge.
#[derive(Clone, Debug)]
pub(crate) struct System<'a> {
    faces: &'a [[u32; 3]],
    face_edges: &'a [[u32; 3]],
    edges: &'a [[u32; 2]],
    diagonal: Vec<Symmetric>,
    off_diagonal: Vec<Symmetric>,
    gradient: Vec<DVec3>,
}

impl<'a> System<'a> {
    /// A system without ties. `face_edges` has the edges from a face's corners 0, 1 and 2 to the
    /// next.
    pub(crate) fn new(
        vertex_count: usize,
        faces: &'a [[u32; 3]],
        face_edges: &'a [[u32; 3]],
        edges: &'a [[u32; 2]],
    ) -> Self {
        Self {
            faces,
            face_edges,
            edges,
            diagonal: vec![Symmetric::default(); vertex_count],
            off_diagonal: vec![Symmetric::default(); edges.len()],
            gradient: vec![DVec3::ZERO; vertex_count],
        }
    }

    /// Adds the squared distance of a tie, most of all along its direction.
    pub(crate) fn add(&mut self, tie: &Tie) {
        let (u, r) = (tie.direction, tie.residual);
        let block = Symmetric::projection(u, 1.0 - TANGENTIAL_WEIGHT, TANGENTIAL_WEIGHT);
        let pull = u * ((1.0 - TANGENTIAL_WEIGHT) * r.dot(u)) + r * TANGENTIAL_WEIGHT;
        let face = tie.face as usize;
        for k in 0..3 {
            let vertex = self.faces[face][k] as usize;
            let share = tie.weight * tie.barycentric[k];
            self.gradient[vertex] += pull * share;
            self.diagonal[vertex].add(&block, share * tie.barycentric[k]);
            let edge = self.face_edges[face][k] as usize;
            self.off_diagonal[edge].add(&block, share * tie.barycentric[(k + 1) % 3]);
        }
    }

    /// Returns the moves that lower the sum of squared distances most (Levenberg's damping, then
    /// block-Jacobi conjugate gradients). Vertices that are `locked` do not move; the list has an
    /// entry for each, or none.
    pub(crate) fn solve(mut self, locked: &[bool]) -> Vec<DVec3> {
        let vertex_count = self.diagonal.len();
        let stiffness: Vec<f64> = self.diagonal.iter().map(|b| b.trace() / 3.0).collect();
        let mean = stiffness.iter().sum::<f64>() / vertex_count.max(1) as f64;
        for (block, vertex_stiffness) in self.diagonal.iter_mut().zip(&stiffness) {
            block.add_diagonal(DAMPING * vertex_stiffness.max(MIN_STIFFNESS_SHARE * mean));
        }
        let mut inverse: Vec<Symmetric> = self.diagonal.iter().map(Symmetric::inverse).collect();
        // Without an inverse no direction of the search has a part of theirs.
        for (block, _) in inverse.iter_mut().zip(locked).filter(|(_, locked)| **locked) {
            *block = Symmetric::default();
        }
        let precondition = |r: &[DVec3]| -> Vec<DVec3> {
            inverse.iter().zip(r).map(|(m, &r)| m.times(r)).collect()
        };
        let mut x = vec![DVec3::ZERO; vertex_count];
        let mut r: Vec<DVec3> = self.gradient.iter().map(|&g| -g).collect();
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        let enough = rz * END_RESIDUAL * END_RESIDUAL;
        for _ in 0..MAX_STEPS {
            if rz <= enough {
                break;
            }
            let q = self.times(&p);
            let alpha = rz / dot(&p, &q);
            for i in 0..vertex_count {
                x[i] += p[i] * alpha;
                r[i] -= q[i] * alpha;
            }
            z = precondition(&r);
            let next = dot(&r, &z);
            for i in 0..vertex_count {
                p[i] = z[i] + p[i] * (next / rz);
            }
            rz = next;
        }
        x
    }

    /// Returns the product of the matrix and a vector.
    fn times(&self, p: &[DVec3]) -> Vec<DVec3> {
        let mut q: Vec<DVec3> = self.diagonal.iter().zip(p).map(|(m, &p)| m.times(p)).collect();
        for (block, &[a, b]) in self.off_diagonal.iter().zip(self.edges) {
            q[a as usize] += block.times(p[b as usize]);
            q[b as usize] += block.times(p[a as usize]);
        }
        q
    }
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inverse_undoes_its_matrix() {
        let mut m = Symmetric::projection(DVec3::new(0.6, 0.0, 0.8), 2.0, 0.1);
        m.add(&Symmetric::projection(DVec3::Y, 1.0, 0.0), 3.0);
        let v = DVec3::new(1.0, -2.0, 0.5);
        assert!((m.inverse().times(m.times(v)) - v).length() < 1e-12);
        assert_eq!(Symmetric::default().inverse(), Symmetric::default());
    }

    #[test]
    fn a_face_follows_a_plane_that_is_shifted() {
        // Ties at the corners of one face ask for a shift by 0.25 along z.
        let (faces, face_edges, edges) = ([[0, 1, 2]], [[0, 1, 2]], [[0, 1], [1, 2], [0, 2]]);
        let mut system = System::new(3, &faces, &face_edges, &edges);
        for k in 0..3 {
            let mut barycentric = [0.0; 3];
            barycentric[k] = 1.0;
            let residual = DVec3::new(0.0, 0.0, -0.25);
            system.add(&Tie { face: 0, barycentric, residual, direction: DVec3::Z, weight: 1.0 });
        }
        let one_locked = system.clone().solve(&[true, false, false]);
        assert!(one_locked[0] == DVec3::ZERO && one_locked[1].z > 0.1, "{one_locked:?}");
        for x in system.solve(&[]) {
            assert!((x - DVec3::new(0.0, 0.0, 0.25)).length() < 0.01, "{x}");
        }
    }
}
