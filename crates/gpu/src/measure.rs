//! Times the cases of a benchmark, passes or draws, by the device's own clock or the host's.

use crate::draw::Canvas;
use crate::{Device, GpuError, Session};
use lodc_plan::{Benchmark, Case};
use std::time::Duration;

/// A case is not repeated once it has taken this long. Chosen by hand: enough rounds for a mean,
/// few enough that a benchmark takes minutes.
const MAX_CASE_TIME: Duration = Duration::from_secs(4);

/// The time of one case.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// The case.
    pub name: &'static str,
    /// Runs that were timed.
    pub runs: usize,
    /// Mean milliseconds of a run, in each round. The first round is left out, because drivers
    /// compile then, unless it took so long that this does not matter.
    pub milliseconds: Vec<f64>,
    /// Bytes that a host sends for a run.
    pub bytes: f64,
    /// Vertices looked at by a run on average; none for draws and where none need be.
    pub vertices: Option<f64>,
}

/// Times every case of a benchmark up to `repeats` times, all in turn. A device without a clock is
/// timed by the host's, from submitting to being done. `now` is the host's clock, from any start.
///
/// # Errors
/// If the device cannot run it.
pub fn measure(
    device: &Device,
    benchmark: &Benchmark,
    repeats: u32,
    now: &dyn Fn() -> Duration,
) -> Result<Vec<Figure>, GpuError> {
    let mut session = Session::new(device, &benchmark.program)?;
    session.run(&benchmark.setup)?;
    let canvases: Vec<Option<Canvas>> = (benchmark.cases.iter())
        .map(|case| case.drawn.as_ref().map(|drawn| Canvas::new(&session, drawn)).transpose())
        .collect::<Result<_, _>>()?;
    // For each case the time spent on it, and the nanoseconds of each round.
    let mut timings = vec![(Duration::ZERO, Vec::new()); benchmark.cases.len()];
    for round in 0..=repeats.max(1) {
        for ((case, canvas), (spent, rounds)) in
            benchmark.cases.iter().zip(&canvases).zip(&mut timings)
        {
            if *spent > MAX_CASE_TIME {
                continue;
            }
            let start = now();
            let nanoseconds = session.timed(&case.before, &case.runs, canvas.as_ref(), now)?;
            *spent += now().saturating_sub(start);
            if round > 0 || *spent > MAX_CASE_TIME {
                rounds.push(nanoseconds);
            }
        }
    }
    Ok(benchmark
        .cases
        .iter()
        .zip(timings)
        .map(|(case, (_, rounds))| figure(case, &rounds))
        .collect())
}

/// The figure of a case, of the nanoseconds that all its runs took in each round.
fn figure(case: &Case, nanoseconds: &[f64]) -> Figure {
    let runs = case.runs.len().max(1) as f64;
    Figure {
        name: case.name,
        runs: case.runs.len(),
        milliseconds: nanoseconds.iter().map(|n| n / 1e6 / runs).collect(),
        bytes: case.bytes() as f64 / runs,
        vertices: (case.vertices > 0).then(|| case.vertices as f64 / runs),
    }
}
