//! The content of an OBJ as arrays, with counts of what was left out.

pub(super) use lodc_mesh::NONE;

/// The content of an OBJ. Indices count from 0 and are in range.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    pub(super) positions: Vec<[f32; 3]>,
    /// Empty, or one per position; white where the file has none.
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) color_has_alpha: bool,
    pub(super) texcoords: Vec<[f32; 2]>,
    /// Empty, or the third components.
    pub(super) texcoords_w: Vec<f32>,
    pub(super) normals: Vec<[f32; 3]>,
    /// Of each corner: its position.
    pub(super) corner_v: Vec<u32>,
    /// Of each corner: its texture coordinates or [`NONE`]; empty if no corner has any.
    pub(super) corner_t: Vec<u32>,
    /// Of each corner: its normal or [`NONE`]; empty if no corner has any.
    pub(super) corner_n: Vec<u32>,
    /// End of the corners of each face.
    pub(super) face_ends: Vec<u32>,
    /// Runs of faces with the same material and label.
    pub(super) runs: Vec<Run>,
    /// Names of materials in order of appearance.
    pub(super) materials: Vec<String>,
    /// Names of groups and objects in order of appearance.
    pub(super) labels: Vec<String>,
    /// The names of `o` statements: none, one, or several.
    pub(super) objects: Vec<String>,
    pub(super) libraries: Vec<String>,
    pub(super) notes: Notes,
}

/// Faces from `first_face` up to the next run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) first_face: u32,
    /// Index into the materials, or [`NONE`].
    pub(super) material: u32,
    /// Index into the labels, or [`NONE`].
    pub(super) label: u32,
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
