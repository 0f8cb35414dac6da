//! Which LOD each wedge group gets, in the same operations as `select.wgsl`, so that the two agree bit for bit.

use super::Cones;
use super::criterion::{Criterion, View};
use super::exact::{dot, inverse_power, rsqrt};
use crate::interactive::CollapseLists;
use lodc_mesh::{CollapseSequence, Lod, Mesh, Simplified};

/// What `select.wgsl` gives each group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct State {
    /// The LOD that is shown: the end of a step, or 0.
    pub shown: u32,
    /// The end of the step in which the group moves next; `shown` if it does not move or nothing is interpolated.
    pub towards: u32,
    /// How far it is on the way there, in 1/65536.
    pub way: u32,
}

/// What the selection of a group looks at: six words on a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Where it is at LOD 0.
    pub position: [f32; 3],
    /// Axis of its cone of normals, times 32767.
    pub axis: [i16; 3],
    /// Cosine of half its angle, times 65536, rounded outwards; 0 for all directions.
    pub cos: u16,
    /// One vertex of the group.
    pub first_vertex: u32,
}

impl Group {
    /// The words.
    #[must_use]
    pub fn words(&self) -> [u32; 6] {
        let [x, y, z] = self.position.map(f32::to_bits);
        let [i, j, k] = self.axis.map(|c| u32::from(c.cast_unsigned()));
        [x, y, z, i | j << 16, k | u32::from(self.cos) << 16, self.first_vertex]
    }
}

/// Groups as the kernel gets them.
pub(super) fn groups(cones: &Cones, mesh: &Mesh) -> Vec<Group> {
    let group = |(cone, &first_vertex): (&super::Cone, &u32)| Group {
        position: mesh.positions()[first_vertex as usize],
        axis: cone.axis.map(|c| (c * 32767.0).round() as i16),
        // Outwards by more than what rounding the axis can do.
        cos: ((cone.cos - 1e-4).max(0.0) * 65536.0) as u16,
        first_vertex,
    };
    cones.cones.iter().zip(&cones.first_vertex).map(group).collect()
}

/// A view in the numbers that the kernel is given.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parameters {
    pub(super) criterion: u32,
    pub(super) lods: [u32; 2],
    pub(super) point: [f32; 3],
    pub(super) scale: f32,
    pub(super) abc: [f32; 3],
    pub(super) morph: bool,
}

impl Parameters {
    pub(super) fn new(view: &View, simplified: &Simplified) -> Self {
        let scale = inverse_power(simplified.mesh().diagonal().max(1e-30));
        let last = simplified.collapses().last();
        let lods = |a: Lod, b: Lod| [a.min(last).0, b.min(last).0];
        let of = |criterion, point, lods, abc| Self { criterion, lods, point, scale, abc, morph: view.morph };
        match view.criterion {
            Criterion::Silhouette { eye, edge, face } => of(0, eye, lods(edge.min(face), face), [0.0; 3]),
            Criterion::ScreenError { eye, slope } => of(1, eye, [0; 2], [slope / scale, 0.0, 0.0]),
            Criterion::Sphere { centre, radius, inside, outside } => {
                let scaled = radius * scale;
                of(2, centre, lods(inside, outside), [scaled * scaled, 0.0, 0.0])
            }
            Criterion::Region { low, high, inside, outside } => of(3, low, lods(inside, outside), high),
        }
    }
}

/// The state of one group.
pub(super) fn state(p: &Parameters, group: &Group, collapses: &CollapseSequence, lists: &CollapseLists) -> State {
    let lod = wanted(p, group, collapses);
    let shown = collapses.floor(Lod(lod)).0;
    let list = lists.list(group.first_vertex);
    let at = list.partition_point(|&entry| entry < shown).min(list.len() - 1);
    if !p.morph || list[at] >= collapses.records() {
        return State { shown, towards: shown, way: 0 };
    }
    let end_after = |record: u32| collapses.parts().step_ends[collapses.steps_at(Lod(record))];
    let came = if at > 0 { end_after(list[at - 1]) } else { 0 };
    let towards = end_after(list[at]);
    let shift = 16 - (towards - came).leading_zeros().min(16);
    let way = ((((lod - came) >> shift) << 16) / ((towards - came) >> shift)).min(65535);
    State { shown, towards, way }
}

fn wanted(p: &Parameters, g: &Group, collapses: &CollapseSequence) -> u32 {
    let ([a, b], position) = (p.lods, g.position);
    if p.criterion > 2 {
        let inside = (0..3).all(|i| position[i] >= p.point[i] && position[i] <= p.abc[i]);
        return if inside { a } else { b };
    }
    let d: [f32; 3] = std::array::from_fn(|i| (p.point[i] - position[i]) * p.scale);
    let square = dot(d, d);
    if p.criterion == 2 {
        return if square <= p.abc[0] { a } else { b };
    }
    // In the eye: as fine as can be.
    if square < 1e-30 {
        return if p.criterion == 0 { a } else { 0 };
    }
    if p.criterion == 1 {
        let error = square * rsqrt(square) * p.abc[0];
        return collapses.lod_for_error(error).0;
    }
    let span = b - a;
    a + ((facing(g, d, square) * span as f32) as u32).min(span)
}

/// From 0, seen edge-on somewhere in the cone, to 1, face-on everywhere.
fn facing(g: &Group, to_eye: [f32; 3], square: f32) -> f32 {
    let axis = g.axis.map(|c| f32::from(c) * (1.0 / 32767.0));
    let half_angle = f32::from(g.cos) * (1.0 / 65536.0);
    let angle = (dot(axis, to_eye).abs() * rsqrt(square)).min(1.0);
    (angle * half_angle - other(angle) * other(half_angle)).max(0.0)
}

/// The sine to a cosine, both from 0 to 1.
fn other(cosine: f32) -> f32 {
    let rest = (1.0 - cosine * cosine).max(1e-20);
    rest * rsqrt(rest)
}
