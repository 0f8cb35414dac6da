//! What to time of Masking Strips on a device.

use super::{Masking, replay::Device};
use crate::plan::{Benchmark, Case, PlanError, Program, sweep};

impl Masking {
    /// The linear sweep over all LODs, down and up.
    ///
    /// # Errors
    /// If a strip changes too often for a kernel.
    pub fn benchmark(&self) -> Result<Benchmark, PlanError> {
        let mut program = Program::default();
        let device = Device::new(&mut program, self)?;
        let stops = sweep(self.simplified.collapses());
        let vertices = stops.windows(2).map(|pair| u64::from(pair[0].max(pair[1]).0)).sum();
        let runs = stops[1..].iter().map(|&lod| device.passes(lod)).collect();
        let memory = vec![("masks", program.bytes() / 4 + 3 * self.simplified.mesh().vertex_count() as u64)];
        let cases = vec![Case { name: "masks, linear sweep", runs, vertices }];
        Ok(Benchmark { program, setup: Vec::new(), cases, memory })
    }
}
