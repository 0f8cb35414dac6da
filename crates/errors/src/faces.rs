//! The faces of the level that the pass has reached.

use crate::input::Input;
use glam::DVec3;
use lodc_mesh::{NONE, is_degenerate};
use lodc_nearest::{MovingTree, Triangles, morton_order};
use std::ops::Range;

/// Faces around a vertex that are read ahead.
const FAN: usize = 7;

/// A face of the current level, half a cache line.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(crate) struct Face {
    /// Its corners, as points.
    pub(crate) points: [u32; 3],
    /// For each corner the next one of the same vertex (3 × face + corner, [`NONE`] at the end).
    next: [u32; 3],
    /// The first of its samples.
    pub(crate) first_sample: u32,
    /// Number of its samples; more than fit are as many as fit.
    pub(crate) samples: u16,
    flags: u8,
}

/// The face is part of the level.
const LIVE: u8 = 1;
/// No step has touched it yet.
const ORIGINAL: u8 = 2;
/// The step that is applied has touched it.
const TOUCHED: u8 = 4;

impl Face {
    #[inline]
    pub(crate) fn is_live(&self) -> bool {
        self.flags & LIVE != 0
    }

    /// Returns true the first time.
    pub(crate) fn take_original(&mut self) -> bool {
        let was = self.flags & ORIGINAL != 0;
        self.flags &= !ORIGINAL;
        was
    }
}

/// All faces, which corners are at each vertex, and a tree over the faces.
pub(crate) struct Faces {
    pub(crate) all: Vec<Face>,
    /// The first and the last corner at each vertex.
    ends: Vec<[u32; 2]>,
    pub(crate) live: u32,
    tree: MovingTree,
    /// Live faces when the tree was built.
    in_tree: u32,
}

/// Changes of a step.
#[derive(Default)]
pub(crate) struct Changes {
    /// All faces with a corner that moves.
    pub(crate) touched: Vec<u32>,
    /// Those of them that stay.
    pub(crate) changed: Vec<u32>,
    /// The points that corners move from, and those that they move to.
    pub(crate) sources: Vec<u32>,
    pub(crate) targets: Vec<u32>,
}

impl Faces {
    pub(crate) fn new(input: &Input, wedges: &[[u32; 3]]) -> Self {
        let mut ends = vec![[NONE; 2]; input.point_of.len()];
        let mut all = Vec::with_capacity(input.triangles.len());
        for (t, (points, wedges)) in (0..).zip(input.triangles.iter().zip(wedges)) {
            all.push(Face {
                points: *points,
                next: [NONE; 3],
                first_sample: NONE,
                samples: 0,
                flags: LIVE | ORIGINAL,
            });
            for (corner, &v) in (3 * t..).zip(wedges) {
                let [first, last] = &mut ends[v as usize];
                match *last {
                    NONE => *first = corner,
                    last => *next(&mut all, last) = corner,
                }
                *last = corner;
            }
        }
        let live = all.len() as u32;
        Self { all, ends, live, tree: input.tree.clone(), in_tree: live }
    }

    /// Reads what the steps of some records will need: their faces lie anywhere in memory, and many
    /// reads that do not wait for each other take little longer than one.
    /// `touch` reads a sample.
    pub(crate) fn read_ahead(
        &self,
        input: &Input,
        records: Range<u32>,
        touch: impl Fn(u32) -> u32,
    ) {
        let mut corners: Vec<u32> = records.map(|v| self.ends[v as usize][0]).collect();
        let mut word = 0;
        for _ in 0..FAN {
            for corner in &mut corners {
                let Some(face) = self.all.get(*corner as usize / 3) else { continue };
                word ^= touch(face.first_sample) ^ self.tree.touch(*corner / 3);
                for point in face.points {
                    word ^= input.places[point as usize][0].to_bits();
                }
                *corner = face.next[*corner as usize % 3];
            }
        }
        std::hint::black_box(word);
    }

    /// Applies a step: the vertices `moves` turn into others.
    pub(crate) fn apply(
        &mut self,
        input: &Input,
        moves: impl Iterator<Item = (u32, u32)>,
        changes: &mut Changes,
    ) {
        changes.touched.clear();
        changes.changed.clear();
        changes.sources.clear();
        changes.targets.clear();
        for (from, to) in moves {
            self.move_vertex(input, from, to, changes);
        }
        for &t in &changes.touched {
            let face = &mut self.all[t as usize];
            face.flags &= !TOUCHED;
            let points = face.points;
            if is_degenerate(points.map(|p| input.positions[p as usize])) {
                face.flags &= !LIVE;
                self.live -= 1;
                self.tree.remove(t, |t| self.all[t as usize].is_live());
                continue;
            }
            changes.changed.push(t);
            let few = changes.targets.len() <= 8;
            for point in points {
                if !few || changes.targets.contains(&point) {
                    self.tree.grow(t, input.places[point as usize]);
                }
            }
        }
        if self.live > 0 && self.live <= self.in_tree / 2 {
            self.rebuild(input);
        }
    }

    fn move_vertex(&mut self, input: &Input, from: u32, to: u32, changes: &mut Changes) {
        let (old, new) = (input.point_of[from as usize], input.point_of[to as usize]);
        if old != new && changes.targets.last() != Some(&new) {
            changes.targets.push(new);
        }
        if old != new && changes.sources.last() != Some(&old) {
            changes.sources.push(old);
        }
        // Dead faces leave the list here.
        let (mut first, mut last) = (NONE, NONE);
        let mut corner = self.ends[from as usize][0];
        while corner != NONE {
            let (t, c) = (corner / 3, corner as usize % 3);
            let face = &mut self.all[t as usize];
            let following = face.next[c];
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
        let ends = &mut self.ends[to as usize];
        match ends[1] {
            NONE => ends[0] = first,
            end => *next(&mut self.all, end) = first,
        }
        ends[1] = last;
    }

    fn rebuild(&mut self, input: &Input) {
        let corners = |t: u32| self.all[t as usize].points.map(|p| input.places[p as usize]);
        let live = self.tree.triangles().filter(|&t| self.all[t as usize].is_live());
        let order = morton_order(live, corners);
        self.tree = MovingTree::of(order, self.all.len(), corners);
        self.in_tree = self.live;
    }

    /// The live faces, and a tree over them.
    pub(crate) fn level<'a>(&'a self, input: &'a Input) -> (Level<'a>, &'a MovingTree) {
        (Level { input, faces: &self.all }, &self.tree)
    }
}

#[inline]
fn next(faces: &mut [Face], corner: u32) -> &mut u32 {
    &mut faces[corner as usize / 3].next[corner as usize % 3]
}

/// The current level as the tree sees it.
pub(crate) struct Level<'a> {
    input: &'a Input,
    faces: &'a [Face],
}

impl Triangles for Level<'_> {
    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.input.at(self.faces[triangle as usize].points)
    }
    #[inline]
    fn is_live(&self, triangle: u32) -> bool {
        self.faces[triangle as usize].is_live()
    }
}
