//! Durations of stages.

use crate::console::detail;
use crate::memory;
use crate::progress::Progress;
use lodc::build::Watch;
use lodc_report::documents::StageReport;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// The stages of one input so far.
#[derive(Debug, Default)]
pub(crate) struct Stages(Vec<StageReport>);

impl Stages {
    /// Does some work as a stage of this name.
    pub(crate) fn run<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.add(name, start);
        result
    }
    /// Work that says itself which of its stages runs.
    pub(crate) fn watched<'a>(&'a mut self, progress: &'a Progress) -> Watched<'a> {
        Watched { progress, stages: Mutex::new((self, None)) }
    }
    fn add(&mut self, name: &'static str, start: Instant) {
        let seconds = start.elapsed().as_secs_f64();
        detail(&format!("{name:>9} {seconds:9.3} s {:7} MiB peak", memory::peak_bytes() >> 20));
        self.0.push(StageReport { name, seconds });
    }
    /// Seconds of all stages.
    pub(crate) fn seconds(&self) -> f64 {
        self.0.iter().map(|s| s.seconds).sum()
    }
    pub(crate) fn into_reports(self) -> Vec<StageReport> {
        self.0
    }
}

/// Durations and progress of the library's work.
#[derive(Debug)]
pub(crate) struct Watched<'a> {
    progress: &'a Progress,
    /// The stages so far, and when the present one began.
    stages: Mutex<(&'a mut Stages, Option<Instant>)>,
}

impl Watch for Watched<'_> {
    fn begin(&self, stage: &'static str, units: Option<u64>) {
        match units {
            Some(units) => self.progress.stage_of(stage, units),
            None => self.progress.stage(stage),
        }
        let mut stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        stages.1.get_or_insert_with(Instant::now);
    }
    fn add(&self, units: u64) {
        self.progress.add(units);
    }
    fn end(&self, stage: &'static str) {
        let mut stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(start) = stages.1.take() {
            stages.0.add(stage, start);
        }
    }
}
