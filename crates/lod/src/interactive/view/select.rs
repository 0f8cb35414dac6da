//! Which LOD each wedge group gets, in the same operations as `select.wgsl`, so that the two agree bit for bit.

use super::criterion::{Criterion, View};
use super::exact::{dot, inverse_power, rsqrt};
use super::{Cones, Group};
use crate::interactive::CollapseLists;
use lodc_mesh::{CollapseSequence, Lod, Simplified};

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

/// Groups as the kernel gets them.
pub(super) fn groups(cones: &Cones) -> Vec<Group> {
    let group = |(cone, &first_vertex): (&super::Cone, &u32)| {
        // Rounded outwards.
        let cos = (cone.cos - 1e-6).max(0.0);
        let sin = (1.0 - cos * cos).sqrt();
        Group { axis: cone.axis.map(|c| c as f32), cos: cos as f32, sin: sin as f32, first_vertex }
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
pub(super) fn state(
    p: &Parameters,
    group: &Group,
    position: [f32; 3],
    collapses: &CollapseSequence,
    lists: &CollapseLists,
) -> State {
    let lod = wanted(p, group, position, collapses);
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

fn wanted(p: &Parameters, g: &Group, position: [f32; 3], collapses: &CollapseSequence) -> u32 {
    let [a, b] = p.lods;
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
    let cos = (dot(g.axis, to_eye).abs() * rsqrt(square)).min(1.0);
    let rest = (1.0 - cos * cos).max(1e-20);
    let sin = rest * rsqrt(rest);
    (cos * g.cos - sin * g.sin).max(0.0)
}
