//! What to time on a device.

use super::{Pass, Program};

/// A program and the cases in which it is timed.
#[derive(Clone, Debug)]
pub struct Benchmark {
    /// Buffers and kernels.
    pub program: Program,
    /// Run once, before anything is timed.
    pub setup: Vec<Pass>,
    /// What is timed, in order.
    pub cases: Vec<Case>,
    /// Words on the device, by variant of the model.
    pub memory: Vec<(&'static str, u64)>,
}

/// Some runs of one kind.
#[derive(Clone, Debug)]
pub struct Case {
    /// What is timed.
    pub name: &'static str,
    /// One after the other; each is timed by itself.
    pub runs: Vec<Vec<Pass>>,
    /// Vertices that all runs together look at.
    pub vertices: u64,
}

impl Case {
    /// Bytes that a host sends to the device for all runs: the parameters of the passes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.runs.iter().flatten().map(|pass| 4 * pass.parameters.len() as u64).sum()
    }
}
