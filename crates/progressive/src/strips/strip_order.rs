//! The drawing order: a doubly linked list of triangles, cut into strips.

use crate::source::split_source::StripPosition;
use lodc_mesh::NONE;

/// The first and the last triangle of a strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StripEnds {
    pub(crate) first: u32,
    pub(crate) last: u32,
}

/// The drawing order of the triangles so far.
#[derive(Clone, Debug)]
pub(crate) struct StripOrder {
    /// The triangle drawn after each, and before each; [`NONE`] at the ends.
    next: Vec<u32>,
    previous: Vec<u32>,
    /// The strip of each triangle. Strips are numbered by their first appearance.
    strip: Vec<u32>,
    ends: Vec<StripEnds>,
    /// The triangle drawn first.
    first: u32,
}

impl StripOrder {
    pub(crate) fn new() -> Self {
        let empty = Vec::new;
        Self { next: empty(), previous: empty(), strip: empty(), ends: Vec::new(), first: NONE }
    }

    pub(crate) fn face_count(&self) -> u32 {
        self.next.len() as u32
    }

    pub(crate) fn strip_count(&self) -> u32 {
        self.ends.len() as u32
    }

    /// Returns the strip of a triangle.
    pub(crate) fn strip(&self, face: u32) -> u32 {
        self.strip[face as usize]
    }

    /// Returns the ends of a strip.
    pub(crate) fn ends(&self, strip: u32) -> StripEnds {
        self.ends[strip as usize]
    }

    /// Returns the triangle drawn after another one; the first one after [`NONE`].
    pub(crate) fn next(&self, face: u32) -> u32 {
        if face == NONE { self.first } else { self.next[face as usize] }
    }

    /// Returns the triangle drawn before another one.
    pub(crate) fn previous(&self, face: u32) -> u32 {
        self.previous[face as usize]
    }

    /// Returns whether two triangles exist and are in one strip.
    pub(crate) fn share_strip(&self, a: u32, b: u32) -> bool {
        a != NONE && b != NONE && self.strip(a) == self.strip(b)
    }

    /// Inserts the next triangle.
    pub(crate) fn insert(&mut self, position: StripPosition) {
        let face = self.face_count();
        let before = self.next(position.after);
        self.next.push(before);
        self.previous.push(position.after);
        self.strip.push(position.strip);
        match position.after {
            NONE => self.first = face,
            after => self.next[after as usize] = face,
        }
        if before != NONE {
            self.previous[before as usize] = face;
        }
        if position.strip == self.strip_count() {
            self.ends.push(StripEnds { first: face, last: face });
        } else {
            let ends = &mut self.ends[position.strip as usize];
            if ends.last == position.after {
                ends.last = face;
            } else if ends.first == before {
                ends.first = face;
            }
        }
    }
}
