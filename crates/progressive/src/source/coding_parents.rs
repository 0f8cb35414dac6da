//! Parents other than targets, so that a target of many splits need not be walked around each time.
//!
//! A split pays for the star of its parent: a bit for each triangle, transferred or not. A vertex
//! that takes over no triangle of its target needs nothing of that star. Where it is large, the
//! vertex is split off another one with the same target: it repeats that one's target.

use crate::source::first_appearance::FirstAppearance;
use lodc_mesh::{Csr, NONE};

/// Stars of more triangles are large. Meshes without hubs have none.
pub(crate) const LARGE_STAR: u32 = 256;
/// Vertices of the same target that are tried, from the latest on.
const TRIES: usize = 8;

/// The splits of a mesh in stream order, as far as they concern stars.
pub(crate) struct Splits<'a> {
    /// The target of each vertex.
    pub(crate) targets: &'a [u32],
    /// The vertices before the first triangle.
    pub(crate) points: u32,
    pub(crate) appearances: &'a [FirstAppearance],
    /// The triangles that appear with each vertex.
    pub(crate) by_vertex: &'a Csr,
    /// The triangles of the whole mesh, in collapse order.
    pub(crate) triangles: &'a [[u32; 3]],
}

impl Splits<'_> {
    /// Returns the vertex that each one is coded as split off: its target, or a vertex with the
    /// same target, which is no point, of a smaller star. Linear time: stars are counted backwards.
    pub(crate) fn coding_parents(self) -> Vec<u32> {
        let Self { targets, points, appearances, by_vertex, triangles } = self;
        let mut star = vec![0u32; targets.len()];
        for v in triangles.as_flattened() {
            star[targets.len() - 1 - *v as usize] += 1;
        }
        let earlier = earlier_siblings(targets, points);
        let mut parents = targets.to_vec();
        for new in (1..targets.len()).rev() {
            for &triangle in by_vertex.row(new as u32) {
                for vertex in appearances[triangle as usize].vertices {
                    star[vertex as usize] -= 1;
                }
            }
            let (target, transferred) = (targets[new], star[new]);
            if transferred == 0 && star[target as usize] > LARGE_STAR && new as u32 >= points {
                let before = |v: usize| Some(earlier[v]).filter(|&v| v != NONE);
                let siblings = std::iter::successors(before(new), |&v| before(v as usize));
                let small = siblings.take(TRIES).find(|&v| star[v as usize] <= LARGE_STAR);
                parents[new] = small.unwrap_or(target);
            }
            star[target as usize] += transferred;
        }
        parents
    }
}

/// Returns for each vertex the one before it with the same target, of those that are no points.
fn earlier_siblings(targets: &[u32], points: u32) -> Vec<u32> {
    let mut latest = vec![NONE; targets.len()];
    let mut earlier = vec![NONE; targets.len()];
    for new in (points.max(1) as usize)..targets.len() {
        earlier[new] = std::mem::replace(&mut latest[targets[new] as usize], new as u32);
    }
    earlier
}
