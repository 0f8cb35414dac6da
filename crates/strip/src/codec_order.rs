//! Triangle order for the index codec of EXT_meshopt_compression, greedily by price: each triangle
//! at an edge that the codec still remembers, so that most take one byte, and each new vertex next
//! to the last ones, so that differences between neighbours in the vertex buffer are small.

use crate::order::renumbered;
use lodc_mesh::{Mesh, is_degenerate};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Recent edges that the codec can name (its edge FIFO has 16 entries, one code is taken).
const MAX_RECENT_EDGES: usize = 15;
/// Recent vertices that the codec can name.
const MAX_RECENT_VERTICES: u32 = 12;

// The price of a triangle: about the bytes that the codec takes for it, and what it may cost later.
// Found by trying, on four models.
/// A vertex that has not been seen yet, or is no longer remembered.
const NOT_REMEMBERED: f32 = 1.5;
/// Per edge that is more recent than the triangle's.
const EDGE_AGE: f32 = 0.5;
/// Gain for each vertex without triangles to be coded.
const FINISHED: f32 = 0.8;
/// For each triangle that a corner has yet to be in, up to [`MAX_REMAINING`] of them.
const REMAINING: f32 = 0.05;
const MAX_REMAINING: u32 = 8;

/// The mesh's triangles in an order that compresses well. Triangles stay in their submesh, corners
/// in their cyclic order.
#[must_use]
pub fn codec_order(mesh: &Mesh) -> Vec<[u32; 3]> {
    let mut order = greedy_order(mesh.triangles(), mesh.vertex_count());
    let submesh = crate::cover::submesh_of(mesh);
    order.sort_by_key(|&t| submesh[t as usize]);
    order.iter().map(|&t| mesh.triangles()[t as usize]).collect()
}

/// [`codec_order`] for a list of triangles over `vertices` vertices.
#[must_use]
pub fn codec_order_list(triangles: &[[u32; 3]], vertices: usize) -> Vec<[u32; 3]> {
    let (compact, count) = renumbered(triangles, vertices);
    let order = greedy_order(&compact, count);
    order.into_iter().map(|t| triangles[t as usize]).collect()
}

/// The numbers of triangles in the order in which they are coded.
fn greedy_order(triangles: &[[u32; 3]], vertices: usize) -> Vec<u32> {
    let mut state = Codec::new(triangles, vertices);
    let mut order = Vec::with_capacity(triangles.len());
    let mut cursor = 0;
    loop {
        let next =
            state.cheapest_at_recent_edge().or_else(|| state.at_forgotten_edge()).or_else(|| {
                while cursor < triangles.len() && state.done[cursor] {
                    cursor += 1;
                }
                (cursor < triangles.len()).then_some((cursor as u32, None))
            });
        let Some((t, edge)) = next else { return order };
        state.code(t, edge);
        order.push(t);
    }
}

/// A directed edge.
type Edge = [u32; 2];

/// The codec's memory, and the triangles that are yet to be coded.
struct Codec<'a> {
    triangles: &'a [[u32; 3]],
    edges: DirectedEdges,
    done: Vec<bool>,
    /// Number of triangles of each vertex that are not coded yet.
    remaining: Vec<u32>,
    /// When each vertex was remembered last, from 1; 0 for never.
    remembered_at: Vec<u32>,
    /// How many times a vertex was remembered.
    remembered_count: u32,
    /// Recent edges that a next triangle may have, the latest last.
    recent: VecDeque<Edge>,
    /// Edges that were recent, the latest last.
    older: Vec<Edge>,
}

impl<'a> Codec<'a> {
    fn new(triangles: &'a [[u32; 3]], vertices: usize) -> Self {
        let mut remaining = vec![0; vertices];
        triangles.as_flattened().iter().for_each(|&v| remaining[v as usize] += 1);
        Self {
            triangles,
            edges: DirectedEdges::new(triangles, vertices),
            done: vec![false; triangles.len()],
            remaining,
            remembered_at: vec![0; vertices],
            remembered_count: 0,
            recent: VecDeque::with_capacity(MAX_RECENT_EDGES + 3),
            older: Vec::new(),
        }
    }

    fn is_remembered(&self, v: u32) -> bool {
        let at = self.remembered_at[v as usize];
        at > 0 && self.remembered_count - at < MAX_RECENT_VERTICES
    }

    /// Of the triangles at recent edges the one with the lowest price, among equals that at the
    /// latest edge; and that edge.
    fn cheapest_at_recent_edge(&mut self) -> Option<(u32, Option<Edge>)> {
        let mut best: Option<(f32, u32, Edge)> = None;
        for (age, &edge) in self.recent.iter().rev().enumerate() {
            let Some(t) = self.edges.first_undone(edge, &self.done) else { continue };
            let price = self.price(t) + EDGE_AGE * age as f32;
            if best.is_none_or(|(lowest, ..)| price < lowest) {
                best = Some((price, t, edge));
            }
        }
        best.map(|(_, t, edge)| (t, Some(edge)))
    }

    /// The price of a triangle by its corners, see the constants above.
    fn price(&self, t: u32) -> f32 {
        let corner = |v: u32| {
            let remaining = self.remaining[v as usize];
            let new = if self.is_remembered(v) { 0.0 } else { NOT_REMEMBERED };
            let finished = if remaining == 1 { FINISHED } else { 0.0 };
            new - finished + REMAINING * (remaining.saturating_sub(1)).min(MAX_REMAINING) as f32
        };
        let [a, b, c] = self.triangles[t as usize].map(corner);
        a + b + c
    }

    /// A triangle at the latest edge that is no longer recent.
    fn at_forgotten_edge(&mut self) -> Option<(u32, Option<Edge>)> {
        loop {
            let edge = self.older.pop()?;
            if let Some(t) = self.edges.first_undone(edge, &self.done) {
                return Some((t, None));
            }
        }
    }

    /// Codes a triangle, at a recent edge or at none.
    fn code(&mut self, t: u32, edge: Option<Edge>) {
        self.done[t as usize] = true;
        let [a, b, c] = self.triangles[t as usize];
        for v in [a, b, c] {
            self.remaining[v as usize] -= 1;
            if !self.is_remembered(v) {
                self.remembered_count += 1;
                self.remembered_at[v as usize] = self.remembered_count;
            }
        }
        // The codec leaves the edge that was used where it is, and pushes the two others, the other
        // way round as a neighbour has them.
        let first = [[a, b], [b, c], [c, a]].iter().position(|&e| Some(e) == edge);
        let rotated = [[a, b, c], [b, c, a], [c, a, b]][first.unwrap_or(0)];
        let [a, b, c] = rotated;
        if edge.is_none() {
            self.recent.push_back([b, a]);
        }
        self.recent.extend([[c, b], [a, c]]);
        while self.recent.len() > MAX_RECENT_EDGES {
            self.older.extend(self.recent.pop_front());
        }
    }
}

/// Triangles by their directed edges.
struct DirectedEdges {
    /// The first entry of each start, and the end.
    first: Vec<u32>,
    /// Start, end and triangle, sorted.
    entries: Vec<[u32; 3]>,
    /// At the start of a run of entries with one edge: the first whose triangle may not be coded
    /// yet.
    next: Vec<u32>,
}

impl DirectedEdges {
    fn new(triangles: &[[u32; 3]], vertices: usize) -> Self {
        let with_distinct_corners = (0..).zip(triangles).filter(|(_, t)| !is_degenerate(**t));
        let mut entries: Vec<[u32; 3]> = with_distinct_corners
            .flat_map(|(i, &[a, b, c])| [[a, b, i], [b, c, i], [c, a, i]])
            .collect();
        entries.par_sort_unstable();
        let mut first = vec![0; vertices + 1];
        entries.iter().for_each(|e| first[e[0] as usize + 1] += 1);
        for v in 0..vertices {
            first[v + 1] += first[v];
        }
        let next = (0..entries.len() as u32).collect();
        Self { first, entries, next }
    }

    /// The first triangle with an edge that is not done.
    fn first_undone(&mut self, [from, to]: Edge, done: &[bool]) -> Option<u32> {
        let [start, end] = [0, 1].map(|k| self.first[from as usize + k] as usize);
        let run = start + self.entries[start..end].partition_point(|e| e[1] < to);
        if run == end {
            return None;
        }
        let next = &mut self.next[run];
        while (*next as usize) < end && self.entries[*next as usize][1] == to {
            let t = self.entries[*next as usize][2];
            if !done[t as usize] {
                return Some(t);
            }
            *next += 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::OrientedTriangle;

    #[test]
    fn every_triangle_comes_once() {
        for (name, make) in lodc_fixtures::ALL {
            let mesh = make();
            let sorted = |triangles: &[[u32; 3]]| {
                let mut all: Vec<_> =
                    triangles.iter().map(|&t| OrientedTriangle::new(0, t)).collect();
                all.sort_unstable();
                all
            };
            assert_eq!(sorted(&codec_order(&mesh)), sorted(mesh.triangles()), "{name}");
        }
    }

    #[test]
    fn a_triangle_follows_a_neighbour() {
        let mesh = lodc_fixtures::torus();
        let order = codec_order(&mesh);
        let shares =
            |pair: &&[[u32; 3]]| pair[0].iter().filter(|v| pair[1].contains(v)).count() == 2;
        let sharing = order.windows(2).filter(shares).count();
        assert!(sharing * 10 > order.len() * 8, "{sharing} of {}", order.len());
    }

    #[test]
    fn many_triangles_may_share_an_edge() {
        let fan: Vec<[u32; 3]> = (2..300_000).map(|v| [0, 1, v]).collect();
        assert_eq!(codec_order_list(&fan, 300_000).len(), fan.len());
    }
}
