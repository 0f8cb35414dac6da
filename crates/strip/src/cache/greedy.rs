//! The first strips for a vertex cache: after each strip, every strip that could begin at a cached
//! vertex is tried.
//!
//! Candidates run straight (without swaps), up to a length. Each prefix of each is judged by what
//! it fetches, by its indices, by the vertices it finishes and by those it evicts from the cache
//! although they will be needed again. All bookkeeping is by counters, so a step of a candidate
//! costs a few nanoseconds whatever the size of the mesh.

use super::parts::Part;
use crate::adjacency::{code, decode};
use crate::cover::{Cover, is_none};
use crate::draw_state::{DrawState, Reference};

/// The weights of a candidate's score, in fetched vertices. Found by a search over three scans.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    /// Per index.
    pub(crate) index: f32,
    /// Per vertex that is evicted with triangles to be drawn.
    pub(crate) evicted: f32,
    /// Gain for each vertex that has no triangles to be drawn afterwards.
    pub(crate) finished: f32,
    /// Gain for each triangle.
    pub(crate) triangle: f32,
    /// Longest strip, in triangles.
    pub(crate) longest: usize,
    /// Number of corners of the first triangle that must be in the cache.
    pub(crate) cached: usize,
    /// Number of first triangles that are tried, those at the vertices that leave the cache next
    /// first: more gain nothing that can be measured.
    pub(crate) tried: usize,
}

struct Candidate {
    score: f32,
    start: u32,
    leave: u32,
    length: usize,
}

struct Greedy<'a> {
    state: DrawState<'a>,
    cover: &'a Cover,
    weights: Weights,
    /// For each triangle, the number of the search that has tried it.
    tried: Vec<u32>,
}

/// Makes strips of a part; returns their paths in drawing order, as codes of the mesh.
pub(super) fn paths(part: &Part, size: u32, weights: Weights) -> Vec<Vec<u32>> {
    let state = DrawState::new(&part.triangles, part.vertices, size);
    let tried = vec![0; part.triangles.len()];
    let mut greedy = Greedy { state, cover: &part.cover, weights, tried };
    let mut paths = Vec::new();
    let mut cursor = 0;
    for search in 1.. {
        let mut best = greedy.near_the_cache(search);
        if best.is_none()
            && let Some(v) = greedy.state.last_unfinished()
        {
            best = greedy.near_vertex(v);
        }
        while best.is_none() && cursor < part.triangles.len() {
            if !greedy.state.done[cursor] {
                best = greedy.try_from(cursor as u32, None);
            }
            cursor += 1;
        }
        let Some(best) = best else { break };
        let mut path = Vec::with_capacity(best.length);
        greedy.take(&best, |t, slot| path.push(code(part.of[t as usize], slot)));
        paths.push(path);
    }
    paths
}

impl Greedy<'_> {
    fn near_the_cache(&mut self, search: u32) -> Option<Candidate> {
        let mut best = None;
        let mut count = 0;
        for miss in self.state.recent() {
            let Some(v) = self.state.live(miss) else { continue };
            if count >= self.weights.tried {
                break;
            }
            for i in self.state.unfinished(v) {
                let t = self.state.incident(i);
                if self.state.done[t as usize] || self.tried[t as usize] == search {
                    continue;
                }
                self.tried[t as usize] = search;
                let corners = self.state.triangles[t as usize];
                let cached = corners.iter().filter(|&&v| self.state.is_cached(v)).count();
                if cached >= self.weights.cached {
                    best = self.try_from(t, best);
                    count += 1;
                }
            }
        }
        best
    }
    fn near_vertex(&mut self, v: u32) -> Option<Candidate> {
        let mut best = None;
        for i in self.state.unfinished(v) {
            let t = self.state.incident(i);
            if !self.state.done[t as usize] {
                best = self.try_from(t, best);
            }
        }
        best
    }
    fn try_from(&mut self, t: u32, mut best: Option<Candidate>) -> Option<Candidate> {
        for leave in 0..3 {
            self.simulate(t, leave, &mut best);
        }
        best
    }
    /// Runs along a candidate, keeps its best prefix if it is better than the best so far, and
    /// takes everything back.
    fn simulate(&mut self, start: u32, leave: u32, best: &mut Option<Candidate>) {
        let w = self.weights;
        let t = self.state.triangles[start as usize];
        let corner = |slot: u32| t[slot as usize % 3];
        let mut cost =
            2.0 * w.index + self.reference(corner(leave + 2)) + self.reference(corner(leave));
        let mut new = corner(leave + 1);
        let (mut at, mut slot) = (start, leave);
        for length in 1.. {
            cost += w.index - w.triangle + self.reference(new);
            cost -= w.finished * self.state.draw(at) as f32;
            if best.as_ref().is_none_or(|b| cost < b.score) {
                *best = Some(Candidate { score: cost, start, leave, length });
            }
            let next = self.cover.neighbour(at, slot);
            if length >= w.longest || is_none(next) || self.state.done[decode(next).0 as usize] {
                break;
            }
            (at, slot, new) = self.step(next, length);
        }
        self.state.undo();
    }
    /// The triangle behind a code as the `n`-th of a straight strip, counted from 0; the slot
    /// through which the strip leaves it, and its new corner.
    fn step(&self, next: u32, n: usize) -> (u32, u32, u32) {
        let (u, entered) = decode(next);
        let leave = (entered + if n % 2 == 1 { 2 } else { 1 }) % 3;
        (u, leave, self.state.triangles[u as usize][(entered as usize + 2) % 3])
    }
    /// References a vertex. Returns the cost.
    fn reference(&mut self, v: u32) -> f32 {
        match self.state.reference(v) {
            Reference::Hit => 0.0,
            Reference::Miss => 1.0,
            Reference::MissEvicting => 1.0 + self.weights.evicted,
        }
    }
    /// Draws a candidate: `visit` gets its triangles and the slot through which each is left, 3 for
    /// the last.
    fn take(&mut self, best: &Candidate, mut visit: impl FnMut(u32, u32)) {
        let t = self.state.triangles[best.start as usize];
        let corner = |slot: u32| t[slot as usize % 3];
        self.reference(corner(best.leave + 2));
        self.reference(corner(best.leave));
        let mut new = corner(best.leave + 1);
        let (mut at, mut slot) = (best.start, best.leave);
        for n in 1..=best.length {
            self.reference(new);
            self.state.draw(at);
            visit(at, if n < best.length { slot } else { 3 });
            if n < best.length {
                (at, slot, new) = self.step(self.cover.neighbour(at, slot), n);
            }
        }
        self.state.commit();
    }
}
