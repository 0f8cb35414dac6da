//! Chooses the LOD of each vertex by a criterion, and the position of a vertex that morphs, in the
//! same operations as `view.wgsl`, so that device and CPU agree bit for bit.

use super::criterion::{Criterion, ViewQuery};
use super::deterministic_math::{dot, inverse_power, rsqrt};
use super::eye_space::rotation;
use super::{Cone, Cones};
use lodc_mesh::{CollapseSequence, Lod, NONE};

/// Collapses of one vertex that are followed one by one. The kernel has the same number, which
/// bounds the time of a thread. Chosen by hand.
pub(super) const MAX_WALK: u32 = 64;

/// Share of a move below which neither it nor the moves that continue it change an `f32`. Without
/// it, thousands of moves around a high-valence vertex may be followed one after the other.
const MIN_SHARE: f32 = 1e-7;

/// Added to the sines of cones, and cosines below which one counts as open: more than the
/// arithmetic on devices may err. Chosen by hand.
const CONE_MARGIN: f64 = 1e-4;

/// The criteria by the numbers that `view.wgsl` has for them.
pub(super) const SILHOUETTE: u32 = 0;
pub(super) const SCREEN_ERROR: u32 = 1;
pub(super) const SPHERE: u32 = 2;
pub(super) const REGION: u32 = 3;
pub(super) const FRUSTUM: u32 = 4;

/// The state of a vertex between the steps in which it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct State {
    /// The LOD that it chose; what is shown is that of the end of the step before.
    pub lod: u32,
    /// The vertex that is shown.
    pub entry: u32,
    /// The vertex that it becomes next; itself if it is the last.
    pub next: u32,
    /// The share of its move to that one's position that it has made, in 1/65536; 0 without
    /// morphing.
    pub progress: u32,
}

/// The input of a vertex's selection, the same for all vertices of a wedge group: four words
/// on a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The position at LOD 0.
    pub position: [f32; 3],
    /// The axis of its cone of normals; only the direction counts.
    pub axis: [i8; 3],
    /// Sine of half the cone's angle, times 255, rounded outwards; 255 for all directions.
    pub sine: u8,
}

impl Point {
    fn new(position: [f32; 3], cone: &Cone) -> Self {
        let largest = cone.axis.iter().fold(0.0f64, |largest, c| largest.max(c.abs()));
        let axis = cone.axis.map(|c| (c * 127.0 / largest).round() as i8);
        let rounded = axis.map(f64::from);
        let length = rounded.iter().map(|c| c * c).sum::<f64>().sqrt();
        let cos_between = rounded
            .iter()
            .zip(cone.axis)
            .map(|(a, b)| a * b / length)
            .sum::<f64>()
            .clamp(-1.0, 1.0);
        // The cone around the rounded axis that holds this one, and a little more. Sums of angles
        // by their sines and cosines: the same on every machine.
        let sine_of = |cos: f64| (1.0 - cos * cos).max(0.0).sqrt();
        let cos = cone.cos.clamp(-1.0, 1.0);
        let sum = sine_of(cos) * cos_between + cos * sine_of(cos_between) + CONE_MARGIN;
        let narrow = cos * cos_between - sine_of(cos) * sine_of(cos_between) > CONE_MARGIN;
        let sine = if narrow { (sum * 255.0).ceil().min(255.0) as u8 } else { 255 };
        Self { position, axis, sine }
    }

    /// Returns the words that a kernel reads.
    #[must_use]
    pub fn words(&self) -> [u32; 4] {
        let [x, y, z] = self.position.map(f32::to_bits);
        let [i, j, k] = self.axis.map(i8::cast_unsigned);
        [x, y, z, u32::from_le_bytes([i, j, k, self.sine])]
    }
}

/// Returns the vertices of a shape as the kernel gets them. All of a group have the position of its
/// first one. Those of no group have an open cone.
pub(super) fn points(cones: &Cones, shape: &[[f32; 3]]) -> Vec<Point> {
    let mut first_vertices = vec![NONE; cones.cones.len()];
    let point = |(v, &group): (u32, &u32)| match first_vertices.get_mut(group as usize) {
        Some(first_vertex) => {
            *first_vertex = (*first_vertex).min(v);
            Point::new(shape[*first_vertex as usize], &cones.cones[group as usize])
        }
        None => Point::new(shape[v as usize], &Cone::OPEN),
    };
    (0..).zip(&cones.of_vertex).map(point).collect()
}

/// Returns the target of each vertex and the LOD from which on it is shown: the end of the step.
/// The last one stays for good.
pub(super) fn links(collapses: &CollapseSequence) -> Vec<[u32; 2]> {
    let parts = collapses.parts();
    let mut links = Vec::with_capacity(parts.targets.len() + 1);
    for &end in &parts.step_ends {
        links.extend((links.len()..end as usize).map(|record| [parts.targets[record], end]));
    }
    links.push([links.len() as u32, NONE]);
    links
}

/// LODs by error, so that a device needs no search: errors that differ by less than about 0.2 %
/// share an entry, the LOD for the smallest of them.
#[derive(Clone, Debug)]
pub(super) struct ByError {
    /// The first entry's error: the upper 18 bits of a float.
    pub(super) lowest: u32,
    /// The coarsest LOD of each; the first for whatever is smaller, the last for whatever is larger
    /// than all errors.
    pub(super) lods: Vec<u32>,
}

impl ByError {
    /// Bits of an `f32` that an entry does not distinguish: 9 of the mantissa are left.
    const DROPPED_BITS: u32 = 14;
    /// Errors of 14 powers of two are distinguished, 512 of each; smaller ones count as none.
    const COUNT: u32 = 14 * 512;

    pub(super) fn new(collapses: &CollapseSequence) -> Self {
        let finite = |e: &&f32| e.is_finite();
        let largest = collapses.parts().step_errors.iter().rev().find(finite);
        let largest = largest.map_or(0, |e| e.to_bits() >> Self::DROPPED_BITS);
        let lowest = (largest + 2).saturating_sub(Self::COUNT);
        let error =
            |i: u32| if i == 0 { 0.0 } else { f32::from_bits((lowest + i) << Self::DROPPED_BITS) };
        Self {
            lowest,
            lods: (0..Self::COUNT).map(|i| collapses.lod_for_error(error(i)).0).collect(),
        }
    }

    /// Returns the coarsest LOD for an error, or one that is finer by less than 0.2 % of it.
    fn lod(&self, error: f32) -> u32 {
        let key = (error.to_bits() >> Self::DROPPED_BITS)
            .clamp(self.lowest, self.lowest + Self::COUNT - 1);
        self.lods[(key - self.lowest) as usize]
    }
}

/// A view in the numbers that the kernel is given.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parameters {
    /// One of the constants above, from [`SILHOUETTE`] to [`FRUSTUM`].
    pub(super) criterion: u32,
    /// The LOD at edges or inside, and the other one.
    pub(super) lods: [u32; 2],
    /// The viewpoint, the centre, or the lowest corner.
    pub(super) point: [f32; 3],
    /// A power of two by which lengths are scaled; of a screen the tangent of half its width.
    pub(super) scale: f32,
    /// Of a screen the tangent of half its height.
    pub(super) height: f32,
    /// Of a silhouette the rise of LODs with the cosine, and the width; of an error on the screen
    /// the factor from distance to error; of a sphere the squared radius; of a box its highest
    /// corner; of a screen the rotation to eye space.
    pub(super) abc: [f32; 3],
    pub(super) morph: bool,
}

impl Parameters {
    /// Those of a view of a surface with this diagonal and LODs down to `last`.
    pub(super) fn new(view: &ViewQuery, diagonal: f64, last: Lod) -> Self {
        let scale = inverse_power(diagonal.max(1e-30));
        let lods = |a: Lod, b: Lod| [a.min(last).0, b.min(last).0];
        let parameters = |criterion, point, lods, abc| Self {
            criterion,
            lods,
            point,
            scale,
            height: 0.0,
            abc,
            morph: view.morph,
        };
        match view.criterion {
            Criterion::Silhouette { eye, edge, face, width } => {
                let [edge, face] = lods(edge.min(face), face);
                let rise = ((face - edge) as f32 / width.max(f32::MIN_POSITIVE)).min(f32::MAX);
                parameters(SILHOUETTE, eye, [edge, face], [rise, width * (1.0 / 255.0), 0.0])
            }
            Criterion::ScreenError { eye, slope } => {
                parameters(SCREEN_ERROR, eye, [0; 2], [(slope / scale).max(0.0), 0.0, 0.0])
            }
            Criterion::Sphere { centre, radius, inside, outside } => {
                let scaled = radius * scale;
                parameters(SPHERE, centre, lods(inside, outside), [scaled * scaled, 0.0, 0.0])
            }
            Criterion::Region { low, high, inside, outside } => {
                parameters(REGION, low, lods(inside, outside), high)
            }
            Criterion::Frustum { eye, target, tangents, inside, outside } => Self {
                scale: tangents[0],
                height: tangents[1],
                ..parameters(FRUSTUM, eye, lods(inside, outside), rotation(eye, target))
            },
        }
    }
}

/// Returns the vertex that is shown for one at a LOD. Short chains of collapses are walked as the
/// kernel walks all; `find_from` finds the end of long ones from a vertex on, as around a vertex of
/// thousands of triangles.
pub(super) fn entry(
    vertex: u32,
    lod: u32,
    links: &[[u32; 2]],
    find_from: impl FnOnce(u32) -> u32,
) -> u32 {
    let mut entry = vertex;
    for _ in 0..MAX_WALK {
        if links[entry as usize][1] > lod {
            return entry;
        }
        entry = links[entry as usize][0];
    }
    find_from(entry)
}

/// Returns the state of a vertex that is shown as `entry` at a LOD.
pub(super) fn state(entry: u32, lod: u32, links: &[[u32; 2]], morph: bool) -> State {
    let [next, removal_lod] = links[entry as usize];
    let progress = if morph { morph_progress(removal_lod, lod, links.len() as u32) } else { 0 };
    State { lod, entry, next, progress }
}

/// Returns the share of its move that a vertex has made at a LOD, in 1/65536. The vertex disappears
/// at the end of some step, `removal_lod`, and begins to move n/8 records before that, n being the
/// number of vertices that remain longer.
fn morph_progress(removal_lod: u32, lod: u32, vertex_count: u32) -> u32 {
    let length = removal_lod.min((vertex_count - removal_lod.min(vertex_count)) / 8 + 1);
    let records_moved = lod.saturating_sub(removal_lod - length);
    // Integers, because division of integers is exact; both fit 16 bits after the shift.
    let shift = 16 - length.leading_zeros().min(16);
    (((records_moved >> shift) << 16) / (length >> shift)).min(65535)
}

/// Returns the position of an entry at a LOD, between its own and that of its target at the LOD: it
/// depends on entry and LOD alone, so that removed triangles do not come back, and is continuous
/// where the entry changes.
pub(super) fn morphed_position(
    entry: u32,
    lod: u32,
    links: &[[u32; 2]],
    position: impl Fn(u32) -> [f32; 3],
) -> [f32; 3] {
    let (mut current, mut share, mut position_now) = (entry, 1.0f32, position(entry));
    loop {
        let [next, removal_lod] = links[current as usize];
        let progress = morph_progress(removal_lod, lod, links.len() as u32);
        if progress == 0 {
            return position_now;
        }
        share *= progress as f32 * (1.0 / 65536.0);
        if share < MIN_SHARE {
            return position_now;
        }
        let (a, b) = (position(current), position(next));
        position_now = std::array::from_fn(|i| position_now[i] + share * (b[i] - a[i]));
        current = next;
    }
}

/// Returns the LOD that a view wants at a point.
pub(super) fn wanted_lod(p: &Parameters, point: &Point, by_error: &ByError) -> u32 {
    let ([a, b], position) = (p.lods, point.position);
    if p.criterion == FRUSTUM {
        return if is_on_screen(p, position) { a } else { b };
    }
    if p.criterion == REGION {
        let inside = (0..3).all(|i| position[i] >= p.point[i] && position[i] <= p.abc[i]);
        return if inside { a } else { b };
    }
    let to_point: [f32; 3] = std::array::from_fn(|i| (p.point[i] - position[i]) * p.scale);
    let square = dot(to_point, to_point);
    if p.criterion == SPHERE {
        return if square <= p.abc[0] { a } else { b };
    }
    // At the viewpoint itself: as fine as can be.
    if square < 1e-30 {
        return if p.criterion == SILHOUETTE { a } else { 0 };
    }
    if p.criterion == SCREEN_ERROR {
        return by_error.lod(square * rsqrt(square) * p.abc[0]);
    }
    let span = b - a;
    a + ((facing(point, to_point, square, p.abc[1]) * p.abc[0]).min(span as f32) as u32).min(span)
}

/// Returns whether a position is ahead of the eye and within the screen.
fn is_on_screen(p: &Parameters, position: [f32; 3]) -> bool {
    let to_point: [f32; 3] = std::array::from_fn(|i| position[i] - p.point[i]);
    let squared = (1.0 - dot(p.abc, p.abc)).max(1e-20);
    let w = squared * rsqrt(squared);
    // Rotated by the unit quaternion (abc, w).
    let doubled = cross(p.abc, to_point).map(|c| 2.0 * c);
    let second = cross(p.abc, doubled);
    let [x, y, z]: [f32; 3] = std::array::from_fn(|i| (to_point[i] + w * doubled[i]) + second[i]);
    x.abs() <= -z * p.scale && y.abs() <= -z * p.height
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

/// Returns a number from 0, where some normal of the cone is seen edge-on, to 1, where all are seen
/// face-on. `square` is the squared length of `to_eye`, `sine_unit` what 1 in [`Point::sine`] is.
fn facing(point: &Point, to_eye: [f32; 3], square: f32, sine_unit: f32) -> f32 {
    let axis = point.axis.map(f32::from);
    let sine = f32::from(point.sine) * sine_unit;
    let cosine = (dot(axis, to_eye).abs() * rsqrt(dot(axis, axis) * square)).min(1.0);
    (cosine * complement(sine) - complement(cosine) * sine).max(0.0)
}

/// Returns the sine for a cosine, or the cosine for a sine, both from 0 to 1.
fn complement(cosine: f32) -> f32 {
    let squared = (1.0 - cosine * cosine).max(1e-20);
    squared * rsqrt(squared)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_find_the_lod_that_is_allowed_and_nearly_the_coarsest() {
        let mesh = lodc_fixtures::icosphere(3);
        let simplified = lodc_fixtures::random_collapse(&mesh, 1);
        let collapses = simplified.collapses();
        let by_error = ByError::new(collapses);
        let largest = *collapses.parts().step_errors.last().expect("steps");
        for i in 0..5000 {
            let error = largest * 1.2 * (i as f32 / 5000.0).powi(3);
            let found = by_error.lod(error);
            assert!(found <= collapses.lod_for_error(error).0, "{error}");
            if error > largest / 8000.0 {
                assert!(found >= collapses.lod_for_error(error * (1.0 - 1.0 / 511.0)).0, "{error}");
            }
        }
        assert_eq!(by_error.lod(f32::MAX), collapses.last().0);
        assert_eq!(by_error.lod(0.0), collapses.lod_for_error(0.0).0);
    }

    #[test]
    fn rounded_cones_hold_what_the_cones_hold() {
        let mut state = 1u64;
        let mut unit = || {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (state >> 40) as f64 / 8_388_608.0 - 1.0
        };
        let mut narrowest = 255;
        for _ in 0..2000 {
            let axis: [f64; 3] = std::array::from_fn(|_| unit());
            let length = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
            let angle = 1.6 * unit().abs().powi(3);
            let cone = Cone { axis: axis.map(|c| c / length), cos: angle.cos().max(0.0) };
            let point = Point::new([0.0; 3], &cone);
            let rounded = point.axis.map(f64::from);
            let length = rounded.iter().map(|c| c * c).sum::<f64>().sqrt();
            let off = rounded
                .iter()
                .zip(cone.axis)
                .map(|(a, b)| a * b / length)
                .sum::<f64>()
                .min(1.0)
                .acos();
            let half_angle = (f64::from(point.sine) / 255.0).asin();
            assert!(point.sine == 255 || half_angle >= angle + off, "{cone:?}: {point:?}");
            assert!(angle > 1.5 || half_angle < angle + 0.1, "{cone:?}: {point:?}");
            narrowest = narrowest.min(point.sine);
        }
        assert!(narrowest < 5, "{narrowest}");
    }
}
