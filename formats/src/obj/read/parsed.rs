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

/// Counts of what was not taken as written, each with the first line where it happened.
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

impl Notes {
    /// Adds those of lines that follow `lines` line ends.
    pub(super) fn add(&mut self, more: &Self, lines: u32) {
        if self.unknown.times == 0 {
            self.unknown_first.clone_from(&more.unknown_first);
        }
        self.lines.append(more.lines, lines);
        self.points.append(more.points, lines);
        self.small_faces.append(more.small_faces, lines);
        self.unknown.append(more.unknown, lines);
        self.free_form.append(more.free_form, lines);
        self.extra_values.append(more.extra_values, lines);
        self.weights.append(more.weights, lines);
        self.uncolored.append(more.uncolored, lines);
    }
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

    /// Adds those of lines that follow `lines` line ends.
    fn append(&mut self, more: Self, lines: u32) {
        if self.times == 0 && more.times > 0 {
            self.line = lines.saturating_add(more.line);
        }
        self.times += more.times;
    }
}
