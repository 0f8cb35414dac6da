//! Questions of one face: how far some of its points are from the input.

use crate::backward::Backward;
use crate::block::Hint;
use crate::input::wide;
use crate::refine::FLOOR;
use crate::samples::sources;
use glam::DVec3;
use lodc_nearest::{Hit, Triangles, distance_squared};

/// Neighbours whose triangle of the input is tried.
const NEIGHBOURS: usize = 8;

/// Share of the bound within which no nearer triangle is looked for.
const NEAR: f64 = 0.39;

/// Questions of one face.
pub(crate) struct Ask<'p, 'a> {
    pub(crate) pass: &'p mut Backward<'a>,
    pub(crate) face: u32,
    pub(crate) hints: &'p [Hint],
    pub(crate) corners: [DVec3; 3],
    /// The largest squared distance so far.
    pub(crate) far: f64,
}

impl Ask<'_, '_> {
    /// Returns whether a point was farther than a share of the bound.
    pub(crate) fn is_beyond(&self, share: f64) -> bool {
        self.far > (self.pass.bound * share * share).max(FLOOR)
    }

    /// Asks points by their barycentric coordinates.
    pub(crate) fn points(&mut self, coordinates: &[[f64; 3]]) {
        for &coordinates in coordinates {
            self.point(lodc_nearest::point_at(self.corners, coordinates), false);
        }
    }

    /// Returns the squared distance of a point to the input, or an upper bound of it that is near
    /// enough unless `exact`.
    pub(crate) fn point(&mut self, p: DVec3, exact: bool) -> f64 {
        let squared = self.distance(p, exact);
        self.far = self.far.max(squared);
        squared
    }

    fn distance(&mut self, p: DVec3, exact: bool) -> f64 {
        // What is nearer than a point that was asked makes the face no farther.
        let enough = (self.pass.bound * (NEAR * NEAR)).max(FLOOR).max(self.far);
        let hint = match self.guess(p, enough) {
            Ok(squared) if !exact => return squared,
            Ok(_) => self.pass.faces[self.face as usize].near,
            Err(hint) => hint,
        };
        let pass = &mut *self.pass;
        let mut nearest = Hit::NOTHING;
        let stop = if exact { 0.0 } else { enough };
        let patience = (pass.work + pass.other).patience(pass.input);
        let opened = pass.input.tree.search(pass.input, p, hint, stop, patience, &mut nearest);
        pass.work.done += u64::from(opened) + 1;
        pass.faces[self.face as usize].near = nearest.triangle;
        pass.bound = pass.bound.max(nearest.squared);
        nearest.squared
    }

    /// Tries what is at hand: corners, the triangle found last, that of a sample, those of
    /// neighbours. Returns a distance that is near enough, or else a triangle to start from.
    fn guess(&mut self, p: DVec3, enough: f64) -> Result<f64, u32> {
        let pass = &mut *self.pass;
        let input = pass.input;
        for corner in self.corners {
            let squared = (p - corner).length_squared();
            if squared <= enough {
                return Ok(squared);
            }
        }
        let near = pass.faces[self.face as usize].near;
        let mut nearest = Hit::NOTHING;
        nearest.offer(distance_squared(p, input.corners(near)), near);
        if nearest.squared <= enough {
            return Ok(nearest.squared);
        }
        let squared = |hint: &&Hint| (wide(hint.place) - p).length_squared();
        let sample = self.hints.iter().min_by(|a, b| squared(a).total_cmp(&squared(b)));
        let sample = sample.map(|hint| sources(input, hint.origin).as_slice()[0]);
        let others = pass.changed.iter().take(NEIGHBOURS).map(|e| pass.faces[e.face as usize].near);
        for other in sample.into_iter().chain(others).filter(|&t| t != near) {
            nearest.offer(distance_squared(p, input.corners(other)), other);
            if nearest.squared <= enough {
                pass.faces[self.face as usize].near = other;
                return Ok(nearest.squared);
            }
        }
        Err(nearest.triangle)
    }
}
