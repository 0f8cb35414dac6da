//! The attributes' part of the price of plain groups, four numbers at a time.
//!
//! Let `gᵢ` be the gradient of an attribute on face `i` of area `aᵢ` around a group of one wedge,
//! `W` the area of all and `ḡ` the mean gradient. The group moves by `δ` to where the attribute
//! differs by `c`. What [`Gradient`](crate::attributes::Gradient) costs is the sum of squares
//!
//! ```text
//! Σ aᵢ(gᵢ·δ − c)²  =  W(ḡ·δ − c)² + Σ aᵢ((gᵢ − ḡ)·δ)²
//! ```
//!
//! of which the right side cancels nothing, so that single precision is enough.

use crate::attributes::Attributes;
use crate::one_ring::{LaneArray, MAX_LEN, OneRing, Surcharge};
use crate::wedges::Wedges;
use crate::working::{Corner, WorkingMesh, next};
use glam::{Vec3, Vec4};

/// The attributes around a group that has one wedge and a closed fan without seams.
pub(crate) struct RingAttributes<'a> {
    pub(crate) mesh: &'a WorkingMesh,
    pub(crate) wedges: &'a Wedges,
    pub(crate) attributes: &'a Attributes,
    /// Factor of the attributes' cost.
    pub(crate) weight: f32,
}

/// The faces of a ring.
struct Faces {
    /// The dual basis of each face's plane: a difference along its two spokes becomes a gradient.
    dual: [[Vec3; 2]; MAX_LEN],
    area: [f32; MAX_LEN],
    whole: f32,
}

/// A gradient of four numbers: one coordinate of each for each vector.
type Gradients = [Vec4; 3];

/// The sum of `weight · v vᵀ` for four vectors at a time, in the order of
/// [`Symmetric`](crate::quadric::Symmetric).
type Outer = [Vec4; 6];

impl Surcharge for RingAttributes<'_> {
    const IS_ZERO: bool = false;

    fn costs<const N: usize>(&self, ring: &OneRing<N>, star: &[Corner]) -> LaneArray<N> {
        let mut costs = [0.0; MAX_LEN + 1];
        let faces = Faces::new(ring);
        if faces.whole <= 0.0 {
            return [Vec4::ZERO; N];
        }
        let spokes = ring.spokes();
        let (mut offsets, mut outer) = ([Vec4::ZERO; MAX_LEN], [Vec4::ZERO; 6]);
        let (here, rows) = self.rows(star);
        for first in (0..self.attributes.width).step_by(4) {
            let four = |row: &[f32]| Vec4::from_slice(&row[first..first + 4]);
            let here = four(here);
            let mut changes = [Vec4::ZERO; MAX_LEN + 1];
            for (change, row) in changes.iter_mut().zip(&rows[..ring.len]) {
                *change = four(row) - here;
            }
            changes[ring.len] = changes[0];
            let mean = faces.add(ring.len, &changes, &mut outer);
            for ((offset, change), spoke) in
                offsets.iter_mut().zip(changes).zip(&spokes[..ring.len])
            {
                let rest = change - (mean[0] * spoke.x + mean[1] * spoke.y + mean[2] * spoke.z);
                *offset += rest * rest;
            }
        }
        for (cost, offset) in costs.iter_mut().zip(offsets) {
            *cost = faces.whole * sum(offset);
        }
        self.add_joints(star, faces.whole, &mut costs);
        let moved = ring.quadratic(outer.map(sum));
        std::array::from_fn(|t| {
            let cost = Vec4::from_slice(&costs[4 * t..4 * t + 4]) + moved[t].max(Vec4::ZERO);
            // Whatever the attributes are, no price may be NaN.
            let cost = cost * self.weight;
            Vec4::select(cost.cmple(Vec4::splat(f32::MAX)), cost, Vec4::splat(f32::MAX))
        })
    }
}

impl RingAttributes<'_> {
    /// The attributes of the group and of its neighbours.
    #[inline]
    fn rows(&self, star: &[Corner]) -> (&[f32], [&[f32]; MAX_LEN]) {
        let row = |wedge: u32| self.attributes.padded(self.wedges.attribute_source[wedge as usize]);
        let mut rows: [&[f32]; MAX_LEN] = [&[]; MAX_LEN];
        for (place, corner) in rows.iter_mut().zip(star) {
            *place = row(self.mesh.wedges(corner.face())[next(corner.at())]);
        }
        (row(self.mesh.wedges(star[0].face())[star[0].at()]), rows)
    }

    /// Adds what the skinning weights of the neighbours cost.
    fn add_joints(&self, star: &[Corner], area: f32, costs: &mut [f32; MAX_LEN + 1]) {
        if !self.attributes.has_joints() {
            return;
        }
        let source = |wedge: u32| self.wedges.position_source[wedge as usize];
        let faces = |corner: Corner| self.mesh.wedges(corner.face());
        let here = source(faces(star[0])[star[0].at()]);
        for (cost, &corner) in costs.iter_mut().zip(star) {
            let there = source(faces(corner)[next(corner.at())]);
            *cost += area * self.attributes.joint_distance_squared(here, there) as f32;
        }
    }
}

impl Faces {
    #[inline]
    fn new<const N: usize>(ring: &OneRing<N>) -> Self {
        let mut faces = Self { dual: [[Vec3::ZERO; 2]; MAX_LEN], area: [0.0; MAX_LEN], whole: 0.0 };
        let (spokes, normals) = (ring.spokes(), ring.normals());
        for i in 0..ring.len {
            let (spoke, following, normal) = (spokes[i], spokes[i + 1], normals[i]);
            let squared = normal.length_squared();
            if squared > 0.0 {
                faces.dual[i] = [following.cross(normal) / squared, normal.cross(spoke) / squared];
                faces.area[i] = 0.5 * squared.sqrt();
                faces.whole += faces.area[i];
            }
        }
        faces
    }

    /// Returns the mean gradient of four numbers, given by their changes along the spokes, and adds
    /// how the faces' gradients scatter about it.
    #[inline]
    fn add(&self, len: usize, changes: &[Vec4; MAX_LEN + 1], outer: &mut Outer) -> Gradients {
        let mut gradients = [[Vec4::ZERO; 3]; MAX_LEN];
        let mut mean = [Vec4::ZERO; 3];
        for i in 0..len {
            let ([d, e], (change, following)) = (self.dual[i], (changes[i], changes[i + 1]));
            let gradient = [
                change * d.x + following * e.x,
                change * d.y + following * e.y,
                change * d.z + following * e.z,
            ];
            gradients[i] = gradient;
            for (mean, gradient) in mean.iter_mut().zip(gradient) {
                *mean += gradient * self.area[i];
            }
        }
        let mean = mean.map(|sum| sum / self.whole);
        for (gradient, &area) in gradients[..len].iter().zip(&self.area) {
            let [x, y, z] = [gradient[0] - mean[0], gradient[1] - mean[1], gradient[2] - mean[2]];
            let weighted = [x * area, y * area, z * area];
            outer[0] += weighted[0] * x;
            outer[1] += weighted[0] * y;
            outer[2] += weighted[0] * z;
            outer[3] += weighted[1] * y;
            outer[4] += weighted[1] * z;
            outer[5] += weighted[2] * z;
        }
        mean
    }
}

#[inline]
fn sum(v: Vec4) -> f32 {
    (v.x + v.y) + (v.z + v.w)
}
