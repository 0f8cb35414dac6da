//! The forward pass: how far points of the input are from the level. Samples travel from face to
//! face; where a point between them may be farther than all so far, triangles of the input are
//! searched by branch and bound. *E* is the largest distance so far.

use crate::block::{Block, Step, TouchedFace};
use crate::faces::{Changes, Faces};
use crate::floor::Floor;
use crate::gap::{Moved, fan_gap};
use crate::input::Input;
use crate::rough::RoughSquare;
use crate::samples::{Sample, SampleOnFace, Samples};
use crate::settings::Settings;
use crate::thinning::Thinning;
use crate::work::{ROUNDING_SQUARED, Work};
use glam::DVec3;
use lodc_mesh::{CollapseSequence, NONE};
use lodc_nearest::{
    FarthestSearch, Hit, MovingSurface, Query, TriangleSearcher, Triangles, area, centroid,
    longest_edge_squared,
};
use std::ops::Range;

/// A sample takes the first changed face within this share of E. At a half errors are the same, but
/// the mean distance of the cow at 10 % is 1.68 times the measured one; with a quarter 1.18 times,
/// in the same time.
const TAKEN_WITHIN: f64 = 0.25;

/// No tree is searched for a nearer face within this share of E: only distances beyond E raise
/// errors, so 1 would do for them; less is for mean distances. Chosen by hand.
const SEARCHED_BEYOND: f64 = 0.75;

/// A triangle is large while E² is below this share of its longest edge, squared: the edge is
/// longer than 20 E. Samples alone would miss holes between them. Chosen by hand.
const LARGE_TRIANGLE_SHARE: f64 = 2.5e-3;
/// Most triangles of a mesh in which large ones are searched: meshes of more have enough points.
/// Chosen by hand.
const MAX_TRIANGLES_WITH_LARGE: usize = 1 << 16;

/// Most samples for each triangle of a mesh of few: objects of a hundred triangles come by the
/// thousand. Chosen by hand.
const MAX_SAMPLES_PER_TRIANGLE: f64 = 32.0;

/// A triangle is a sliver if its longest edge, squared, is more than this many times its area; and
/// a long one while that is more than this many times E². In its middle it may be far where its
/// corners are near: it keeps the samples that it is tried at. Chosen by hand.
const SLIVER_RATIO_SQUARED: f64 = 16.0;
const LONG_RATIO_SQUARED: f64 = 4.0;
/// Most triangles of a mesh whose slivers keep more samples. Chosen by hand.
const MAX_TRIANGLES_WITH_SLIVERS: usize = 1 << 18;

/// A new sample is kept if its squared distance is beyond this share of E² (0.3 of E): nearer ones
/// rarely come to decide E. Chosen by hand.
const KEPT_BEYOND_SQUARED: f64 = 0.09;

/// The triangles of a sample's origin are searched again when its squared distance has grown by
/// this factor. Chosen by hand.
const SEARCHED_AGAIN_RATIO: f64 = 1.1;

/// Changed faces that a sample is tried on before the tree is searched: twice a large star. Chosen
/// by hand.
const MAX_FACES_TRIED: usize = 48;

/// Records whose faces are read ahead at once, about as many misses as a core has under way at a
/// time.
const RECORDS_READ_AHEAD: u32 = 16;

/// The faces of the level, the samples that travel over them, and the present step.
pub(crate) struct Forward<'a> {
    input: &'a Input,
    floor: Floor<'a>,
    settings: Settings,
    faces: Faces,
    samples: Samples,
    thinning: Thinning,
    changes: Changes,
    /// Corners of the surviving faces.
    corners: Vec<[DVec3; 3]>,
    /// E², the square of the largest distance so far, of either pass.
    max_squared: f64,
    searcher: TriangleSearcher,
    work: Work,
    /// Work of the backward pass, as far as it is known.
    backward_work: Work,
    /// Samples of the touched faces, with the face of each before the step.
    moved_samples: Vec<SampleOnFace>,
    /// Samples that are far from the level, with the face of each.
    far_samples: Vec<SampleOnFace>,
    /// Large triangles of the input, which are searched as a whole.
    large_triangles: Vec<u32>,
    /// The border of the fan that the step removes.
    link: Vec<DVec3>,
    next_record: u32,
    /// The first record that was not read ahead.
    first_unread_record: u32,
}

impl<'a> Forward<'a> {
    /// Starts at LOD 0. `corner_vertices` has the corners of its triangles as vertices of the mesh.
    pub(crate) fn new(
        input: &'a Input,
        corner_vertices: &[[u32; 3]],
        floor: Floor<'a>,
        settings: Settings,
    ) -> Self {
        let mut faces = Faces::new(input, corner_vertices);
        let most = MAX_SAMPLES_PER_TRIANGLE * input.triangles.len() as f64;
        let in_all = settings.few_triangles_samples.min(most);
        let samples = Samples::new(input, &mut faces.all, in_all);
        Self {
            input,
            floor,
            settings,
            faces,
            samples,
            thinning: Thinning::new(settings.few_faces_samples),
            changes: Changes::default(),
            corners: vec![],
            max_squared: 0.0,
            searcher: TriangleSearcher::new(FarthestSearch::for_size(input.diagonal)),
            work: Work::default(),
            backward_work: Work::default(),
            moved_samples: vec![],
            far_samples: vec![],
            large_triangles: vec![],
            link: vec![],
            next_record: 0,
            first_unread_record: 0,
        }
    }

    /// Returns about how far each triangle of the input is: the largest distance of its samples.
    pub(crate) fn triangle_distances(&self) -> Vec<RoughSquare> {
        let mut distances = vec![RoughSquare::ZERO; self.input.triangles.len()];
        for sample in &self.samples.all {
            let rough = RoughSquare::new(sample.squared_distance);
            if rough > RoughSquare::ZERO {
                for &t in sample.origin.triangles(self.input).as_slice() {
                    let distance = &mut distances[t as usize];
                    *distance = rough.max(*distance);
                }
            }
        }
        distances
    }

    /// Takes over what the backward pass has found: the largest squared distance, and its work.
    pub(crate) fn learn(&mut self, max_squared: f64, work: Work) {
        self.max_squared = self.max_squared.max(max_squared);
        self.backward_work = work;
    }

    /// Follows some steps, and fills `block` with what the backward pass needs of them; with fewer
    /// steps if the limit of work is reached.
    pub(crate) fn run(
        &mut self,
        sequence: &CollapseSequence,
        steps: Range<u32>,
        block: &mut Block,
    ) {
        let (targets, ends) = (sequence.targets(), &sequence.parts().step_ends);
        block.clear();
        let max_work = self.settings.limits.max_work(self.input.triangles.len());
        for step in steps {
            if (self.work + self.backward_work).0 > max_work {
                break;
            }
            self.max_squared = self.max_squared.max(self.floor.squared(step as usize));
            let end = ends[step as usize];
            if end > self.first_unread_record {
                let to = (end + RECORDS_READ_AHEAD).min(targets.len() as u32);
                let records = self.first_unread_record..to;
                self.faces.read_ahead(self.input, records, |s| self.samples.touch(s));
                self.first_unread_record = to;
            }
            let moves = (self.next_record..end).map(|k| (k, targets[k as usize]));
            self.faces.apply(self.input, moves, &mut self.changes);
            self.next_record = end;
            self.work.0 += 1 + self.changes.touched.len() as u64;
            if self.faces.live_count > 0 && !self.changes.touched.is_empty() {
                self.follow();
            }
            self.append_step(block);
        }
        block.work = self.work;
    }

    /// Appends the present step to a block.
    fn append_step(&self, block: &mut Block) {
        let Self { faces, changes, samples, .. } = self;
        for &t in &changes.touched {
            let face = &faces.all[t as usize];
            block.touched.push(if face.is_live() {
                samples.touched_face(self.input.corners_of(face.points), t, face)
            } else {
                TouchedFace::dead(t, face.points)
            });
        }
        block.targets.extend_from_slice(&changes.targets);
        block.steps.push(Step {
            touched_end: block.touched.len() as u32,
            targets_end: block.targets.len() as u32,
            source: self.source(),
            live_faces: faces.live_count,
            max_squared: self.max_squared,
            mean_square: samples.mean_square(),
        });
    }

    /// Returns the point that the step moved, if it was one; [`NONE`] otherwise.
    fn source(&self) -> u32 {
        if let [source] = self.changes.sources[..] { source } else { NONE }
    }

    /// Follows one step.
    fn follow(&mut self) {
        let Self { input, faces, changes, corners, .. } = self;
        corners.clear();
        let surviving = changes.surviving.iter();
        corners.extend(surviving.map(|&t| input.corners_of(faces.all[t as usize].points)));
        self.far_samples.clear();
        self.reassign_samples();
        self.add_new_samples();
        self.search_around_far_samples();
        self.search_large_triangles();
        for i in 0..self.changes.surviving.len() {
            let (face, live_faces) = (self.changes.surviving[i], self.faces.live_count);
            let (samples, faces) = (&mut self.samples, &mut self.faces.all);
            self.thinning.thin(samples, faces, face, live_faces, self.max_squared);
        }
    }

    /// Finds a face for each sample of the touched faces.
    fn reassign_samples(&mut self) {
        let mut moved = std::mem::take(&mut self.moved_samples);
        moved.clear();
        for &t in &self.changes.touched {
            self.samples.unlink_all(&mut self.faces.all, t, &mut moved);
        }
        self.work.0 += moved.len() as u64;
        for &moved in &moved {
            self.place(moved);
        }
        // A point that is no vertex any more may be far now. While it was one it was near, so that
        // its sample may have been dropped.
        for i in 0..self.changes.sources.len() {
            let point = self.changes.sources[i];
            if self.samples.is_dropped(point) {
                self.place(SampleOnFace { sample: point, face: self.changes.touched[0] });
            }
        }
        self.moved_samples = moved;
    }

    /// Puts a sample into the list of a face that is near; `face` is where it was, or may be.
    fn place(&mut self, SampleOnFace { sample, face }: SampleOnFace) {
        let p = self.samples.all[sample as usize].position();
        let taken_within = self.max_squared * (TAKEN_WITHIN * TAKEN_WITHIN);
        let (hit, is_finished) = self.find_face(p, face, taken_within);
        let searched_at = f64::from(self.samples.all[sample as usize].searched_at_squared);
        if hit.squared > self.searched_beyond_squared()
            && hit.squared > SEARCHED_AGAIN_RATIO * searched_at
        {
            self.far_samples.push(SampleOnFace { sample, face: hit.triangle });
        }
        if is_finished {
            self.max_squared = self.max_squared.max(hit.squared);
        }
        self.samples.set_squared_distance(sample, hit.squared);
        self.samples.link(&mut self.faces.all, hit.triangle, sample);
    }

    /// Tries the centroids and the edge midpoints of triangles that change for the first time, and
    /// keeps those that are far.
    fn add_new_samples(&mut self) {
        for i in 0..self.changes.touched.len() {
            let t = self.changes.touched[i];
            if !self.faces.all[t as usize].clear_original() {
                continue;
            }
            let points = self.input.triangles[t as usize];
            let corners = self.input.corners_of(points);
            let is_long_sliver = self.is_long_sliver(corners);
            for k in 0..4 {
                // Each inner edge is tried by the triangle that has it in rising order.
                if k < 3 && points[k] > points[(k + 1) % 3] {
                    continue;
                }
                let p = match k {
                    3 => centroid(corners),
                    k => (corners[k] + corners[(k + 1) % 3]) * 0.5,
                };
                let kept_beyond = self.max_squared * KEPT_BEYOND_SQUARED;
                let (hit, is_finished) = self.find_face(p, t, kept_beyond);
                let is_near = hit.squared <= kept_beyond.max(ROUNDING_SQUARED);
                if is_near && !is_long_sliver || hit.triangle == NONE {
                    continue;
                }
                let sample = Sample::without_area(p.to_array().map(|x| x as f32), t);
                let sample = self.samples.add(&mut self.faces.all, hit.triangle, sample);
                self.samples.set_squared_distance(sample, hit.squared);
                if hit.squared > self.searched_beyond_squared() {
                    self.far_samples.push(SampleOnFace { sample, face: hit.triangle });
                }
                if is_finished {
                    self.max_squared = self.max_squared.max(hit.squared);
                }
            }
        }
    }

    fn is_long_sliver(&self, corners: [DVec3; 3]) -> bool {
        let longest = longest_edge_squared(corners);
        self.input.triangles.len() <= MAX_TRIANGLES_WITH_SLIVERS
            && longest > LONG_RATIO_SQUARED * self.max_squared
            && longest > SLIVER_RATIO_SQUARED * area(corners)
    }

    /// Returns a live face near a point, one found in the tree if the others are too far: `face` if
    /// it is live, or the first surviving face within the squared distance `taken_within`. And
    /// whether the search for it was finished, so that no other is nearer as far as that matters.
    fn find_face(&mut self, p: DVec3, face: u32, taken_within: f64) -> (Hit, bool) {
        let mut hit = Hit::NONE;
        let taken_within = taken_within.max(ROUNDING_SQUARED);
        if self.faces.all[face as usize].is_live() {
            let corners = self.input.corners_of(self.faces.all[face as usize].points);
            hit.replace_if_nearer(p, corners, face);
        }
        let surviving = self.changes.surviving.iter().zip(&self.corners);
        for (&t, corners) in surviving.take(MAX_FACES_TRIED) {
            if hit.squared <= taken_within {
                break;
            }
            if t != face {
                self.work.0 += 1;
                hit.replace_if_nearer(p, *corners, t);
            }
        }
        let enough = self.searched_beyond_squared();
        if hit.squared > enough {
            let (level, tree) = self.faces.level_and_tree(self.input);
            let max_boxes = self.settings.limits.boxes_nearest;
            let query = Query { point: p, hint: hit.triangle, enough, max_boxes };
            let opened_boxes = tree.search(&level, query, &mut hit);
            self.work.0 += u64::from(opened_boxes);
            return (hit, opened_boxes < max_boxes);
        }
        (hit, true)
    }

    /// The squared distance within which nothing is searched; see [`SEARCHED_BEYOND`].
    fn searched_beyond_squared(&self) -> f64 {
        (self.max_squared * (SEARCHED_BEYOND * SEARCHED_BEYOND)).max(ROUNDING_SQUARED)
    }

    /// Searches the triangles of the input around samples that are far.
    fn search_around_far_samples(&mut self) {
        for i in 0..self.far_samples.len() {
            let SampleOnFace { sample, face } = self.far_samples[i];
            let searched_beyond = self.searched_beyond_squared();
            let sample = &mut self.samples.all[sample as usize];
            // E may have grown since.
            if f64::from(sample.squared_distance) <= searched_beyond {
                continue;
            }
            sample.searched_at_squared = sample.squared_distance;
            for &t in sample.origin.triangles(self.input).as_slice() {
                self.search_triangle(t, face);
            }
        }
    }

    /// Searches those triangles of the input whose samples the step has moved and which are large:
    /// the step may leave a hole in which no sample is.
    fn search_large_triangles(&mut self) {
        if self.input.triangles.len() > MAX_TRIANGLES_WITH_LARGE {
            return;
        }
        let mut large = std::mem::take(&mut self.large_triangles);
        large.clear();
        for moved in &self.moved_samples {
            let triangles = self.samples.all[moved.sample as usize].origin.triangles(self.input);
            large.extend(triangles.as_slice().iter().filter(|&&t| self.is_large(t)));
        }
        if !large.is_empty() && !self.is_unfolded_fan() {
            large.sort_unstable();
            large.dedup();
            for &t in &large {
                self.search_triangle(t, t);
            }
        }
        self.large_triangles = large;
    }

    fn is_large(&self, triangle: u32) -> bool {
        let longest = longest_edge_squared(self.input.corners(triangle));
        self.max_squared.max(ROUNDING_SQUARED) < LARGE_TRIANGLE_SHARE * longest
    }

    /// Returns whether the step made a closed fan smaller and nothing folds, which leaves no hole.
    fn is_unfolded_fan(&mut self) -> bool {
        let source = self.source();
        let Self { input, faces, changes, link, .. } = self;
        let touched = changes.touched.iter().map(|&t| &faces.all[t as usize]);
        let touched = touched.map(|face| (face.is_live(), face.points));
        fan_gap(input, Moved { source, targets: &changes.targets }, touched, link).is_some()
    }

    /// Looks for a point of a triangle of the input that is beyond E, and raises E to its distance.
    /// `hint` is a face that is probably near.
    fn search_triangle(&mut self, triangle: u32, hint: u32) {
        let Self { input, faces, searcher, max_squared, work, .. } = self;
        let (level, tree) = faces.level_and_tree(input);
        let level = MovingSurface { triangles: &level, tree };
        let distance = max_squared.max(ROUNDING_SQUARED).sqrt();
        let max_boxes = self.settings.limits.boxes_farthest;
        let found = searcher.search(distance, input.corners(triangle), hint, &level, max_boxes);
        if found.lower > distance {
            *max_squared = found.lower * found.lower;
        }
        work.0 += found.opened_boxes;
    }
}
