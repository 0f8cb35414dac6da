//! A cursor over a Progressive Mesh: edge collapses and vertex splits, one after the other.

use super::moving::{Faces, Watch};
use super::record::Records;
use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use lodc_model::{Changes, Traffic};

/// The moving part of a [`ProgressiveMesh`](super::ProgressiveMesh).
#[derive(Clone, Debug)]
pub struct Cursor {
    /// Number of steps (collapses) that are done.
    steps: usize,
    faces: Faces,
    /// Number of triangles of each submesh that are drawn: its first ones.
    live: Vec<u32>,
    touched: Touched,
}

/// Triangles as they were before a move changed them; empty while changes are ignored.
#[derive(Clone, Debug, Default)]
struct Touched {
    /// The number of the move that last changed each triangle.
    last_move: Vec<u32>,
    /// The number of the present move.
    present_move: u32,
    /// Triangles that the present move has changed, with their corners before it.
    before: Vec<(u32, [u32; 3])>,
}

impl Watch for Touched {
    fn changes(&mut self, faces: &Faces, triangle: u32) {
        if std::mem::replace(&mut self.last_move[triangle as usize], self.present_move)
            != self.present_move
        {
            self.before.push((triangle, corners(faces, triangle)));
        }
    }
}

fn corners(faces: &Faces, triangle: u32) -> [u32; 3] {
    let first = 3 * triangle as usize;
    [faces.corners[first], faces.corners[first + 1], faces.corners[first + 2]]
}

impl Cursor {
    pub(super) fn new(simplified: &Simplified, records: &Records) -> Self {
        Self {
            steps: 0,
            faces: Faces::new(simplified.mesh(), &records.opposite),
            live: simplified.mesh().submeshes().iter().map(|s| s.triangle_count).collect(),
            touched: Touched::default(),
        }
    }

    pub(super) fn lod(&self, simplified: &Simplified) -> Lod {
        Lod(end_of(simplified, self.steps))
    }

    pub(super) fn drawn(&self) -> u64 {
        3 * self.live.iter().map(|&l| u64::from(l)).sum::<u64>()
    }

    pub(super) fn triangles(
        &self,
        simplified: &Simplified,
    ) -> impl Iterator<Item = OrientedTriangle> {
        let submeshes = (0..).zip(simplified.mesh().submeshes().iter().zip(&self.live));
        submeshes.flat_map(move |(s, (submesh, &live))| {
            let drawn = submesh.first_triangle..submesh.first_triangle + live;
            drawn.map(move |t| OrientedTriangle::new(s, corners(&self.faces, t)))
        })
    }

    pub(super) fn seek<C: Changes>(
        &mut self,
        simplified: &Simplified,
        records: &Records,
        lod: Lod,
        changes: &mut C,
    ) -> Traffic {
        let (from, to) = (self.lod(simplified), simplified.collapses().floor(lod));
        let rewritten = if C::REPORTED {
            let mut touched = std::mem::take(&mut self.touched);
            touched.last_move.resize(records.removal_lods.len(), 0);
            touched.present_move += 1;
            let rewritten = self.walk(simplified, records, to, &mut touched);
            for (triangle, before) in touched.before.drain(..) {
                let (submesh, removal_lod) =
                    (submesh_of(simplified, triangle), records.removal_lods[triangle as usize]);
                if removal_lod > from.0 {
                    changes.removed(OrientedTriangle::new(submesh, before));
                }
                if removal_lod > to.0 {
                    changes.added(OrientedTriangle::new(submesh, corners(&self.faces, triangle)));
                }
            }
            self.touched = touched;
            rewritten
        } else {
            self.walk(simplified, records, to, &mut ())
        };
        Traffic { records: from.0.abs_diff(to.0), rewritten }
    }

    fn walk(
        &mut self,
        simplified: &Simplified,
        records: &Records,
        to: Lod,
        watch: &mut impl Watch,
    ) -> u64 {
        let targets = simplified.collapses().targets();
        let ends = &simplified.collapses().parts().step_ends;
        let mut rewritten = 0;
        let mut lod = end_of(simplified, self.steps);
        while lod < to.0 {
            let end = ends[self.steps];
            rewritten +=
                self.faces.collapse(records, self.steps, lod..end, |v| targets[v as usize], watch);
            self.steps += 1;
            lod = end;
        }
        while lod > to.0 {
            self.steps -= 1;
            let start = end_of(simplified, self.steps);
            rewritten += self.faces.split(records, self.steps, start..lod, watch);
            lod = start;
        }
        self.update_live(simplified, records, to);
        rewritten
    }

    /// Moves the end of the drawn triangles of each submesh.
    fn update_live(&mut self, simplified: &Simplified, records: &Records, lod: Lod) {
        for (live, submesh) in self.live.iter_mut().zip(simplified.mesh().submeshes()) {
            let removal_lods = &records.removal_lods[submesh.triangles()];
            while *live > 0 && removal_lods[*live as usize - 1] <= lod.0 {
                *live -= 1;
            }
            while removal_lods.get(*live as usize).is_some_and(|&removal_lod| removal_lod > lod.0) {
                *live += 1;
            }
        }
    }
}

/// The LOD after some steps.
fn end_of(simplified: &Simplified, steps: usize) -> u32 {
    if steps == 0 { 0 } else { simplified.collapses().parts().step_ends[steps - 1] }
}

fn submesh_of(simplified: &Simplified, triangle: u32) -> u32 {
    simplified.mesh().vertex_submesh()[simplified.mesh().triangles()[triangle as usize][0] as usize]
}
