//! Which triangles share an edge: the dual graph that strips are paths in. Built from half-edges
//! sorted by their vertices, in O(n log n) for any input, non-manifold ones too.
//!
//! In this package `t` and `u` are triangles, `v` is a vertex, a *slot* is one of a triangle's
//! three edges, and a *code* `c` is a triangle with a slot, in one word.

use lodc_mesh::{NONE, is_degenerate};

/// The neighbours of each triangle: slot `e` is the edge from corner `e` to corner `e + 1`. It
/// holds the triangle across that edge, with the slot that the edge has there, as [`code`]; or
/// [`NONE`].
///
/// Two triangles are neighbours only if they run through their edge in opposite directions. Where
/// several do, they are paired off one to one, so that the relation is always symmetric.
pub(crate) type Neighbours = Vec<[u32; 3]>;

/// A slot of a triangle in one word. Meshes have less than 2³⁰ triangles.
#[inline]
pub(crate) fn code(triangle: u32, slot: u32) -> u32 {
    triangle << 2 | slot
}

/// The triangle and the slot of a code.
#[inline]
pub(crate) fn decode(code: u32) -> (u32, u32) {
    (code >> 2, code & 3)
}

/// Finds all neighbours. Half-edges are gathered at their smaller vertex and sorted there, so that
/// even a vertex that every triangle uses costs no more than a sort.
pub(crate) fn neighbours(triangles: &[[u32; 3]], vertex_count: usize) -> Neighbours {
    let mut bucket_start = vec![0u32; vertex_count + 1];
    let edges = |t: [u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    let with_distinct_corners =
        || triangles.iter().enumerate().filter(|(_, t)| !is_degenerate(**t));
    for (_, &t) in with_distinct_corners() {
        for (a, b) in edges(t) {
            bucket_start[a.min(b) as usize + 1] += 1;
        }
    }
    for v in 0..vertex_count {
        bucket_start[v + 1] += bucket_start[v];
    }
    let mut next = bucket_start.clone();
    // For each half-edge its larger vertex and its code, by which it is sorted.
    let mut half_edges = vec![(0u32, 0u32); bucket_start[vertex_count] as usize];
    for (i, &t) in with_distinct_corners() {
        for (slot, (a, b)) in edges(t).into_iter().enumerate() {
            let end = &mut next[a.min(b) as usize];
            half_edges[*end as usize] = (a.max(b), code(i as u32, slot as u32));
            *end += 1;
        }
    }
    let mut neighbours = vec![[NONE; 3]; triangles.len()];
    let mut forward = Vec::new();
    let mut backward = Vec::new();
    for v in 0..vertex_count {
        let bucket = &mut half_edges[bucket_start[v] as usize..bucket_start[v + 1] as usize];
        bucket.sort_unstable();
        for edge in bucket.chunk_by(|a, b| a.0 == b.0) {
            forward.clear();
            backward.clear();
            for &(_, c) in edge {
                let (t, slot) = decode(c);
                let starts_at_v = triangles[t as usize][slot as usize] as usize == v;
                if starts_at_v { forward.push(c) } else { backward.push(c) }
            }
            for (&a, &b) in forward.iter().zip(&backward) {
                let ((t, e), (u, f)) = (decode(a), decode(b));
                neighbours[t as usize][e as usize] = b;
                neighbours[u as usize][f as usize] = a;
            }
        }
    }
    neighbours
}
