//! The forward pass: how far points of the input are from the level. Samples travel from face to
//! face; what they cannot tell is searched.

use crate::block::{Block, Entry, Step};
use crate::faces::{Changes, Faces};
use crate::floor::Floor;
use crate::gap::gap_of;
use crate::input::Input;
use crate::samples::{Sample, Samples};
use crate::thinning::Thinning;
use crate::thresholds::Thresholds;
use crate::work::{FLOOR, Work};
use glam::DVec3;
use lodc_mesh::{CollapseSequence, NONE};
use lodc_nearest::{Hit, Moving, Search, Seeker, centroid};
use std::ops::Range;

/// A sample takes the first changed face within this share of the bound. At a half errors are the
/// same, but the mean distance of the cow at 10 % is 1.68 times the measured one; with a quarter
/// 1.18 times, in the same time.
const NEAR: f64 = 0.25;

/// Distances within this share of the bound need no better face: only beyond the bound would they
/// count. The rest is for mean distances. Chosen by hand.
const NEAR_ENOUGH: f64 = 0.75;

/// A triangle is searched for points that nothing covers while the squared bound is this share of
/// its longest edge, squared: the edge is 20 times the bound, and samples alone would miss what
/// lies between them.
const UNCOVERED: f64 = 2.5e-3;
/// Most triangles of a mesh in which this is done: larger ones have enough points.
const COVERABLE: usize = 1 << 16;

/// A new sample is kept if its squared distance is beyond this share of the squared bound (0.3 of
/// the bound): nearer ones rarely come to decide it. Chosen by hand.
const KEPT_BEYOND: f64 = 0.09;

/// A sample that was searched around before is searched around again when its squared distance has
/// grown by this factor. Chosen by hand.
const GROWN: f64 = 1.1;

/// Changed faces that a sample is tried on before the tree is searched: twice a large star. Chosen
/// by hand.
const TRIED: usize = 48;

/// Records whose faces are read ahead at once, about as many misses as a core has under way at a
/// time.
const READ_AHEAD: u32 = 16;

/// The faces of the level, and the samples that travel over them.
pub(crate) struct Forward<'a> {
    input: &'a Input,
    floor: Floor<'a>,
    thresholds: Thresholds,
    faces: Faces,
    samples: Samples,
    thinning: Thinning,
    changes: Changes,
    /// Corners of the changed faces.
    corners: Vec<[DVec3; 3]>,
    /// The squared bound.
    bound: f64,
    seeker: Seeker,
    work: Work,
    /// Work of the backward pass, as far as it is known.
    other: Work,
    taken: Vec<(u32, u32)>,
    /// Samples that are far, with the face that each is nearest to.
    doubtful: Vec<(u32, u32)>,
    /// Triangles of the input that are looked at as a whole.
    large: Vec<u32>,
    /// The border of the fan that the step removes.
    link: Vec<DVec3>,
    /// The first record of the next step, and the first that was not read ahead.
    record: u32,
    ahead: u32,
}

impl<'a> Forward<'a> {
    /// Starts at LOD 0. `wedges` has the corners of its triangles as vertices of the mesh.
    pub(crate) fn new(
        input: &'a Input,
        wedges: Vec<[u32; 3]>,
        (floor, thresholds): (Floor<'a>, Thresholds),
    ) -> Self {
        let mut faces = Faces::new(input, &wedges);
        drop(wedges);
        let samples = Samples::new(input, &mut faces.all, thresholds.samples);
        Self {
            input,
            floor,
            thresholds,
            faces,
            samples,
            thinning: Thinning::new(thresholds.kept),
            changes: Changes::default(),
            corners: vec![],
            bound: 0.0,
            seeker: Seeker::new(Search::within(input.diagonal)),
            work: Work::default(),
            other: Work::default(),
            taken: vec![],
            doubtful: vec![],
            large: vec![],
            link: vec![],
            record: 0,
            ahead: 0,
        }
    }

    /// Returns the share of the area that belongs to samples at points.
    pub(crate) fn at_points(&self) -> f64 {
        self.samples.at_points
    }

    /// Takes over what the backward pass has found.
    pub(crate) fn learn(&mut self, bound: f64, work: Work) {
        self.bound = self.bound.max(bound);
        self.other = work;
    }

    /// Follows some steps, and notes what the backward pass needs of them in `block`.
    pub(crate) fn run(
        &mut self,
        sequence: &CollapseSequence,
        steps: Range<u32>,
        block: &mut Block,
    ) {
        let (targets, ends) = (sequence.targets(), &sequence.parts().step_ends);
        block.clear();
        for step in steps {
            if (self.work + self.other).is_too_much(self.input) {
                block.gave_up = true;
                break;
            }
            self.bound = self.bound.max(self.floor.squared(step as usize));
            let end = ends[step as usize];
            if end > self.ahead {
                let to = (end + READ_AHEAD).min(targets.len() as u32);
                self.faces.read_ahead(self.input, self.ahead..to, |s| self.samples.touch(s));
                self.ahead = to;
            }
            let moves = (self.record..end).map(|k| (k, targets[k as usize]));
            self.faces.apply(self.input, moves, &mut self.changes);
            self.record = end;
            self.work.done += 1 + self.changes.touched.len() as u64;
            if self.faces.live > 0 && !self.changes.touched.is_empty() {
                self.follow();
            }
            self.note(block);
        }
        block.work = self.work;
    }

    /// Notes a step.
    fn note(&self, block: &mut Block) {
        let Self { faces, changes, samples, .. } = self;
        for &t in &changes.touched {
            let face = &faces.all[t as usize];
            block.entries.push(if face.is_live() {
                samples.entry(self.input.at(face.points), t, face)
            } else {
                Entry::dead(t, face.points)
            });
        }
        block.targets.extend_from_slice(&changes.targets);
        block.steps.push(Step {
            entries_end: block.entries.len() as u32,
            targets_end: block.targets.len() as u32,
            source: if let [source] = changes.sources[..] { source } else { NONE },
            live: faces.live,
            bound: self.bound,
            mean_square: samples.mean_square(),
        });
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
        self.cover_taken();
        for i in 0..self.changes.changed.len() {
            let (face, live) = (self.changes.changed[i], self.faces.live);
            self.thinning.thin(&mut self.samples, &mut self.faces.all, face, live, self.bound);
        }
        if self.input.triangles.len() <= self.thresholds.exhaustive {
            self.cover_around();
        }
    }

    /// Looks for points beyond the bound in all triangles of the input that the step may have taken
    /// the nearest face from: the old faces were within the bound of them.
    fn cover_around(&mut self) {
        let (input, Self { faces, changes, .. }) = (self.input, &*self);
        let touched = changes.touched.iter().flat_map(|&t| faces.all[t as usize].points);
        let places = touched.chain(changes.sources.iter().copied()).map(|p| input.place(p));
        let (low, high) = extent(places);
        let reach = self.bound.max(FLOOR).sqrt();
        for (t, &points) in (0..).zip(&input.triangles) {
            let (own_low, own_high) = extent(input.at(points).into_iter());
            if (own_low - reach).cmple(high).all() && (own_high + reach).cmpge(low).all() {
                self.seek(t, t);
            }
        }
    }

    /// Looks for a point beyond the bound in a triangle of the input. `near` is a face near it.
    fn seek(&mut self, triangle: u32, near: u32) {
        let Self { input, faces, seeker, bound, work, .. } = self;
        let (level, tree) = faces.level(input);
        let least = bound.max(FLOOR).sqrt();
        let corners = input.at(input.triangles[triangle as usize]);
        let to = Moving { triangles: &level, tree };
        let found = seeker.seek(least, corners, near, &to, (*work + self.other).boxes(input));
        if found.least > least {
            *bound = found.least * found.least;
        }
        work.done += found.opened;
    }

    /// Decides how far those triangles of the input are whose samples the step has moved, where
    /// they are so large beside the bound that a part may be uncovered in which no sample is.
    fn cover_taken(&mut self) {
        if self.input.triangles.len() > COVERABLE {
            return;
        }
        let mut large = std::mem::take(&mut self.large);
        large.clear();
        for &(number, _) in &self.taken {
            let sources = self.samples.all[number as usize].sources(self.input);
            large.extend(sources.as_slice().iter().filter(|&&t| self.is_large(t)));
        }
        if large.is_empty() || self.unfolds() {
            self.large = large;
            return;
        }
        large.sort_unstable();
        large.dedup();
        for &t in &large {
            self.seek(t, t);
        }
        self.large = large;
    }

    /// Returns whether the step made a closed fan smaller and nothing folds, which leaves no hole.
    fn unfolds(&mut self) -> bool {
        let Self { input, faces, changes, link, .. } = self;
        let source = if let [source] = changes.sources[..] { source } else { NONE };
        let touched = changes.touched.iter().map(|&t| &faces.all[t as usize]);
        let touched = touched.map(|face| (face.is_live(), face.points));
        gap_of(input, (source, &changes.targets), touched, link).is_some()
    }

    fn is_large(&self, triangle: u32) -> bool {
        let [a, b, c] = self.input.at(self.input.triangles[triangle as usize]);
        let edges = [b - a, c - b, a - c].map(DVec3::length_squared);
        self.bound.max(FLOOR) < UNCOVERED * edges[0].max(edges[1]).max(edges[2])
    }

    /// Finds the nearest face for the samples of all faces that were touched.
    fn place_samples(&mut self) {
        let mut taken = std::mem::take(&mut self.taken);
        taken.clear();
        for &t in &self.changes.touched {
            self.samples.take(&mut self.faces.all, t, &mut taken);
        }
        self.work.done += taken.len() as u64;
        for &(number, own) in &taken {
            let p = self.samples.all[number as usize].place();
            let nearest = self.nearest_face(p, own, self.bound * (NEAR * NEAR));
            if nearest.squared > self.enough()
                && nearest.squared > GROWN * f64::from(self.samples.all[number as usize].refined)
            {
                self.doubtful.push((number, nearest.triangle));
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
            if !self.faces.all[t as usize].take_original() {
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
                    3 => centroid(corners),
                    k => (corners[k] + corners[(k + 1) % 3]) * 0.5,
                };
                let near = self.bound * KEPT_BEYOND;
                let nearest = self.nearest_face(p, t, near);
                if nearest.squared <= near.max(FLOOR) || nearest.triangle == NONE {
                    continue;
                }
                let sample = Sample::inside(p.to_array().map(|x| x as f32), t, 0.0);
                let number = self.samples.add(&mut self.faces.all, nearest.triangle, sample);
                self.samples.set(number, nearest.squared);
                if nearest.squared > self.enough() {
                    self.doubtful.push((number, nearest.triangle));
                }
                self.bound = self.bound.max(nearest.squared);
            }
        }
    }

    /// Looks more closely at the input around samples that are far.
    fn refine_doubtful(&mut self) {
        for i in 0..self.doubtful.len() {
            let (number, near) = self.doubtful[i];
            let enough = self.enough();
            let sample = &mut self.samples.all[number as usize];
            if f64::from(sample.squared) <= enough {
                continue;
            }
            sample.refined = sample.squared;
            for &t in sample.sources(self.input).as_slice() {
                self.seek(t, near);
            }
        }
    }

    /// Returns a live face near a point: its own, a changed one, or one found in the tree if these
    /// are too far. Stops within the squared distance `near`.
    fn nearest_face(&mut self, p: DVec3, own: u32, near: f64) -> Hit {
        let mut nearest = Hit::NOTHING;
        let near = near.max(FLOOR);
        if self.faces.all[own as usize].is_live() {
            let corners = self.input.at(self.faces.all[own as usize].points);
            nearest.look(p, corners, own);
        }
        for (&t, corners) in self.changes.changed.iter().zip(&self.corners).take(TRIED) {
            if nearest.squared <= near {
                break;
            }
            if t != own {
                self.work.done += 1;
                nearest.look(p, *corners, t);
            }
        }
        let enough = self.enough();
        if nearest.squared > enough {
            let (level, tree) = self.faces.level(self.input);
            let patience = (self.work + self.other).patience(self.input);
            let hint = nearest.triangle;
            self.work.done +=
                u64::from(tree.search(&level, p, hint, enough, patience, &mut nearest));
        }
        nearest
    }

    /// The squared distance within which nothing has to be looked for.
    fn enough(&self) -> f64 {
        (self.bound * (NEAR_ENOUGH * NEAR_ENOUGH)).max(FLOOR)
    }
}

/// Least and greatest coordinates.
fn extent(places: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    let bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    places.fold(bounds, |(low, high), p| (low.min(p), high.max(p)))
}
