//! Closed fans with any wedges: which edges are seams, and the planes that collapses should keep.

use crate::cut::mesh::{Corner, WorkingMesh, next, previous};
use crate::cut::neighborhood::{
    EdgeKind, Entry, FeaturePlane, fold_plane, plane_along, seam_weight,
};
use crate::cut::wedges::Wedges;
use crate::price::one_ring::{MAX_LEN, OneRing};

/// The ring of a group, and its edges.
pub(crate) struct SeamRing<const N: usize> {
    pub(crate) ring: OneRing<N>,
    /// The wedges at the corners of each face, the group's first.
    pub(crate) corners: [[u32; 3]; MAX_LEN],
    /// The faces on both sides of the edge to each neighbour.
    entries: [[Entry; 2]; MAX_LEN],
    kinds: [EdgeKind; MAX_LEN],
    pub(crate) seams: u32,
}

/// Returns whether an edge between two faces of a closed fan is a seam, given the wedges at the
/// group and at its other end in both.
#[inline]
fn is_seam(wedges: &Wedges, here: [u32; 2], there: [u32; 2]) -> bool {
    let alike = |[a, b]: [u32; 2]| a == b || wedges.class(a) == wedges.class(b);
    !alike(here) || !alike(there)
}

/// Returns whether an edge at a group with a closed fan is a seam.
pub(crate) fn has_seams(mesh: &WorkingMesh, wedges: &Wedges, group: u32) -> bool {
    let wedges_at = |c: &Corner| {
        let (face, at) = (mesh.wedges(c.face()), c.at());
        (face[at], face[next(at)], face[previous(at)])
    };
    let star = mesh.star(group);
    let Some((mut here, _, mut behind)) = star.last().map(wedges_at) else { return false };
    star.iter().map(wedges_at).any(|(next_here, ahead, next_behind)| {
        let seam = is_seam(wedges, [here, next_here], [behind, ahead]);
        (here, behind) = (next_here, next_behind);
        seam
    })
}

impl<const N: usize> SeamRing<N> {
    #[inline]
    pub(crate) fn new(mesh: &WorkingMesh, wedges: &Wedges, from: u32, star: &[Corner]) -> Self {
        let mut corners = [[0; 3]; MAX_LEN];
        for (corners, corner) in corners.iter_mut().zip(star) {
            let (face, at) = (mesh.wedges(corner.face()), corner.at());
            *corners = [face[at], face[next(at)], face[previous(at)]];
        }
        let mut entries = [[Entry::default(); 2]; MAX_LEN];
        let mut kinds = [EdgeKind::Smooth; MAX_LEN];
        let (mut seams, mut before) = (0, star.len() - 1);
        for (i, corner) in star.iter().enumerate() {
            let ([here, there, _], [other_here, _, other_there]) = (corners[i], corners[before]);
            let group = corner.ahead;
            let mut faces = [
                Entry { group, here, there, slot: i as u32 },
                Entry { group, here: other_here, there: other_there, slot: before as u32 },
            ];
            faces.sort_unstable_by_key(Entry::key);
            if is_seam(wedges, [here, other_here], [there, other_there]) {
                kinds[i] = EdgeKind::Seam;
                seams += 1;
            }
            entries[i] = faces;
            before = i;
        }
        Self { ring: OneRing::new(mesh, from, star), corners, entries, kinds, seams }
    }

    /// The neighbours: their places in the ring, the kinds of the edges there and their faces.
    pub(crate) fn edges(&self) -> impl Iterator<Item = (usize, EdgeKind, &[Entry; 2])> {
        let edges = self.kinds.into_iter().zip(&self.entries).take(self.ring.len);
        edges.enumerate().map(|(i, (kind, entries))| (i, kind, entries))
    }

    /// Adds the planes that collapses should keep: along seams, and where two faces fold back.
    pub(crate) fn add_planes(&self, wedges: &Wedges, planes: &mut Vec<FeaturePlane>) {
        let folded = self.ring.is_folded();
        if self.seams == 0 && !folded {
            return;
        }
        let (spokes, normals) = (self.ring.spokes(), self.ring.normals());
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
