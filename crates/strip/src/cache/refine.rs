//! Improves strips for a vertex cache: runs the local search of `window` along the whole drawing
//! order, cut into chunks that do not depend on each other, and within a chunk over stretches that
//! overlap by half.

use super::paths::{Strip, Surface};
use super::window::{Schedule, Stretch, Workspace};
use crate::adjacency::{Neighbours, code, decode};
use crate::anneal::generator;
use crate::cover::{is_none, write_path};
use crate::meter::Meter;
use lodc_mesh::{NONE, SplitMix64};
use rayon::prelude::*;
use std::collections::VecDeque;
use std::ops::Range;

/// Triangles of a chunk, roughly: what a thread works on at a time, small enough for its cache.
/// Strips never cross chunks. Chosen by hand.
const CHUNK_TRIANGLES: usize = 1 << 12;
/// Indices that are drawn before a stretch so that the cache holds what it would: ten caches' worth
/// at the default size, since most indices are hits. Not exact for larger caches, which only makes
/// the search aim a little off.
const MIN_HEAD: usize = 160;
/// Indices after a stretch whose misses count for it: three caches' worth at the default size.
const TAIL_INDICES: usize = 48;

/// The drawing order that is improved: strips as paths of codes, each a triangle with the slot
/// through which the path leaves it, 3 at the end.
pub(crate) struct Drawing<'a> {
    pub(crate) paths: &'a [Vec<u32>],
    pub(crate) triangles: &'a [[u32; 3]],
    pub(crate) neighbours: &'a Neighbours,
}

/// The aim of the search, and the time that it takes.
pub(crate) struct Goal {
    /// Number of vertices that the cache holds.
    pub(crate) cache_size: u32,
    pub(crate) schedules: &'static [Schedule],
}

/// A finished strip, in the numbers of the mesh.
pub(crate) struct FinishedStrip {
    pub(crate) first_triangle: u32,
    pub(crate) indices: Vec<u32>,
}

/// Improves strips and returns them as indices.
pub(crate) fn refine(drawing: &Drawing<'_>, goal: &Goal, meter: &Meter<'_>) -> Vec<FinishedStrip> {
    let chunks = Chunks::new(drawing);
    let improved = |number: usize| {
        let mut chunk = chunks.chunk(number);
        let mut random = generator(number as u64);
        for schedule in goal.schedules {
            chunk.improve(goal, schedule, &mut random);
        }
        meter.add(chunk.triangles.len());
        chunk.in_mesh_numbers()
    };
    let done: Vec<Vec<FinishedStrip>> =
        (0..chunks.ranges.len()).into_par_iter().map(improved).collect();
    done.into_iter().flatten().collect()
}

/// The drawing order, cut.
struct Chunks<'a> {
    drawing: &'a Drawing<'a>,
    /// The paths of each chunk.
    ranges: Vec<Range<usize>>,
    /// For each triangle its chunk, and its number there.
    chunk_of: Vec<u32>,
    index_in_chunk: Vec<u32>,
}

impl<'a> Chunks<'a> {
    fn new(drawing: &'a Drawing<'a>) -> Self {
        let (mut ranges, mut start, mut triangles) = (Vec::new(), 0, 0);
        for (i, path) in drawing.paths.iter().enumerate() {
            triangles += path.len();
            if triangles >= CHUNK_TRIANGLES || i + 1 == drawing.paths.len() {
                ranges.push(start..i + 1);
                (start, triangles) = (i + 1, 0);
            }
        }
        let none = vec![NONE; drawing.triangles.len()];
        let (mut chunk_of, mut index_in_chunk) = (none.clone(), none);
        for (number, range) in ranges.iter().enumerate() {
            for (i, &c) in drawing.paths[range.clone()].iter().flatten().enumerate() {
                chunk_of[decode(c).0 as usize] = number as u32;
                index_in_chunk[decode(c).0 as usize] = i as u32;
            }
        }
        Self { drawing, ranges, chunk_of, index_in_chunk }
    }

    /// The indices of a path as it is drawn now.
    fn indices(&self, path: &[u32]) -> Vec<u32> {
        let mut indices = Vec::new();
        let neighbour = |t: u32, slot: u32| self.drawing.neighbours[t as usize][slot as usize];
        write_path(path, self.drawing.triangles, neighbour, &mut indices);
        indices
    }

    /// The indices drawn before a path: at least [`MIN_HEAD`], as far as there are any, since each
    /// triangle takes at least one.
    fn head(&self, path: usize) -> Vec<u32> {
        let (mut first, mut triangles) = (path, 0);
        while first > 0 && triangles < MIN_HEAD {
            first -= 1;
            triangles += self.drawing.paths[first].len();
        }
        self.drawing.paths[first..path].iter().flat_map(|path| self.indices(path)).collect()
    }

    /// The [`TAIL_INDICES`] indices that are drawn from a path on.
    fn tail(&self, path: usize) -> Vec<u32> {
        let paths = self.drawing.paths[path..].iter().take(TAIL_INDICES);
        paths.flat_map(|path| self.indices(path)).take(TAIL_INDICES).collect()
    }

    /// A chunk, with triangles and vertices numbered by itself.
    fn chunk(&self, number: usize) -> Chunk {
        let range = self.ranges[number].clone();
        let paths = &self.drawing.paths[range.clone()];
        let corners = |t: u32| self.drawing.triangles[t as usize];
        let triangles: Vec<u32> = paths.iter().flatten().map(|&c| decode(c).0).collect();
        let (mut head, mut tail) = (self.head(range.start), self.tail(range.end));
        let mut vertices: Vec<u32> = triangles.iter().flat_map(|&t| corners(t)).collect();
        vertices.extend(head.iter().chain(&tail));
        vertices.sort_unstable();
        vertices.dedup();
        let local =
            |v: u32| vertices.binary_search(&v).expect("gathered from the same triangles") as u32;
        head.iter_mut().chain(&mut tail).for_each(|v| *v = local(*v));
        let local_neighbour = |c: u32| {
            let (u, slot) = decode(c);
            let inside = !is_none(c) && self.chunk_of[u as usize] == number as u32;
            if inside { code(self.index_in_chunk[u as usize], slot) } else { NONE }
        };
        let neighbours = |&t: &u32| self.drawing.neighbours[t as usize].map(local_neighbour);
        let surface = Surface {
            triangles: triangles.iter().map(|&t| corners(t).map(local)).collect(),
            neighbours: triangles.iter().map(neighbours).collect(),
        };
        let strip = |path: &Vec<u32>| {
            let renumbered =
                |&c: &u32| code(self.index_in_chunk[decode(c).0 as usize], decode(c).1);
            let path: Vec<u32> = path.iter().map(renumbered).collect();
            let mut indices = Vec::with_capacity(path.len() + 4);
            surface.write_indices(&path, &mut indices);
            Strip { path, indices }
        };
        let strips = paths.iter().map(strip).collect();
        Chunk { triangles, vertices, surface, strips, head, tail }
    }
}

/// Strips that are improved by themselves.
struct Chunk {
    /// The triangles and vertices of the mesh, by their numbers here.
    triangles: Vec<u32>,
    vertices: Vec<u32>,
    surface: Surface,
    strips: Vec<Strip>,
    /// Indices that are drawn before the chunk and after it.
    head: Vec<u32>,
    tail: Vec<u32>,
}

impl Chunk {
    /// Searches in stretches that overlap by half.
    fn improve(&mut self, goal: &Goal, schedule: &Schedule, random: &mut SplitMix64) {
        let (vertices, size) = (self.vertices.len(), goal.cache_size);
        let mut workspace = Workspace::new(&self.surface, vertices, size, random);
        let mut done: Vec<Strip> = Vec::new();
        let mut waiting: VecDeque<Strip> = std::mem::take(&mut self.strips).into();
        let mut stretch: Vec<Strip> = Vec::new();
        // Each triangle is in two stretches.
        let half = Schedule { proposals: schedule.proposals / 2.0, ..*schedule };
        loop {
            let mut triangles: usize = stretch.iter().map(|s| s.path.len()).sum();
            while triangles < schedule.stretch {
                let Some(s) = waiting.pop_front() else { break };
                triangles += s.path.len();
                stretch.push(s);
            }
            let (head, tail) = (head_of(&done, &self.head), tail_of(&waiting, &self.tail));
            stretch = Stretch::new(&mut workspace, stretch, &head, tail).search(&half);
            if waiting.is_empty() {
                break;
            }
            let (mut finished_strips, mut finished) = (0, 0);
            while finished_strips < stretch.len() && finished < triangles / 2 {
                finished += stretch[finished_strips].path.len();
                finished_strips += 1;
            }
            done.extend(stretch.drain(..finished_strips));
        }
        done.extend(stretch);
        self.strips = done;
    }

    /// The strips with the numbers of the mesh.
    fn in_mesh_numbers(&self) -> Vec<FinishedStrip> {
        let finished = |s: &Strip| {
            let first_triangle = self.triangles[decode(s.path[0]).0 as usize];
            let indices = s.indices.iter().map(|&v| self.vertices[v as usize]).collect();
            FinishedStrip { first_triangle, indices }
        };
        self.strips.iter().map(finished).collect()
    }
}

/// At least [`MIN_HEAD`] indices drawn before a stretch, as far as there are any.
fn head_of(done: &[Strip], head: &[u32]) -> Vec<u32> {
    let (mut first, mut length) = (done.len(), 0);
    while first > 0 && length < MIN_HEAD {
        first -= 1;
        length += done[first].indices.len();
    }
    let head = if first == 0 { head } else { &[] };
    head.iter().chain(done[first..].iter().flat_map(|s| &s.indices)).copied().collect()
}

/// The [`TAIL_INDICES`] indices that are drawn after a stretch.
fn tail_of(waiting: &VecDeque<Strip>, tail: &[u32]) -> Vec<u32> {
    let strips = waiting.iter().take(TAIL_INDICES).flat_map(|s| &s.indices);
    strips.chain(tail).take(TAIL_INDICES).copied().collect()
}
