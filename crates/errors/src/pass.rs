//! The pass over all steps: an error that never falls, raised where a sample or a new face is
//! farther.

use crate::faces::{Changes, Faces};
use crate::input::Input;
use crate::refine::{FLOOR, Refine};
use crate::samples::{Sample, Samples, area};
use crate::step_errors::StepErrors;
use glam::DVec3;
use lodc_mesh::{NONE, Simplified};
use lodc_nearest::Hit;
use lodc_nearest::distance_squared;

/// Margin stated above the distance found, for what no sample saw.
const MARGIN: f64 = 1.05;

/// Distances within this share of the bound need no better face.
const NEAR_ENOUGH: f64 = 0.75;
/// The same once many places have been refined.
const NEAR_ENOUGH_LATE: f64 = 0.95;

/// Changed faces that a sample is tried on before the tree is asked.
const TRIED: usize = 48;

/// Points asked in one refinement.
const QUERIES: u32 = 150;

/// Triangles of a mesh that is searched as a whole after every step.
const EXHAUSTIVE: usize = 100;
const EXHAUSTIVE_QUERIES: u32 = 10_000;

/// Records that are read ahead at once.
const READ_AHEAD: u32 = 16;

/// Work for each input triangle, in faces touched, distances to faces and boxes opened, after which
/// the pass gives up: then the diagonal bounds all errors. Real meshes need less than a third.
const WORK_PER_TRIANGLE: u64 = 1_000;

/// Work that any mesh may take besides.
const FREE_WORK: u64 = 10_000_000;

/// Boxes that one search may open: many, and few once half of the work is done. A search that
/// ends early gives distances that are too large, never too small.
const PATIENCE: [u32; 2] = [20_000, 64];

pub(crate) struct Pass<'a> {
    pub(crate) input: &'a Input,
    pub(crate) faces: Faces,
    pub(crate) samples: Samples,
    pub(crate) changes: Changes,
    /// The border of the fan that a step removes.
    pub(crate) link: Vec<DVec3>,
    /// Corners of the changed faces.
    pub(crate) corners: Vec<[DVec3; 3]>,
    /// The squared bound.
    pub(crate) bound: f64,
    near_enough: f64,
    pub(crate) queries: u64,
    pub(crate) work: u64,
    /// The step that is followed, counted from 1.
    pub(crate) step: u32,
    /// For each point the last step that asked an edge to it.
    pub(crate) asked: Vec<u32>,
    taken: Vec<(u32, u32)>,
    doubtful: Vec<u32>,
    /// Sum of area times mean squared distance over live faces, and of areas.
    back: [f64; 2],
}

impl<'a> Pass<'a> {
    /// Starts at LOD 0. `wedges` has the corners of its triangles as vertices of the mesh.
    pub(crate) fn new(input: &'a Input, wedges: Vec<[u32; 3]>) -> Self {
        let mut faces = Faces::new(input, &wedges);
        drop(wedges);
        for face in &mut faces.all {
            face.area = area(input.at(face.points));
        }
        let samples = Samples::new(input, &mut faces.all);
        Self {
            input,
            back: [0.0, samples.weight],
            faces,
            samples,
            changes: Changes::default(),
            link: vec![],
            corners: vec![],
            bound: 0.0,
            near_enough: NEAR_ENOUGH,
            queries: 0,
            work: 0,
            step: 0,
            asked: vec![0; input.places.len()],
            taken: vec![],
            doubtful: vec![],
        }
    }

    /// Runs through all steps.
    pub(crate) fn run(mut self, simplified: &Simplified) -> StepErrors {
        let sequence = simplified.collapses();
        let (targets, ends) = (sequence.targets(), &sequence.parts().step_ends);
        let all = self.input.triangles.len() as u64;
        let mut errors = StepErrors::with_capacity(ends.len());
        let most = WORK_PER_TRIANGLE * all + FREE_WORK;
        let (mut first, mut ahead, mut rms, mut gone) = (0, 0, 0.0f64, 0u32);
        for (step, &end) in (1u32..).zip(ends) {
            if self.work > most {
                let left = sequence.parts().step_triangles[step as usize - 1] > 0;
                let diagonal = self.input.diagonal * self.input.unit;
                let error = if left { diagonal } else { f64::INFINITY };
                errors.push(error, error);
                continue;
            }
            let late =
                self.queries > 4_000.min(4 * all) + 2 * all * u64::from(step) / ends.len() as u64;
            self.near_enough = if late { NEAR_ENOUGH_LATE } else { NEAR_ENOUGH };
            let moves = (first..end).map(|k| (k, targets[k as usize]));
            self.step = step;
            if end > ahead {
                let to = (end + READ_AHEAD).min(targets.len() as u32);
                self.faces.read_ahead(self.input, ahead..to, |s| self.samples.touch(s));
                ahead = to;
            }
            self.faces.apply(self.input, step, moves, &mut self.changes);
            gone += u32::from(!self.changes.touched.is_empty());
            first = end;
            self.work += 1 + self.changes.touched.len() as u64;
            if all == 0 {
                errors.push(0.0, 0.0);
            } else if self.faces.live == 0 {
                errors.push(f64::INFINITY, f64::INFINITY);
            } else {
                if !self.changes.touched.is_empty() {
                    self.follow();
                }
                rms = rms.max(self.rms(gone));
                let error = if self.bound <= FLOOR { 0.0 } else { self.bound.sqrt() * MARGIN };
                errors.push(error * self.input.unit, rms.min(error) * self.input.unit);
            }
        }
        errors
    }

    /// Follows one step.
    fn follow(&mut self) {
        let Self { input, faces, changes, corners, .. } = self;
        corners.clear();
        corners.extend(changes.changed.iter().map(|&t| input.at(faces.all[t as usize].points)));
        self.doubtful.clear();
        self.place_samples();
        self.take_new_samples();
        self.refine_doubtful();
        for i in 0..self.changes.changed.len() {
            self.samples.thin(&mut self.faces.all, self.changes.changed[i], self.faces.live);
        }
        self.measure_back();
        if self.input.triangles.len() <= EXHAUSTIVE {
            self.refine_all();
        }
    }

    /// Searches the whole input and all changed faces by branch and bound.
    fn refine_all(&mut self) {
        let Self { input, faces, corners, .. } = self;
        let (level, tree) = faces.level(input);
        let patience = PATIENCE[0];
        let (bound, left, opened) = (self.bound, EXHAUSTIVE_QUERIES, 0);
        let mut refine = Refine { triangles: &level, tree, bound, left, patience, opened };
        for &t in &input.triangles {
            refine.triangle(input.at(t), NONE);
        }
        let (triangles, tree) = (*input, &input.tree);
        let bound = refine.bound;
        let mut refine = Refine { triangles, tree, bound, left, patience, opened };
        for &face in corners.iter() {
            refine.triangle(face, NONE);
        }
        self.bound = refine.bound;
    }

    /// Finds the nearest face for the samples of all faces that were touched.
    fn place_samples(&mut self) {
        let mut taken = std::mem::take(&mut self.taken);
        taken.clear();
        for &t in &self.changes.touched {
            self.samples.take(&mut self.faces.all, t, &mut taken);
        }
        self.work += taken.len() as u64;
        for &(number, own) in &taken {
            let p = self.samples.all[number as usize].place();
            let nearest = self.nearest_face(p, own, self.bound * 0.25);
            if nearest.squared > self.enough()
                && nearest.squared > 1.1 * f64::from(self.samples.all[number as usize].refined)
            {
                self.doubtful.push(number);
            }
            self.bound = self.bound.max(nearest.squared);
            self.samples.set(number, nearest.squared);
            self.samples.link(&mut self.faces.all, nearest.triangle, number);
        }
        self.taken = taken;
    }

    /// Tries the centroids and the edge midpoints of triangles that change for the first time, and
    /// keeps those that are far.
    fn take_new_samples(&mut self) {
        for i in 0..self.changes.touched.len() {
            let t = self.changes.touched[i];
            if !std::mem::take(&mut self.faces.all[t as usize].original) {
                continue;
            }
            let points = self.input.triangles[t as usize];
            let corners = self.input.at(points);
            for k in 0..4 {
                // Each inner edge is tried by the triangle that has it in rising order.
                if k < 3 && points[k] > points[(k + 1) % 3] {
                    continue;
                }
                let p = match k {
                    3 => lodc_nearest::centroid(corners),
                    k => (corners[k] + corners[(k + 1) % 3]) * 0.5,
                };
                let near = self.bound * 0.09;
                let nearest = self.nearest_face(p, t, near);
                if nearest.squared <= near.max(FLOOR) || nearest.triangle == NONE {
                    continue;
                }
                let sample = Sample::inside(p.to_array().map(|x| x as f32), t, 0.0);
                let number = self.samples.add(&mut self.faces.all, nearest.triangle, sample);
                self.samples.set(number, nearest.squared);
                if nearest.squared > self.enough() {
                    self.doubtful.push(number);
                }
                self.bound = self.bound.max(nearest.squared);
            }
        }
    }

    /// Looks more closely at the input around samples that are far.
    fn refine_doubtful(&mut self) {
        for i in 0..self.doubtful.len() {
            let sample = &mut self.samples.all[self.doubtful[i] as usize];
            let sources = sample.sources(self.input);
            let enough = (self.bound * self.near_enough * self.near_enough).max(FLOOR);
            if f64::from(sample.squared) <= enough {
                continue;
            }
            sample.refined = sample.squared;
            let (level, tree) = self.faces.level(self.input);
            let mut refine = Refine {
                triangles: &level,
                tree,
                bound: self.bound,
                left: QUERIES,
                patience: patience(self.work, self.input),
                opened: 0,
            };
            for &t in sources.as_slice() {
                if refine.left == 0 {
                    break;
                }
                refine.triangle(self.input.at(self.input.triangles[t as usize]), NONE);
            }
            self.bound = refine.bound;
            self.queries += u64::from(QUERIES - refine.left);
            self.work += refine.opened;
        }
    }

    /// Returns a live face near a point: its own, a changed one, or one found in the tree if these
    /// are too far. Stops within the squared distance `near`.
    fn nearest_face(&mut self, p: DVec3, own: u32, near: f64) -> Hit {
        let mut nearest = Hit::NOTHING;
        let near = near.max(FLOOR);
        if self.faces.all[own as usize].live {
            let corners = self.input.at(self.faces.all[own as usize].points);
            nearest.offer(distance_squared(p, corners), own);
        }
        for (&t, corners) in self.changes.changed.iter().zip(&self.corners).take(TRIED) {
            if nearest.squared <= near {
                break;
            }
            if t != own {
                self.work += 1;
                nearest.offer(distance_squared(p, *corners), t);
            }
        }
        let enough = self.enough();
        if nearest.squared > enough {
            let (level, tree) = self.faces.level(self.input);
            let (hint, patience) = (nearest.triangle, patience(self.work, self.input));
            self.work += u64::from(tree.search(&level, p, hint, enough, patience, &mut nearest));
        }
        nearest
    }

    /// The squared distance within which nothing has to be looked for.
    pub(crate) fn enough(&self) -> f64 {
        (self.bound * self.near_enough * self.near_enough).max(FLOOR)
    }

    /// Notes the area and the mean squared distance of the faces of the step.
    pub(crate) fn settle(&mut self, face: u32, mean_square: f64, area: f32) {
        let f = &mut self.faces.all[face as usize];
        let (old, old_area) = (f64::from(f.mean_square), f64::from(f.area));
        (f.mean_square, f.area) = (mean_square as f32, area);
        self.back[0] += f64::from(f.mean_square) * f64::from(f.area) - old * old_area;
        self.back[1] += f64::from(f.area) - old_area;
    }

    /// Returns the root mean square distance, the larger of both ways, after steps that moved
    /// `gone` points.
    fn rms(&self, gone: u32) -> f64 {
        // Between a sample that is off and one that is not, the distance falls to 0: the integral
        // of a piecewise linear function is smaller than its lumped sum by (1 + share gone) / 2.
        let share = f64::from(gone) / self.input.places.len() as f64;
        let lumped = (0.5 + 0.5 * share).min(1.0);
        let mean = |sum: f64, weight: f64| if weight > 0.0 { (sum / weight).max(0.0) } else { 0.0 };
        let forward = mean(self.samples.sum, self.samples.weight);
        (lumped * forward.max(mean(self.back[0], self.back[1]))).sqrt()
    }
}

/// Returns how many boxes one search may open after some work.
pub(crate) fn patience(work: u64, input: &Input) -> u32 {
    let most = WORK_PER_TRIANGLE * input.triangles.len() as u64 + FREE_WORK;
    PATIENCE[usize::from(work > most / 2)]
}
