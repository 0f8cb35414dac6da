//! Durations of stages.

use crate::console::detail;
use crate::memory;
use crate::report::StageReport;
use std::time::Instant;

/// The stages of one input so far.
#[derive(Debug, Default)]
pub(crate) struct Stages(Vec<StageReport>);

impl Stages {
    /// Does some work as a stage of this name.
    pub(crate) fn run<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        let seconds = start.elapsed().as_secs_f64();
        detail(&format!("{name:>9} {seconds:9.3} s {:7} MiB peak", memory::peak_bytes() >> 20));
        self.0.push(StageReport { name, seconds });
        result
    }
    /// Seconds of all stages.
    pub(crate) fn seconds(&self) -> f64 {
        self.0.iter().map(|s| s.seconds).sum()
    }
    pub(crate) fn into_reports(self) -> Vec<StageReport> {
        self.0
    }
}
