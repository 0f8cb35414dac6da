//! The first strips for a vertex cache: after each strip, every strip that could begin at a cached vertex is tried.
//!
//! Candidates run straight (without swaps), up to a length. Each prefix of each is judged by what it fetches, by its
//! indices, by the vertices it finishes and by those it throws out of the cache although they will be needed again.
//! All bookkeeping is by counters, so a step of a candidate costs a few nanoseconds whatever the size of the mesh.

use crate::adjacency::{code, decode, is_degenerate};
use crate::cover::{Cover, is_none};

/// What a candidate is judged by, in fetched vertices. Found by a search over three scans.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    /// Per index.
    pub(crate) index: f32,
    /// Per vertex that is thrown out with triangles left.
    pub(crate) evicted: f32,
    /// Per vertex without triangles left (for).
    pub(crate) finished: f32,
    /// Per triangle (for).
    pub(crate) triangle: f32,
    /// Longest strip, in triangles.
    pub(crate) longest: usize,
    /// How many corners of the first triangle must be in the cache.
    pub(crate) cached: usize,
}

/// How many entries of a vertex's list of triangles are looked at for candidates.
const LOOK: usize = 24;

#[derive(Clone, Copy, Default)]
struct Vertex {
    /// The number of the miss that fetched it last, from 1; 0 for never.
    fetched: u32,
    /// How many triangles it still has.
    left: u32,
}

struct Candidate {
    score: f32,
    start: u32,
    leave: u32,
    length: usize,
}

struct Greedy<'a> {
    triangles: &'a [[u32; 3]],
    cover: &'a mut Cover,
    size: u32,
    weights: Weights,
    vertices: Vec<Vertex>,
    /// Triangles of each vertex; those before `first_left` are done.
    incident: Vec<u32>,
    first_left: Vec<u32>,
    last: Vec<u32>,
    /// The vertex of each miss.
    history: Vec<u32>,
    /// Vertices to go back to when nothing in the cache has triangles left.
    behind: Vec<u32>,
    done: Vec<bool>,
    /// For each triangle, the number of the search that has tried it.
    tried: Vec<u32>,
    /// Undo lists of a simulation.
    path: Vec<u32>,
    before: Vec<(u32, u32)>,
}

/// Links triangles to strips; returns the strips in drawing order, as the code of the first triangle and the slot through
/// which it is left (slot 3 for a single triangle).
pub(crate) fn strips(
    triangles: &[[u32; 3]],
    vertex_count: usize,
    cover: &mut Cover,
    size: u32,
    weights: Weights,
) -> Vec<u32> {
    let mut greedy = Greedy::new(triangles, vertex_count, cover, size, weights);
    let mut strips = Vec::new();
    let mut cursor = 0;
    let mut search = 0;
    loop {
        search += 1;
        let mut best = greedy.near_the_cache(search);
        while best.is_none() {
            let Some(v) = greedy.behind.pop() else { break };
            best = greedy.near_vertex(v);
        }
        while best.is_none() && cursor < triangles.len() {
            if !greedy.done[cursor] {
                best = greedy.try_from(cursor as u32, None);
            }
            cursor += 1;
        }
        let Some(best) = best else { return strips };
        strips.push(greedy.take(&best));
    }
}

impl<'a> Greedy<'a> {
    fn new(triangles: &'a [[u32; 3]], vertex_count: usize, cover: &'a mut Cover, size: u32, weights: Weights) -> Self {
        let mut vertices = vec![Vertex::default(); vertex_count];
        let real = || triangles.iter().enumerate().filter(|(_, t)| !is_degenerate(**t));
        for v in real().flat_map(|(_, t)| t) {
            vertices[*v as usize].left += 1;
        }
        let mut sum = 0;
        let first_left: Vec<u32> = vertices
            .iter()
            .map(|v| {
                sum += v.left;
                sum - v.left
            })
            .collect();
        let mut last = first_left.clone();
        let mut incident = vec![0; sum as usize];
        for (i, t) in real() {
            for &v in t {
                incident[last[v as usize] as usize] = i as u32;
                last[v as usize] += 1;
            }
        }
        Self {
            triangles,
            cover,
            size,
            weights,
            vertices,
            incident,
            first_left,
            last,
            history: Vec::new(),
            behind: Vec::new(),
            done: triangles.iter().map(|&t| is_degenerate(t)).collect(),
            tried: vec![0; triangles.len()],
            path: Vec::new(),
            before: Vec::new(),
        }
    }
    fn is_cached(&self, v: u32) -> bool {
        let fetched = self.vertices[v as usize].fetched;
        fetched != 0 && self.history.len() as u32 - fetched < self.size
    }
    fn near_the_cache(&mut self, search: u32) -> Option<Candidate> {
        let mut best = None;
        let from = self.history.len().saturating_sub(self.size as usize);
        for miss in from..self.history.len() {
            let v = self.history[miss];
            if self.vertices[v as usize].left == 0 || self.vertices[v as usize].fetched != miss as u32 + 1 {
                continue;
            }
            let (first, end) = self.left(v);
            for i in first..end {
                let t = self.incident[i];
                if self.done[t as usize] || self.tried[t as usize] == search {
                    continue;
                }
                self.tried[t as usize] = search;
                let cached = self.triangles[t as usize].iter().filter(|&&v| self.is_cached(v)).count();
                if cached >= self.weights.cached {
                    best = self.try_from(t, best);
                }
            }
        }
        best
    }
    /// A bounded part of a vertex's triangles, beginning with the first that is not done.
    fn left(&mut self, v: u32) -> (usize, usize) {
        let (mut first, last) = (self.first_left[v as usize] as usize, self.last[v as usize] as usize);
        while first < last && self.done[self.incident[first] as usize] {
            first += 1;
        }
        self.first_left[v as usize] = first as u32;
        (first, last.min(first + LOOK))
    }
    fn near_vertex(&mut self, v: u32) -> Option<Candidate> {
        let (first, end) = self.left(v);
        let mut best = None;
        for i in first..end {
            let t = self.incident[i];
            if !self.done[t as usize] {
                best = self.try_from(t, best);
            }
        }
        if best.is_some() {
            // There may be more here for the next time.
            self.behind.push(v);
        }
        best
    }
    fn try_from(&mut self, t: u32, mut best: Option<Candidate>) -> Option<Candidate> {
        for leave in 0..3 {
            self.simulate(t, leave, &mut best);
        }
        best
    }
    /// Runs along a candidate, keeps its best prefix if it is better than the best so far, and takes everything back.
    fn simulate(&mut self, start: u32, leave: u32, best: &mut Option<Candidate>) {
        let w = self.weights;
        let misses = self.history.len();
        self.path.clear();
        self.before.clear();
        let t = self.triangles[start as usize];
        let corner = |slot: u32| t[slot as usize % 3];
        let mut cost = 2.0 * w.index;
        for slot in [leave + 2, leave] {
            cost += self.touch(corner(slot));
        }
        let mut new = corner(leave + 1);
        let (mut at, mut slot) = (start, leave);
        loop {
            cost += w.index - w.triangle + self.touch(new);
            self.path.push(at);
            self.done[at as usize] = true;
            for v in self.triangles[at as usize] {
                let left = &mut self.vertices[v as usize].left;
                *left -= 1;
                if *left == 0 {
                    cost -= w.finished;
                }
            }
            if best.as_ref().is_none_or(|b| cost < b.score) {
                *best = Some(Candidate { score: cost, start, leave, length: self.path.len() });
            }
            let next = self.cover.neighbour(at, slot);
            if self.path.len() >= w.longest || is_none(next) {
                break;
            }
            let (u, entered) = decode(next);
            if self.done[u as usize] {
                break;
            }
            new = self.triangles[u as usize][(entered as usize + 2) % 3];
            slot = leave_by(entered, self.path.len());
            at = u;
        }
        for &t in &self.path {
            self.done[t as usize] = false;
            for v in self.triangles[t as usize] {
                self.vertices[v as usize].left += 1;
            }
        }
        for &(v, fetched) in self.before.iter().rev() {
            self.vertices[v as usize].fetched = fetched;
        }
        self.history.truncate(misses);
    }
    /// Asks the cache for a vertex and says what that costs.
    fn touch(&mut self, v: u32) -> f32 {
        if self.is_cached(v) {
            return 0.0;
        }
        let mut cost = 1.0;
        if let Some(out) = self.history.len().checked_sub(self.size as usize) {
            let gone = self.vertices[self.history[out] as usize];
            if gone.fetched == out as u32 + 1 && gone.left > 0 {
                cost += self.weights.evicted;
            }
        }
        let vertex = &mut self.vertices[v as usize];
        self.before.push((v, vertex.fetched));
        self.history.push(v);
        vertex.fetched = self.history.len() as u32;
        cost
    }
    /// Makes a candidate a strip.
    fn take(&mut self, best: &Candidate) -> u32 {
        let first_miss = self.history.len();
        let t = self.triangles[best.start as usize];
        let corner = |slot: u32| t[slot as usize % 3];
        self.touch(corner(best.leave + 2));
        self.touch(corner(best.leave));
        let mut new = corner(best.leave + 1);
        let (mut at, mut slot) = (best.start, best.leave);
        for n in 1..=best.length {
            self.touch(new);
            self.done[at as usize] = true;
            for v in self.triangles[at as usize] {
                self.vertices[v as usize].left -= 1;
            }
            if n < best.length {
                let (u, entered) = decode(self.cover.neighbour(at, slot));
                self.cover.toggle(at, slot);
                new = self.triangles[u as usize][(entered as usize + 2) % 3];
                slot = leave_by(entered, n);
                at = u;
            }
        }
        self.before.clear();
        for i in first_miss..self.history.len() {
            self.behind.push(self.history[i]);
        }
        code(best.start, if best.length == 1 { 3 } else { best.leave })
    }
}

/// The slot through which a straight strip leaves its `n`-th triangle, counted from 0.
fn leave_by(entered: u32, n: usize) -> u32 {
    (entered + if n % 2 == 1 { 2 } else { 1 }) % 3
}
