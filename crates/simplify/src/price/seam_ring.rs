//! Closed fans with any wedges: which edges are seams, and the planes that collapses should keep.

use super::one_ring::{MAX_LEN, OneRing};
use crate::cut::{
    Corner, EdgeKind, Entry, FeaturePlane, Wedges, WorkingMesh, fold_plane, is_seam, plane_along,
    seam_weight,
};

/// The ring of a group, and its edges.
pub(super) struct SeamRing<const N: usize> {
    pub(super) ring: OneRing<N>,
    /// The wedges at the corners of each face, the group's first.
    pub(super) corners: [[u32; 3]; MAX_LEN],
    /// The faces on both sides of the edge to each neighbour.
    entries: [[Entry; 2]; MAX_LEN],
    /// The kind of the edge to each neighbour.
    kinds: [EdgeKind; MAX_LEN],
    /// Number of seams that end at the group.
    pub(super) seams: u32,
}

impl<const N: usize> SeamRing<N> {
    #[inline]
    pub(super) fn new(mesh: &WorkingMesh, wedges: &Wedges, from: u32, star: &[Corner]) -> Self {
        let mut corners = [[0; 3]; MAX_LEN];
        for (corners, corner) in corners.iter_mut().zip(star) {
            *corners = mesh.wedges_from(*corner);
        }
        let mut entries = [[Entry::default(); 2]; MAX_LEN];
        let mut kinds = [EdgeKind::Smooth; MAX_LEN];
        let (mut seams, mut before) = (0, star.len() - 1);
        for (i, corner) in star.iter().enumerate() {
            let ([wedge, neighbour_wedge, _], [other_wedge, _, other_neighbour]) =
                (corners[i], corners[before]);
            let group = corner.ahead;
            let mut faces = [
                Entry { group, wedge, neighbour_wedge, slot: i as u32 },
                Entry {
                    group,
                    wedge: other_wedge,
                    neighbour_wedge: other_neighbour,
                    slot: before as u32,
                },
            ];
            faces.sort_unstable_by_key(Entry::key);
            if is_seam(wedges, [wedge, other_wedge], [neighbour_wedge, other_neighbour]) {
                kinds[i] = EdgeKind::Seam;
                seams += 1;
            }
            entries[i] = faces;
            before = i;
        }
        Self { ring: OneRing::new(mesh, from, star), corners, entries, kinds, seams }
    }

    /// For each neighbour its index in the ring, the kind of the edge to it and the edge's faces.
    pub(super) fn edges(&self) -> impl Iterator<Item = (usize, EdgeKind, &[Entry; 2])> {
        let edges = self.kinds.into_iter().zip(&self.entries).take(self.ring.len);
        edges.enumerate().map(|(i, (kind, entries))| (i, kind, entries))
    }

    /// Adds the planes that collapses should keep: along seams, and where two faces fold back.
    pub(super) fn add_planes(&self, wedges: &Wedges, planes: &mut Vec<FeaturePlane>) {
        self.add_planes_in(&self.ring, wedges, planes);
    }

    /// The same in another shape, given the ring in it.
    pub(super) fn add_planes_in(
        &self,
        ring: &OneRing<N>,
        wedges: &Wedges,
        planes: &mut Vec<FeaturePlane>,
    ) {
        let folded = ring.is_folded();
        if self.seams == 0 && !folded {
            return;
        }
        let (spokes, normals) = (ring.spokes(), ring.normals());
        for (i, kind, entries) in self.edges() {
            let edge = spokes[i].as_dvec3();
            let normal = |e: &Entry| normals[e.slot as usize].normalize_or_zero();
            if kind == EdgeKind::Seam {
                let weight = seam_weight(wedges, entries) * edge.length_squared();
                let along = |e| plane_along(normal(e).as_dvec3(), edge, weight);
                planes.extend(entries.iter().filter_map(along));
            } else if folded {
                planes.extend(fold_plane(normal(&entries[0]), normal(&entries[1]), edge));
            }
        }
    }
}
