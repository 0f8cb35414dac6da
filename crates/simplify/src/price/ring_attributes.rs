//! The attributes' part of the price of plain groups: the sum that [`gradients`](super::gradients)
//! explains, for all neighbours of one wedge at once.

use super::gradients::{Dual, FourGradients, Scatter, WedgeAttributes, continued, sum};
use super::one_ring::{LaneArray, MAX_LEN, OneRing, Surcharge};
use crate::cut::{Corner, next};
use glam::Vec4;

/// The attributes around a group that has one wedge and a closed fan without seams.
pub(super) struct RingAttributes<'a> {
    pub(super) view: WedgeAttributes<'a>,
    /// Factor of the attributes' cost.
    pub(super) weight: f32,
}

/// The faces of a ring, and their area together.
struct Faces {
    duals: [Dual; MAX_LEN],
    area: f32,
}

impl Surcharge for RingAttributes<'_> {
    const IS_ZERO: bool = false;

    fn costs<const N: usize>(&self, ring: &OneRing<N>, star: &[Corner]) -> LaneArray<N> {
        let mut costs = [0.0; MAX_LEN + 1];
        let faces = Faces::new(ring);
        if faces.area <= 0.0 {
            return [Vec4::ZERO; N];
        }
        let spokes = ring.spokes();
        let (mut offsets, mut scatter) = ([Vec4::ZERO; MAX_LEN], Scatter::default());
        let (own_row, rows) = self.rows(star);
        for first in (0..self.view.attributes.width).step_by(4) {
            let four = |row: &[f32]| Vec4::from_slice(&row[first..first + 4]);
            let own_row = four(own_row);
            let mut changes = [Vec4::ZERO; MAX_LEN + 1];
            for (change, row) in changes.iter_mut().zip(&rows[..ring.len]) {
                *change = four(row) - own_row;
            }
            changes[ring.len] = changes[0];
            let mean = faces.add(ring.len, &changes, &mut scatter);
            for ((offset, change), spoke) in
                offsets.iter_mut().zip(changes).zip(&spokes[..ring.len])
            {
                let residual = change - continued(&mean, *spoke);
                *offset += residual * residual;
            }
        }
        for (cost, offset) in costs.iter_mut().zip(offsets) {
            *cost = faces.area * sum(offset);
        }
        self.add_joints(star, faces.area, &mut costs);
        let moved = ring.quadratic(scatter.form());
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
        let row = |wedge: u32| {
            self.view.attributes.padded(self.view.wedges.attribute_source[wedge as usize])
        };
        let mut rows: [&[f32]; MAX_LEN] = [&[]; MAX_LEN];
        for (neighbor_row, corner) in rows.iter_mut().zip(star) {
            *neighbor_row = row(self.view.mesh.wedges(corner.face())[next(corner.at())]);
        }
        (row(self.view.mesh.wedges(star[0].face())[star[0].at()]), rows)
    }

    /// Adds what the skinning weights of the neighbours cost.
    fn add_joints(&self, star: &[Corner], area: f32, costs: &mut [f32; MAX_LEN + 1]) {
        if !self.view.attributes.has_joints() {
            return;
        }
        let source = |wedge: u32| self.view.wedges.position_source[wedge as usize];
        let faces = |corner: Corner| self.view.mesh.wedges(corner.face());
        let source_wedge = source(faces(star[0])[star[0].at()]);
        for (cost, &corner) in costs.iter_mut().zip(star) {
            let target_wedge = source(faces(corner)[next(corner.at())]);
            *cost += area
                * self.view.attributes.joint_distance_squared(source_wedge, target_wedge) as f32;
        }
    }
}

impl Faces {
    #[inline]
    fn new<const N: usize>(ring: &OneRing<N>) -> Self {
        let mut faces = Self { duals: [Dual::default(); MAX_LEN], area: 0.0 };
        let (spokes, normals) = (ring.spokes(), ring.normals());
        for (i, dual) in faces.duals[..ring.len].iter_mut().enumerate() {
            *dual = Dual::new([spokes[i], spokes[i + 1]], normals[i]);
            faces.area += dual.area;
        }
        faces
    }

    /// Returns the mean gradient of four numbers, given by their changes along the spokes, and adds
    /// how the faces' gradients scatter about it.
    #[inline]
    fn add(
        &self,
        len: usize,
        changes: &[Vec4; MAX_LEN + 1],
        scatter: &mut Scatter,
    ) -> FourGradients {
        let mut gradients = [[Vec4::ZERO; 3]; MAX_LEN];
        let mut mean = [Vec4::ZERO; 3];
        for (i, (gradient, dual)) in gradients[..len].iter_mut().zip(&self.duals).enumerate() {
            *gradient = dual.gradient([changes[i], changes[i + 1]]);
            for (mean, gradient) in mean.iter_mut().zip(gradient) {
                *mean += *gradient * dual.area;
            }
        }
        let mean = mean.map(|sum| sum / self.area);
        for (gradient, dual) in gradients[..len].iter().zip(&self.duals) {
            scatter.add(gradient, &mean, dual.area);
        }
        mean
    }
}
