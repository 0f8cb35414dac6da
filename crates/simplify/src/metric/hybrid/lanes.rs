//! Samples four at a time, in SIMD lanes: the values of them that pricing reads.

use super::pixel::ShadingError;
use super::samples::Samples;
use super::triangle::PreparedTriangle;
use super::vectors::{NearestPoints, Vec3x4, cosines};
use glam::{Vec3, Vec4};
use lodc_mesh::NONE;

/// The input is near where a sample is nearer than this many times its extent. Samples of a lattice
/// are at most 0.7 extents from any place between them; the rest is for uneven ones.
const NEAR: f32 = 1.5;
/// Squared distance, in squared extents, by which a face that turns its back comes later: half an
/// extent, so that only sheets that nearly coincide are told apart by it. Chosen by hand.
const TURNED: f32 = 0.25;

/// Four samples of a star. Those that are missing are like the first, and weigh nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleQuad {
    /// Their numbers; `NONE` for those that are missing.
    pub(super) ids: [u32; 4],
    position: Vec3x4,
    pub(super) normal: Vec3x4,
    pub(super) extent: Vec4,
    pub(super) curvature: Vec4,
    pub(super) weight: Vec4,
    /// Mean squares of the channels of their colours.
    pub(super) power: Vec4,
    /// Errors of shading where they show what they show now.
    pub(super) shading: ShadingError<Vec4>,
}

impl SampleQuad {
    /// One to four samples.
    pub(super) fn new(four: &[u32], samples: &Samples) -> Self {
        let mut ids = [NONE; 4];
        ids[..four.len()].copy_from_slice(four);
        let (mut position, mut normal) = ([Vec3::ZERO; 4], [Vec3::ZERO; 4]);
        let mut values = [[0.0; 4]; 4];
        let mut shading = ShadingError::default();
        for i in 0..4 {
            let is_missing = i >= four.len();
            let s = samples.get(four[if is_missing { 0 } else { i }]);
            (position[i], normal[i]) = (s.position, s.normal);
            values[0][i] = s.extent;
            values[1][i] = s.curvature;
            values[2][i] = if is_missing { 0.0 } else { s.weight };
            values[3][i] = s.power;
            shading.set(i, &s.shading);
        }
        let [extent, curvature, weight, power] = values.map(Vec4::from);
        Self {
            ids,
            position: Vec3x4::new(&position),
            normal: Vec3x4::new(&normal),
            extent,
            curvature,
            weight,
            power,
            shading: shading.lanes(),
        }
    }

    /// The squares of how far the samples reach.
    fn squared_reach(&self) -> Vec4 {
        (NEAR * NEAR * self.extent * self.extent).max(Vec4::splat(f32::MIN_POSITIVE))
    }

    /// Returns whether a place is within the reach of a sample.
    #[inline]
    pub(super) fn reaches(&self, place: Vec3) -> bool {
        let away = self.position.minus(place);
        away.dot(away).cmplt(self.squared_reach()).any()
    }

    /// The squared distances of a place, divided by the squared reaches.
    pub(super) fn reaches_away(&self, place: Vec3) -> Vec4 {
        let away = self.position.minus(place);
        away.dot(away) / self.squared_reach()
    }

    /// The points of the moved faces that are nearest. A face that turns its back to a sample comes
    /// after one nearly as near that does not: where faces coincide, each keeps its samples.
    /// `likely` is the index of a face to begin with: the nearer that is, the sooner others are
    /// ruled out.
    fn nearest(&self, moved: &[PreparedTriangle], likely: u32) -> NearestPoints {
        let behind = TURNED * self.extent * self.extent;
        let mut best = Vec4::INFINITY;
        let (mut face, mut at) = (Vec4::ZERO, [Vec4::ZERO; 2]);
        let likely = likely as usize;
        for i in std::iter::once(likely).chain((0..moved.len()).filter(|&i| i != likely)) {
            let is_turned = self.normal.dot_with(moved[i].normal).cmplt(Vec4::ZERO);
            let added = Vec4::select(is_turned, behind, Vec4::ZERO);
            let Some(found) = moved[i].nearest_to(self.position, best - added) else { continue };
            let squared = found.squared + added;
            let nearer = squared.cmplt(best);
            best = Vec4::select(nearer, squared, best);
            face = Vec4::select(nearer, Vec4::splat(i as f32), face);
            at = [0, 1].map(|k| Vec4::select(nearer, found.at[k], at[k]));
        }
        let face = face.to_array().map(|f| f as u32);
        let [u, v] = at.map(|lane| lane.to_array());
        let mut points = [Vec3::ZERO; 4];
        for i in 0..4 {
            points[i] = moved[face[i] as usize].at([u[i], v[i]]);
        }
        let away = self.position.minus_each(Vec3x4::new(&points));
        NearestPoints { face, at, away, squared: away.dot(away) }
    }
}

/// The samples of a star, four at a time, with their nearest points of the moved faces; none where
/// no face is left. The search begins with the face of the sample before, which lies near.
pub(super) fn nearest_points<'a>(
    samples: &'a [SampleQuad],
    moved: &'a [PreparedTriangle],
) -> impl Iterator<Item = (&'a SampleQuad, NearestPoints)> {
    let mut likely = 0;
    samples.iter().filter(|_| !moved.is_empty()).map(move |quad| {
        let nearest = quad.nearest(moved, likely);
        likely = nearest.face[3];
        (quad, nearest)
    })
}

/// Four samples of a face that keeps its place, priced by the normals that the face is shaded with.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadedQuad {
    at: [Vec4; 2],
    normal: Vec3x4,
    weight: Vec4,
    shading: ShadingError<Vec4>,
    geometric: Vec4,
}

impl ShadedQuad {
    /// Appends the samples of a face, four at a time.
    pub(super) fn gather(face: u32, samples: &Samples, into: &mut Vec<Self>) {
        let mut list = samples.of(face).peekable();
        while list.peek().is_some() {
            let mut normal = [Vec3::ZERO; 4];
            let mut values = [[0.0; 4]; 4];
            let mut shading = ShadingError::default();
            for (i, s) in list.by_ref().take(4).enumerate() {
                let s = samples.get(s);
                normal[i] = s.normal;
                values[0][i] = s.at[0];
                values[1][i] = s.at[1];
                values[2][i] = s.weight;
                values[3][i] = s.geometric;
                shading.set(i, &s.shading);
            }
            let [u, v, weight, geometric] = values.map(Vec4::from);
            let normal = Vec3x4::new(&normal);
            into.push(Self { at: [u, v], normal, weight, shading: shading.lanes(), geometric });
        }
    }

    /// The sum of the four.
    #[inline]
    pub(super) fn energy(&self, shading: &[Vec3; 3]) -> f64 {
        let [a, b, c] = *shading;
        let [u, v] = self.at;
        let shown = Vec3x4::mix([a, b, c], [Vec4::ONE - u - v, u, v]);
        let shading = self.shading.error(cosines(shown, self.normal));
        sum(self.weight * shading + self.geometric)
    }
}

/// The sum of four numbers.
#[inline]
pub(super) fn sum(four: Vec4) -> f64 {
    let [a, b, c, d] = four.to_array();
    f64::from(a) + f64::from(b) + f64::from(c) + f64::from(d)
}
