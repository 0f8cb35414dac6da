//! Progress of a generator, summed over its threads and reported in triangles of the mesh.

use std::sync::atomic::{AtomicU64, Ordering};

/// Gets the number of triangles done since the last report. For each generator they add up to those
/// of the mesh.
pub type Report<'a> = &'a (dyn Fn(u64) + Sync);

/// The work of a generator that goes over all triangles a number of times.
pub(crate) struct Meter<'a> {
    report: Report<'a>,
    passes: u64,
    done: AtomicU64,
}

impl<'a> Meter<'a> {
    pub(crate) fn new(report: Report<'a>, passes: usize) -> Self {
        Self { report, passes: passes.max(1) as u64, done: AtomicU64::new(0) }
    }

    /// Adds triangles that a pass has done.
    pub(crate) fn add(&self, triangles: usize) {
        let before = self.done.fetch_add(triangles as u64, Ordering::Relaxed);
        (self.report)((before + triangles as u64) / self.passes - before / self.passes);
    }
}
