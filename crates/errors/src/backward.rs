//! The backward pass: how far new faces are from the input.

use crate::block::{Block, Entry, Step};
use crate::gap::gap_of;
use crate::input::Input;
use crate::samples::sources;
use crate::thresholds::Thresholds;
use crate::work::{FLOOR, Work};
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{Moving, Search, Seeker, Surface, area, centroid, point_at};

/// A point is near enough within this share of the bound, so that its search may stop there; a face
/// with a point beyond the second share is searched as a whole. Without these points errors of up
/// to 1.9 times the bound went unseen; the shares are chosen by hand.
const ENOUGH: f64 = 0.39;
const DOUBTFUL: f64 = 0.5;

/// Where no more faces than this are left every one is searched as a whole: faces are large there,
/// and four points tell little of them. Doing so always takes twice the time on the bunny.
const FEW: u32 = 600;

/// Barycentric coordinates of the middle of a face, and of the middles of nine equal parts.
const MIDDLE: [f64; 3] = [1.0 / 3.0; 3];
const SPREAD: [[f64; 3]; 9] = [
    [7.0 / 9.0, 1.0 / 9.0, 1.0 / 9.0],
    [1.0 / 9.0, 7.0 / 9.0, 1.0 / 9.0],
    [1.0 / 9.0, 1.0 / 9.0, 7.0 / 9.0],
    [4.0 / 9.0, 4.0 / 9.0, 1.0 / 9.0],
    [4.0 / 9.0, 1.0 / 9.0, 4.0 / 9.0],
    [1.0 / 9.0, 4.0 / 9.0, 4.0 / 9.0],
    [5.0 / 9.0, 2.0 / 9.0, 2.0 / 9.0],
    [2.0 / 9.0, 5.0 / 9.0, 2.0 / 9.0],
    [2.0 / 9.0, 2.0 / 9.0, 5.0 / 9.0],
];

/// State of a face, as far as this way needs it.
#[derive(Clone, Copy, Debug)]
struct Face {
    /// A triangle of the input near its middle.
    near: u32,
    /// Its area, and the mean squared distance over it.
    area: f32,
    mean_square: f32,
    /// The distance within which all its points are from the input, as far as is known.
    reach: f32,
}

/// Distances after a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// The squared bound of both ways.
    pub(crate) bound: f64,
    /// The mean squared distance over the faces.
    pub(crate) mean_square: f64,
}

/// A block that was followed.
pub(crate) struct Followed {
    pub(crate) block: Block,
    /// Distances after each of its steps, or the first of them.
    pub(crate) found: Vec<Found>,
    /// The squared bound and the work done at its end.
    pub(crate) bound: f64,
    pub(crate) work: Work,
}

/// The faces of the level as seen from the input.
pub(crate) struct Backward<'a> {
    input: &'a Input,
    thresholds: Thresholds,
    faces: Vec<Face>,
    seeker: Seeker,
    /// The squared bound.
    bound: f64,
    /// Sum of area times mean squared distance over live faces, and of areas.
    sums: [f64; 2],
    work: Work,
    /// Work of the forward pass at the end of the block.
    other: Work,
    /// The border of the fan that a step removes.
    link: Vec<DVec3>,
}

/// A step while it is followed.
#[derive(Clone, Copy)]
struct CurrentStep<'b> {
    step: Step,
    entries: &'b [Entry],
    targets: &'b [u32],
}

impl<'a> Backward<'a> {
    /// Starts at LOD 0.
    pub(crate) fn new(input: &'a Input, thresholds: Thresholds) -> Self {
        let face = |(near, &points)| {
            let area = area(input.at(points)) as f32;
            Face { near, area, mean_square: 0.0, reach: 0.0 }
        };
        let faces: Vec<Face> = (0..).zip(&input.triangles).map(face).collect();
        let weight = faces.iter().map(|f| f64::from(f.area)).sum();
        Self {
            input,
            thresholds,
            faces,
            seeker: Seeker::new(Search::within(input.diagonal)),
            bound: 0.0,
            sums: [0.0, weight],
            work: Work::default(),
            other: Work::default(),
            link: vec![],
        }
    }

    /// Follows the steps of a block, or the first of them if they are too much work.
    pub(crate) fn run(&mut self, block: Block) -> Followed {
        let mut found = Vec::with_capacity(block.steps.len());
        self.other = block.work;
        for (step, entries, targets) in block.each() {
            if (self.work + self.other).is_too_much(self.input) {
                break;
            }
            self.bound = self.bound.max(step.bound);
            self.work.done += entries.len() as u64;
            if !entries.is_empty() {
                self.follow(CurrentStep { step, entries, targets });
            }
            let [sum, weight] = self.sums;
            let mean_square = if weight > 0.0 { (sum / weight).max(0.0) } else { 0.0 };
            found.push(Found { bound: self.bound, mean_square });
        }
        Followed { block, found, bound: self.bound, work: self.work }
    }

    /// Decides how far every changed face is from the input, and notes the faces' mean distances.
    fn follow(&mut self, now: CurrentStep) {
        let reach = self.reach(now);
        let near = self.bound.max(FLOOR).sqrt();
        for &entry in now.entries {
            if !entry.is_live {
                self.settle(entry.face, 0.0, 0.0);
                continue;
            }
            let corners = self.input.at(entry.points);
            match reach {
                Some(reach) if reach <= near => {
                    self.faces[entry.face as usize].reach = reach as f32;
                }
                Some(_) if now.step.live > FEW && !self.is_doubtful(entry, corners) => {}
                _ => self.seek(entry, corners),
            }
            let is_small = self.input.triangles.len() <= self.thresholds.exhaustive;
            let mean_square = match f64::from(entry.mean_square) {
                _ if is_small => Some(self.mean_square(entry.face, corners, &SPREAD)),
                mean if !mean.is_nan() => Some(mean),
                _ if self.thresholds.means => {
                    Some(self.mean_square(entry.face, corners, &[MIDDLE]))
                }
                _ => None,
            };
            match mean_square {
                Some(mean) => self.settle(entry.face, mean, area(corners) as f32),
                None => self.settle(entry.face, 0.0, 0.0),
            }
        }
    }

    /// Asks the middle of a face and of its edges. Returns whether one is so far that another point
    /// may be beyond the bound: where a fan became a smaller one, no hole hides between them.
    fn is_doubtful(&mut self, Entry { face, hint, .. }: Entry, corners: [DVec3; 3]) -> bool {
        let Self { input, work, other, bound, .. } = self;
        let face = &mut self.faces[face as usize];
        if hint != NONE {
            face.near = sources(input, hint).as_slice()[0];
        }
        let to = Moving { triangles: *input, tree: &input.tree };
        let patience = (*work + *other).patience(input);
        let mut far = 0.0f64;
        let [a, b, c] = corners;
        for p in [centroid(corners), (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5] {
            let enough = (*bound * (ENOUGH * ENOUGH)).max(FLOOR).max(far);
            let (hit, opened) = to.near(p, face.near, enough, patience);
            face.near = hit.triangle;
            far = far.max(hit.squared);
            work.done += u64::from(opened) + 1;
        }
        face.reach = far.sqrt() as f32;
        far > (*bound * (DOUBTFUL * DOUBTFUL)).max(FLOOR)
    }

    /// Looks for a point of a face that is beyond the bound.
    fn seek(&mut self, Entry { face, hint, .. }: Entry, corners: [DVec3; 3]) {
        let Self { input, work, other, seeker, bound, .. } = self;
        let face = &mut self.faces[face as usize];
        if hint != NONE {
            face.near = sources(input, hint).as_slice()[0];
        }
        let least = bound.max(FLOOR).sqrt();
        let to = Moving { triangles: *input, tree: &input.tree };
        let found = seeker.seek(least, corners, face.near, &to, (*work + *other).boxes(input));
        face.reach = (found.most * (1.0 + 1e-6)) as f32;
        if found.least > least {
            *bound = found.least * found.least;
        }
        work.done += found.opened;
    }

    /// Returns the mean squared distance of some points of a face.
    fn mean_square(&mut self, face: u32, corners: [DVec3; 3], points: &[[f64; 3]]) -> f64 {
        let Self { input, work, other, .. } = self;
        let near = &mut self.faces[face as usize].near;
        let to = Moving { triangles: *input, tree: &input.tree };
        let patience = (*work + *other).patience(input);
        let mut sum = 0.0;
        for &at in points {
            let (hit, opened) = to.near(point_at(corners, at), *near, 0.0, patience);
            *near = hit.triangle;
            work.done += u64::from(opened) + 1;
            sum += hit.squared;
        }
        sum / points.len() as f64
    }

    /// Notes the area and the mean squared distance of a face of the step.
    fn settle(&mut self, face: u32, mean_square: f64, area: f32) {
        let f = &mut self.faces[face as usize];
        let (old, old_area) = (f64::from(f.mean_square), f64::from(f.area));
        (f.mean_square, f.area) = (mean_square as f32, area);
        self.sums[0] += f64::from(f.mean_square) * f64::from(f.area) - old * old_area;
        self.sums[1] += f64::from(f.area) - old_area;
    }

    /// Returns how far the changed faces are from the input at most, where a closed fan became a
    /// smaller one: they are as near to its faces as those to them.
    fn reach(&mut self, now: CurrentStep) -> Option<f64> {
        let CurrentStep { step, entries, targets } = now;
        let faces = entries.iter().map(|entry| (entry.is_live, entry.points));
        let gap = gap_of(self.input, (step.source, targets), faces, &mut self.link)?;
        let reach = |entry: &Entry| f64::from(self.faces[entry.face as usize].reach);
        // Rounded up for good, whatever a face keeps of it.
        Some((gap + now.entries.iter().map(reach).fold(0.0, f64::max)) * (1.0 + 1e-6))
    }
}
