//! The hybrid metric: the cost of a collapse is the error that it adds to pictures of the surface.
//!
//! The input's surface is sampled. A sample keeps its position, the normal and the colour that the
//! input shows there, and its visible share (over the cameras of viewpoint metrics). Its error is
//! the expected squared difference of pixels, with a light at the camera, between that and what the
//! nearest of the current triangles shows in its place: normals and texture coordinates of vertices
//! where the mesh has them, else normals of faces averaged across edges below 60°. To that come its
//! distance (silhouettes move by it, where the surface is curved), a place that nothing covers any
//! more, and faces that come to lie where the input has nothing. Hidden samples weigh nothing, so
//! hidden parts are removed first, in the order of the quadric.
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
use crate::metric::reprice::Reprice;
use crate::options::Options;
use crate::recorded::RecordedCollapse;
use appearance::Appearance;
use lodc_mesh::Mesh;
use patch::Source;
use samples::Samples;

/// A distance of this share of the mesh's size has the energy of a normal that is off by one (60°).
/// Image errors of eight textured models hardly differ from 0.0125 to 0.05
/// (design-notes/metrics.md).
const DISTANCE: f64 = 0.025;
/// Weight of attributes beside the quadric. What is seen of them is in the samples; joints and
/// whatever is not shown count by this. Image errors (eight textured models) are at most 0.02 lower
/// with 0, which would leave joints out, 0.01 higher with 1,000, and a quarter higher with 40,000.
const ATTRIBUTES: f64 = 100.0;
/// Pixels across a picture of the mesh: texels are averaged over one. Twice the 256 at which
/// `compare` and the judge of builds look; not tuned.
const PIXELS: f64 = 512.0;
/// The most candidates of a group that are repriced, the geometrically cheapest ones. With eight
/// chr_knight, which chooses colours from a palette, has 1.3 of 255 for 1.8 at 77 %, three other
/// models little less than with three.
const MAX_CANDIDATES: usize = 3;
/// The most faces times candidates that are repriced: 21 faces still have three. Chosen by hand, as
/// a bound on the time that a group takes.
const MAX_FACES_PRICED: usize = 64;
/// Weight of geometry and attributes where nothing is visible, as a share of that elsewhere: it
/// keeps hidden parts in the order of the quadric and before all that is seen. Any small number
/// would do.
const HIDDEN: f64 = 1e-6;
/// Costs below zero, of collapses that improve the look, are mapped to less than this, the others
/// to more, since keys of the queue are not negative. Below what rounding leaves of an energy.
const ZERO: f64 = 1e-16;

/// See the module.
pub(crate) struct HybridMetric<'a> {
    appearance: Appearance<'a>,
    samples: Samples,
    /// The error of each face's samples.
    energy: Vec<f64>,
    /// The energy of a squared distance of one.
    distance_weight: f32,
    /// Weight of the quadric: it decides where nothing is visible, and in planes.
    tie_weight: f64,
    /// Numbers of faces between which it chooses collapses, the larger of each pair first.
    hybrid_ranges: Vec<[f64; 2]>,
    /// The collapses of an earlier run that are repeated first, and the number of faces that ends
    /// them.
    prefix: Option<(&'a [RecordedCollapse], f64)>,
    /// Set in the legal phase until it decides no more: samples follow the faces.
    follows: bool,
    /// Set while it decides.
    active: bool,
    /// Distance of the visible samples of the last star that moved, if samples follow.
    moved: Option<f64>,
    /// Buffers for commits.
    patch: Patch,
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
        let pixel = (size / PIXELS).powi(2) as f32;
        let mut samples = Samples::new(mesh, wedges, &appearance, pixel, options.hybrid_samples);
        visibility::weigh(mesh, &mut samples);
        let faces = |share: f32| f64::from(share) * mesh.faces.len() as f64;
        let hybrid_ranges = guidance.hybrid_ranges.unwrap_or(&[[1.0, 0.0]]);
        let per = |length: f64| if size > 0.0 { (length * size).powi(-2) } else { 0.0 };
        Self {
            appearance,
            samples,
            energy: vec![0.0; mesh.faces.len()],
            distance_weight: per(DISTANCE) as f32,
            tie_weight: per(1.0),
            hybrid_ranges: hybrid_ranges.iter().map(|shares| shares.map(faces)).collect(),
            prefix: guidance.prefix.map(|prefix| (&prefix.collapses.0[..], faces(prefix.share))),
            follows: false,
            active: false,
            moved: None,
            patch: Patch::default(),
        }
    }
}

impl Reprice for HybridMetric<'_> {
    type ViewScratch = Patch;

    fn attribute_weight(&self) -> f64 {
        if self.active { ATTRIBUTES } else { 1.0 }
    }

    fn collapsed(&mut self, mesh: &WorkingMesh, wedges: &Wedges, from: u32, to: u32) {
        self.moved = None;
        if self.follows {
            let Self { appearance, samples, energy, patch, .. } = self;
            let source = Source { mesh, wedges, appearance, samples, energy };
            patch.gather(&source, from);
            patch.move_to(&source, from, to);
            for corner in mesh.star(from) {
                samples.clear(corner.face());
            }
            self.moved = Some(patch.settle(samples, appearance, self.distance_weight, energy));
            samples.sort(mesh);
        }
    }

    /// The root mean square distance of what is visible. Levels of several
    /// objects are chosen by it: hidden parts must not keep one object fine while others go.
    fn error(&self) -> Option<f64> {
        self.moved
    }

    fn is_active(&self) -> bool {
        self.active
    }

    fn should_toggle(&self, mesh: &WorkingMesh) -> bool {
        let faces = f64::from(mesh.live_faces);
        let within = |&[most, least]: &[f64; 2]| faces > least && faces <= most;
        let decides = self.follows && self.hybrid_ranges.iter().any(within);
        decides != self.active
    }

    fn toggle(&mut self, mesh: &WorkingMesh, legal: bool) {
        let faces = f64::from(mesh.live_faces);
        self.follows = legal && self.hybrid_ranges.iter().any(|range| faces > range[1]);
        if self.should_toggle(mesh) {
            self.active = !self.active;
        }
    }

    fn given(&self, mesh: &WorkingMesh, i: usize) -> Option<RecordedCollapse> {
        let (collapses, end) = self.prefix?;
        collapses.get(i).copied().filter(|_| f64::from(mesh.live_faces) > end)
    }

    fn reprice(
        &self,
        mesh: &WorkingMesh,
        wedges: &Wedges,
        from: u32,
        candidates: &mut [(f64, u32)],
        only_cheapest: bool,
        patch: &mut Patch,
    ) {
        let Self { appearance, samples, energy, .. } = self;
        let source = Source { mesh, wedges, appearance, samples, energy };
        patch.gather(&source, from);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let priced = (MAX_FACES_PRICED / mesh.star(from).len().max(1))
            .clamp(1, MAX_CANDIDATES)
            .min(candidates.len());
        let (near, far) = candidates.split_at_mut(priced);
        let tie = self.tie_weight * (patch.visible + HIDDEN);
        let (mut least, mut worst) = (f64::INFINITY, 0.0);
        for (cost, to) in near {
            patch.move_to(&source, from, *to);
            let before = patch.current_energy - tie * *cost;
            let most = if only_cheapest { least + before } else { f64::INFINITY };
            // The energy before is the larger by far, and what is taken from it rounds.
            let most = most + 1e-9 * most.abs();
            let moved = patch.energy(samples, appearance, self.distance_weight, most);
            let added = moved - patch.current_energy + tie * *cost;
            least = added.min(least);
            *cost = if added >= 0.0 { ZERO + added } else { ZERO * ZERO / (ZERO - added) };
            worst = cost.max(worst);
        }
        for (cost, _) in far {
            *cost = worst + tie * *cost;
        }
    }
}
