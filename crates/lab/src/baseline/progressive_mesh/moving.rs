//! The mesh that edge collapses and vertex splits work on: triangles with neighbour pointers.

use super::connect::{next, previous};
use super::record::Records;
use lodc_mesh::{Mesh, NONE};
use std::ops::Range;

/// Hears of every triangle just before it changes.
pub(super) trait Watch {
    fn changes(&mut self, faces: &Faces, triangle: u32);
}

impl Watch for () {
    fn changes(&mut self, _: &Faces, _: u32) {}
}

/// The triangles as they are drawn, and their neighbours. Dead ones keep what they had last.
#[derive(Clone, Debug)]
pub(super) struct Faces {
    /// The index list: three vertices for each triangle.
    pub(super) corners: Vec<u32>,
    /// The half-edge across each half-edge.
    pub(super) opposite: Vec<u32>,
}

impl Faces {
    pub(super) fn new(mesh: &Mesh, opposite: &[u32]) -> Self {
        Self { corners: mesh.triangles().as_flattened().to_vec(), opposite: opposite.to_vec() }
    }

    /// One step coarser: rewrites the fans of its records (`numbers`), then takes the dying
    /// triangles out from between their neighbours. Returns how many corners were rewritten.
    pub(super) fn collapse(
        &mut self,
        records: &Records,
        step: usize,
        numbers: Range<u32>,
        target: impl Fn(u32) -> u32,
        watch: &mut impl Watch,
    ) -> u64 {
        let mut rewritten = 0;
        for record in numbers.clone() {
            let mut to = target(record);
            while to < numbers.end {
                to = target(to);
            }
            rewritten += self.rewrite(records, record, to, watch);
        }
        for &edge in records.lost_in(step) {
            watch.changes(self, edge / 3);
            let [a, b] = [next(edge), previous(edge)].map(|h| self.opposite[h as usize]);
            self.join(a, b);
            self.join(b, a);
        }
        rewritten
    }

    /// Undoes [`Self::collapse`].
    pub(super) fn split(
        &mut self,
        records: &Records,
        step: usize,
        numbers: Range<u32>,
        watch: &mut impl Watch,
    ) -> u64 {
        // A dead triangle still points at its neighbours; taken in the opposite order they are the
        // right ones.
        for &edge in records.lost_in(step).iter().rev() {
            watch.changes(self, edge / 3);
            for h in [next(edge), previous(edge)] {
                self.join(self.opposite[h as usize], h);
            }
        }
        numbers.map(|record| self.rewrite(records, record, record, watch)).sum()
    }

    fn join(&mut self, a: u32, b: u32) {
        if a != NONE {
            self.opposite[a as usize] = b;
        }
    }

    /// Writes a vertex into the corners of a record's fans.
    fn rewrite(
        &mut self,
        records: &Records,
        record: u32,
        vertex: u32,
        watch: &mut impl Watch,
    ) -> u64 {
        let mut rewritten = 0;
        for fan in records.fans_of(record) {
            let mut corner = fan.corner;
            watch.changes(self, corner / 3);
            self.corners[corner as usize] = vertex;
            for _ in 1..fan.corners {
                corner = self.opposite[previous(corner) as usize];
                watch.changes(self, corner / 3);
                self.corners[corner as usize] = vertex;
            }
            rewritten += u64::from(fan.corners);
        }
        rewritten
    }
}
