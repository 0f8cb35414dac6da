//! Times of models on a graphics device: by the device's clock where it has one, else by the
//! host's. Draws and uploads of whole levels are timed by the host's in any case.

use crate::error::LabError;
use crate::primitives::Primitive;
use crate::report::{CaseReport, DrawnCurve, GpuReport, MemoryReport, PrimitiveDraws};
use crate::structures::Measured;
use crate::timings::Timings;
use lodc::LodObject;
pub use lodc_gpu::Device;
use lodc_gpu::{DRAWN_UPDATES, SWEEP_UPDATES, drawn_stops, timed_updates};
use lodc_gpu::{GpuError, Instance, Instanced, InstancedDraw, InstancedFrame};
use lodc_measure::render::{Camera, Framing, Lens, Up};
use lodc_mesh::{Lod, Simplified};
use lodc_model::Model;
use lodc_report::text::grouped;
use std::time::{Duration, Instant};

/// Returns the times and memory of each model, and the times of draws of every structure over the
/// LODs `stops` of a sweep; none if there is no model. What the device has no room for is named.
///
/// # Errors
/// If the device fails.
pub(crate) fn measure(
    device: &Device,
    object: &LodObject,
    levels: [Vec<Primitive>; 2],
    structures: &mut [Measured<'_>],
    stops: &[Lod],
    rounds: u32,
) -> Result<Option<GpuReport>, LabError> {
    let mut report = GpuReport {
        adapter: device.adapter().to_string(),
        clock: if device.has_clock() { "device" } else { "host" },
        limit: limit(&object.simplified),
        ..GpuReport::default()
    };
    let simplified = &object.simplified;
    // Of LOD 0: fakes are not counted, as other tools have none.
    let vertices = (simplified.mesh().vertex_count() - simplified.fakes()).max(1) as f64;
    let start = Instant::now();
    for model in &object.models {
        let benchmark = match model.benchmark() {
            Ok(benchmark) => benchmark,
            Err(error) => {
                report.left_out.insert(model.name().to_owned(), error.to_string());
                continue;
            }
        };
        let memory = benchmark.memory.iter().map(|m| {
            let [positions, normals] = [m.positions, m.normals].map(|w| w as f64 / vertices);
            (m.variant.to_owned(), MemoryReport { positions, normals })
        });
        report.words_per_vertex.insert(model.name(), memory.collect());
        // Room for all of it is asked for before anything is sent.
        let timed = lodc_gpu::measure(device, &benchmark, rounds, &|| start.elapsed());
        let Some(figures) = report.fitting(model.name(), timed)? else { continue };
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
        report.models.insert(model.name(), cases.collect());
    }
    if let Some(stage) = report.fitting("draws", Stage::new(device, simplified, rounds))? {
        primitives(&stage, levels, &mut report)?;
        curve(&stage, simplified, structures, stops, &mut report)?;
    }
    Ok((!object.models.is_empty()).then_some(report))
}

impl GpuReport {
    /// What came of work of this name; none, and a line, if the device has no room for it.
    fn fitting<T>(&mut self, name: &str, done: Result<T, GpuError>) -> Result<Option<T>, GpuError> {
        match done {
            Err(error @ GpuError::Limit { .. }) => {
                self.left_out.insert(name.to_owned(), error.to_string());
                Ok(None)
            }
            done => done.map(Some),
        }
    }
}

/// Triangles of a mesh that is timed on a device of software. Chosen by hand: all of it takes some
/// minutes.
const MAX_TRIANGLES_ON_SOFTWARE: u64 = 2_000_000;

/// Bytes of the longest list of a model for each triangle, about; most are shorter.
const LIST_BYTES: u64 = 32;

/// The most triangles of a mesh whose models are timed on a device: what its buffers hold, and of
/// software what does not take too long.
#[must_use]
pub fn most_triangles(device: &Device) -> u64 {
    let held = device.largest_binding() / LIST_BYTES;
    if device.adapter().software { held.min(MAX_TRIANGLES_ON_SOFTWARE) } else { held }
}

/// What takes longer than this is not repeated. Chosen by hand.
const MAX_ROUNDS_NANOSECONDS: f64 = 5e8;

/// The host's clock.
type Clock<'a> = &'a dyn Fn() -> Duration;

/// An object seen from one fixed side, for timing draws of its levels.
struct Stage<'d> {
    drawn: Instanced<'d>,
    instance: Instance,
    rounds: u32,
    start: Instant,
}

impl<'d> Stage<'d> {
    fn new(device: &'d Device, simplified: &Simplified, rounds: u32) -> Result<Self, GpuError> {
        let positions = simplified.mesh().positions().to_vec();
        let wide: Vec<[f64; 3]> = positions.iter().map(|p| p.map(f64::from)).collect();
        let lens = Lens::Orthographic;
        let framing = Framing { up: Up::Y, azimuth: 30.0, elevation: 20.0, lens, zoom: 1.0 };
        let camera = Camera::around(&wide, &framing, 1.0);
        let origin = camera.centre.map(|c| -c as f32);
        let instance = Instance { origin, rotation: [1.0, 0.0] };
        let drawn = Instanced::new(device, &[positions], camera.matrix())?;
        Ok(Self { drawn, instance, rounds, start: Instant::now() })
    }

    /// Milliseconds of the best round. The first one is not counted, because drivers compile
    /// shaders in it, unless it took so long that this does not matter.
    fn best(&self, time: &dyn Fn(Clock<'_>) -> Result<f64, GpuError>) -> Result<f64, GpuError> {
        let now = || self.start.elapsed();
        let first = time(&now)?;
        let (mut best, mut spent) = (f64::INFINITY, first);
        let mut rounds = 0;
        while spent <= MAX_ROUNDS_NANOSECONDS && rounds < self.rounds {
            let taken = time(&now)?;
            (best, spent, rounds) = (best.min(taken), spent + taken, rounds + 1);
        }
        Ok(if rounds == 0 { first } else { best } / 1e6)
    }

    /// Milliseconds of drawing indices of triangles, or of strips.
    fn draw_ms(&self, indices: Vec<u32>, strips: bool) -> Result<f64, GpuError> {
        let all = 0..indices.len() as u32;
        let draws = vec![InstancedDraw { mesh: 0, indices: all, instances: 0..1 }];
        let frame = InstancedFrame { indices, strips, instances: vec![self.instance], draws };
        self.best(&|now| self.drawn.timed(&frame, now))
    }
}

/// Times draws of the four primitives of table 5.3 of the thesis, at LOD 0 and at 20 % of the
/// triangles.
fn primitives(
    stage: &Stage<'_>,
    [whole, fifth]: [Vec<Primitive>; 2],
    report: &mut GpuReport,
) -> Result<(), GpuError> {
    for (whole, fifth) in whole.into_iter().zip(fifth) {
        let draws = || {
            let draw_ms = stage.draw_ms(whole.indices, whole.strips)?;
            let draw_ms_20 = stage.draw_ms(fifth.indices, fifth.strips)?;
            Ok(PrimitiveDraws { draw_ms, draw_ms_20 })
        };
        if let Some(draws) = report.fitting(whole.name, draws())? {
            report.primitives.insert(whole.name, draws);
        }
    }
    Ok(())
}

/// Points of a curve on a device, and those of a large mesh, at least. Chosen by hand: more points
/// take more draws and uploads.
const POINTS: usize = 20;
const MIN_POINTS: usize = 4;

/// Triangles of a mesh times points of a curve. Chosen by hand.
const MAX_TRIANGLES_AT_POINTS: usize = 10_000_000;

/// The number of points of a curve over the LODs of a mesh.
fn point_count(simplified: &Simplified) -> usize {
    let triangles = simplified.mesh().triangles().len().max(1);
    (MAX_TRIANGLES_AT_POINTS / triangles).clamp(MIN_POINTS, POINTS)
}

/// What is left out because the mesh is large, for people; none if nothing is.
fn limit(simplified: &Simplified) -> Option<String> {
    let updates = timed_updates(simplified).len();
    let [draws, all_draws] = [drawn_stops(simplified).len() - 1, 2 * DRAWN_UPDATES as usize];
    let [points, all] = [point_count(simplified), 2 * SWEEP_UPDATES as usize];
    let is_whole = updates >= all && draws >= all_draws && points >= POINTS;
    (!is_whole).then(|| {
        format!(
            "the mesh is large: {} of {} updates, {draws} of {all_draws} draws and {points} of \
             {POINTS} levels are timed",
            grouped(updates as u64),
            grouped(all as u64)
        )
    })
}

/// Times draws of every structure over some LODs, and the upload of the update that leads to each
/// from the LOD before it in the sweep.
fn curve(
    stage: &Stage<'_>,
    simplified: &Simplified,
    structures: &mut [Measured<'_>],
    stops: &[Lod],
    report: &mut GpuReport,
) -> Result<(), GpuError> {
    let count = stops.len().min(point_count(simplified));
    let stop_numbers: Vec<usize> = (1..=count).map(|i| i * stops.len() / count - 1).collect();
    let collapses = simplified.collapses();
    report.curve.lods = stop_numbers.iter().map(|&i| stops[i].0).collect();
    report.curve.triangles =
        stop_numbers.iter().map(|&i| collapses.triangles_at(stops[i])).collect();
    for structure in structures.iter_mut().filter(|s| s.continuous) {
        let drawn = drawn_curve(stage, structure, stops, &stop_numbers);
        structure.runner.seek(Lod(0));
        if let Some(drawn) = report.fitting(structure.name, drawn)? {
            report.curve.structures.insert(structure.name.to_owned(), drawn);
        }
    }
    Ok(())
}

/// The curve of one structure, over the stops of these numbers.
fn drawn_curve(
    stage: &Stage<'_>,
    structure: &mut Measured<'_>,
    stops: &[Lod],
    stop_numbers: &[usize],
) -> Result<DrawnCurve, GpuError> {
    let mut drawn = DrawnCurve::default();
    for &i in stop_numbers {
        structure.runner.seek(if i == 0 { Lod(0) } else { stops[i - 1] });
        let (traffic, bytes) = structure.runner.send(stops[i]);
        // What an upload of nothing but the indices that change would send, four bytes each.
        let single = bytes.min(4 * traffic.rewritten);
        let (indices, strips) = structure.runner.indices();
        drawn.draw_ms.push(stage.draw_ms(indices, strips)?);
        drawn.bytes.push(bytes);
        drawn.upload_ms.push(stage.best(&|now| stage.drawn.upload(bytes, now))?);
        drawn.single_bytes.push(single);
        drawn.single_upload_ms.push(stage.best(&|now| stage.drawn.upload(single, now))?);
    }
    Ok(drawn)
}

#[cfg(test)]
#[path = "device_tests.rs"]
mod tests;
