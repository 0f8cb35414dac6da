//! The JSON document of `bench`. Its keys are a contract as those in `crate::report` are.

use super::crowd::CrowdReport;
use super::timings::Spread;
use crate::report::ObjectCounts;
use indexmap::IndexMap;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// `bench --json`.
#[derive(Debug, Serialize)]
pub(super) struct BenchReport {
    pub(super) schema_version: u32,
    pub(super) tool_version: &'static str,
    /// Share of the LODs between two updates of a sweep.
    pub(super) steps: f64,
    pub(super) files: Vec<BenchFile>,
    /// Null if no crowd was asked for.
    pub(super) crowd: Option<CrowdReport>,
}

/// One input.
#[derive(Debug, Serialize)]
pub(super) struct BenchFile {
    pub(super) file: String,
    pub(super) error: Option<String>,
    pub(super) objects: Vec<BenchObject>,
}

/// One object of an input.
#[derive(Debug, Serialize)]
pub(super) struct BenchObject {
    #[serde(flatten)]
    pub(super) counts: ObjectCounts,
    /// Updates of a sweep in each direction.
    pub(super) updates: u64,
    /// The target of the jump from LOD 0: 1 % of the triangles.
    pub(super) jump_lod: u32,
    pub(super) curve: CurveReport,
    /// Microseconds to make that LOD's index list from scratch.
    pub(super) rebuild_us: Option<f64>,
    /// The same over all rounds.
    pub(super) rebuild_spread: Option<Spread>,
    /// By name: `triangles`, `triangles_cache`, `stripe`, `cache`.
    pub(super) primitives: IndexMap<&'static str, PrimitiveReport>,
    /// By name: models, baselines, then `triangles` and `strips` for storage.
    pub(super) models: IndexMap<&'static str, SubjectReport>,
    /// Null if nothing was timed on a GPU.
    pub(super) gpu: Option<GpuReport>,
    /// Null if streams were not asked for.
    pub(super) stream: Option<StreamReport>,
}

/// An object as a progressive stream. Bits are per vertex of LOD 0, without the stream's head.
#[derive(Debug, Serialize)]
pub(super) struct StreamReport {
    /// Of the lossless stream with strips, its head included.
    pub(super) bytes: u64,
    pub(super) lossless: f64,
    pub(super) lossless_strips: f64,
    /// Positions in 16 bits, normals in 10, texture coordinates in 12.
    pub(super) quantized_strips: f64,
    /// The same packages as plain words and bytes (thesis, table 4.3), with positions only and with
    /// normals.
    pub(super) packages: f64,
    pub(super) packages_normals: f64,
    /// A Progressive Mesh sent as vertex splits of Hoppe's words, from its last vertex on, with
    /// positions only and with normals.
    pub(super) progressive_mesh: f64,
    pub(super) progressive_mesh_normals: f64,
    /// Null if nothing was timed.
    pub(super) speed: Option<StreamSpeed>,
    /// Of the lossless stream with strips.
    pub(super) prefixes: Vec<PrefixReport>,
}

/// The speed of a stream on one thread, in memory: triangles only, from and to an index list.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct StreamSpeed {
    pub(super) encode_ms: f64,
    pub(super) decode_ms: f64,
    /// Milliseconds over all rounds.
    pub(super) encode_spread: Spread,
    pub(super) decode_spread: Spread,
    pub(super) encode_million_triangles_per_second: f64,
    pub(super) decode_million_triangles_per_second: f64,
    /// From a stream with strips, which are passed over.
    pub(super) decode_past_strips_million_triangles_per_second: f64,
}

/// The mesh that the first bytes of a stream show.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct PrefixReport {
    pub(super) percent: u32,
    pub(super) bytes: u64,
    pub(super) triangles: u64,
    /// In percent of the diagonal, the greater of both ways; null as all that follows while there
    /// are no triangles.
    pub(super) rms: Option<f64>,
    pub(super) hausdorff: Option<f64>,
    /// Root mean square difference of grey (0 to 255) over 24 pictures.
    pub(super) image: Option<f64>,
}

/// Times on a graphics device, and the memory that it needs.
#[derive(Debug, Default, Serialize)]
pub(super) struct GpuReport {
    pub(super) adapter: String,
    /// Whose clock: `device` (time stamps around passes) or `host` (from submitting to being done).
    pub(super) clock: &'static str,
    /// By model and variant: words on the device for each vertex of LOD 0.
    pub(super) words_per_vertex: IndexMap<&'static str, IndexMap<String, MemoryReport>>,
    /// By model and case.
    pub(super) models: IndexMap<&'static str, IndexMap<String, CaseReport>>,
    /// Everything over LODs, baselines as well.
    pub(super) curve: DeviceCurve,
}

/// Times over LODs of models and baselines that a processor moves and a device draws: the triangles
/// that each shows, in its order, as an index list.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct DeviceCurve {
    pub(super) lods: Vec<u32>,
    pub(super) triangles: Vec<u32>,
    /// By name: a value for each LOD.
    pub(super) structures: BTreeMap<String, DrawnCurve>,
}

/// One structure over LODs.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct DrawnCurve {
    /// Drawing one LOD.
    pub(super) draw_ms: Vec<f64>,
    /// Bytes that the update before it sends.
    pub(super) bytes: Vec<u64>,
    /// Sending them, by the host's clock.
    pub(super) upload_ms: Vec<f64>,
}

/// Words on a device for each vertex of LOD 0.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "made only where there is a device"))]
pub(super) struct MemoryReport {
    pub(super) positions: f64,
    pub(super) normals: f64,
}

/// One thing that was timed on a graphics device.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "made only where there is a device"))]
pub(super) struct CaseReport {
    /// Number of updates or views.
    pub(super) runs: u64,
    /// Of one, on average.
    pub(super) milliseconds: f64,
    /// The same over all rounds.
    pub(super) spread: Spread,
    /// That a host sends for one.
    pub(super) bytes: f64,
    /// Vertices looked at; null for draws and where none need be.
    pub(super) million_vertices_per_second: Option<f64>,
}

/// The triangles of LOD 0 as a graphics card gets them.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct PrimitiveReport {
    /// Null for lists.
    pub(crate) strips: Option<u64>,
    pub(crate) indices: u64,
    pub(crate) indices_per_triangle: f64,
    /// Misses per triangle of a first-in-first-out cache of 16 vertices.
    pub(crate) acmr_fifo16: f64,
}

/// One model or baseline.
#[derive(Clone, Debug, Serialize)]
pub(super) struct SubjectReport {
    pub(super) baseline: bool,
    pub(super) bits_per_vertex: Bits,
    /// Null for what has no levels of detail.
    pub(super) drawn: Option<DrawnReport>,
    /// Null for what does not show every LOD.
    pub(super) traffic: Option<TrafficReport>,
    /// Null too if nothing was timed.
    pub(super) extraction: Option<ExtractionReport>,
}

/// Bits per vertex of LOD 0.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Bits {
    pub(super) thesis: f64,
    pub(super) thesis_normals: f64,
    /// Down to 95 % of the LODs.
    pub(super) thesis_95: f64,
    pub(super) thesis_normals_95: f64,
    /// Null for what is not stored.
    pub(super) file: Option<f64>,
    /// The bits that the structure really holds; null where that is what `thesis` counts.
    pub(super) tight: Option<f64>,
}

/// LODs over which models have curves, up to a hundred from fine to coarse.
#[derive(Clone, Debug, Serialize)]
pub(super) struct CurveReport {
    pub(super) lods: Vec<u32>,
    pub(super) triangles: Vec<u32>,
}

/// Indices drawn over all LODs.
#[derive(Clone, Debug, Serialize)]
pub(super) struct DrawnReport {
    pub(super) indices_per_lod: f64,
    pub(super) indices_per_triangle: f64,
    /// Indices at each LOD of the object's curve.
    pub(super) curve: Vec<u64>,
    /// Share of the degenerate triangles of strips that is taken out; null but for Speed Strips.
    pub(super) degenerates_removed: Option<f64>,
}

/// The traffic of an update, on average.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct TrafficReport {
    pub(super) bytes_per_update: f64,
    pub(super) rewritten_per_update: f64,
    /// Share of the records that change the length of a strip; null but for Speed Strips.
    pub(super) length_changes: Option<f64>,
}

/// Times of moves, the best of all rounds. Ratios below 1 are faster than what they name.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ExtractionReport {
    pub(super) coarser_us: f64,
    pub(super) finer_us: f64,
    pub(super) mean_us: f64,
    /// `mean_us` as a multiple of that of a baseline in the same run; null if it took no part.
    pub(super) per_progressive_mesh: Option<f64>,
    pub(super) per_lodstrips: Option<f64>,
    pub(super) jump_us: f64,
    pub(super) jump_per_rebuild: f64,
    /// Of an update, both ways, at each LOD of the object's curve.
    pub(super) curve_us: Vec<f64>,
    pub(super) spread: ExtractionSpread,
}

/// Microseconds of moves over all rounds.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct ExtractionSpread {
    pub(super) coarser: Spread,
    pub(super) finer: Spread,
    pub(super) jump: Spread,
}

/// A row as JSON.
pub(super) fn value(row: &impl Serialize) -> Value {
    serde_json::to_value(row).expect("a struct of numbers is JSON")
}
