//! Timing passes by the device's own clock.

use crate::{Device, GpuError, Session};
use lodc_lod::plan::Benchmark;

/// How long one case took.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// The case.
    pub name: &'static str,
    /// Runs that were timed.
    pub runs: usize,
    /// Mean milliseconds of a run, the first time left out: that is when drivers compile.
    pub milliseconds: f64,
    /// Bytes that a host sends for a run.
    pub bytes: f64,
    /// Vertices looked at per second.
    pub vertices_per_second: f64,
}

/// Times every case of a benchmark `repeats` times and takes the fastest; nothing if the device has no clock.
///
/// # Errors
/// If the device cannot run it.
pub fn measure(device: &Device, benchmark: &Benchmark, repeats: u32) -> Result<Vec<Figure>, GpuError> {
    let mut session = Session::new(device, &benchmark.program)?;
    session.run(&benchmark.setup)?;
    let mut figures = Vec::new();
    for case in &benchmark.cases {
        for passes in &case.runs {
            session.run(passes)?;
        }
        let mut fastest = f64::INFINITY;
        for _ in 0..repeats.max(1) {
            let mut nanoseconds = 0.0;
            for passes in &case.runs {
                let Some(time) = session.timed(passes)? else { return Ok(Vec::new()) };
                nanoseconds += time;
            }
            fastest = fastest.min(nanoseconds);
        }
        figures.push(Figure {
            name: case.name,
            runs: case.runs.len(),
            milliseconds: fastest / 1e6 / case.runs.len().max(1) as f64,
            bytes: case.bytes() as f64 / case.runs.len().max(1) as f64,
            vertices_per_second: case.vertices as f64 / (fastest / 1e9),
        });
    }
    Ok(figures)
}
