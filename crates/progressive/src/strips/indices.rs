//! Strips as index lists that a graphics card draws.
//!
//! ```text
//! triangles   (0 1 2) (2 1 3) (2 3 4)                strip    0 1 2 3 4
//! pivots             1       2
//!
//! triangles   (0 1 2) (0 2 3) (0 3 4) (0 4 5)        strip    1 2 0 3 0 4 5
//! pivots             2       0       0
//! ```
//!
//! From a triangle to the next a strip pivots around a vertex of their common edge. Where it pivots
//! around one vertex twice in a row, that index is repeated, which draws an empty triangle.

use crate::partial_mesh::mesh::PartialMesh;
use crate::strips::strip_order::StripOrder;
use lodc_mesh::NONE;
use lodc_strip::StripSet;

/// Returns the strips of a mesh with so many submeshes; none for a crafted stream whose strips are
/// not sorted by submesh. Where triangles of a strip share no edge the strip falls into several.
pub(crate) fn strip_set(
    order: &StripOrder,
    mesh: &PartialMesh,
    submeshes: usize,
) -> Option<StripSet> {
    let (mut indices, mut ends) = (Vec::new(), Vec::new());
    let mut submesh_ends = vec![0; submeshes];
    let mut strip = Vec::new();
    let mut face = order.next(NONE);
    while face != NONE {
        strip.push(mesh.face(face));
        let next = order.next(face);
        if !order.share_strip(face, next) {
            append(&strip, &mut indices, &mut ends);
            strip.clear();
            let submesh = mesh.submesh[mesh.face(face)[0] as usize];
            submesh_ends[submesh as usize] = ends.len() as u32;
        }
        face = next;
    }
    for s in 1..submeshes {
        submesh_ends[s] = submesh_ends[s].max(submesh_ends[s - 1]);
    }
    StripSet::from_parts(indices, ends, submesh_ends).ok()
}

/// Appends the indices of a sequence of triangles: one strip as long as each shares the right edge
/// with the next.
fn append(triangles: &[[u32; 3]], indices: &mut Vec<u32>, ends: &mut Vec<u32>) {
    let mut rest = triangles;
    while !rest.is_empty() {
        let used = append_strip(rest, indices);
        ends.push(indices.len() as u32);
        rest = &rest[used..];
    }
}

/// A common edge of two consecutive triangles.
#[derive(Clone, Copy, Debug, Default)]
struct SharedEdge {
    /// The corner of the first triangle at which the edge starts, counter-clockwise.
    from: usize,
    /// The corner of the second triangle opposite the edge.
    opposite: usize,
}

/// Returns all common edges of two triangles; mostly one.
fn shared_edges(first: [u32; 3], second: [u32; 3]) -> impl Iterator<Item = SharedEdge> {
    let all = (0..9).map(|i| SharedEdge { from: i / 3, opposite: i % 3 });
    all.filter(move |edge| {
        first[edge.from] == second[(edge.opposite + 2) % 3]
            && first[(edge.from + 1) % 3] == second[(edge.opposite + 1) % 3]
    })
}

/// Returns the vertex that the edge into a triangle, opposite corner `opposite`, and the edge out
/// of it, from corner `from`, have in common; none if they are the same edge.
fn pivot(triangle: [u32; 3], opposite: usize, from: usize) -> Option<u32> {
    match (from + 3 - opposite) % 3 {
        0 => Some(triangle[(from + 1) % 3]),
        2 => Some(triangle[from]),
        _ => None,
    }
}

/// The cheapest way from the first triangle to a shared edge.
#[derive(Clone, Copy, Debug)]
struct Way {
    edge: SharedEdge,
    /// Indices repeated so far.
    repeats: u32,
    /// The vertex of the last turn.
    pivot: u32,
    /// Index of the way to the edge before.
    previous: usize,
}

/// Returns the cheapest ways to the edges that two triangles share, given those to the edges before
/// (Viterbi 1967); ties go to the first.
fn extend_ways(before: Option<&Vec<Way>>, pair: &[[u32; 3]]) -> Vec<Way> {
    let extend = |edge: SharedEdge| {
        let Some(before) = before else {
            let pivot = pair[0][edge.from];
            return Some(Way { edge, repeats: 0, pivot, previous: 0 });
        };
        let ways = before.iter().enumerate().filter_map(|(previous, way)| {
            let pivot = pivot(pair[0], way.edge.opposite, edge.from)?;
            let repeats = way.repeats + u32::from(pivot == way.pivot);
            Some(Way { edge, repeats, pivot, previous })
        });
        ways.min_by_key(|way| (way.repeats, way.previous))
    };
    shared_edges(pair[0], pair[1]).filter_map(extend).collect()
}

/// Appends the longest strip that the first triangles make, in the fewest indices. Returns how many
/// triangles it has.
fn append_strip(triangles: &[[u32; 3]], indices: &mut Vec<u32>) -> usize {
    let mut ways: Vec<Vec<Way>> = Vec::new();
    for pair in triangles.windows(2) {
        let extended = extend_ways(ways.last(), pair);
        if extended.is_empty() {
            break;
        }
        ways.push(extended);
    }
    let Some(last) = ways.last() else {
        indices.extend(triangles[0]);
        return 1;
    };
    let mut at = (0..last.len()).min_by_key(|&i| last[i].repeats).unwrap_or_default();
    let mut path = Vec::with_capacity(ways.len());
    for ways in ways.iter().rev() {
        path.push(ways[at]);
        at = ways[at].previous;
    }
    path.reverse();

    let (first, from) = (triangles[0], path[0].edge.from);
    indices.extend([first[(from + 2) % 3], first[from], first[(from + 1) % 3]]);
    for (i, pair) in path.windows(2).enumerate() {
        if pair[1].pivot == pair[0].pivot {
            indices.push(pair[1].pivot);
        }
        indices.push(triangles[i + 1][pair[0].edge.opposite]);
    }
    indices.push(triangles[path.len()][path[path.len() - 1].edge.opposite]);
    path.len() + 1
}
