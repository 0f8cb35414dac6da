//! Levels for many instances under one budget of triangles, or of pixels of error, for each frame
//! (thesis sections 2.5 and 6.2).
//!
//! All instances share one bound: the pixels that an error may take on the screen. Of every
//! instance the coarsest level within the bound is shown. Taking the smallest bound under which the
//! triangles fit is the same as coarsening, again and again, the instance whose next level is least
//! visible, until they fit; but a bound can be searched for by bisection.
//!
//! ```text
//!  eye ·──────────── d ───────────▪ instance, scale s     pixels = error · s · screen / d
//! ```
//!
//! ```
//! use lodc_select::{Goal, Instance, LevelCurve, SceneManager, View};
//!
//! // Errors and triangles of the levels of one model, the finest first.
//! let curve = LevelCurve::new(&[(0.0, 1000), (0.01, 300), (0.05, 80), (0.3, 12)], 1.0);
//! let near = Instance { curve: 0, position: [0.0, 0.0, -4.0], scale: 1.0 };
//! let far = Instance { position: [0.0, 0.0, -90.0], ..near };
//! let mut manager = SceneManager::new(vec![curve], vec![near, far]);
//!
//! let view = View::new([0.0; 3], 60.0, 1080.0);
//! let shown = manager.frame(&view, Goal::Triangles(400));
//! assert!(shown <= 400);
//! assert!(manager.level(0).triangles > manager.level(1).triangles);
//! ```

mod curve;
#[cfg(test)]
mod tests;

pub use curve::{CurveLevel, LevelCurve};

use curve::{LAST_STEP, error_of, step_of};

/// Error steps, 128 to an octave, by which an instance may stay finer than it has to, so that its
/// level does not change while the camera moves a little. Chosen by hand: an eighth of an octave,
/// 9 %.
const HYSTERESIS: u32 = 16;

/// One instance of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Number of its model's curve.
    pub curve: u32,
    /// The centre of its sphere in the world.
    pub position: [f32; 3],
    /// World units of one unit of the model.
    pub scale: f32,
}

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Its position in the world.
    pub eye: [f32; 3],
    /// The focal length in pixels: the size of a unit of length at distance 1.
    pub screen: f32,
    /// Point that it looks at. If given, instances wholly behind the eye get their coarsest level.
    pub target: Option<[f32; 3]>,
}

impl View {
    /// A camera with a vertical field of view in degrees and a screen of a height in pixels.
    #[must_use]
    pub fn new(eye: [f32; 3], fovy: f32, height: f32) -> Self {
        let screen = height / (2.0 * (fovy.to_radians() / 2.0).tan());
        Self { eye, screen, target: None }
    }

    /// The same camera, looking at a point.
    #[must_use]
    pub fn towards(self, target: [f32; 3]) -> Self {
        Self { target: Some(target), ..self }
    }

    /// Returns whether a sphere is wholly behind the eye; `offset` leads from the eye to its
    /// centre.
    fn is_behind(&self, offset: [f32; 3], radius: f32) -> bool {
        let Some(target) = self.target else { return false };
        let forward: [f32; 3] = std::array::from_fn(|c| target[c] - self.eye[c]);
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        dot(forward, offset) < -radius * dot(forward, forward).sqrt()
    }
}

/// Limit on a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// The largest number of triangles of all instances together.
    Triangles(u64),
    /// The largest error of any instance, in pixels.
    Pixels(f32),
}

/// Chooser of levels for the instances of a scene, frame by frame.
#[derive(Clone, Debug)]
pub struct SceneManager {
    curves: Vec<LevelCurve>,
    instances: Vec<Instance>,
    /// For each instance, the error in its model's units that takes one pixel.
    per_pixel: Vec<f32>,
    /// For each instance, the step of its level.
    current: Vec<u32>,
    /// The step of the bound, in pixels, of the last frame.
    bound: u32,
    /// Number of sums of triangles over all instances so far.
    sums: u64,
}

impl SceneManager {
    /// A manager of instances; before the first frame all are at their finest level.
    ///
    /// # Panics
    /// If an instance names a curve that is not there.
    #[must_use]
    pub fn new(curves: Vec<LevelCurve>, instances: Vec<Instance>) -> Self {
        let has_curve = |i: &Instance| (i.curve as usize) < curves.len();
        assert!(instances.iter().all(has_curve), "every instance has a curve");
        let count = instances.len();
        let (per_pixel, current) = (vec![0.0; count], vec![0; count]);
        Self { curves, instances, per_pixel, current, bound: step_of(1.0), sums: 0 }
    }

    /// The instances, which may move between frames.
    pub fn instances_mut(&mut self) -> &mut [Instance] {
        &mut self.instances
    }

    /// The level of an instance, as the last frame chose it.
    #[must_use]
    pub fn level(&self, instance: usize) -> &CurveLevel {
        self.curve(instance).at(self.current[instance])
    }

    /// The bound of the last frame: no error takes more pixels. None if the coarsest levels of all
    /// have more triangles than the budget.
    #[must_use]
    pub fn pixels(&self) -> Option<f32> {
        (self.bound < LAST_STEP).then(|| error_of(self.bound))
    }

    /// Number of times that the triangles of all instances were summed so far; a measure of work.
    #[must_use]
    pub fn sums(&self) -> u64 {
        self.sums
    }

    /// Chooses the levels of a frame and returns their triangles. A budget of triangles is kept
    /// unless the coarsest levels of all have more.
    pub fn frame(&mut self, view: &View, goal: Goal) -> u64 {
        for (instance, per_pixel) in self.instances.iter().zip(&mut self.per_pixel) {
            let [x, y, z] = std::array::from_fn(|c| instance.position[c] - view.eye[c]);
            let radius = self.curves[instance.curve as usize].radius() * instance.scale;
            if view.is_behind([x, y, z], radius) {
                *per_pixel = f32::MAX;
                continue;
            }
            // The distance to the nearest point of the sphere. From inside the sphere it is a small
            // share of the radius, so that errors stay finite; the share is chosen by hand.
            let distance = ((x * x + y * y + z * z).sqrt() - radius).max(radius / 64.0);
            *per_pixel = distance / (view.screen * instance.scale);
        }
        match goal {
            Goal::Pixels(pixels) => {
                self.bound = step_of(pixels).min(LAST_STEP);
                self.choose(u64::MAX)
            }
            Goal::Triangles(budget) => {
                self.bound = self.smallest_bound(budget);
                self.choose(budget)
            }
        }
    }

    fn curve(&self, instance: usize) -> &LevelCurve {
        &self.curves[self.instances[instance].curve as usize]
    }

    /// The error step of an instance under a bound: the coarsest within it, or the present one if
    /// that is finer by no more than [`HYSTERESIS`].
    fn step(&self, instance: usize, bound: u32) -> u32 {
        let coarsest = step_of(error_of(bound) * self.per_pixel[instance]).min(LAST_STEP);
        let coarsest = self.curve(instance).clamped(coarsest);
        let current_step = self.current[instance];
        if current_step <= coarsest && coarsest - current_step <= HYSTERESIS {
            current_step
        } else {
            coarsest
        }
    }

    /// Triangles of all instances under a bound: never more under a larger one. Hysteresis does not
    /// change that: an instance that stays finer under a bound does so under all bounds up to the
    /// one at which it changes, and then gets coarser.
    fn triangles(&mut self, bound: u32) -> u64 {
        self.sums += 1;
        let triangles = |i| u64::from(self.curve(i).at(self.step(i, bound)).triangles);
        (0..self.instances.len()).map(triangles).sum()
    }

    /// The smallest bound under which the triangles fit; the search starts from the last frame's.
    fn smallest_bound(&mut self, budget: u64) -> u32 {
        let (mut low, mut high) = self.bracket(budget);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if self.triangles(middle) > budget { low = middle } else { high = middle }
        }
        high
    }

    /// Two bounds: too many triangles at the first (or it is 0), few enough at the second (or it
    /// is the last). Strides from the last frame's bound grow until they enclose the answer.
    fn bracket(&mut self, budget: u64) -> (u32, u32) {
        let (start, mut stride) = (self.bound, 1);
        if self.triangles(start) > budget {
            let mut low = start;
            while low + stride < LAST_STEP && self.triangles(low + stride) > budget {
                low += stride;
                stride *= 4;
            }
            (low, (low + stride).min(LAST_STEP))
        } else {
            let mut high = start;
            while high > stride && self.triangles(high - stride) <= budget {
                high -= stride;
                stride *= 4;
            }
            (high.saturating_sub(stride), high)
        }
    }

    /// Chooses every instance's level under the bound, then spends the rest of the budget on levels
    /// of the next smaller bound, in the order of instances. `u64::MAX` is no budget.
    fn choose(&mut self, budget: u64) -> u64 {
        let next_bound = self.bound.saturating_sub(1);
        let mut total = self.triangles(self.bound);
        for instance in 0..self.instances.len() {
            let step = self.step(instance, self.bound);
            let finer_step = self.step(instance, next_bound);
            let curve = self.curve(instance);
            let (triangles, finer_triangles) =
                (curve.at(step).triangles, curve.at(finer_step).triangles);
            let with_finer = total + u64::from(finer_triangles) - u64::from(triangles);
            let takes_finer =
                budget < u64::MAX && finer_triangles > triangles && with_finer <= budget;
            if takes_finer {
                total = with_finer;
            }
            self.current[instance] = if takes_finer { finer_step } else { step };
        }
        total
    }
}
