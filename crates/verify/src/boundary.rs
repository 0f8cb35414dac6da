//! The boundary of a mesh as a sum of oriented position-edges.
//!
//! The boundary of a set of oriented triangles is the formal sum of their edges, `a→b` being minus
//! `b→a`. A map of positions carries the boundary of a mesh to the boundary of its image, so the
//! boundary of every LOD must be the image of LOD 0's: nothing for a closed mesh. Where it is not,
//! the mesh is torn.

use lodc_mesh::{Mesh, PositionIds};

/// An edge from one position to another.
type Edge = [u32; 2];

/// The value of an edge, a pseudo-random number, of which the reversed edge has the negative. The
/// values of a sum of edges add up to zero if the sum is zero, and otherwise by chance with
/// probability 2⁻⁶⁴. So a running sum needs one number, not a table.
pub(super) fn edge_value([a, b]: Edge) -> u64 {
    let mut x = u64::from(a.min(b)) << 32 | u64::from(a.max(b));
    x = (x ^ (x >> 30) ^ 0x5851_f42d_4c95_7f2d).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x = (x ^ (x >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    x ^= x >> 31;
    match a.cmp(&b) {
        std::cmp::Ordering::Less => x,
        std::cmp::Ordering::Equal => 0,
        std::cmp::Ordering::Greater => x.wrapping_neg(),
    }
}

/// The three edges of a triangle.
pub(super) fn edges([a, b, c]: [u32; 3]) -> [Edge; 3] {
    [[a, b], [b, c], [c, a]]
}

/// The boundary of a mesh: a pair of vertices for each position-edge that does not cancel out,
/// repeated as often as it is used more in this direction than in the other.
pub(super) fn boundary(mesh: &Mesh, positions: &PositionIds) -> Vec<[u32; 2]> {
    // Position-edge with its smaller end first, its direction, the vertices.
    let mut all: Vec<(Edge, bool, [u32; 2])> = Vec::with_capacity(3 * mesh.triangles().len());
    for &t in mesh.triangles() {
        for [a, b] in edges(t) {
            let (p, q) = (positions.of_vertex[a as usize], positions.of_vertex[b as usize]);
            all.push(([p.min(q), p.max(q)], p < q, [a, b]));
        }
    }
    all.sort_unstable();
    let mut boundary_edges = Vec::new();
    for edge in all.chunk_by(|a, b| a.0 == b.0) {
        // Backward edges come first. The surplus of the more frequent direction is the boundary.
        let backwards = edge.partition_point(|e| !e.1);
        let forwards = edge.len() - backwards;
        let surplus = if forwards > backwards {
            &edge[2 * backwards..]
        } else {
            &edge[..backwards - forwards]
        };
        boundary_edges.extend(surplus.iter().map(|e| e.2));
    }
    boundary_edges
}

/// The first edge whose coefficient is not zero in a sum of edges with signs, and that coefficient.
pub(super) fn first_nonzero(terms: impl Iterator<Item = (Edge, i64)>) -> Option<(Edge, i64)> {
    let oriented = |([a, b], n): (Edge, i64)| if a <= b { ([a, b], n) } else { ([b, a], -n) };
    let mut terms: Vec<(Edge, i64)> = terms.filter(|([a, b], _)| a != b).map(oriented).collect();
    terms.sort_unstable();
    let mut sums = terms
        .chunk_by(|a, b| a.0 == b.0)
        .map(|run| (run[0].0, run.iter().map(|t| t.1).sum::<i64>()));
    sums.find(|&(_, sum)| sum != 0)
        .map(|(edge, sum)| if sum > 0 { (edge, sum) } else { ([edge[1], edge[0]], -sum) })
}
