//! The first strips for a vertex cache, by a greedy search: after each strip, candidates that begin
//! at cached vertices are simulated, and the best prefix of any becomes the next strip.
//!
//! Candidates run straight, up to a length. Each prefix is scored by the vertices it fetches, its
//! indices, the vertices it finishes, and those it evicts from the cache although triangles still
//! need them. All is kept in counters that can be undone, so a step of a candidate costs a few
//! nanoseconds whatever the size of the mesh.
//!
//! A slot is one of a triangle's three edges: slot `e` runs from corner `e` to corner `e + 1`. A
//! code is a triangle with a slot (`adjacency`). A strip is straight if it turns left and right
//! alternately; two turns to the same side would need a swap, one repeated index (`cover`).

use super::parts::Part;
use crate::adjacency::{code, decode};
use crate::cover::{Cover, is_none};
use crate::draw_state::{DrawState, Reference};

/// The weights of a candidate's score, in fetched vertices; the lowest score wins.
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
    pub(crate) max_length: usize,
    /// Number of corners of the first triangle that must be in the cache, at least.
    pub(crate) min_cached: usize,
    /// Number of first triangles that are tried, in the order in which their vertices will leave
    /// the cache: more gain nothing that can be measured.
    pub(crate) max_tried: usize,
}

/// A straight strip that could be drawn next.
struct Candidate {
    score: f32,
    /// The first triangle, and the slot through which the strip leaves it.
    start: u32,
    exit: u32,
    /// Number of triangles.
    length: usize,
}

/// A triangle of a straight strip.
#[derive(Clone, Copy)]
struct StripTriangle {
    triangle: u32,
    /// The slot through which the strip leaves it.
    exit: u32,
    /// The corner that the triangle before it does not have.
    new: u32,
}

struct Greedy<'a> {
    state: DrawState<'a>,
    cover: &'a Cover,
    weights: Weights,
    /// For each triangle, the number of the search that has tried it last.
    tried_by: Vec<u32>,
}

/// Makes strips of a part; returns their paths in drawing order: for each triangle a code of its
/// number in the mesh and the slot through which the path leaves it, 3 for the last.
pub(super) fn paths(part: &Part, size: u32, weights: Weights) -> Vec<Vec<u32>> {
    let state = DrawState::new(&part.triangles, part.vertex_count, size);
    let tried_by = vec![0; part.triangles.len()];
    let mut greedy = Greedy { state, cover: &part.cover, weights, tried_by };
    let mut paths = Vec::new();
    let mut cursor = 0;
    for search in 1.. {
        let mut best = greedy.best_near_cache(search);
        if best.is_none()
            && let Some(v) = greedy.state.last_unfinished()
        {
            best = greedy.best_near_vertex(v);
        }
        while best.is_none() && cursor < part.triangles.len() {
            if !greedy.state.done[cursor] {
                best = greedy.try_start(cursor as u32, None);
            }
            cursor += 1;
        }
        let Some(best) = best else { break };
        let mut path = Vec::with_capacity(best.length);
        greedy
            .draw_candidate(&best, |t, slot| path.push(code(part.triangle_ids[t as usize], slot)));
        paths.push(path);
    }
    paths
}

impl Greedy<'_> {
    /// The best candidate that starts at a cached vertex. `search` numbers the calls, from 1.
    fn best_near_cache(&mut self, search: u32) -> Option<Candidate> {
        let mut best = None;
        let mut count = 0;
        for miss in self.state.recent() {
            let Some(v) = self.state.unfinished_at(miss) else { continue };
            if count >= self.weights.max_tried {
                break;
            }
            for i in self.state.unfinished(v) {
                let t = self.state.incident(i);
                if self.state.done[t as usize] || self.tried_by[t as usize] == search {
                    continue;
                }
                self.tried_by[t as usize] = search;
                let corners = self.state.triangles[t as usize];
                let cached = corners.iter().filter(|&&v| self.state.is_cached(v)).count();
                if cached >= self.weights.min_cached {
                    best = self.try_start(t, best);
                    count += 1;
                }
            }
        }
        best
    }

    /// The best candidate that starts at a vertex.
    fn best_near_vertex(&mut self, v: u32) -> Option<Candidate> {
        let mut best = None;
        for i in self.state.unfinished(v) {
            let t = self.state.incident(i);
            if !self.state.done[t as usize] {
                best = self.try_start(t, best);
            }
        }
        best
    }

    /// Tries the three candidates that start with a triangle; returns the best so far.
    fn try_start(&mut self, t: u32, mut best: Option<Candidate>) -> Option<Candidate> {
        for exit in 0..3 {
            self.simulate(t, exit, &mut best);
        }
        best
    }

    /// Runs along a candidate, keeps its best prefix if it is better than the best so far, and
    /// takes everything back.
    fn simulate(&mut self, start: u32, exit: u32, best: &mut Option<Candidate>) {
        let weights = self.weights;
        let (mut cost, mut last) = self.begin(start, exit);
        for length in 1.. {
            cost += weights.index - weights.triangle + self.reference(last.new);
            cost -= weights.finished * self.state.draw(last.triangle) as f32;
            if best.as_ref().is_none_or(|b| cost < b.score) {
                *best = Some(Candidate { score: cost, start, exit, length });
            }
            let next = self.cover.neighbour(last.triangle, last.exit);
            if length >= weights.max_length
                || is_none(next)
                || self.state.done[decode(next).0 as usize]
            {
                break;
            }
            last = self.next_triangle(next, length);
        }
        self.state.undo();
    }

    /// Draws a candidate: `visit` gets its triangles and the slot through which each is left, 3 for
    /// the last.
    fn draw_candidate(&mut self, best: &Candidate, mut visit: impl FnMut(u32, u32)) {
        let (_, mut last) = self.begin(best.start, best.exit);
        for n in 1..=best.length {
            let StripTriangle { triangle, exit, new } = last;
            self.reference(new);
            self.state.draw(triangle);
            visit(triangle, if n < best.length { exit } else { 3 });
            if n < best.length {
                last = self.next_triangle(self.cover.neighbour(triangle, exit), n);
            }
        }
        self.state.commit();
    }

    /// References the first two vertices of a strip. Returns their cost and the first triangle. The
    /// strip leaves it through the edge from corner `exit` to the next one, so these two come last.
    fn begin(&mut self, start: u32, exit: u32) -> (f32, StripTriangle) {
        let corners = self.state.triangles[start as usize];
        let corner = |number: u32| corners[number as usize % 3];
        let cost = 2.0 * self.weights.index
            + self.reference(corner(exit + 2))
            + self.reference(corner(exit));
        (cost, StripTriangle { triangle: start, exit, new: corner(exit + 1) })
    }

    /// The triangle of a code as the `n`-th of a straight strip, counted from 0. The strip enters
    /// it through the code's slot.
    fn next_triangle(&self, entered: u32, n: usize) -> StripTriangle {
        let (triangle, slot) = decode(entered);
        let exit = (slot + if n % 2 == 1 { 2 } else { 1 }) % 3;
        let new = self.state.triangles[triangle as usize][(slot as usize + 2) % 3];
        StripTriangle { triangle, exit, new }
    }

    /// References a vertex. Returns the cost.
    fn reference(&mut self, v: u32) -> f32 {
        match self.state.reference(v) {
            Reference::Hit => 0.0,
            Reference::Miss => 1.0,
            Reference::MissEvicting => 1.0 + self.weights.evicted,
        }
    }
}
