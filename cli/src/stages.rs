//! Measured durations of a command's stages, for `--verbose` and JSON.

use crate::clock::Clock;
use crate::console::detail;
use crate::memory;
use crate::progress::Progress;
use lodc::pipeline::{Tick, Watch};
use lodc_report::documents::StageReport;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// The stages of one input so far, and its clock.
#[derive(Debug)]
pub(crate) struct Stages {
    done: Vec<StageReport>,
    /// What the stages told of their result.
    notes: Vec<String>,
    clock: Clock,
}

impl Stages {
    /// No stages yet, of an input with this clock.
    pub(crate) fn new(clock: Clock) -> Self {
        Self { done: Vec::new(), notes: Vec::new(), clock }
    }
    /// Does work as a stage of this name, unless the asset's time is over.
    pub(crate) fn run<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        self.clock.check();
        let start = Instant::now();
        let result = work();
        self.add(name, start);
        result
    }
    /// Does work as a stage of this name. It calls the function that it is given now and then; that
    /// leaves the work when the asset's time is over.
    pub(crate) fn checked<T>(
        &mut self,
        name: &'static str,
        work: impl FnOnce(&Tick<'_>) -> T,
    ) -> T {
        let clock = self.clock.clone();
        self.run(name, || work(&|| clock.check()))
    }
    /// For work that announces its stages itself.
    pub(crate) fn watched<'a>(&'a mut self, progress: &'a Progress) -> Watched<'a> {
        let clock = self.clock.clone();
        Watched { progress, clock, stages: Mutex::new(WatchedStages { all: self, start: None }) }
    }
    fn add(&mut self, name: &'static str, start: Instant) {
        let seconds = start.elapsed().as_secs_f64();
        print(name, seconds);
        self.done.push(StageReport { name, seconds });
    }
    /// Takes what the stages told of their result, for its warnings.
    pub(crate) fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }
    /// Seconds of all stages.
    pub(crate) fn seconds(&self) -> f64 {
        self.done.iter().map(|s| s.seconds).sum()
    }
    pub(crate) fn into_reports(self) -> Vec<StageReport> {
        self.done
    }
}

/// With `--verbose`, prints the time of a stage, and the largest memory so far.
pub(crate) fn print(name: &str, seconds: f64) {
    detail(&format!("{name:>9} {seconds:9.3} s {:7} MiB peak", memory::peak_bytes() >> 20));
}

/// Takes down durations and progress of the library's work, and leaves it when the time is over.
#[derive(Debug)]
pub(crate) struct Watched<'a> {
    progress: &'a Progress,
    clock: Clock,
    stages: Mutex<WatchedStages<'a>>,
}

#[derive(Debug)]
struct WatchedStages<'a> {
    all: &'a mut Stages,
    /// When the present stage began.
    start: Option<Instant>,
}

impl Watch for Watched<'_> {
    fn begin(&self, stage: &'static str, units: Option<u64>) {
        self.clock.check();
        match units {
            Some(units) => self.progress.stage_with_units(stage, units),
            None => self.progress.stage(stage),
        }
        let mut stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        stages.start.get_or_insert_with(Instant::now);
    }
    fn add(&self, units: u64) {
        self.clock.check();
        self.progress.add(units);
    }
    fn end(&self, stage: &'static str) {
        let mut stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(start) = stages.start.take() {
            stages.all.add(stage, start);
        }
    }
    fn note(&self, line: String) {
        let mut stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        stages.all.notes.push(line);
    }
}
