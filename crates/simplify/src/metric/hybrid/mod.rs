//! The hybrid metric: the cost of a collapse is the error that it adds to pictures of the surface.
//!
//! The input's surface is sampled. A sample keeps its position, the normal and the colour that the
//! input shows there, and its visible share (over the cameras of viewpoint metrics). Its error is
//! the expected squared difference of pixels, with a light at the camera, between the input at the
//! sample and the nearest point of the current triangles. These are shaded with the normals and
//! texture coordinates of vertices where the mesh has them, else with normals of faces averaged
//! across edges below 60°. Three other errors are added: the distance of the sample (by which
//! silhouettes move where the surface is curved), samples that no triangle covers any more, and
//! triangles where the input has nothing. An *energy* is a sum of errors, each times the area of
//! its sample. Hidden samples weigh nothing, so hidden parts are removed first, in the order of the
//! quadric.
//!
//! The metric decides in the legal phase only, while no collapse turns a face over or breaks
//! another rule (`choose::legality`), and there within [`Guidance::hybrid_ranges`] (by default
//! always). Elsewhere, and in the terminal phase that follows, the
//! quadric decides.
//!
//! Related: image-driven simplification (Lindstrom and Turk 2000), appearance-preserving
//! simplification (Cohen, Olano and Manocha 1998) and point samples that follow the surface (Hoppe
//! 1996). No picture is drawn while collapsing: pricing a collapse takes microseconds.

mod appearance;
mod energy;
mod lanes;
mod patch;
mod pixel;
mod samples;
#[cfg(test)]
mod seen_tests;
#[cfg(test)]
mod tests;
mod triangle;
mod vectors;
mod visibility;

pub use appearance::{Checkerboard, SurfaceColours};
pub(crate) use patch::Patch;

use crate::Guidance;
use crate::cut::{Region, Wedges, WorkingMesh};
use crate::metric::reevaluate::Reevaluate;
use crate::options::Options;
use crate::recorded::RecordedCollapse;
use appearance::Appearance;
use lodc_mesh::Mesh;
use patch::PatchInput;
use samples::Samples;

/// A distance of this share of the mesh's size has the energy of a normal that is off by one (60°).
/// Image errors of eight textured models hardly differ from 0.0125 to 0.05
/// (design-notes/metrics.md).
const DISTANCE_SHARE: f64 = 0.025;
/// Weight of attributes beside the quadric. Samples hold what is seen of attributes; this weight is
/// for joints and whatever else is not shown. Image errors (eight textured models) are at most 0.02
/// lower with 0, which would leave joints out, 0.01 higher with 1,000, and a quarter higher with
/// 40,000.
const ATTRIBUTE_WEIGHT: f64 = 100.0;
/// Pixels across a picture of the mesh: texels are averaged over one. Twice the 256 at which
/// `compare` and the judge of builds look; not tuned.
const PICTURE_PIXELS: f64 = 512.0;
/// The most candidates of a group that are re-evaluated: those that are cheapest by geometry. A
/// limit of eight lowers the image error of chr_knight, whose texture is a palette, at 77 % of its
/// triangles from 1.8 to 1.3 (of 255), and that of three other models hardly; it takes longer.
const MAX_CANDIDATES: usize = 3;
/// The most faces times candidates that are re-evaluated: 21 faces still have three. Chosen by
/// hand, as a bound on the time that a group takes.
const MAX_FACES_PRICED: usize = 64;
/// Weight of geometry and attributes where nothing is visible, as a share of that elsewhere: it
/// keeps hidden parts in the order of the quadric and before all that is seen. Any small number
/// would do.
const HIDDEN_WEIGHT: f64 = 1e-6;
/// The cost of a collapse that changes no energy. Keys of the queue are not negative: costs of
/// collapses that improve the look lie between zero and this, all others above. It is smaller than
/// the rounding error of an energy.
const ZERO_COST: f64 = 1e-16;

/// The state of the hybrid metric; the module says how it prices.
pub(crate) struct HybridMetric<'a> {
    appearance: Appearance<'a>,
    samples: Samples,
    /// The energy of each face: the weighted errors of its samples.
    energy: Vec<f64>,
    /// The energy of a squared distance of one.
    distance_weight: f32,
    /// Weight of the quadric beside energies, so small that it decides only where nothing is
    /// visible and in planes.
    tie_weight: f64,
    /// Numbers of faces between which this metric decides, the larger of each pair first.
    hybrid_ranges: Vec<[f64; 2]>,
    /// The collapses of an earlier run that are repeated first, if any.
    prefix: Option<RepeatedPrefix<'a>>,
    /// True while samples are kept with the current faces: in the legal phase, until no range is
    /// left in which this metric decides.
    samples_follow: bool,
    /// True while this metric decides, false while the quadric does.
    active: bool,
    /// Root mean square distance of the visible samples of the last star that moved, in working
    /// units, if samples follow.
    last_rms: Option<f64>,
    /// Buffers for commits.
    patch: Patch,
}

/// The part of an earlier run that is repeated.
struct RepeatedPrefix<'a> {
    collapses: &'a [RecordedCollapse],
    /// It is over once no more faces than this are left.
    end_faces: f64,
}

impl<'a> HybridMetric<'a> {
    /// Samples a mesh and its visibility. Without `colours`, and then without normals of vertices,
    /// the shape alone is seen. `size` is the mesh's diagonal in working units.
    pub(crate) fn new(
        input: &Mesh,
        colours: Option<&'a dyn SurfaceColours>,
        Region { mesh, wedges, .. }: &Region,
        size: f64,
        options: &Options,
        guidance: Guidance<'a>,
    ) -> Self {
        let appearance = colours.map_or_else(Appearance::of_shape, |c| Appearance::new(input, c));
        let pixel_area = (size / PICTURE_PIXELS).powi(2) as f32;
        let mut samples =
            Samples::new(mesh, wedges, &appearance, pixel_area, options.hybrid_samples);
        visibility::weigh(mesh, &mut samples, size);
        let face_count = |share: f32| f64::from(share) * mesh.faces.len() as f64;
        let hybrid_ranges = guidance.hybrid_ranges.unwrap_or(&[[1.0, 0.0]]);
        let inverse_square = |length: f64| if size > 0.0 { (length * size).powi(-2) } else { 0.0 };
        Self {
            appearance,
            samples,
            energy: vec![0.0; mesh.faces.len()],
            distance_weight: inverse_square(DISTANCE_SHARE) as f32,
            tie_weight: inverse_square(1.0),
            hybrid_ranges: hybrid_ranges.iter().map(|shares| shares.map(face_count)).collect(),
            prefix: guidance.prefix.map(|prefix| RepeatedPrefix {
                collapses: &prefix.collapses.0,
                end_faces: face_count(prefix.share),
            }),
            samples_follow: false,
            active: false,
            last_rms: None,
            patch: Patch::default(),
        }
    }
}

impl Reevaluate for HybridMetric<'_> {
    type ViewScratch = Patch;

    fn attribute_weight(&self) -> f64 {
        if self.active { ATTRIBUTE_WEIGHT } else { 1.0 }
    }

    /// Samples lie on the surface at rest. What a collapse costs more in motion counts like as much
    /// squared distance of what is visible: `reevaluate` multiplies it by the weight of the
    /// quadric.
    fn motion_weight(&self) -> f64 {
        if self.active { DISTANCE_SHARE.powi(-2) } else { 1.0 }
    }

    fn collapsed(&mut self, mesh: &WorkingMesh, wedges: &Wedges, from: u32, to: u32) {
        self.last_rms = None;
        if self.samples_follow {
            let Self { appearance, samples, energy, patch, .. } = self;
            let input = PatchInput { mesh, wedges, appearance, samples, energy };
            patch.gather(&input, from);
            patch.move_to(&input, from, to);
            for corner in mesh.star(from) {
                samples.clear(corner.face());
            }
            self.last_rms = Some(patch.settle(samples, appearance, self.distance_weight, energy));
            samples.sort(mesh);
        }
    }

    /// The root mean square distance of what is visible. Levels of several objects are chosen by
    /// it, and hidden parts must not keep one object finer than the others.
    fn error(&self) -> Option<f64> {
        self.last_rms
    }

    fn is_active(&self) -> bool {
        self.active
    }

    fn activity_changes(&self, mesh: &WorkingMesh) -> bool {
        let faces = f64::from(mesh.live_faces);
        let within = |&[upper, lower]: &[f64; 2]| faces > lower && faces <= upper;
        let decides = self.samples_follow && self.hybrid_ranges.iter().any(within);
        decides != self.active
    }

    fn update_activity(&mut self, mesh: &WorkingMesh, legal: bool) {
        let faces = f64::from(mesh.live_faces);
        self.samples_follow = legal && self.hybrid_ranges.iter().any(|range| faces > range[1]);
        if self.activity_changes(mesh) {
            self.active = !self.active;
        }
    }

    fn given(&self, mesh: &WorkingMesh, i: usize) -> Option<RecordedCollapse> {
        let prefix = self.prefix.as_ref()?;
        let is_repeated = f64::from(mesh.live_faces) > prefix.end_faces;
        prefix.collapses.get(i).copied().filter(|_| is_repeated)
    }

    fn reevaluate(
        &self,
        mesh: &WorkingMesh,
        wedges: &Wedges,
        from: u32,
        candidates: &mut [(f64, u32)],
        only_cheapest: bool,
        patch: &mut Patch,
    ) {
        let Self { appearance, samples, energy, .. } = self;
        let input = PatchInput { mesh, wedges, appearance, samples, energy };
        patch.gather(&input, from);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let priced = (MAX_FACES_PRICED / mesh.star(from).len().max(1))
            .clamp(1, MAX_CANDIDATES)
            .min(candidates.len());
        let (cheapest, others) = candidates.split_at_mut(priced);
        let tie_weight = self.tie_weight * (patch.visible + HIDDEN_WEIGHT);
        let (mut least, mut worst) = (f64::INFINITY, 0.0);
        for (cost, to) in cheapest {
            patch.move_to(&input, from, *to);
            let before = patch.current_energy - tie_weight * *cost;
            let limit = if only_cheapest { least + before } else { f64::INFINITY };
            // `added` is a small difference of two large energies: the margin is for its rounding.
            let limit = limit + 1e-9 * limit.abs();
            let moved = patch.energy(samples, appearance, self.distance_weight, limit);
            let added = moved - patch.current_energy + tie_weight * *cost;
            least = added.min(least);
            *cost = if added >= 0.0 {
                ZERO_COST + added
            } else {
                ZERO_COST * ZERO_COST / (ZERO_COST - added)
            };
            worst = cost.max(worst);
        }
        // Candidates that were not re-evaluated come after all that were.
        for (cost, _) in others {
            *cost = worst + tie_weight * *cost;
        }
    }
}
