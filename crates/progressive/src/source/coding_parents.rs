//! Chooses the parent of each new vertex: the vertex that it is coded as split off. That is its
//! target, except at some high-valence vertices.
//!
//! A split pays for the star of its parent: a bit for each triangle, transferred or not. A vertex
//! that takes over no triangle of its target needs nothing of that star. If the star is large, the
//! vertex is coded as split off an earlier vertex with the same target (a sibling), and a bit says
//! that it repeats that vertex's target.
//!
//! Some vertices do take over a few triangles of a large star. If these stars cost much more than
//! the rest of the mesh, the triangles that are transferred are coded by their numbers instead (an
//! explicit face list).

use crate::partial_mesh::star::LARGE_STAR;
use crate::source::first_appearance::FirstAppearance;
use lodc_mesh::{Csr, NONE};

/// Vertices of the same target that are tried as parents, from the latest on. The latest nearly
/// always has a small star; chosen by hand.
const MAX_SIBLINGS: usize = 8;

/// Which stars are too large for a bit for each of their triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StarRule {
    /// Stars of more triangles are large.
    pub(crate) large_star: u32,
    /// A split off a large star may have an explicit face list if the star has more than this many
    /// triangles for each that is transferred. Beyond 32, numbers (about 17 bits for each triangle
    /// that is transferred) are smaller than bits (one for each triangle of the star).
    pub(crate) max_star_ratio: u64,
    /// Explicit face lists are used only if the stars of all splits that may have one hold together
    /// more than this many triangles for each of the mesh. A triangle of a star costs a few
    /// nanoseconds, a triangle of the mesh some microseconds. So a mesh with up to 32 is packed
    /// fast enough with bits, which are smaller than numbers.
    pub(crate) max_total_ratio: u64,
}

impl StarRule {
    /// With these none of 25 generated meshes with high-valence vertices takes more than 1.3 times
    /// as long to pack as loose triangles.
    pub(crate) const DEFAULT: Self =
        Self { large_star: LARGE_STAR, max_star_ratio: 32, max_total_ratio: 32 };
}

/// How each split is coded.
pub(crate) struct SplitPlan {
    /// The vertex that each one is coded as split off.
    pub(crate) parents: Vec<u32>,
    /// The vertices with an explicit face list, in falling order; none if these are not worth it.
    pub(crate) listed: Vec<u32>,
}

/// The splits of a mesh in stream order, with what decides the size of stars.
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
    /// Chooses parents and explicit face lists. The parent of a vertex is its target, or an earlier
    /// vertex with the same target and a small star that is not a point. Linear time: the sizes of
    /// stars are followed backwards from the whole mesh.
    pub(crate) fn plan(self, rule: StarRule) -> SplitPlan {
        let Self { targets, points, appearances, by_vertex, triangles } = self;
        let mut star_sizes = vec![0u32; targets.len()];
        for v in triangles.as_flattened() {
            // From collapse order to stream order.
            star_sizes[targets.len() - 1 - *v as usize] += 1;
        }
        let earlier = earlier_siblings(targets, points);
        let mut parents = targets.to_vec();
        let (mut listed, mut listed_triangles) = (Vec::new(), 0);
        for new in (1..targets.len()).rev() {
            // Going backwards, the split is undone: without the triangles that came with `new`, its
            // star is what was transferred.
            for &triangle in by_vertex.row(new as u32) {
                for vertex in appearances[triangle as usize].vertices {
                    star_sizes[vertex as usize] -= 1;
                }
            }
            let (target, transferred) = (targets[new], star_sizes[new]);
            let is_high_valence = star_sizes[target as usize] > rule.large_star;
            if transferred == 0 && is_high_valence && new as u32 >= points {
                let earlier_sibling = |v: usize| Some(earlier[v]).filter(|&v| v != NONE);
                let siblings =
                    std::iter::successors(earlier_sibling(new), |&v| earlier_sibling(v as usize));
                let is_small = |&v: &u32| star_sizes[v as usize] <= rule.large_star;
                parents[new] = siblings.take(MAX_SIBLINGS).find(is_small).unwrap_or(target);
            }
            star_sizes[target as usize] += transferred;
            let size = star_sizes[target as usize];
            let is_large = parents[new] == target && size > rule.large_star;
            if is_large && u64::from(size) > rule.max_star_ratio * u64::from(transferred) {
                listed.push(new as u32);
                listed_triangles += u64::from(size);
            }
        }
        if listed_triangles <= rule.max_total_ratio * triangles.len() as u64 {
            listed.clear();
        }
        SplitPlan { parents, listed }
    }
}

/// Returns for each vertex the latest one before it with the same target that is not a point.
fn earlier_siblings(targets: &[u32], points: u32) -> Vec<u32> {
    let mut latest = vec![NONE; targets.len()];
    let mut earlier = vec![NONE; targets.len()];
    for new in (points.max(1) as usize)..targets.len() {
        earlier[new] = std::mem::replace(&mut latest[targets[new] as usize], new as u32);
    }
    earlier
}
