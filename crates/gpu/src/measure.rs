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

/// Times every case of a benchmark in up to `repeats` rounds, at least one. Each times all
/// cases in turn. A device without a clock is timed by the host's, from submitting to being done.
/// `now` is the host's clock, from any start.
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
    let mut timings = vec![Timing::default(); benchmark.cases.len()];
    for round in 0..=repeats.max(1) {
        for (i, case) in benchmark.cases.iter().enumerate() {
            let timing = &mut timings[i];
            if timing.spent > MAX_CASE_TIME {
                continue;
            }
            let start = now();
            let nanoseconds = session.timed(&case.before, &case.runs, canvases[i].as_ref(), now)?;
            timing.spent += now().saturating_sub(start);
            if round > 0 || timing.spent > MAX_CASE_TIME {
                timing.nanoseconds.push(nanoseconds);
            }
        }
    }
    let timed = benchmark.cases.iter().zip(&timings);
    Ok(timed.map(|(case, timing)| figure(case, &timing.nanoseconds)).collect())
}

/// What is known of a case so far.
#[derive(Clone, Default)]
struct Timing {
    /// The host's time spent on it, with all that is not timed.
    spent: Duration,
    /// For each round that counts, the nanoseconds of all runs together.
    nanoseconds: Vec<f64>,
}

/// The figure of a case, given for each round the nanoseconds of all its runs together.
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
