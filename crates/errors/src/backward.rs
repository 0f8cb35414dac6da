//! The other way: how far new faces are from the input.

use crate::pass::{DEPTH, Pass, patience};
use crate::refine::Refine;
use crate::samples::area;
use crate::tree::{Nearest, Triangles};
use crate::triangle::{centroid, distance_squared};
use glam::DVec3;
use lodc_mesh::NONE;

/// Samples of a face that are looked at for a way to the input.
const SAMPLES: usize = 24;

/// Neighbours whose triangle of the input is tried.
const NEIGHBOURS: usize = 8;

/// Area of a large face, and of a very large one, in mean areas of the input.
const LARGE: f64 = 8.0;
const VERY_LARGE: f64 = 32.0;

/// Samples that say enough of a large face.
const ENOUGH_SAMPLES: u32 = 4;

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

impl Pass<'_> {
    /// Asks points of every changed face for their distance to the input, and notes the faces'
    /// mean distances.
    pub(crate) fn measure_back(&mut self) {
        for i in 0..self.changes.touched.len() {
            let t = self.changes.touched[i];
            if !self.faces.all[t as usize].live {
                self.settle(t, 0.0, 0.0);
            }
        }
        let skip = self.is_covered_disc();
        for i in 0..self.changes.changed.len() {
            let (t, corners) = (self.changes.changed[i], self.corners[i]);
            let mean = self.samples.mean_square(&self.faces.all[t as usize]);
            let asked = if skip { 0.0 } else { self.ask_face(i, t, corners, mean.is_none()) };
            self.settle(t, mean.unwrap_or(asked), area(corners));
        }
    }

    /// Returns whether a single fan of faces became a smaller one with the same link, and all its
    /// samples are well within the bound: then its faces are as near to the input as these are to
    /// them. Large faces need some samples for that.
    fn is_covered_disc(&self) -> bool {
        let changes = &self.changes;
        let (touched, changed) = (&changes.touched, &changes.changed);
        let [target] = changes.targets[..] else { return false };
        if touched.len() != changed.len() + 2 || touched.len() > 64 || self.is_coarse(32) {
            return false;
        }
        // Each vertex of the link is met twice, in live faces or in those that died.
        let mut link = [NONE; 128];
        let mut met = 0;
        for &t in touched {
            for point in self.faces.all[t as usize].points.into_iter().filter(|&p| p != target) {
                let Some(slot) = link.get_mut(met) else { return false };
                *slot = point;
                met += 1;
            }
        }
        let link = &mut link[..met];
        link.sort_unstable();
        let paired = link.len().is_multiple_of(2)
            && link.chunks_exact(2).all(|pair| pair[0] == pair[1])
            && link.windows(3).all(|three| three[0] != three[2]);
        let near = (self.bound * 0.25) as f32;
        let is_covered = |(&t, &corners): (&u32, &[DVec3; 3])| {
            let face = &self.faces.all[t as usize];
            (face.samples >= ENOUGH_SAMPLES || f64::from(area(corners)) <= LARGE * self.mean_area)
                && self.samples.of(face).all(|s| self.samples.all[s as usize].squared <= near)
        };
        paired && changed.iter().zip(&self.corners).all(is_covered)
    }

    /// Returns whether no more than one in `share` faces is left, or so few that it does not
    /// matter.
    fn is_coarse(&self, share: u32) -> bool {
        self.faces.live <= (self.input.triangles.len() as u32 / share).max(64)
    }

    /// Asks points of a changed face. Returns the squared distance of its centroid, or an upper
    /// bound of it unless `exact`.
    fn ask_face(&mut self, i: usize, t: u32, corners: [DVec3; 3], exact: bool) -> f64 {
        let mut ask = Ask { pass: self, i, t, corners, is_hot: false };
        let middle = ask.point(centroid(corners), exact);
        let points = ask.pass.faces.all[t as usize].points;
        for k in 0..3 {
            let ends = [points[k], points[(k + 1) % 3]];
            if ask.pass.is_new_edge(ends) {
                ask.point((corners[k] + corners[(k + 1) % 3]) * 0.5, false);
            }
        }
        let large = f64::from(area(corners)) / ask.pass.mean_area;
        let more: &[&[[f64; 3]]] = if large > VERY_LARGE || ask.pass.is_coarse(32) {
            &[&FEW, &VERY_FEW]
        } else if large > LARGE || ask.pass.is_coarse(8) {
            &[&FEW]
        } else {
            &[]
        };
        for w in more.iter().copied().flatten() {
            ask.point(corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2], false);
        }
        if ask.is_hot {
            self.refine_face(corners);
        }
        middle
    }

    /// Returns whether a step made an edge and no face has asked it yet: each is asked once.
    fn is_new_edge(&mut self, ends: [u32; 2]) -> bool {
        let [from, to] = ends.map(|p| self.changes.targets.contains(&p));
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

    fn refine_face(&mut self, corners: [DVec3; 3]) {
        let many = if self.is_coarse(32) { 600 } else { 150 };
        let mut refine = Refine {
            triangles: self.input,
            tree: &self.input.tree,
            bound: self.bound,
            depth: DEPTH,
            left: many,
            patience: patience(self.work, self.input),
            opened: 0,
        };
        refine.triangle(corners, NONE);
        self.bound = refine.bound;
        self.queries += u64::from(many - refine.left);
        self.work += refine.opened;
    }
}

/// Questions of one face.
struct Ask<'p, 'a> {
    pass: &'p mut Pass<'a>,
    /// The face's number among the changed ones.
    i: usize,
    t: u32,
    corners: [DVec3; 3],
    /// True if a point was not near enough.
    is_hot: bool,
}

impl Ask<'_, '_> {
    /// Returns the squared distance of a point to the input, or an upper bound of it that is near
    /// enough unless `exact`.
    fn point(&mut self, p: DVec3, exact: bool) -> f64 {
        let enough = self.pass.enough();
        let hint = match self.guess(p, enough) {
            Ok(squared) if !exact => return squared,
            Ok(_) => self.pass.faces.all[self.t as usize].near,
            Err(hint) => hint,
        };
        let pass = &mut *self.pass;
        let mut nearest = Nearest::NOTHING;
        let stop = if exact { 0.0 } else { enough };
        let patience = patience(pass.work, pass.input);
        let opened = pass.input.tree.search(pass.input, p, hint, stop, patience, &mut nearest);
        pass.work += u64::from(opened) + 1;
        pass.faces.all[self.t as usize].near = nearest.triangle;
        self.is_hot |= nearest.squared > enough;
        pass.bound = pass.bound.max(nearest.squared);
        nearest.squared
    }

    /// Tries what is at hand: corners, the triangle found last, samples, neighbours. Returns a
    /// distance that is near enough, or else a triangle to start from.
    fn guess(&mut self, p: DVec3, enough: f64) -> Result<f64, u32> {
        let pass = &mut *self.pass;
        let input = pass.input;
        for corner in self.corners {
            let squared = (p - corner).length_squared();
            if squared <= enough {
                return Ok(squared);
            }
        }
        let near = pass.faces.all[self.t as usize].near;
        let squared = distance_squared(p, input.corners(near));
        if squared <= enough {
            return Ok(squared);
        }
        let mut nearest = Nearest::NOTHING;
        for s in pass.samples.of(&pass.faces.all[self.t as usize]).take(SAMPLES) {
            let sample = &pass.samples.all[s as usize];
            nearest.offer((p - sample.place()).length_squared(), s);
            if nearest.squared <= enough {
                return Ok(nearest.squared);
            }
        }
        if nearest.triangle != NONE {
            let sample = &pass.samples.all[nearest.triangle as usize];
            nearest.triangle = sample.sources(input).as_slice()[0];
            let squared = distance_squared(p, input.corners(nearest.triangle));
            if squared <= enough {
                pass.faces.all[self.t as usize].near = nearest.triangle;
                return Ok(squared);
            }
        }
        for j in 0..pass.changes.changed.len().min(NEIGHBOURS) {
            let other = pass.faces.all[pass.changes.changed[j] as usize].near;
            if j != self.i && other != near {
                let squared = distance_squared(p, input.corners(other));
                if squared <= enough {
                    pass.faces.all[self.t as usize].near = other;
                    return Ok(squared);
                }
            }
        }
        Err(if nearest.triangle == NONE { near } else { nearest.triangle })
    }
}
