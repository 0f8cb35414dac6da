//! The attributes' part of the price of plain groups: the sum that [`gradients`](super::gradients)
//! explains, for all neighbours of one wedge at once.

use super::gradients::{Dual, FourGradients, Scatter, WedgeAttributes, continued, sum};
use super::one_ring::{AttributeCost, LaneArray, MAX_LEN, OneRing};
use crate::cut::{Corner, InMotion, next};
use crate::number::each_shape;
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

impl AttributeCost for RingAttributes<'_> {
    const IS_ZERO: bool = false;

    fn costs<const N: usize>(&self, ring: &OneRing<N>, star: &[Corner]) -> LaneArray<N> {
        let four = |row: &[f32], first: usize| Vec4::from_slice(&row[first..first + 4]);
        let (own, sources) = self.sources(star);
        let own = self.view.attributes.padded(own);
        let mut rows: [&[f32]; MAX_LEN] = [&[]; MAX_LEN];
        for (row, &source) in rows.iter_mut().zip(&sources[..star.len()]) {
            *row = self.view.attributes.padded(source);
        }
        self.costs_of(ring, star, |first| four(own, first), |i, first| four(rows[i], first))
    }

    #[inline]
    fn raise_in_motion<const N: usize>(
        &self,
        view: &InMotion<'_>,
        from: u32,
        star: &[Corner],
        costs: &mut LaneArray<N>,
    ) {
        if !self.view.attributes.has_turned() {
            return;
        }
        let (own, all) = self.sources(star);
        let turned = |source: u32| self.view.attributes.turned(source);
        let set = all[..star.len()].iter().fold(turned(own), |set, &v| set | turned(v));
        for shape in each_shape(set) {
            let ring = OneRing::<N>::in_motion(view, from, star, shape);
            let four =
                |source: u32, first: usize| self.view.attributes.four_in(source, first, shape);
            let moving = self.costs_of(
                &ring,
                star,
                |first| four(own, first),
                |i, first| four(all[i], first),
            );
            let weight = Vec4::splat(view.shapes.weight(shape) as f32);
            for (cost, moving) in costs.iter_mut().zip(moving) {
                *cost = cost.max(moving * weight);
            }
        }
    }
}

impl RingAttributes<'_> {
    /// The costs, given four numbers of the group and of each neighbour, from the number `first`
    /// on.
    #[inline(always)]
    fn costs_of<const N: usize>(
        &self,
        ring: &OneRing<N>,
        star: &[Corner],
        own: impl Fn(usize) -> Vec4,
        neighbour: impl Fn(usize, usize) -> Vec4,
    ) -> LaneArray<N> {
        let mut costs = [0.0; MAX_LEN + 1];
        let faces = Faces::new(ring);
        if faces.area <= 0.0 {
            return [Vec4::ZERO; N];
        }
        let spokes = ring.spokes();
        let (mut offsets, mut scatter) = ([Vec4::ZERO; MAX_LEN], Scatter::default());
        for first in (0..self.view.attributes.width).step_by(4) {
            let own = own(first);
            let mut changes = [Vec4::ZERO; MAX_LEN + 1];
            for (i, change) in changes[..ring.len].iter_mut().enumerate() {
                *change = neighbour(i, first) - own;
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

    /// The vertices of the input whose attributes the group and its neighbours have.
    #[inline]
    fn sources(&self, star: &[Corner]) -> (u32, [u32; MAX_LEN]) {
        let source = |wedge: u32| self.view.wedges.attribute_source[wedge as usize];
        let own = source(self.view.mesh.wedges(star[0].face())[star[0].at()]);
        let mut sources = [own; MAX_LEN];
        for (neighbour, corner) in sources.iter_mut().zip(star) {
            *neighbour = source(self.view.mesh.wedges(corner.face())[next(corner.at())]);
        }
        (own, sources)
    }

    /// Adds what the skinning weights of the neighbours cost.
    fn add_joints(&self, star: &[Corner], area: f32, costs: &mut [f32; MAX_LEN + 1]) {
        if !self.view.attributes.has_joints() {
            return;
        }
        let source = |wedge: u32| self.view.wedges.position_source[wedge as usize];
        let wedges = |corner: Corner| self.view.mesh.wedges(corner.face());
        let own = source(wedges(star[0])[star[0].at()]);
        for (cost, &corner) in costs.iter_mut().zip(star) {
            let neighbour = source(wedges(corner)[next(corner.at())]);
            *cost += area * self.view.attributes.joint_distance_squared(own, neighbour) as f32;
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
