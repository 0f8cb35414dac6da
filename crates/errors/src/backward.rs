//! The other way: how far new faces are from the input.

use crate::faces::Changes;
use crate::gap::{self, gap};
use crate::pass::{Pass, patience};
use crate::refine::FLOOR;
use crate::refine::Refine;
use crate::samples::area;
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{Hit, Triangles};
use lodc_nearest::{centroid, distance_squared};

/// Samples of a face that are looked at for a way to the input.
const SAMPLES: usize = 24;

/// Neighbours whose triangle of the input is tried.
const NEIGHBOURS: usize = 8;

/// Shares of the bound: a face with a point beyond the first is asked at more points, one beyond
/// the second is searched.
const WARM: f64 = 0.4;
const HOT: f64 = 0.75;

/// Share of the bound within which no nearer triangle is looked for.
const NEAR: f64 = 0.25;

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
        let reach = self.reach();
        let near = self.bound.max(FLOOR).sqrt();
        for i in 0..self.changes.changed.len() {
            let (t, corners) = (self.changes.changed[i], self.corners[i]);
            let mean = self.samples.mean_square(&self.faces.all[t as usize]);
            let mut asked = 0.0;
            if reach.is_none_or(|reach| reach > near) {
                asked = self.ask_face(i, t, corners, mean.is_none(), reach.is_some());
            } else if let Some(reach) = reach {
                self.faces.all[t as usize].reach = reach as f32;
            }
            self.settle(t, mean.unwrap_or(asked), area(corners));
        }
    }

    /// Returns how far the changed faces are from the input at most, where a closed fan became a
    /// smaller one: they are as near to its faces as those to them.
    fn reach(&mut self) -> Option<f64> {
        let gap = self.fan().and_then(|middle| gap(middle, &self.link))?;
        let reach = |&t: &u32| f64::from(self.faces.all[t as usize].reach);
        // Rounded up for good, whatever a face keeps of it.
        Some((gap + self.changes.touched.iter().map(reach).fold(0.0, f64::max)) * (1.0 + 1e-6))
    }

    /// Returns the middle of the fan that a step removed, and notes the border in order, from the
    /// point that the middle became; nothing if the faces were no closed fan.
    fn fan(&mut self) -> Option<DVec3> {
        let Changes { touched, changed, sources, targets } = &self.changes;
        let (&[middle], &[target]) = (&sources[..], &targets[..]) else { return None };
        if touched.len() != changed.len() + 2 || touched.len() > gap::MOST {
            return None;
        }
        let faces = &self.faces.all;
        let mut ends = touched.iter().filter(|&&t| !faces[t as usize].live).map(|&t| {
            let mut others = faces[t as usize].points.into_iter().filter(|&p| p != target);
            others.next().filter(|_| others.next().is_none())
        });
        let ends = [ends.next()??, ends.next()??];
        // The border of each face: from one point to the next.
        let mut edges = [[NONE; 2]; gap::MOST];
        let edges = &mut edges[..changed.len()];
        for (edge, &t) in edges.iter_mut().zip(changed) {
            let [a, b, c] = faces[t as usize].points;
            *edge = match target {
                p if p == a => [b, c],
                p if p == b => [c, a],
                _ => [a, b],
            };
        }
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
        (at == ends[1 - first]).then(|| self.input.place(middle))
    }

    /// Returns whether no more than one in `share` faces is left, or so few that it does not
    /// matter.
    fn is_coarse(&self, share: u32) -> bool {
        self.faces.live <= (self.input.triangles.len() as u32 / share).max(64)
    }

    /// Asks points of a changed face. Returns the squared distance of its centroid, or an upper
    /// bound of it unless `exact`.
    fn ask_face(&mut self, i: usize, t: u32, corners: [DVec3; 3], exact: bool, disc: bool) -> f64 {
        let mut ask = Ask { pass: self, i, t, corners, far: 0.0 };
        let middle = ask.point(centroid(corners), exact);
        let points = ask.pass.faces.all[t as usize].points;
        for k in 0..3 {
            let ends = [points[k], points[(k + 1) % 3]];
            if ask.pass.is_new_edge(ends) {
                ask.point((corners[k] + corners[(k + 1) % 3]) * 0.5, false);
            }
        }
        if !disc || ask.is_beyond(WARM) || ask.pass.is_coarse(8) {
            ask.points(&FEW);
        }
        if ask.is_beyond(WARM) || ask.pass.is_coarse(32) {
            ask.points(&VERY_FEW);
        }
        let (is_hot, far) = (ask.is_beyond(HOT), ask.far);
        if is_hot {
            self.refine_face(corners);
        }
        let reach = if is_hot { self.bound.max(far) } else { far };
        self.faces.all[t as usize].reach = reach.sqrt() as f32;
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
    /// The largest squared distance so far.
    far: f64,
}

impl Ask<'_, '_> {
    /// Returns whether a point was farther than a share of the bound.
    fn is_beyond(&self, share: f64) -> bool {
        self.far > (self.pass.bound * share * share).max(FLOOR)
    }

    /// Asks points by their barycentric coordinates.
    fn points(&mut self, coordinates: &[[f64; 3]]) {
        let [a, b, c] = self.corners;
        for [u, v, w] in coordinates {
            self.point(a * *u + b * *v + c * *w, false);
        }
    }

    /// Returns the squared distance of a point to the input, or an upper bound of it that is near
    /// enough unless `exact`.
    fn point(&mut self, p: DVec3, exact: bool) -> f64 {
        let squared = self.distance(p, exact);
        self.far = self.far.max(squared);
        squared
    }

    fn distance(&mut self, p: DVec3, exact: bool) -> f64 {
        let enough = (self.pass.bound * (NEAR * NEAR)).max(FLOOR);
        let hint = match self.guess(p, enough) {
            Ok(squared) if !exact => return squared,
            Ok(_) => self.pass.faces.all[self.t as usize].near,
            Err(hint) => hint,
        };
        let pass = &mut *self.pass;
        let mut nearest = Hit::NOTHING;
        let stop = if exact { 0.0 } else { enough };
        let patience = patience(pass.work, pass.input);
        let opened = pass.input.tree.search(pass.input, p, hint, stop, patience, &mut nearest);
        pass.work += u64::from(opened) + 1;
        pass.faces.all[self.t as usize].near = nearest.triangle;
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
        let mut nearest = Hit::NOTHING;
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
