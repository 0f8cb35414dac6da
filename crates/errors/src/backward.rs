//! The other way: how far new faces are from the input.

use crate::ask::Ask;
use crate::block::{Block, Entry, Hint, Step};
use crate::care::Care;
use crate::forward::EXHAUSTIVE_QUERIES;
use crate::gap::{self, gap};
use crate::input::Input;
use crate::refine::{FLOOR, Refine};
use crate::work::Work;
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{Search, TriangleTree, area, centroid};

/// Barycentric coordinates asked besides on large faces and where few are left, and very few.
const FEW: [[f64; 3]; 3] = [[0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6]];
const VERY_FEW: [[f64; 3]; 12] = [
    [0.8, 0.1, 0.1],
    [0.1, 0.8, 0.1],
    [0.1, 0.1, 0.8],
    [0.45, 0.45, 0.1],
    [0.1, 0.45, 0.45],
    [0.45, 0.1, 0.45],
    [0.7, 0.3, 0.0],
    [0.3, 0.7, 0.0],
    [0.0, 0.7, 0.3],
    [0.0, 0.3, 0.7],
    [0.7, 0.0, 0.3],
    [0.3, 0.0, 0.7],
];

/// A face with a point beyond this share of the bound is searched.
const HOT: f64 = 0.75;

/// A face is looked at for holes below it while the squared bound is this share of its longest
/// edge, squared; boxes that may be opened for one.
const UNCOVERED: f64 = 2.5e-3;
const COVERED: [u32; 2] = [2_000, 0];

/// Meshes of up to so many triangles have a tree for that: larger ones save its memory.
const COVERABLE: usize = 1 << 16;

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
    care: Care,
    faces: Vec<Face>,
    /// One over the input for [`Search`], of a mesh that is not too large.
    tree: Option<TriangleTree>,
    /// The squared bound.
    bound: f64,
    /// Sum of area times mean squared distance over live faces, and of areas.
    sums: [f64; 2],
    work: Work,
    /// Work of the first way at the end of the block.
    other: Work,
    /// The step that is followed, counted from 1, and for each point the last step that asked an
    /// edge to it.
    step: u32,
    asked: Vec<u32>,
    /// The border of the fan that a step removes.
    link: Vec<DVec3>,
    /// Live faces of the step.
    changed: Vec<Entry>,
    /// A triangle of the input near each of them.
    near: Vec<u32>,
}

/// A step while it is followed.
#[derive(Clone, Copy)]
struct Now<'b> {
    step: Step,
    entries: &'b [Entry],
    targets: &'b [u32],
    /// Those of the block.
    hints: &'b [Hint],
}

impl<'a> Backward<'a> {
    /// Starts at LOD 0.
    pub(crate) fn new(input: &'a Input, care: Care) -> Self {
        let face = |(near, &points)| {
            let area = area(input.at(points)) as f32;
            Face { near, area, mean_square: 0.0, reach: 0.0 }
        };
        let faces: Vec<Face> = (0..).zip(&input.triangles).map(face).collect();
        let weight = faces.iter().map(|f| f64::from(f.area)).sum();
        Self {
            input,
            care,
            faces,
            tree: (input.triangles.len() <= COVERABLE).then(|| {
                let corners: Vec<_> = input.triangles.iter().map(|&t| input.at(t)).collect();
                TriangleTree::new(&corners)
            }),
            bound: 0.0,
            sums: [0.0, weight],
            work: Work::default(),
            other: Work::default(),
            step: 0,
            asked: vec![0; input.places.len()],
            link: vec![],
            changed: vec![],
            near: vec![],
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
            self.step += 1;
            self.bound = self.bound.max(step.bound);
            self.work.done += entries.len() as u64;
            if !entries.is_empty() {
                self.follow(Now { step, entries, targets, hints: &block.hints });
            }
            let [sum, weight] = self.sums;
            let mean_square = if weight > 0.0 { (sum / weight).max(0.0) } else { 0.0 };
            found.push(Found { bound: self.bound, mean_square });
        }
        Followed { block, found, bound: self.bound, work: self.work }
    }

    /// Asks points of every changed face for their distance to the input, and notes the faces'
    /// mean distances.
    fn follow(&mut self, now: Now) {
        let reach = self.reach(now);
        self.changed.clear();
        self.near.clear();
        for entry in now.entries {
            if entry.is_live {
                self.changed.push(*entry);
                self.near.push(self.faces[entry.face as usize].near);
            } else {
                self.settle(entry.face, 0.0, 0.0);
            }
        }
        let near = self.bound.max(FLOOR).sqrt();
        for i in 0..self.changed.len() {
            let Entry { face, points, mean_square, .. } = self.changed[i];
            let corners = self.input.at(points);
            let mut asked = 0.0;
            if reach.is_none_or(|reach| reach > near) {
                asked = self.ask_face(now, i, corners, reach.is_some());
            } else if let Some(reach) = reach {
                self.faces[face as usize].reach = reach as f32;
            }
            match f64::from(mean_square) {
                mean if !mean.is_nan() => self.settle(face, mean, area(corners) as f32),
                _ if self.care.means => self.settle(face, asked, area(corners) as f32),
                _ => self.settle(face, 0.0, 0.0),
            }
        }
        if self.input.triangles.len() <= self.care.exhaustive {
            self.refine_all();
        }
    }

    /// Searches all changed faces by branch and bound.
    fn refine_all(&mut self) {
        let input = self.input;
        let mut refine = Refine::new(input, &input.tree, self.bound, EXHAUSTIVE_QUERIES);
        for entry in &self.changed {
            refine.triangle(input.at(entry.points), NONE);
        }
        self.bound = refine.bound;
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
    fn reach(&mut self, now: Now) -> Option<f64> {
        let gap = self.fan(now).and_then(|middle| gap(middle, &self.link))?;
        let reach = |entry: &Entry| f64::from(self.faces[entry.face as usize].reach);
        // Rounded up for good, whatever a face keeps of it.
        Some((gap + now.entries.iter().map(reach).fold(0.0, f64::max)) * (1.0 + 1e-6))
    }

    /// Returns the middle of the fan that a step removed, and notes the border in order, from the
    /// point that the middle became; nothing if the faces were no closed fan.
    fn fan(&mut self, Now { step, entries, targets, .. }: Now) -> Option<DVec3> {
        let &[target] = targets else { return None };
        if step.source == NONE || !(3..=gap::MOST).contains(&entries.len()) {
            return None;
        }
        let mut ends = [NONE; 2];
        let mut dead = 0;
        let mut edges = [[NONE; 2]; gap::MOST];
        let mut live = 0;
        for entry in entries {
            let [a, b, c] = entry.points;
            // The border of the face: from one point to the next.
            let edge = match target {
                p if p == a => [b, c],
                p if p == b => [c, a],
                _ => [a, b],
            };
            if entry.is_live {
                edges[live] = edge;
                live += 1;
                continue;
            }
            // One of its other points is the target, too.
            let mut others = entry.points.into_iter().filter(|&p| p != target);
            let (end, None) = (others.next()?, others.next()) else { return None };
            *ends.get_mut(dead)? = end;
            dead += 1;
        }
        if dead != 2 {
            return None;
        }
        let edges = &mut edges[..live];
        let first = usize::from(!edges.iter().any(|e| e[0] == ends[0]));
        let mut at = ends[first];
        self.link.clear();
        self.link.extend([self.input.place(target), self.input.place(at)]);
        for done in 0..edges.len() {
            let next = (done..edges.len()).find(|&i| edges[i][0] == at)?;
            edges.swap(done, next);
            at = edges[done][1];
            self.link.push(self.input.place(at));
        }
        (at == ends[1 - first]).then(|| self.input.place(step.source))
    }

    /// Asks points of a changed face. Returns the squared distance of its centroid, or an upper
    /// bound of it if the face has samples.
    fn ask_face(&mut self, now: Now, i: usize, corners: [DVec3; 3], disc: bool) -> f64 {
        let Entry { face, points, mean_square, hints: [from, to], .. } = self.changed[i];
        let care = if now.step.is_coarse(self.input, 32) { Care::AT_REST } else { self.care };
        let edges = [0, 1, 2].map(|k| self.is_new_edge(now, [points[k], points[(k + 1) % 3]]));
        let mut ask = Ask {
            input: self.input,
            share: care.asked,
            corners,
            near: self.near[i],
            hints: &now.hints[from as usize..to as usize],
            others: &self.near,
            patience: (self.work + self.other).patience(self.input),
            opened: 0,
            bound: self.bound,
            far: 0.0,
        };
        let middle = ask.point(centroid(corners), care.means && mean_square.is_nan());
        for k in (0..3).filter(|&k| edges[k]) {
            ask.point((corners[k] + corners[(k + 1) % 3]) * 0.5, false);
        }
        let is_coarse = |share| now.step.is_coarse(self.input, share);
        if !disc || ask.is_beyond(care.warm) || is_coarse(8) {
            ask.points(&FEW);
        }
        if ask.is_beyond(care.warm) || is_coarse(32) && ask.is_beyond(care.tepid) {
            ask.points(&VERY_FEW);
        }
        let Ask { near, far, bound, opened, .. } = ask;
        let is_hot = ask.is_beyond(HOT);
        (self.near[i], self.faces[face as usize].near, self.bound) = (near, near, bound);
        self.work.done += opened;
        if is_hot {
            self.refine_face(now, corners);
        } else if !disc && self.may_uncover(corners) {
            self.cover_face(corners);
        }
        let reach = if is_hot { self.bound.max(far) } else { far };
        self.faces[face as usize].reach = reach.sqrt() as f32;
        middle
    }

    /// Returns whether a face is so large beside the bound that a point of it may be beyond where
    /// none was asked: over a hole that other faces in its plane surround.
    fn may_uncover(&self, [a, b, c]: [DVec3; 3]) -> bool {
        let edges = [b - a, c - b, a - c].map(DVec3::length_squared);
        self.bound.max(FLOOR) < UNCOVERED * edges[0].max(edges[1]).max(edges[2])
    }

    /// Decides how far a face is by clipping it with the prisms of the input's triangles: flat
    /// places end exactly.
    fn cover_face(&mut self, corners: [DVec3; 3]) {
        let Some(tree) = &self.tree else { return };
        let floor = self.bound.max(FLOOR).sqrt();
        // A pool's threads may all be waiting for this way.
        let within = Search::within(self.input.diagonal);
        let search = Search { floor, boxes: COVERED, ..within };
        let found = search.farthest(&[corners], tree);
        if found.least > floor {
            self.bound = self.bound.max(found.least * found.least);
        }
        self.work.done += found.opened;
    }

    /// Returns whether a step made an edge and no face has asked it yet: each is asked once.
    fn is_new_edge(&mut self, now: Now, ends: [u32; 2]) -> bool {
        let [from, to] = ends.map(|p| now.targets.contains(&p));
        let link = ends[usize::from(from)] as usize;
        if from && to {
            return true;
        }
        let is_new = (from || to) && self.asked[link] != self.step;
        if is_new {
            self.asked[link] = self.step;
        }
        is_new
    }

    fn refine_face(&mut self, now: Now, corners: [DVec3; 3]) {
        let many = if now.step.is_coarse(self.input, 32) { 600 } else { 150 };
        let mut refine = Refine::new(self.input, &self.input.tree, self.bound, many);
        refine.patience = (self.work + self.other).patience(self.input);
        refine.triangle(corners, NONE);
        self.bound = refine.bound;
        self.work.queries += u64::from(many - refine.left);
        self.work.done += refine.opened;
    }
}
