//! The content of an OBJ as arrays, with counts of what was left out.

pub(super) use crate::faces::{Faces, NONE, Run};

/// The content of an OBJ.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    /// Labels are groups and objects; objects are `o` statements.
    pub(super) faces: Faces,
    pub(super) libraries: Vec<String>,
    pub(super) notes: Notes,
}

/// Counts of what was not taken as it stands, each with the first line where it happened.
#[derive(Debug, Default)]
pub(super) struct Notes {
    pub(super) lines: Count,
    pub(super) points: Count,
    pub(super) small_faces: Count,
    pub(super) unknown: Count,
    pub(super) unknown_first: String,
    pub(super) free_form: Count,
    pub(super) extra_values: Count,
    pub(super) weights: Count,
    pub(super) uncolored: Count,
}

/// Count of occurrences, and the line of the first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Count {
    pub(super) times: u64,
    pub(super) line: u32,
}

impl Count {
    /// Once more, on this line.
    pub(super) fn add(&mut self, line: u32) {
        if self.times == 0 {
            self.line = line;
        }
        self.times += 1;
    }
}
