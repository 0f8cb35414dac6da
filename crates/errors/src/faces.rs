//! The faces of the level that the pass has reached.

use crate::input::Input;
use glam::DVec3;
use lodc_mesh::{NONE, is_degenerate};
use lodc_nearest::{MovingTree, Triangles};
use std::ops::Range;

/// Faces around a vertex that are read ahead: one more than most vertices have. Chosen by hand.
const FACES_READ_AHEAD: usize = 7;

/// The tree is built anew when half of its faces have gone; or when its boxes have grown this much
/// and, so that building takes no more than a share of the work, at least its faces divided by this
/// have moved. Chosen by hand.
const MAX_GROWTH: f64 = 1.5;
const MOVED_DIVISOR: u32 = 8;

/// A face of the current level, half a cache line.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(crate) struct Face {
    /// Its corners, as points.
    pub(crate) points: [u32; 3],
    /// For each corner the next one of the same vertex (3 × face + corner, [`NONE`] at the end).
    next_corner: [u32; 3],
    /// The first of its samples; [`NONE`] without any.
    pub(crate) first_sample: u32,
    /// Number of its samples; `u16::MAX` for more.
    pub(crate) sample_count: u16,
    flags: u8,
}

/// The face is part of the level.
const LIVE: u8 = 1;
/// No step has touched the face yet.
const ORIGINAL: u8 = 2;
/// The step that is being applied has touched the face.
const TOUCHED: u8 = 4;

impl Face {
    #[inline]
    pub(crate) fn is_live(&self) -> bool {
        self.flags & LIVE != 0
    }

    /// Marks the face as touched for good. Returns whether it was untouched before.
    pub(crate) fn clear_original(&mut self) -> bool {
        let was_original = self.flags & ORIGINAL != 0;
        self.flags &= !ORIGINAL;
        was_original
    }
}

/// All faces, dead ones too, in the order of the input's triangles; the list of corners at each
/// vertex; and a tree over the faces.
pub(crate) struct Faces {
    pub(crate) all: Vec<Face>,
    /// The first and the last corner at each vertex; both [`NONE`] without any.
    corner_list_ends: Vec<[u32; 2]>,
    pub(crate) live_count: u32,
    tree: MovingTree,
    /// Live faces when the tree was built, and faces that have moved since.
    live_in_tree: u32,
    moved: u32,
}

/// Changes of a step.
#[derive(Default)]
pub(crate) struct Changes {
    /// All faces with a corner that moves.
    pub(crate) touched: Vec<u32>,
    /// Those of them that are live after the step.
    pub(crate) surviving: Vec<u32>,
    /// The points that corners move from, and those that they move to.
    pub(crate) sources: Vec<u32>,
    pub(crate) targets: Vec<u32>,
}

impl Faces {
    /// The triangles of the input. `corner_vertices` has their corners as vertices of the mesh.
    pub(crate) fn new(input: &Input, corner_vertices: &[[u32; 3]]) -> Self {
        let mut corner_list_ends = vec![[NONE; 2]; input.point_of_vertex.len()];
        let mut all = Vec::with_capacity(input.triangles.len());
        for (t, (points, vertices)) in (0..).zip(input.triangles.iter().zip(corner_vertices)) {
            all.push(Face {
                points: *points,
                next_corner: [NONE; 3],
                first_sample: NONE,
                sample_count: 0,
                flags: LIVE | ORIGINAL,
            });
            for (corner, &v) in (3 * t..).zip(vertices) {
                let [first, last] = &mut corner_list_ends[v as usize];
                match *last {
                    NONE => *first = corner,
                    last => *next(&mut all, last) = corner,
                }
                *last = corner;
            }
        }
        let live_count = all.len() as u32;
        let tree = input.tree.clone().for_moving(all.len());
        Self { all, corner_list_ends, live_count, tree, live_in_tree: live_count, moved: 0 }
    }

    /// Reads what the steps of some records will need: their faces are anywhere in memory, and many
    /// reads that do not wait for each other take little longer than one. `touch_sample` reads a
    /// sample.
    pub(crate) fn read_ahead(
        &self,
        input: &Input,
        records: Range<u32>,
        touch_sample: impl Fn(u32) -> u32,
    ) {
        let mut corners: Vec<u32> = records.map(|v| self.corner_list_ends[v as usize][0]).collect();
        let mut word = 0;
        for _ in 0..FACES_READ_AHEAD {
            for corner in &mut corners {
                let Some(face) = self.all.get(*corner as usize / 3) else { continue };
                word ^= touch_sample(face.first_sample) ^ self.tree.touch(*corner / 3);
                for point in face.points {
                    word ^= input.coordinates[point as usize][0].to_bits();
                }
                *corner = face.next_corner[*corner as usize % 3];
            }
        }
        // So that the compiler keeps the reads.
        std::hint::black_box(word);
    }

    /// Applies a step: of each pair in `moves`, the first vertex becomes the second.
    pub(crate) fn apply(
        &mut self,
        input: &Input,
        moves: impl Iterator<Item = (u32, u32)>,
        changes: &mut Changes,
    ) {
        changes.touched.clear();
        changes.surviving.clear();
        changes.sources.clear();
        changes.targets.clear();
        for (from, to) in moves {
            self.move_vertex(input, from, to, changes);
        }
        for &t in &changes.touched {
            let face = &mut self.all[t as usize];
            face.flags &= !TOUCHED;
            let points = face.points;
            if is_degenerate(points.map(|p| input.position_ids[p as usize])) {
                face.flags &= !LIVE;
                self.live_count -= 1;
                self.tree.remove(t, |t| self.all[t as usize].is_live());
                continue;
            }
            changes.surviving.push(t);
            self.tree.grow(t, &points.map(|p| input.coordinates[p as usize]));
        }
        self.moved += changes.surviving.len() as u32;
        let has_grown =
            self.moved >= self.live_in_tree / MOVED_DIVISOR && self.tree.growth() > MAX_GROWTH;
        let has_shrunk = self.live_count <= self.live_in_tree / 2;
        if self.live_count > 0 && (has_grown || has_shrunk) {
            self.rebuild_tree(input);
        }
    }

    /// Moves the corners at a vertex to another one, and appends their list to its list.
    fn move_vertex(&mut self, input: &Input, from: u32, to: u32, changes: &mut Changes) {
        let (old, new) = (input.point_of_vertex[from as usize], input.point_of_vertex[to as usize]);
        if old != new && changes.targets.last() != Some(&new) {
            changes.targets.push(new);
        }
        if old != new && changes.sources.last() != Some(&old) {
            changes.sources.push(old);
        }
        // The list loses the corners of dead faces.
        let (mut first, mut last) = (NONE, NONE);
        let mut corner = self.corner_list_ends[from as usize][0];
        while corner != NONE {
            let (t, c) = (corner / 3, corner as usize % 3);
            let face = &mut self.all[t as usize];
            let following = face.next_corner[c];
            if face.is_live() {
                face.points[c] = new;
                if old != new && face.flags & TOUCHED == 0 {
                    face.flags |= TOUCHED;
                    changes.touched.push(t);
                }
                match last {
                    NONE => first = corner,
                    last => *next(&mut self.all, last) = corner,
                }
                last = corner;
            }
            corner = following;
        }
        if last == NONE {
            return;
        }
        *next(&mut self.all, last) = NONE;
        let ends = &mut self.corner_list_ends[to as usize];
        match ends[1] {
            NONE => ends[0] = first,
            last_at_target => *next(&mut self.all, last_at_target) = first,
        }
        ends[1] = last;
    }

    fn rebuild_tree(&mut self, input: &Input) {
        let corners = |t: u32| self.all[t as usize].points.map(|p| input.coordinates[p as usize]);
        let live = (0..self.all.len() as u32).filter(|&t| self.all[t as usize].is_live());
        self.tree = MovingTree::of(live, self.all.len(), corners);
        (self.live_in_tree, self.moved) = (self.live_count, 0);
    }

    /// The current level and a tree over it.
    pub(crate) fn level_and_tree<'a>(
        &'a self,
        input: &'a Input,
    ) -> (LevelFaces<'a>, &'a MovingTree) {
        (LevelFaces { input, faces: &self.all }, &self.tree)
    }
}

/// The corner after one in the list of its vertex.
#[inline]
fn next(faces: &mut [Face], corner: u32) -> &mut u32 {
    &mut faces[corner as usize / 3].next_corner[corner as usize % 3]
}

/// The current level as its tree reads it.
pub(crate) struct LevelFaces<'a> {
    input: &'a Input,
    faces: &'a [Face],
}

impl Triangles for LevelFaces<'_> {
    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.input.corners_of(self.faces[triangle as usize].points)
    }
    #[inline]
    fn is_live(&self, triangle: u32) -> bool {
        self.faces[triangle as usize].is_live()
    }
}
