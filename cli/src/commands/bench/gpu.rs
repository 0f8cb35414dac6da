//! Timing models on a graphics device, by the device's own clock.

use super::report::BenchObject;
use crate::exit::Outcome;
use crate::gpu::{self, Device, GpuArgs, GpuUse};
use lodc_formats::lodc::LodObject;

/// Opens the device that was asked for; none if none was, or none is there that need not be.
///
/// # Errors
/// If one is required and there is none.
pub(super) fn open(args: &GpuArgs) -> Outcome<Option<Device>> {
    match (args.gpu, args.gpu.map(|_| gpu::open(args.adapter.as_deref()))) {
        (_, None) => Ok(None),
        (Some(GpuUse::Auto), Some(Err(failure))) => {
            crate::console::note(&format!("nothing is timed on a GPU: {failure}"));
            Ok(None)
        }
        (_, Some(opened)) => opened.map(Some),
    }
}

/// Adds what the device takes for each model that it can show.
///
/// # Errors
/// If the device fails or is too small.
#[cfg(feature = "gpu")]
pub(super) fn measure(
    device: &Device,
    object: &LodObject,
    rounds: u32,
    report: &mut BenchObject,
) -> Outcome<()> {
    use super::report::{CaseReport, GpuReport, MemoryReport, value};
    use super::timings::Timings;
    use crate::exit::{Failure, Status};
    use lodc_model::Model;
    use std::time::Instant;

    let start = Instant::now();
    for model in &object.models {
        let failed = |what: String| format!("{}: {what}", object.info.name);
        let benchmark =
            model.benchmark().map_err(|e| Failure::new(Status::Limit, failed(e.to_string())))?;
        let figures = lodc_gpu::measure(device, &benchmark, rounds, &|| start.elapsed())
            .map_err(|e| gpu::failure(&e))?;
        let per_vertex =
            |words: u64| words as f64 / report.counts.referenced_vertices.max(1) as f64;
        let cases = figures.iter().map(|f| {
            let timings: Timings = f.milliseconds.iter().copied().collect();
            let case = CaseReport {
                runs: f.runs as u64,
                milliseconds: timings.best(),
                spread: timings.spread(),
                bytes: f.bytes,
                million_vertices_per_second: f.vertices.map(|n| n / timings.best() / 1e3),
            };
            (f.name.to_owned(), value(&case))
        });
        let report = report.gpu.get_or_insert_with(|| GpuReport {
            adapter: device.adapter().to_string(),
            ..GpuReport::default()
        });
        report.clock = if device.has_clock() { "device" } else { "host" };
        let memory = benchmark.memory.iter().map(|m| {
            let words =
                MemoryReport { positions: per_vertex(m.positions), normals: per_vertex(m.normals) };
            (m.variant.to_owned(), value(&words))
        });
        report
            .words_per_vertex
            .insert(model.name().to_owned(), serde_json::Value::Object(memory.collect()));
        report.models.insert(model.name().to_owned(), serde_json::Value::Object(cases.collect()));
    }
    Ok(())
}

/// There is no device.
///
/// # Errors
/// Never.
#[cfg(not(feature = "gpu"))]
pub(super) fn measure(device: &Device, _: &LodObject, _: u32, _: &mut BenchObject) -> Outcome<()> {
    match *device {}
}
