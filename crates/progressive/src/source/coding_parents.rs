//! Chooses the vertex that each new one is coded as split off, where its target is a hub.
//!
//! A split pays for the star of its parent: a bit for each triangle, transferred or not. A vertex
//! that takes over no triangle of its target needs nothing of that star. Where it is large, the
//! vertex is split off another one with the same target: it repeats that one's target.
//!
//! There remain large stars of which a vertex takes over a few triangles. Where these cost much
//! more than the rest of the mesh, only the triangles that are transferred are named.

use crate::partial_mesh::star::LARGE_STAR;
use crate::source::first_appearance::FirstAppearance;
use lodc_mesh::{Csr, NONE};

/// Vertices of the same target that are tried as parents, from the latest on. The latest nearly
/// always has a small star; chosen by hand.
const MAX_SIBLINGS: usize = 8;

/// The stars that are too large to be walked around.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StarRule {
    /// Stars of more triangles are large.
    pub(crate) large: u32,
    /// A large star is named if it is more than this many times as large as what is transferred.
    pub(crate) share: u64,
    /// Stars are named only if all these have more than this many triangles for each of the mesh.
    pub(crate) worth: u64,
}

impl StarRule {
    /// A triangle of a star costs a few nanoseconds, a triangle of the mesh some microseconds: a
    /// mesh whose large stars take less than 32 triangles for each of its own is packed in time
    /// anyway, and bits are smaller than names. By `share`, names cost less than the bits they
    /// replace: 17 bits or so for each triangle that is transferred, for one bit of each of the
    /// star. With these no hub of 25 made ones takes more than 1.3 times as long as loose
    /// triangles.
    pub(crate) const DEFAULT: Self = Self { large: LARGE_STAR, share: 32, worth: 32 };
}

/// The coding of the splits of a mesh.
pub(crate) struct SplitPlan {
    /// The vertex that each one is coded as split off.
    pub(crate) parents: Vec<u32>,
    /// The vertices with a named star, in falling order; none if naming is not worth it.
    pub(crate) named: Vec<u32>,
}

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
    /// Plans how they are coded. The parent of a vertex is its target, or a vertex with the same
    /// target, which is no point, of a smaller star. Linear time: stars are counted backwards.
    pub(crate) fn plan(self, rule: StarRule) -> SplitPlan {
        let Self { targets, points, appearances, by_vertex, triangles } = self;
        let mut star = vec![0u32; targets.len()];
        for v in triangles.as_flattened() {
            star[targets.len() - 1 - *v as usize] += 1;
        }
        let earlier = earlier_siblings(targets, points);
        let mut parents = targets.to_vec();
        let (mut named, mut walked) = (Vec::new(), 0);
        for new in (1..targets.len()).rev() {
            for &triangle in by_vertex.row(new as u32) {
                for vertex in appearances[triangle as usize].vertices {
                    star[vertex as usize] -= 1;
                }
            }
            let (target, transferred) = (targets[new], star[new]);
            if transferred == 0 && star[target as usize] > rule.large && new as u32 >= points {
                let earlier_sibling = |v: usize| Some(earlier[v]).filter(|&v| v != NONE);
                let siblings =
                    std::iter::successors(earlier_sibling(new), |&v| earlier_sibling(v as usize));
                let small = siblings.take(MAX_SIBLINGS).find(|&v| star[v as usize] <= rule.large);
                parents[new] = small.unwrap_or(target);
            }
            star[target as usize] += transferred;
            let size = star[target as usize];
            let is_large = parents[new] == target && size > rule.large;
            if is_large && u64::from(size) > rule.share * u64::from(transferred) {
                named.push(new as u32);
                walked += u64::from(size);
            }
        }
        if walked <= rule.worth * triangles.len() as u64 {
            named.clear();
        }
        SplitPlan { parents, named }
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
