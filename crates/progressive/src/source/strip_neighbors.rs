//! The strips of an object as the order in which an encoder's triangles are drawn.

use crate::source::split_source::StripPosition;
use lodc_mesh::{Mesh, NONE, OrientedTriangle};
use lodc_strip::StripSet;
use std::error::Error;
use std::fmt;

/// Strips that do not draw the triangles of their mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StripMismatch;

impl fmt::Display for StripMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("its strips do not draw its mesh")
    }
}

impl Error for StripMismatch {}

/// For each triangle in stream order its neighbours in drawing order among those before it.
pub(crate) struct StripNeighbors {
    previous: Vec<u32>,
    next: Vec<u32>,
    /// The strip that draws each triangle, as the strip set numbers them.
    strip: Vec<u32>,
}

/// One triangle that a strip draws.
struct Drawn {
    triangle: OrientedTriangle,
    strip: u32,
}

impl StripNeighbors {
    /// Finds the neighbours. `order` has the triangles of the mesh in stream order. Fails if the
    /// strips do not draw the mesh.
    pub(crate) fn new(
        mesh: &Mesh,
        strips: &StripSet,
        order: &[u32],
    ) -> Result<Self, StripMismatch> {
        let mut own = Vec::with_capacity(order.len());
        for (s, submesh) in (0..).zip(mesh.submeshes()) {
            let oriented = |t| OrientedTriangle::new(s, mesh.triangles()[t]);
            own.extend(submesh.triangles().map(|t| (oriented(t), t as u32)));
        }
        own.sort_unstable();
        let drawn = drawn(strips, order.len());
        let mut by_triangle: Vec<u32> = (0..drawn.len() as u32).collect();
        by_triangle.sort_by_key(|&i| (drawn[i as usize].triangle, i));
        let same =
            |(&i, own): (&u32, &(OrientedTriangle, u32))| drawn[i as usize].triangle == own.0;
        if own.len() != drawn.len() || !by_triangle.iter().zip(&own).all(same) {
            return Err(StripMismatch);
        }

        let mut face_of = vec![0; order.len()];
        for (face, &t) in (0..).zip(order) {
            face_of[t as usize] = face;
        }
        let mut faces = vec![0; order.len()];
        let mut strip = vec![0; order.len()];
        for (&i, &(_, t)) in by_triangle.iter().zip(&own) {
            let face = face_of[t as usize];
            faces[i as usize] = face;
            strip[face as usize] = drawn[i as usize].strip;
        }
        let mut neighbors =
            Self { previous: vec![NONE; order.len()], next: vec![NONE; order.len()], strip };
        neighbors.link(&faces);
        Ok(neighbors)
    }

    /// Links triangles in drawing order, then leaves each with the neighbours that it has when it
    /// is the newest: all that come later are unlinked, the last first.
    fn link(&mut self, drawing_order: &[u32]) {
        for pair in drawing_order.windows(2) {
            self.next[pair[0] as usize] = pair[1];
            self.previous[pair[1] as usize] = pair[0];
        }
        for face in (0..drawing_order.len()).rev() {
            let (previous, next) = (self.previous[face], self.next[face]);
            if previous != NONE {
                self.next[previous as usize] = next;
            }
            if next != NONE {
                self.previous[next as usize] = previous;
            }
        }
    }

    /// Returns where a triangle stands, see `SplitSource::strip_position`.
    pub(crate) fn position(
        &self,
        face: u32,
        strips: u32,
        strip_of: &dyn Fn(u32) -> u32,
    ) -> StripPosition {
        let (after, before) = (self.previous[face as usize], self.next[face as usize]);
        let same_strip = |f: u32| f != NONE && self.strip[f as usize] == self.strip[face as usize];
        let strip = if same_strip(after) {
            strip_of(after)
        } else if same_strip(before) {
            strip_of(before)
        } else {
            strips
        };
        StripPosition { after, strip }
    }
}

/// Returns what the strips draw, in drawing order.
fn drawn(strips: &StripSet, capacity: usize) -> Vec<Drawn> {
    let mut drawn = Vec::with_capacity(capacity);
    for (strip, submesh) in (0..).zip(strips.submeshes()) {
        let triangles = lodc_strip::strip_triangles(strips.strip(strip as usize));
        let entry = |t| Drawn { triangle: OrientedTriangle::new(submesh, t), strip };
        drawn.extend(triangles.map(entry));
    }
    drawn
}
