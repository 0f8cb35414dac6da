//! Values at the vertices of a level, so that what is interpolated between them is nearest to given
//! values, by least squares.

use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::point_at;

/// Pull towards the values at the start, as a share of a value's own weight. Chosen by hand.
const DAMPING: f64 = 0.02;
/// Pull towards the values at the start where they are held, as a multiple of the other one: they
/// hardly move.
const HELD: f64 = 1e6;
/// The least weight of a value that its pull counts with, as a share of the mean one. Chosen by
/// hand.
const MIN_WEIGHT_SHARE: f64 = 0.1;
/// The most steps of conjugate gradients, and the share of the first residual at which they end.
/// Chosen by hand.
const MAX_STEPS: usize = 30;
const END_RESIDUAL: f64 = 1e-4;

/// A value at a point of a face of the level.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub(crate) face: u32,
    pub(crate) barycentric: [f64; 3],
    pub(crate) value: DVec3,
    pub(crate) weight: f64,
}

/// The normal equations: a block for each face, so that no edges are needed.
#[derive(Clone)]
pub(crate) struct Interpolation<'a> {
    /// The unknowns at the corners of each face.
    faces: &'a [[u32; 3]],
    /// For each face the weighted sums of products of barycentric coordinates: 00, 11, 22, 01, 12,
    /// 20.
    blocks: Vec<[f64; 6]>,
    right_side: Vec<DVec3>,
}

impl<'a> Interpolation<'a> {
    /// A system without targets.
    pub(crate) fn new(faces: &'a [[u32; 3]], unknown_count: usize) -> Self {
        let (blocks, right_side) = (vec![[0.0; 6]; faces.len()], vec![DVec3::ZERO; unknown_count]);
        Self { faces, blocks, right_side }
    }

    /// Returns what is interpolated at the place of a target.
    pub(crate) fn interpolated(&self, target: &Target, values: &[DVec3]) -> DVec3 {
        let corners = self.faces[target.face as usize].map(|v| values[v as usize]);
        point_at(corners, target.barycentric)
    }

    /// Adds the squared distance of the interpolated value from a target.
    pub(crate) fn add(&mut self, target: &Target) {
        let (face, [a, b, c]) = (target.face as usize, target.barycentric);
        let products = [a * a, b * b, c * c, a * b, b * c, c * a];
        self.blocks[face].iter_mut().zip(products).for_each(|(sum, p)| *sum += target.weight * p);
        for (&v, share) in self.faces[face].iter().zip(target.barycentric) {
            self.right_side[v as usize] += target.value * (target.weight * share);
        }
    }

    /// Returns the values with the least sum of squares, pulled towards `first` and held there
    /// where `is_held` says so (conjugate gradients from `current`, preconditioned by the
    /// diagonal).
    pub(crate) fn solve(
        mut self,
        current: &[DVec3],
        first: &[DVec3],
        is_held: impl Fn(usize) -> bool,
    ) -> Vec<DVec3> {
        let mut diagonal = vec![0.0; self.right_side.len()];
        for (f, block) in self.known_blocks() {
            (0..3).for_each(|k| diagonal[f[k] as usize] += block[k]);
        }
        let mean = diagonal.iter().sum::<f64>() / diagonal.len().max(1) as f64;
        let min_diagonal = f64::max(MIN_WEIGHT_SHARE * mean, f64::MIN_POSITIVE);
        let damping = |(v, d): (usize, &f64)| {
            let held = if is_held(v) { HELD } else { 1.0 };
            DAMPING * d.max(min_diagonal) * held
        };
        let damping: Vec<f64> = diagonal.iter().enumerate().map(damping).collect();
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

    /// Returns the faces whose corners all have values, and their blocks.
    fn known_blocks(&self) -> impl Iterator<Item = (&[u32; 3], &[f64; 6])> {
        self.faces.iter().zip(&self.blocks).filter(|(f, _)| !f.contains(&NONE))
    }

    /// Returns the product of the matrix and a vector.
    fn times(&self, p: &[DVec3], damping: &[f64]) -> Vec<DVec3> {
        let mut q: Vec<DVec3> = p.iter().zip(damping).map(|(&p, &d)| p * d).collect();
        for (f, m) in self.known_blocks() {
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
