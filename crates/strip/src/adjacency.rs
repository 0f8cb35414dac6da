//! Triangles that meet at edges, in near-linear time for any mesh.

use lodc_mesh::{NONE, is_degenerate};

/// The neighbours of each triangle: slot `e` is the edge from corner `e` to corner `e + 1`,
/// and holds the neighbour there with its own slot, as [`code`], or [`NONE`].
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
    let mut first = vec![0u32; vertex_count + 1];
    let edges = |t: [u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    let real = || triangles.iter().enumerate().filter(|(_, t)| !is_degenerate(**t));
    for (_, &t) in real() {
        for (a, b) in edges(t) {
            first[a.min(b) as usize + 1] += 1;
        }
    }
    for v in 0..vertex_count {
        first[v + 1] += first[v];
    }
    let mut next = first.clone();
    // Larger vertex, then direction, then the slot: what sorting needs, in one word each.
    let mut gathered = vec![(0u32, 0u32); first[vertex_count] as usize];
    for (i, &t) in real() {
        for (slot, (a, b)) in edges(t).into_iter().enumerate() {
            let place = &mut next[a.min(b) as usize];
            gathered[*place as usize] = (a.max(b), code(i as u32, slot as u32));
            *place += 1;
        }
    }
    let mut neighbours = vec![[NONE; 3]; triangles.len()];
    let mut there = Vec::new();
    let mut back = Vec::new();
    for v in 0..vertex_count {
        let bucket = &mut gathered[first[v] as usize..first[v + 1] as usize];
        bucket.sort_unstable();
        for edge in bucket.chunk_by(|a, b| a.0 == b.0) {
            there.clear();
            back.clear();
            for &(_, c) in edge {
                let (t, slot) = decode(c);
                let forward = triangles[t as usize][slot as usize] as usize == v;
                if forward { there.push(c) } else { back.push(c) }
            }
            for (&a, &b) in there.iter().zip(&back) {
                let ((t, e), (u, f)) = (decode(a), decode(b));
                neighbours[t as usize][e as usize] = b;
                neighbours[u as usize][f as usize] = a;
            }
        }
    }
    neighbours
}
