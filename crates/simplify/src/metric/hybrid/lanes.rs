//! Samples four at a time, one in each SIMD lane: the values of them that pricing reads.

use super::pixel::ShadingError;
use super::samples::Samples;
use super::triangle::PreparedTriangle;
use super::vectors::{NearestPoints, Vec3x4, cosines};
use glam::{Vec3, Vec4};
use lodc_mesh::NONE;

/// A sample covers the points that are nearer to it than this many times its extent. No point
/// between samples of a square lattice is farther than 0.7 extents from one; the rest is a margin
/// for uneven samples, chosen by hand.
const COVERED_EXTENTS: f32 = 1.5;
/// Added to the squared distance, in squared extents, of a face that turns its back to a sample:
/// the square of half an extent, so that it decides only between sheets that nearly coincide.
/// Chosen by hand.
const TURNED_PENALTY: f32 = 0.25;

/// Up to four samples of a star. Lanes without a sample repeat the first one with weight 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleQuad {
    /// The numbers of the samples; `NONE` in lanes without one.
    pub(super) ids: [u32; 4],
    position: Vec3x4,
    pub(super) normal: Vec3x4,
    /// These values are those of [`Sample`](super::samples::Sample).
    pub(super) extent: Vec4,
    pub(super) curvature: Vec4,
    pub(super) weight: Vec4,
    /// Mean squares of the channels of their colours.
    pub(super) power: Vec4,
    /// The fields of [`Layer`](super::samples::Layer).
    pub(super) free: Vec4,
    pub(super) inverse_rest: Vec4,
    /// The error of shading by the normals there, with the colours that are shown now.
    pub(super) shading: ShadingError<Vec4>,
}

impl SampleQuad {
    /// One to four samples.
    pub(super) fn new(four: &[u32], samples: &Samples) -> Self {
        let mut ids = [NONE; 4];
        ids[..four.len()].copy_from_slice(four);
        let (mut position, mut normal) = ([Vec3::ZERO; 4], [Vec3::ZERO; 4]);
        let [mut extent, mut curvature, mut weight, mut power, mut free, mut inverse_rest] =
            [[0.0; 4]; 6];
        let mut shading = ShadingError::default();
        for i in 0..4 {
            let is_missing = i >= four.len();
            let s = samples.get(four[if is_missing { 0 } else { i }]);
            (position[i], normal[i]) = (s.position, s.normal);
            extent[i] = s.extent;
            curvature[i] = s.curvature;
            weight[i] = if is_missing { 0.0 } else { s.weight };
            power[i] = s.power;
            free[i] = s.layer.free;
            inverse_rest[i] = if is_missing { 0.0 } else { s.layer.inverse_rest };
            shading.set(i, &s.shading);
        }
        Self {
            ids,
            position: Vec3x4::new(&position),
            normal: Vec3x4::new(&normal),
            extent: extent.into(),
            curvature: curvature.into(),
            weight: weight.into(),
            power: power.into(),
            free: free.into(),
            inverse_rest: inverse_rest.into(),
            shading: shading.lanes(),
        }
    }

    /// The squared distances up to which the samples cover points.
    fn squared_cover_radius(&self) -> Vec4 {
        (COVERED_EXTENTS * COVERED_EXTENTS * self.extent * self.extent)
            .max(Vec4::splat(f32::MIN_POSITIVE))
    }

    /// Returns whether one of the samples covers a point.
    #[inline]
    pub(super) fn covers(&self, point: Vec3) -> bool {
        let away = self.position.minus(point);
        away.dot(away).cmplt(self.squared_cover_radius()).any()
    }

    /// The squared distances of a point from the samples, as multiples of the squared distances up
    /// to which they cover points.
    pub(super) fn relative_distances(&self, point: Vec3) -> Vec4 {
        let away = self.position.minus(point);
        away.dot(away) / self.squared_cover_radius()
    }

    /// The nearest points of the moved faces, of which there is at least one. A face that turns its
    /// back to a sample yields to one that does not and is nearly as near, so that faces that
    /// coincide keep their samples. The search begins with `moved[likely]`: the nearer it is, the
    /// sooner others are ruled out.
    fn nearest(&self, moved: &[PreparedTriangle], likely: u32) -> NearestPoints {
        let penalty = TURNED_PENALTY * self.extent * self.extent;
        let mut best = Vec4::INFINITY;
        // Which face, as a float: exact up to 2²⁴.
        let (mut face, mut at) = (Vec4::ZERO, [Vec4::ZERO; 2]);
        let likely = likely as usize;
        for i in std::iter::once(likely).chain((0..moved.len()).filter(|&i| i != likely)) {
            let is_turned = self.normal.dot_with(moved[i].normal).cmplt(Vec4::ZERO);
            let added = Vec4::select(is_turned, penalty, Vec4::ZERO);
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

/// The samples of a star, four at a time, with their nearest points of the moved faces; empty if no
/// face is left. Each search begins with the face that was nearest to the sample before.
pub(super) fn nearest_points<'a>(
    samples: &'a [SampleQuad],
    moved: &'a [PreparedTriangle],
) -> impl Iterator<Item = (&'a SampleQuad, NearestPoints)> {
    let samples = if moved.is_empty() { &[] } else { samples };
    let mut likely = 0;
    samples.iter().map(move |quad| {
        let nearest = quad.nearest(moved, likely);
        likely = nearest.face[3];
        (quad, nearest)
    })
}

/// Four samples of a face that does not move, but whose shading changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadedQuad {
    /// The points of the face: shares of its second and third corner.
    at: [Vec4; 2],
    normal: Vec3x4,
    weight: Vec4,
    shading: ShadingError<Vec4>,
    /// The weighted errors by distance, which shading does not change.
    geometric: Vec4,
}

impl ShadedQuad {
    /// Appends the samples of a face, four at a time.
    pub(super) fn gather(face: u32, samples: &Samples, into: &mut Vec<Self>) {
        let mut list = samples.of(face).peekable();
        while list.peek().is_some() {
            let mut normal = [Vec3::ZERO; 4];
            let (mut at, mut weight, mut geometric) = ([[0.0; 4]; 2], [0.0; 4], [0.0; 4]);
            let mut shading = ShadingError::default();
            for (i, s) in list.by_ref().take(4).enumerate() {
                let s = samples.get(s);
                normal[i] = s.normal;
                [at[0][i], at[1][i]] = s.at;
                weight[i] = s.weight;
                geometric[i] = s.geometric;
                shading.set(i, &s.shading);
            }
            into.push(Self {
                at: at.map(Vec4::from),
                normal: Vec3x4::new(&normal),
                weight: weight.into(),
                shading: shading.lanes(),
                geometric: geometric.into(),
            });
        }
    }

    /// The energy of the four samples on a face whose corners are shaded with these normals, in
    /// squared working units, as their weights are.
    #[inline]
    pub(super) fn energy(&self, normals: &[Vec3; 3]) -> f64 {
        let [u, v] = self.at;
        let shown = Vec3x4::mix(*normals, [Vec4::ONE - u - v, u, v]);
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
