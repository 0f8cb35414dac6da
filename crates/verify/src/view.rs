//! Checks of view-dependent levels of detail against the collapse sequence: the right triangles,
//! and no crack.

use crate::boundary::{boundary, edge_value, edges, first_nonzero};
use crate::difference::{Failure, first_difference};
use lodc_mesh::{CollapseSequence, Lod, OrientedTriangle, PositionIds, Simplified, is_degenerate};

/// The content of a view in which every vertex of LOD 0 has a LOD of its own. All lists but
/// `indices` have one entry for each vertex.
#[derive(Clone, Copy, Debug)]
pub struct ShownView<'a> {
    /// The LOD that a vertex chose.
    pub lods: &'a [Lod],
    /// The vertex that it is shown as.
    pub vertices: &'a [u32],
    /// The position at which it is drawn.
    pub positions: &'a [[f32; 3]],
    /// The triangles that are drawn, three vertices of LOD 0 each.
    pub indices: &'a [u32],
    /// True if vertices are drawn between two positions. Then only tears are looked for.
    pub morphs: bool,
}

/// The judge of the views of a mesh.
#[derive(Clone, Debug)]
pub struct ViewReference<'a> {
    simplified: &'a Simplified,
    positions: PositionIds,
    /// The border of LOD 0.
    border: Vec<[u32; 2]>,
}

impl<'a> ViewReference<'a> {
    /// Prepares the positions and the border of LOD 0.
    #[must_use]
    pub fn new(simplified: &'a Simplified) -> Self {
        let mesh = simplified.mesh();
        // Views draw the mesh at rest; what parts in motion has borders, though they lie together.
        let positions = PositionIds::new(mesh.positions());
        let border = boundary(mesh, &mesh.position_ids());
        Self { simplified, positions, border }
    }

    /// Returns the first failure of a view, in near-linear time if there is none.
    ///
    /// Without morphing each triangle of LOD 0 is compared with every corner resolved at its own
    /// LOD by the plain sequence (and, where all corners are at one LOD, with the reference
    /// itself). In any view, only the border of LOD 0 may have open edges.
    #[must_use]
    pub fn first_failure(&self, view: &ShownView<'_>) -> Option<Failure> {
        let corners = self.simplified.mesh().triangles().as_flattened();
        let lod = |v: u32| self.simplified.collapses().floor(view.lods[v as usize]);
        let coarsest = corners.iter().map(|&v| lod(v)).max().unwrap_or(Lod(0));
        let uniform = || corners.iter().all(|&v| lod(v) == coarsest);
        let compared = || {
            let drawn = drawn(self.simplified, view);
            let reference = uniform().then(|| {
                let reference = self.simplified.triangles_at_with(coarsest, &self.positions);
                first_difference(coarsest, reference, drawn.clone())
            });
            let resolved = || resolved(self.simplified, &self.positions, view.lods);
            reference.flatten().or_else(|| first_difference(coarsest, resolved(), drawn))
        };
        let failure = if view.morphs { None } else { compared() };
        failure.or_else(|| self.torn(view, coarsest))
    }

    /// An edge that is drawn more often in one direction than in the other, and not because the
    /// input has a border there.
    fn torn(&self, view: &ShownView<'_>, lod: Lod) -> Option<Failure> {
        let drawn_at = PositionIds::new(view.positions);
        let position_id = |v: u32| drawn_at.of_vertex[v as usize];
        let triangles =
            || view.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(position_id));
        let border = || self.border.iter().map(|edge| edge.map(position_id));
        let sum = |edges: &mut dyn Iterator<Item = [u32; 2]>| {
            edges.map(edge_value).fold(0, u64::wrapping_add)
        };
        if sum(&mut triangles().flat_map(edges)) == sum(&mut border()) {
            return None;
        }
        let terms = triangles().flat_map(edges).map(|e| (e, 1));
        let (edge, surplus) = first_nonzero(terms.chain(border().map(|e| (e, -1))))?;
        let point = |p: u32| view.positions[drawn_at.first_vertex[p as usize] as usize];
        Some(Failure::Torn { lod, edge: edge.map(point), surplus })
    }
}

/// The triangles of LOD 0 with every corner resolved at its own LOD, without degenerate ones.
fn resolved(
    simplified: &Simplified,
    positions: &PositionIds,
    lods: &[Lod],
) -> Vec<OrientedTriangle> {
    let mesh = simplified.mesh();
    let image = images(simplified.collapses(), lods);
    let mut live = Vec::with_capacity(mesh.triangles().len());
    for (s, submesh) in mesh.submeshes().iter().enumerate() {
        for triangle in &mesh.triangles()[submesh.triangles()] {
            let corners = triangle.map(|v| image[v as usize]);
            if !is_degenerate(corners.map(|v| positions.of_vertex[v as usize])) {
                live.push(OrientedTriangle::new(s as u32, corners));
            }
        }
    }
    live
}

/// The vertex that each vertex has become at its own LOD, in near-linear time however long chains
/// of collapses are: records are applied in order, and vertices that have become one are a set
/// (union-find).
fn images(collapses: &CollapseSequence, lods: &[Lod]) -> Vec<u32> {
    let ends: Vec<u32> = lods.iter().map(|&lod| collapses.floor(lod).0).collect();
    let mut order: Vec<u32> = (0..ends.len() as u32).collect();
    order.sort_unstable_by_key(|&v| ends[v as usize]);
    let mut becomes: Vec<u32> = (0..=collapses.records()).collect();
    let mut images = vec![0; ends.len()];
    let mut done = 0;
    for v in order {
        while done < ends[v as usize] {
            becomes[done as usize] = collapses.targets()[done as usize];
            done += 1;
        }
        let mut current = v;
        while becomes[current as usize] != current {
            // Path halving.
            becomes[current as usize] = becomes[becomes[current as usize] as usize];
            current = becomes[current as usize];
        }
        images[v as usize] = current;
    }
    images
}

fn drawn(simplified: &Simplified, view: &ShownView<'_>) -> Vec<OrientedTriangle> {
    let submesh = simplified.mesh().vertex_submesh();
    let triangle = |t: &[u32]| {
        let corners = [t[0], t[1], t[2]].map(|v| view.vertices[v as usize]);
        OrientedTriangle::new(submesh[t[0] as usize], corners)
    };
    view.indices.chunks_exact(3).map(triangle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_fixtures as fixtures;
    use lodc_mesh::SplitMix64;

    #[test]
    fn images_are_what_the_plain_sequence_says() {
        for seed in 0..20 {
            let simplified = fixtures::random_collapse(&fixtures::random(seed), seed);
            let collapses = simplified.collapses();
            let mut random = SplitMix64::new(seed);
            let lods: Vec<Lod> = (0..simplified.mesh().vertex_count())
                .map(|_| Lod((random.bits() >> 32) as u32 % (collapses.records() + 1)))
                .collect();
            let plain = |(v, &lod)| collapses.resolve(v, collapses.floor(lod));
            let plain: Vec<u32> = (0..).zip(&lods).map(plain).collect();
            assert_eq!(images(collapses, &lods), plain, "seed {seed}");
        }
    }
}
