//! A cursor over an Interactive Mesh that works in proportion to what changes.
//!
//! The extraction pass of the thesis looks at all vertices below the LOD, which suits a GPU and a
//! frame; walking through every one of 500,000 steps that way would take quadratic time. A cursor
//! moves in one of two ways. *Near*: the vertices that have become a record's vertex are
//! consecutive in a [`Tour`] of the collapses, and those that still have triangles get its target.
//! *Far*: every vertex below the LOD is resolved anew.

use super::{index::Index, tour::Tour};
use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use lodc_model::{Changes, Traffic};
use std::sync::Arc;

/// Vertices below the coarser LOD that a far move resolves in the time of one record of a near one:
/// that takes 30 to 50 ns a record where caches hold the mesh and more elsewhere, a far move 0.4 to
/// 0.6 ns a vertex.
const VERTICES_PER_RECORD: u32 = 128;

/// The moving part of an [`Interactive`](super::Interactive) mesh.
#[derive(Clone, Debug)]
pub struct Cursor {
    lod: u32,
    /// The vertex as which each vertex of the input is shown. Only good for those that still have
    /// live triangles.
    shown_as: Vec<u32>,
    /// During a move whose changes are reported, the same at the coarser of its two LODs. Only good
    /// for vertices that the move rewrites.
    coarser_shown_as: Vec<u32>,
    /// Number of triangles of each submesh that are drawn.
    live: Vec<u32>,
    /// Shared by copies of the cursor, as the next is.
    tour: Arc<Tour>,
    index: Arc<Index>,
    /// Number of `index.triangles` that are not drawn.
    dead_triangles: usize,
    /// Number of `index.vertices` that have no triangle any more.
    dead_vertices: usize,
}

/// A move between two LODs.
#[derive(Clone, Copy)]
struct Move {
    fine: u32,
    coarse: u32,
    /// True if it goes from the finer to the coarser one.
    coarsens: bool,
}

impl Cursor {
    pub(super) fn new(simplified: &Simplified, removal_lods: &[u32]) -> Self {
        let vertices = simplified.mesh().vertex_count() as u32;
        let index = Index::new(simplified, removal_lods);
        Self {
            lod: 0,
            shown_as: (0..vertices).collect(),
            coarser_shown_as: vec![0; vertices as usize],
            live: simplified.mesh().submeshes().iter().map(|s| s.triangle_count).collect(),
            tour: Arc::new(Tour::new(simplified.collapses().targets(), &index.vertex_removal_lods)),
            index: Arc::new(index),
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
                see(OrientedTriangle::new(s as u32, triangle.map(|v| self.shown_as[v as usize])));
            }
        }
    }

    pub(super) fn seek<C: Changes>(
        &mut self,
        simplified: &Simplified,
        removal_lods: &[u32],
        lod: Lod,
        changes: &mut C,
    ) -> Traffic {
        let (from, to) = (self.lod, simplified.collapses().floor(lod).0);
        let (fine, coarse, coarsens) = (from.min(to), from.max(to), to > from);
        if from == to {
            return Traffic::default();
        }
        let records = coarse - fine;
        // A far move resolves everything below the coarser LOD; the rest is shown as itself.
        if !C::REPORTED && records > coarse / VERTICES_PER_RECORD {
            return Traffic { records, rewritten: self.rebuild(simplified, removal_lods, to) };
        }
        if !coarsens {
            self.restore_vertices(fine);
        }
        let rewritten = if C::REPORTED {
            let between = Move { fine, coarse, coarsens };
            self.move_reporting(simplified, removal_lods, between, changes)
        } else if coarsens {
            self.coarsen(simplified, fine, coarse)
        } else {
            self.refine(simplified, fine, coarse)
        };
        if coarsens {
            self.count_dead(simplified, removal_lods, coarse);
        } else {
            self.count_revived(simplified, removal_lods, fine);
        }
        self.lod = to;
        Traffic { records, rewritten }
    }

    /// The far move: resolves every vertex that is removed at either LOD. Returns how many vertices
    /// were rewritten, of those that have triangles, as near moves count.
    fn rebuild(&mut self, simplified: &Simplified, removal_lods: &[u32], to: u32) -> u64 {
        let (from, targets) = (self.lod, simplified.collapses().targets());
        let (fine, coarse) = (from.min(to), from.max(to));
        // What vertices are shown as at the finer LOD says which of them move: before the rebuild,
        // or after it.
        let count_moving = |shown_as: &[u32], vertex_removal_lods: &[u32]| {
            let vertices = shown_as.iter().zip(vertex_removal_lods).take(coarse as usize);
            vertices.filter(|&(&shown, &lod)| shown < coarse && lod > fine).count() as u64
        };
        let mut rewritten = 0;
        if to > from {
            rewritten = count_moving(&self.shown_as, &self.index.vertex_removal_lods);
        }
        for v in (0..to as usize).rev() {
            let target = targets[v];
            self.shown_as[v] = if target < to { self.shown_as[target as usize] } else { target };
        }
        for v in to..from {
            self.shown_as[v as usize] = v;
        }
        if to < from {
            rewritten = count_moving(&self.shown_as, &self.index.vertex_removal_lods);
        }
        for (live, submesh) in self.live.iter_mut().zip(simplified.mesh().submeshes()) {
            let removal_lods = &removal_lods[submesh.triangles()];
            *live = removal_lods.partition_point(|&removal_lod| removal_lod > to) as u32;
        }
        let index = &self.index;
        self.dead_triangles = index.triangles.partition_point(|&t| removal_lods[t as usize] <= to);
        let is_dead = |&v: &u32| index.vertex_removal_lods[v as usize] <= to;
        let dead = index.vertices.partition_point(is_dead);
        // Moves do not update vertices without triangles; those below `from` have been resolved
        // above.
        for &v in index.vertices.get(dead..self.dead_vertices).unwrap_or_default() {
            if v >= from {
                self.shown_as[v as usize] = v;
            }
        }
        self.dead_vertices = dead;
        self.lod = to;
        rewritten
    }

    /// Shows the targets that remain at the coarser LOD. Returns how many vertices were rewritten.
    fn coarsen(&mut self, simplified: &Simplified, fine: u32, coarse: u32) -> u64 {
        let mut rewritten = 0;
        for (record, target) in outermost(simplified, fine, coarse) {
            self.tour.for_each_live(record, fine, |v| {
                self.shown_as[v as usize] = target;
                rewritten += 1;
            });
        }
        rewritten
    }

    /// Shows the vertex of every record again; of several for one vertex the lowest comes last and
    /// stays. Returns how many vertices were rewritten.
    fn refine(&mut self, simplified: &Simplified, fine: u32, coarse: u32) -> u64 {
        let mut rewritten = 0;
        for record in (fine..coarse).rev() {
            let mut count = 0;
            self.tour.for_each_live(record, fine, |v| {
                self.shown_as[v as usize] = record;
                count += 1;
            });
            let is_first = simplified.collapses().targets()[record as usize] >= coarse;
            rewritten += if is_first { count } else { 0 };
        }
        rewritten
    }

    /// Moves and reports all changes. Returns how many vertices were rewritten.
    fn move_reporting(
        &mut self,
        simplified: &Simplified,
        removal_lods: &[u32],
        between: Move,
        changes: &mut impl Changes,
    ) -> u64 {
        let Move { fine, coarse, coarsens } = between;
        let mut moved = Vec::new();
        let (tour, coarser) = (&self.tour, &mut self.coarser_shown_as);
        for (record, target) in outermost(simplified, fine, coarse) {
            tour.for_each_live(record, fine, |v| {
                moved.push(v);
                coarser[v as usize] = target;
            });
        }
        // Either way `shown_as` is that of the finer LOD while changes are reported.
        if coarsens {
            self.report(simplified, removal_lods, &moved, between, changes);
            for &v in &moved {
                self.shown_as[v as usize] = self.coarser_shown_as[v as usize];
            }
        } else {
            self.refine(simplified, fine, coarse);
            self.report(simplified, removal_lods, &moved, between, changes);
        }
        moved.len() as u64
    }

    /// Reports every triangle around the moved vertices that is live at the finer LOD, once.
    fn report(
        &self,
        simplified: &Simplified,
        removal_lods: &[u32],
        moved: &[u32],
        Move { fine, coarse, coarsens }: Move,
        changes: &mut impl Changes,
    ) {
        let moves = |corner: u32| (fine..coarse).contains(&self.shown_as[corner as usize]);
        for &v in moved {
            let submesh = simplified.mesh().vertex_submesh()[v as usize];
            for &t in self.index.incident(v) {
                if removal_lods[t as usize] <= fine {
                    break;
                }
                let corners = simplified.mesh().triangles()[t as usize];
                // A triangle of which several corners move is reported by the first of them.
                if corners.into_iter().find(|&c| moves(c)) != Some(v) {
                    continue;
                }
                let finer =
                    OrientedTriangle::new(submesh, corners.map(|c| self.shown_as[c as usize]));
                let coarser = (removal_lods[t as usize] > coarse).then(|| {
                    let shown_as = |c: u32| {
                        let vertices =
                            if moves(c) { &self.coarser_shown_as } else { &self.shown_as };
                        vertices[c as usize]
                    };
                    OrientedTriangle::new(submesh, corners.map(shown_as))
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

    /// Counts the vertices and triangles that die on the way to a coarser LOD.
    fn count_dead(&mut self, simplified: &Simplified, removal_lods: &[u32], coarse: u32) {
        while let Some(&v) = self.index.vertices.get(self.dead_vertices)
            && self.index.vertex_removal_lods[v as usize] <= coarse
        {
            self.dead_vertices += 1;
        }
        while let Some(&t) = self.index.triangles.get(self.dead_triangles)
            && removal_lods[t as usize] <= coarse
        {
            self.live[submesh_of(simplified, t)] -= 1;
            self.dead_triangles += 1;
        }
    }

    /// Shows vertices that have triangles at a finer LOD again as what they were when they lost
    /// these: moves do not update vertices without triangles.
    fn restore_vertices(&mut self, fine: u32) {
        while let Some(&v) = self.index.vertices[..self.dead_vertices].last()
            && self.index.vertex_removal_lods[v as usize] > fine
        {
            self.dead_vertices -= 1;
            self.shown_as[v as usize] = self.index.shown_at_removal[self.dead_vertices];
        }
    }

    /// Counts the triangles that are drawn again at a finer LOD.
    fn count_revived(&mut self, simplified: &Simplified, removal_lods: &[u32], fine: u32) {
        while let Some(&t) = self.index.triangles[..self.dead_triangles].last()
            && removal_lods[t as usize] > fine
        {
            self.live[submesh_of(simplified, t)] += 1;
            self.dead_triangles -= 1;
        }
    }
}

/// The records between two LODs whose targets are shown at the coarser one, and these targets.
fn outermost(simplified: &Simplified, fine: u32, coarse: u32) -> impl Iterator<Item = (u32, u32)> {
    let targets = &simplified.collapses().targets()[fine as usize..coarse as usize];
    (fine..).zip(targets.iter().copied()).filter(move |&(_, target)| target >= coarse)
}

fn submesh_of(simplified: &Simplified, triangle: u32) -> usize {
    simplified.mesh().vertex_submesh()[simplified.mesh().triangles()[triangle as usize][0] as usize]
        as usize
}
