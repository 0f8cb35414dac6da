//! Questions of one face: how far some of its points are from the input.

use crate::block::Hint;
use crate::input::{Input, wide};
use crate::refine::FLOOR;
use crate::samples::sources;
use glam::DVec3;
use lodc_nearest::{Hit, Triangles, point_at};

/// Neighbours whose triangle of the input is tried.
const NEIGHBOURS: usize = 8;

/// Questions of one face.
pub(crate) struct Ask<'a> {
    pub(crate) input: &'a Input,
    /// Share of the bound within which no nearer triangle is looked for.
    pub(crate) share: f64,
    pub(crate) corners: [DVec3; 3],
    /// A triangle of the input near its middle, or the one found last.
    pub(crate) near: u32,
    /// Samples of the face.
    pub(crate) hints: &'a [Hint],
    /// Triangles near it and its neighbours.
    pub(crate) others: &'a [u32],
    /// Boxes that one search may open, and those that were opened.
    pub(crate) patience: u32,
    pub(crate) opened: u64,
    /// The squared bound, and the largest squared distance of this face so far.
    pub(crate) bound: f64,
    pub(crate) far: f64,
}

impl Ask<'_> {
    /// Returns whether a point was farther than a share of the bound.
    pub(crate) fn is_beyond(&self, share: f64) -> bool {
        self.far > (self.bound * share * share).max(FLOOR)
    }

    /// Asks points by their barycentric coordinates.
    pub(crate) fn points(&mut self, coordinates: &[[f64; 3]]) {
        for &coordinates in coordinates {
            self.point(point_at(self.corners, coordinates), false);
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
        let enough = (self.bound * (self.share * self.share)).max(FLOOR).max(self.far);
        let hint = match self.guess(p, enough) {
            Ok(squared) if !exact => return squared,
            Ok(_) => self.near,
            Err(hint) => hint,
        };
        let mut nearest = Hit::NOTHING;
        let (input, stop) = (self.input, if exact { 0.0 } else { enough });
        let opened = input.tree.search(input, p, hint, stop, self.patience, &mut nearest);
        self.opened += u64::from(opened) + 1;
        self.near = nearest.triangle;
        self.bound = self.bound.max(nearest.squared);
        nearest.squared
    }

    /// Tries what is at hand: corners, the triangle found last, that of a sample, those of
    /// neighbours. Returns a distance that is near enough, or else a triangle to start from.
    fn guess(&mut self, p: DVec3, enough: f64) -> Result<f64, u32> {
        for corner in self.corners {
            let squared = (p - corner).length_squared();
            if squared <= enough {
                return Ok(squared);
            }
        }
        let mut nearest = Hit::NOTHING;
        nearest.look(p, self.input.corners(self.near), self.near);
        if nearest.squared <= enough {
            return Ok(nearest.squared);
        }
        let mut sample = (f64::INFINITY, None);
        for hint in self.hints {
            let squared = (wide(hint.place) - p).length_squared();
            if squared < sample.0 {
                sample = (squared, Some(hint));
            }
        }
        let sample = sample.1.map(|hint| sources(self.input, hint.origin).as_slice()[0]);
        let others = self.others.iter().take(NEIGHBOURS).copied();
        for other in sample.into_iter().chain(others).filter(|&t| t != self.near) {
            nearest.look(p, self.input.corners(other), other);
            if nearest.squared <= enough {
                self.near = other;
                return Ok(nearest.squared);
            }
        }
        Err(nearest.triangle)
    }
}
