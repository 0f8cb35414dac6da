//! Making the records: one walk down the whole sequence, writing down what each edge collapse
//! changes.

use super::connect::{next, opposites, previous};
use super::moving::Faces;
use super::record::{Fan, Records};
use lodc_mesh::{Mesh, NONE, PositionIds, Simplified, removal_lods};

/// Makes the records of a sequence.
pub(super) fn records(simplified: &Simplified) -> Records {
    let mesh = simplified.mesh();
    let positions = mesh.position_ids();
    let removal_lods = removal_lods(simplified, &positions);
    let mut by_removal: Vec<u32> = (0..removal_lods.len() as u32).collect();
    by_removal.sort_by_key(|&t| removal_lods[t as usize]);
    let records = Records {
        opposite: opposites(mesh, &positions),
        first_fan: vec![0],
        fans: Vec::new(),
        lost_edges: Vec::with_capacity(removal_lods.len()),
        lost_ends: Vec::with_capacity(simplified.collapses().steps()),
        removal_lods,
    };
    let faces = Faces::new(mesh, &records.opposite);
    Walk {
        simplified,
        positions,
        corner_lists: CornerLists::new(mesh),
        fan_of: vec![NONE; faces.corners.len()],
        faces,
        records,
    }
    .finish(&by_removal)
}

/// For each vertex the list of corners that are at it. Corners of dead triangles stay in the list
/// until it is taken.
struct CornerLists {
    first: Vec<u32>,
    last: Vec<u32>,
    next: Vec<u32>,
}

impl CornerLists {
    fn new(mesh: &Mesh) -> Self {
        let (vertices, corners) = (mesh.vertex_count(), mesh.triangles().as_flattened());
        let mut around = Self {
            first: vec![NONE; vertices],
            last: vec![NONE; vertices],
            next: vec![NONE; corners.len()],
        };
        for (corner, &v) in corners.iter().enumerate() {
            around.push(v, corner as u32);
        }
        around
    }

    /// Appends a corner to the list of a vertex.
    fn push(&mut self, vertex: u32, corner: u32) {
        let v = vertex as usize;
        self.next[corner as usize] = NONE;
        match self.last[v] {
            NONE => self.first[v] = corner,
            last => self.next[last as usize] = corner,
        }
        self.last[v] = corner;
    }

    /// Moves the list of a vertex to `corners`, which is emptied before.
    fn take(&mut self, vertex: u32, corners: &mut Vec<u32>) {
        corners.clear();
        let mut corner = std::mem::replace(&mut self.first[vertex as usize], NONE);
        self.last[vertex as usize] = NONE;
        while corner != NONE {
            corners.push(corner);
            corner = self.next[corner as usize];
        }
    }
}

/// The mesh on its way down.
struct Walk<'a> {
    simplified: &'a Simplified,
    positions: PositionIds,
    faces: Faces,
    corner_lists: CornerLists,
    /// The record whose fans a corner is to be put into.
    fan_of: Vec<u32>,
    records: Records,
}

impl Walk<'_> {
    /// Walks down. `by_removal` are the triangles in the order of their removal LODs.
    fn finish(mut self, by_removal: &[u32]) -> Records {
        let mut corners = Vec::new();
        let (mut start, mut lost) = (0, 0);
        for &end in &self.simplified.collapses().parts().step_ends {
            for record in start..end {
                self.corner_lists.take(record, &mut corners);
                corners.retain(|&c| self.records.removal_lods[c as usize / 3] > end);
                self.add_fans(record, &corners);
                let target = self.target(record, end);
                corners.iter().for_each(|&c| self.corner_lists.push(target, c));
            }
            let dying = lost
                + by_removal[lost..]
                    .partition_point(|&t| self.records.removal_lods[t as usize] <= end);
            for &t in &by_removal[lost..dying] {
                let edge = self.collapsed_edge(t, end);
                self.records.lost_edges.push(edge);
            }
            self.records.lost_ends.push(dying as u32);
            self.faces.collapse(
                &self.records,
                self.records.lost_ends.len() - 1,
                start..end,
                |v| self.simplified.collapses().targets()[v as usize],
                &mut (),
            );
            (start, lost) = (end, dying);
        }
        self.records
    }

    /// Resolves a vertex at the end of a step.
    fn target(&self, vertex: u32, end: u32) -> u32 {
        let mut v = vertex;
        while v < end {
            v = self.simplified.collapses().targets()[v as usize];
        }
        v
    }

    /// Puts the surviving corners of a record into fans.
    fn add_fans(&mut self, record: u32, corners: &[u32]) {
        for &c in corners {
            self.fan_of[c as usize] = record;
        }
        // First those with a beginning, then the closed ones, which may begin anywhere.
        for closed in [false, true] {
            for &corner in corners {
                let before = self.faces.opposite[corner as usize];
                let begins = before == NONE || self.fan_of[next(before) as usize] != record;
                if self.fan_of[corner as usize] != record || !(begins || closed) {
                    continue;
                }
                let mut fan = Fan { corner, corners: 0 };
                let mut c = corner;
                while c != NONE && self.fan_of[c as usize] == record {
                    self.fan_of[c as usize] = NONE;
                    fan.corners += 1;
                    c = self.faces.opposite[previous(c) as usize];
                }
                self.records.fans.push(fan);
            }
        }
        self.records.first_fan.push(self.records.fans.len() as u32);
    }

    /// The edge of a triangle whose ends come to be at one position.
    fn collapsed_edge(&self, triangle: u32, end: u32) -> u32 {
        let at = |c: u32| {
            self.positions.of_vertex[self.target(self.faces.corners[c as usize], end) as usize]
        };
        (3 * triangle..3 * triangle + 3)
            .find(|&c| at(c) == at(next(c)))
            .expect("a dying triangle has two corners at one position")
    }
}
