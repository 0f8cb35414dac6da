//! A cursor over an Interactive Mesh that works in proportion to what changes.
//!
//! The extraction pass of the thesis looks at all vertices below the LOD, which suits a GPU and a
//! frame; walking through every one of 500,000 steps that way would be quadratic. A cursor
//! therefore keeps, for every vertex that is still there, the list of the input vertices that it
//! stands for. A record moves the whole list of its vertex to the end of its target's; a vertex
//! whose last triangle dies leaves its list. Both take constant time and are undone exactly,
//! because finer LODs undo them in the opposite order (Knuth's *dancing links*). So a move costs
//! what its records and the triangles around the vertices they move cost.

use super::{index::Index, links::Links};
use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use lodc_model::{Changes, Traffic};

/// The moving part of an [`Interactive`](super::Interactive) mesh.
#[derive(Clone, Debug)]
pub struct Cursor {
    lod: u32,
    /// The vertex as which each vertex of the input is shown. Only good for those that still have
    /// live triangles.
    shown: Vec<u32>,
    /// During a move, what the coarser of its two LODs shows. Only good for vertices that the move
    /// rewrites.
    coarser: Vec<u32>,
    /// Number of triangles of each submesh that are drawn.
    live: Vec<u32>,
    links: Links,
    index: Index,
    /// Number of `index.triangles` that are dead.
    dead_triangles: usize,
    /// Number of `index.vertices` that are dead.
    dead_vertices: usize,
}

impl Cursor {
    pub(super) fn new(simplified: &Simplified, removal_lods: &[u32]) -> Self {
        let vertices = simplified.mesh().vertex_count() as u32;
        let index = Index::new(simplified, removal_lods);
        Self {
            lod: 0,
            shown: (0..vertices).collect(),
            coarser: vec![0; vertices as usize],
            live: simplified.mesh().submeshes().iter().map(|s| s.triangle_count).collect(),
            links: Links::new(vertices, &index.vertices),
            index,
            dead_triangles: 0,
            dead_vertices: 0,
        }
    }

    pub(super) fn lod(&self) -> Lod {
        Lod(self.lod)
    }

    pub(super) fn drawn(&self) -> u64 {
        3 * (self.index.triangles.len() - self.dead_triangles) as u64
    }

    pub(super) fn for_each_triangle(
        &self,
        simplified: &Simplified,
        mut see: impl FnMut(OrientedTriangle),
    ) {
        for (s, (submesh, &live)) in
            simplified.mesh().submeshes().iter().zip(&self.live).enumerate()
        {
            let drawn = &simplified.mesh().triangles()[submesh.triangles()][..live as usize];
            for triangle in drawn {
                see(OrientedTriangle::new(s as u32, triangle.map(|v| self.shown[v as usize])));
            }
        }
    }

    pub(super) fn seek(
        &mut self,
        s: &Simplified,
        removal_lods: &[u32],
        lod: Lod,
        changes: &mut impl Changes,
    ) -> Traffic {
        let (from, to) = (self.lod, s.collapses().floor(lod).0);
        let (fine, coarse) = (from.min(to), from.max(to));
        if from == to {
            return Traffic::default();
        }
        // At the finer of the two LODs, the lists of the records between them hold exactly the
        // vertices that move. Either way `shown` is what the finer LOD shows and `coarser` what the
        // coarser one does when it comes to telling of changes.
        let moved;
        if to > from {
            moved = self.links.members(fine..coarse);
            let hops = hops(s.collapses().targets(), fine, coarse);
            for &v in &moved {
                self.coarser[v as usize] = hops[(self.shown[v as usize] - fine) as usize];
            }
            self.report(s, removal_lods, &moved, to > from, (fine, coarse), changes);
            for &v in &moved {
                self.shown[v as usize] = self.coarser[v as usize];
            }
            self.apply(s, removal_lods, fine, coarse);
        } else {
            self.revert(s, removal_lods, fine, coarse);
            moved = self.links.members(fine..coarse);
            for &v in &moved {
                self.coarser[v as usize] = self.shown[v as usize];
            }
            for record in fine..coarse {
                self.links.for_each(record, |v| self.shown[v as usize] = record);
            }
            self.report(s, removal_lods, &moved, to > from, (fine, coarse), changes);
        }
        self.lod = to;
        Traffic { records: coarse - fine, rewritten: moved.len() as u64 }
    }

    /// Tells of every triangle around the moved vertices that is live at the finer LOD, once.
    fn report(
        &self,
        s: &Simplified,
        removal_lods: &[u32],
        moved: &[u32],
        coarsens: bool,
        (fine, coarse): (u32, u32),
        changes: &mut impl Changes,
    ) {
        let moves = |corner: u32| (fine..coarse).contains(&self.shown[corner as usize]);
        for &v in moved {
            let submesh = s.mesh().vertex_submesh()[v as usize];
            for &t in self.index.incident(v) {
                if removal_lods[t as usize] <= fine {
                    break;
                }
                let corners = s.mesh().triangles()[t as usize];
                // A triangle of which several corners move is reported by the first of them.
                if corners.into_iter().find(|&c| moves(c)) != Some(v) {
                    continue;
                }
                let finer = OrientedTriangle::new(submesh, corners.map(|c| self.shown[c as usize]));
                let coarser = (removal_lods[t as usize] > coarse).then(|| {
                    let shown = corners
                        .map(|c| if moves(c) { &self.coarser } else { &self.shown }[c as usize]);
                    OrientedTriangle::new(submesh, shown)
                });
                if coarsens {
                    changes.removed(finer);
                    coarser.into_iter().for_each(|t| changes.added(t));
                } else {
                    coarser.into_iter().for_each(|t| changes.removed(t));
                    changes.added(finer);
                }
            }
        }
    }

    /// Applies records to the lists and counts. A vertex or triangle that dies at LOD `k + 1` goes
    /// with record `k`.
    fn apply(&mut self, s: &Simplified, removal_lods: &[u32], fine: u32, coarse: u32) {
        for record in fine..coarse {
            self.links.splice(record, s.collapses().targets()[record as usize]);
            while let Some(&v) = self.index.vertices.get(self.dead_vertices)
                && self.index.vertex_removal_lod(removal_lods, v) == record + 1
            {
                self.links.unlink(v);
                self.dead_vertices += 1;
            }
        }
        while let Some(&t) = self.index.triangles.get(self.dead_triangles)
            && removal_lods[t as usize] <= coarse
        {
            self.live[submesh_of(s, t)] -= 1;
            self.dead_triangles += 1;
        }
    }

    /// Undoes [`Self::apply`], in exactly the opposite order.
    fn revert(&mut self, s: &Simplified, removal_lods: &[u32], fine: u32, coarse: u32) {
        for record in (fine..coarse).rev() {
            while let Some(&v) = self.index.vertices[..self.dead_vertices].last()
                && self.index.vertex_removal_lod(removal_lods, v) == record + 1
            {
                self.links.relink(v);
                self.dead_vertices -= 1;
                // While it was dead, nobody kept this.
                self.shown[v as usize] = self.index.shown_at_removal[self.dead_vertices];
            }
            self.links.unsplice(record);
        }
        while let Some(&t) = self.index.triangles[..self.dead_triangles].last()
            && removal_lods[t as usize] > fine
        {
            self.live[submesh_of(s, t)] += 1;
            self.dead_triangles -= 1;
        }
    }
}

fn submesh_of(s: &Simplified, triangle: u32) -> usize {
    s.mesh().vertex_submesh()[s.mesh().triangles()[triangle as usize][0] as usize] as usize
}

/// Resolves each of the vertices `fine..coarse` at LOD `coarse`.
fn hops(targets: &[u32], fine: u32, coarse: u32) -> Vec<u32> {
    let mut hops = targets[fine as usize..coarse as usize].to_vec();
    for i in (0..hops.len()).rev() {
        if hops[i] < coarse {
            hops[i] = hops[(hops[i] - fine) as usize];
        }
    }
    hops
}
