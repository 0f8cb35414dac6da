//! Timing models on a graphics device, by the device's own clock.

#[cfg(feature = "gpu")]
use super::report::DrawnCurve;
use super::report::{BenchObject, DeviceCurve};
use super::subject::Subject;
use crate::exit::Outcome;
use crate::gpu::{self, Device, GpuArgs, GpuUse};
use lodc_formats::lodc::LodObject;
use lodc_mesh::{Lod, Simplified};
#[cfg(feature = "gpu")]
use std::collections::BTreeMap;
#[cfg(feature = "gpu")]
use std::time::Instant;

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
    use super::report::{CaseReport, GpuReport, MemoryReport};
    use super::timings::Timings;
    use crate::exit::{Failure, Status};
    use lodc_model::Model;

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
            (f.name.to_owned(), case)
        });
        let report = report.gpu.get_or_insert_with(|| GpuReport {
            adapter: device.adapter().to_string(),
            ..GpuReport::default()
        });
        report.clock = if device.has_clock() { "device" } else { "host" };
        let memory = benchmark.memory.iter().map(|m| {
            let words =
                MemoryReport { positions: per_vertex(m.positions), normals: per_vertex(m.normals) };
            (m.variant.to_owned(), words)
        });
        report.words_per_vertex.insert(model.name(), memory.collect());
        report.models.insert(model.name(), cases.collect());
    }
    Ok(())
}

/// LODs of a curve on a device.
#[cfg(feature = "gpu")]
const LODS: usize = 20;

/// Adds draws of every structure over LODs, and what its last update before each sends.
///
/// # Errors
/// If the device fails or is too small.
#[cfg(feature = "gpu")]
pub(super) fn curve(
    device: &Device,
    simplified: &Simplified,
    subjects: &mut [Subject<'_>],
    stops: &[Lod],
    rounds: u32,
) -> Outcome<DeviceCurve> {
    use lodc_gpu::picture::{Camera, Framing, Lens, Up};
    use lodc_gpu::{Instance, Instanced, InstancedDraw, InstancedFrame};

    let positions = simplified.mesh().positions().to_vec();
    let wide: Vec<[f64; 3]> = positions.iter().map(|p| p.map(f64::from)).collect();
    let framing =
        Framing { up: Up::Y, azimuth: 30.0, elevation: 20.0, lens: Lens::Orthographic, zoom: 1.0 };
    let camera = Camera::around(&wide, &framing, 1.0);
    let stage = Instanced::new(device, &[positions], &camera).map_err(|e| gpu::failure(&e))?;
    let place = camera.centre.map(|c| -c as f32);
    let count = stops.len().min(LODS);
    let at: Vec<usize> = (1..=count).map(|i| i * stops.len() / count - 1).collect();
    let collapses = simplified.collapses();
    let start = Instant::now();
    let now = || start.elapsed();
    let best = |time: &dyn Fn() -> Result<f64, lodc_gpu::GpuError>| -> Outcome<f64> {
        // In the first round drivers compile.
        let all = (0..=rounds).map(|_| time()).collect::<Result<Vec<f64>, _>>();
        let all = all.map_err(|e| gpu::failure(&e))?;
        Ok(all[1..].iter().copied().fold(f64::INFINITY, f64::min) / 1e6)
    };
    let mut curve = DeviceCurve {
        lods: at.iter().map(|&i| stops[i].0).collect(),
        triangles: at.iter().map(|&i| collapses.triangles_at(stops[i])).collect(),
        structures: BTreeMap::new(),
    };
    for subject in subjects.iter_mut().filter(|s| s.continuous) {
        let mut drawn = DrawnCurve::default();
        for &i in &at {
            subject.runner.seek(if i == 0 { Lod(0) } else { stops[i - 1] });
            let (_, bytes) = subject.runner.send(stops[i]);
            let indices: Vec<u32> =
                subject.runner.triangles().iter().flat_map(|t| t.corners).collect();
            let all = 0..indices.len() as u32;
            let frame = InstancedFrame {
                indices,
                instances: vec![Instance { place, turn: [1.0, 0.0] }],
                draws: vec![InstancedDraw { mesh: 0, indices: all, instances: 0..1 }],
            };
            drawn.draw_ms.push(best(&|| stage.timed(&frame, &now))?);
            drawn.bytes.push(bytes);
            drawn.upload_ms.push(best(&|| stage.upload(bytes, &now))?);
        }
        subject.runner.seek(Lod(0));
        curve.structures.insert(subject.name.to_owned(), drawn);
    }
    Ok(curve)
}

/// There is no device.
///
/// # Errors
/// Never.
#[cfg(not(feature = "gpu"))]
pub(super) fn curve(
    device: &Device,
    _: &Simplified,
    _: &mut [Subject<'_>],
    _: &[Lod],
    _: u32,
) -> Outcome<DeviceCurve> {
    match *device {}
}

/// There is no device.
///
/// # Errors
/// Never.
#[cfg(not(feature = "gpu"))]
pub(super) fn measure(device: &Device, _: &LodObject, _: u32, _: &mut BenchObject) -> Outcome<()> {
    match *device {}
}
