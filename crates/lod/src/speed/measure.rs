//! What to time of Speed Strips on a device.

use super::{Speed, replay::Device};
use crate::plan::{Benchmark, Case, PlanError, Program, sweep};

impl Speed {
    /// The linear sweep over all LODs, down and up.
    ///
    /// # Errors
    /// If a strip is longer than a kernel may loop.
    pub fn benchmark(&self) -> Result<Benchmark, PlanError> {
        let mut program = Program::default();
        let device = Device::new(&mut program, self)?;
        let stops = sweep(self.simplified.collapses());
        let vertices = stops.windows(2).map(|pair| u64::from(pair[0].max(pair[1]).0)).sum();
        let runs = stops.windows(2).map(|pair| device.passes(self, pair[0], pair[1])).collect();
        let memory = vec![("direct", program.bytes() / 4 + 3 * self.simplified.mesh().vertex_count() as u64)];
        let cases = vec![Case { name: "direct, linear sweep", runs, vertices }];
        Ok(Benchmark { program, setup: Vec::new(), cases, memory })
    }
}
