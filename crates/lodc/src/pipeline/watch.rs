//! Progress of long work, as a caller learns of it.

/// Is told which stage of some work runs, and how far it is. `()` ignores it.
pub trait Watch: Sync {
    /// A stage begins, or the one that runs starts over: `units` of work, if they are counted.
    fn begin(&self, _stage: &'static str, _units: Option<u64>) {}
    /// More units of the stage are done; called by any thread.
    fn add(&self, _units: u64) {}
    /// The stage is over.
    fn end(&self, _stage: &'static str) {}
    /// A line about the result, for who uses it.
    fn note(&self, _line: String) {}
}

impl Watch for () {}

/// Does work as a stage.
pub(crate) fn run_stage<T>(
    watch: &dyn Watch,
    stage: &'static str,
    units: Option<u64>,
    work: impl FnOnce() -> T,
) -> T {
    watch.begin(stage, units);
    let result = work();
    watch.end(stage);
    result
}
