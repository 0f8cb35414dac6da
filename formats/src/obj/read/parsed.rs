//! The content of an OBJ as arrays, with counts of what was ignored or changed.

pub(super) use crate::faces::{Faces, NONE, Run};

/// The content of an OBJ.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    /// Its `labels` are the names of `g` and `o` statements, its `objects` those of `o` alone.
    pub(super) faces: Faces,
    /// Material libraries (`mtllib`).
    pub(super) libraries: Vec<String>,
    /// Vertices of points, and of each line. Some may not be there.
    pub(super) points: Vec<i64>,
    pub(super) line_elements: Vec<Vec<i64>>,
    pub(super) notes: Notes,
}

/// Counts of what was ignored or changed, each with the first line where it happened.
#[derive(Debug, Default)]
pub(super) struct Notes {
    /// Line elements (`l`).
    pub(super) lines: Count,
    /// Point elements (`p`).
    pub(super) points: Count,
    /// Faces with fewer than three corners.
    pub(super) small_faces: Count,
    /// Statements that are none of OBJ.
    pub(super) unknown: Count,
    /// The first word of the first of these.
    pub(super) unknown_first: String,
    /// Free-form curves and surfaces.
    pub(super) free_form: Count,
    /// Statements with more numbers than they need.
    pub(super) extra_values: Count,
    /// Positions with a weight other than 1.
    pub(super) weights: Count,
    /// Indices of texture coordinates (1) and normals (2) of which the file has none.
    pub(super) dangling: [Count; 3],
    /// Corners with 0 as the number of texture coordinates or of a normal.
    pub(super) zeros: Count,
    /// Positions without a colour.
    pub(super) uncolored: Count,
}

impl Notes {
    /// Adds the notes of a chunk that follows `lines_before` line ends.
    pub(super) fn add(&mut self, more: &Self, lines_before: u32) {
        if self.unknown.times == 0 {
            self.unknown_first.clone_from(&more.unknown_first);
        }
        self.lines.append(more.lines, lines_before);
        self.points.append(more.points, lines_before);
        self.small_faces.append(more.small_faces, lines_before);
        self.unknown.append(more.unknown, lines_before);
        self.free_form.append(more.free_form, lines_before);
        self.extra_values.append(more.extra_values, lines_before);
        self.weights.append(more.weights, lines_before);
        for (count, more) in self.dangling.iter_mut().zip(more.dangling) {
            count.append(more, lines_before);
        }
        self.zeros.append(more.zeros, lines_before);
        self.uncolored.append(more.uncolored, lines_before);
    }
}

/// Count of occurrences, and the line of the first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Count {
    pub(super) times: u64,
    pub(super) line: u32,
}

impl Count {
    /// Counts an occurrence on this line.
    pub(super) fn add(&mut self, line: u32) {
        if self.times == 0 {
            self.line = line;
        }
        self.times += 1;
    }

    /// Adds the count of a chunk that follows `lines` line ends.
    fn append(&mut self, more: Self, lines: u32) {
        if self.times == 0 && more.times > 0 {
            self.line = lines.saturating_add(more.line);
        }
        self.times += more.times;
    }
}
