//! The figures of an object as `bench --json` has them. Their keys are a contract with scripts
//! (docs/CLI.md): more may be added, none may change.

use crate::primitives::PrimitiveReport;
use crate::timings::Spread;
use indexmap::IndexMap;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The way in which objects are measured.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Share of the LODs from one update to the next. A sweep leads to the last LOD and back.
    pub steps: f64,
    /// Rounds of timing, of which the best counts; with none everything that differs from run to
    /// run is left out.
    pub rounds: Option<u32>,
    /// Objects are packed as progressive streams, too.
    pub streams: bool,
}

/// The figures of one object.
#[derive(Debug, Serialize)]
pub struct BenchObject {
    /// All records of its sequence, of which shares of the LODs are counted.
    #[serde(skip)]
    pub(crate) records: u32,
    /// Updates of a sweep in each direction.
    pub(crate) updates: u64,
    /// The target of the jump from LOD 0: 1 % of the triangles.
    pub(crate) jump_lod: u32,
    pub(crate) curve: CurveReport,
    /// Microseconds to make that LOD's index list from scratch.
    pub(crate) rebuild_us: Option<f64>,
    /// The same over all rounds.
    pub(crate) rebuild_spread: Option<Spread>,
    /// By name: `triangles`, `triangles_cache`, `stripe`, `cache`.
    pub(crate) primitives: IndexMap<&'static str, PrimitiveReport>,
    /// The same where a fifth of the triangles is left.
    pub(crate) primitives_20: IndexMap<&'static str, PrimitiveReport>,
    /// By name: models, baselines, then `triangles` and `strips` for storage.
    pub(crate) models: IndexMap<&'static str, StructureReport>,
    /// Null if nothing was timed on a GPU.
    pub(crate) gpu: Option<GpuReport>,
    /// Null if streams were not asked for.
    pub(crate) stream: Option<StreamReport>,
}

/// An object as a progressive stream. Bits are per vertex of LOD 0, without the stream's head.
#[derive(Debug, Serialize)]
pub(crate) struct StreamReport {
    /// Of the lossless stream, its head included.
    pub(crate) bytes: u64,
    /// Of the lossless stream.
    pub(crate) lossless: f64,
    /// Of the lossless stream with every step in the order of the sequence.
    pub(crate) lossless_exact: f64,
    /// Positions in 16 bits, normals in 10, texture coordinates in 12.
    pub(crate) quantized: f64,
    /// Of the same splits without entropy coding, in the thesis's packages of words and bytes
    /// (table 4.3), with positions only and with normals.
    pub(crate) packages: f64,
    pub(crate) packages_normals: f64,
    /// A Progressive Mesh sent as vertex splits of Hoppe's words, from its last vertex on, with
    /// positions only and with normals.
    pub(crate) progressive_mesh: f64,
    pub(crate) progressive_mesh_normals: f64,
    /// Null if nothing was timed.
    pub(crate) speed: Option<StreamTimings>,
    /// Parts of the lossless stream, from its beginning.
    pub(crate) prefixes: Vec<PrefixReport>,
}

/// The speed of a stream on one thread, in memory: triangles only, from and to an index list.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct StreamTimings {
    pub(crate) encode_ms: f64,
    pub(crate) decode_ms: f64,
    /// Milliseconds over all rounds.
    pub(crate) encode_spread: Spread,
    pub(crate) decode_spread: Spread,
    pub(crate) encode_million_triangles_per_second: f64,
    pub(crate) decode_million_triangles_per_second: f64,
}

/// The mesh that the first bytes of a stream show.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct PrefixReport {
    /// Of the bytes.
    pub(crate) percent: u32,
    pub(crate) bytes: u64,
    pub(crate) triangles: u64,
    /// Distances in percent of the diagonal, the greater of both ways. They and `image` are null
    /// while there are no triangles.
    pub(crate) rms: Option<f64>,
    pub(crate) hausdorff: Option<f64>,
    /// Root mean square difference of grey (0 to 255) over 24 pictures.
    pub(crate) image: Option<f64>,
}

/// Times on a graphics device, and the memory that it needs.
#[derive(Debug, Default, Serialize)]
pub(crate) struct GpuReport {
    pub(crate) adapter: String,
    /// Whose clock: `device` (time stamps around passes) or `host` (from submitting to being done).
    pub(crate) clock: &'static str,
    /// What is not timed because the mesh is large; null if nothing is left out.
    pub(crate) limit: Option<String>,
    /// By name: why what the device has no room for is not timed.
    pub(crate) left_out: IndexMap<String, String>,
    /// By model and variant: words on the device for each vertex of LOD 0.
    pub(crate) words_per_vertex: IndexMap<&'static str, IndexMap<String, MemoryReport>>,
    /// By model and case.
    pub(crate) models: IndexMap<&'static str, IndexMap<String, CaseReport>>,
    /// By name: `triangles`, `triangles_cache`, `stripe`, `cache`.
    pub(crate) primitives: IndexMap<&'static str, PrimitiveDraws>,
    /// Draws and uploads over LODs, of models and baselines.
    pub(crate) curve: DeviceCurve,
}

/// Milliseconds of drawing LOD 0, and the level with a fifth of its triangles, lists as lists and
/// strips as strips that restart.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct PrimitiveDraws {
    pub(crate) draw_ms: f64,
    pub(crate) draw_ms_20: f64,
}

/// Times over LODs of models and baselines that a processor moves and a device draws: the strips of
/// those that have some, else the triangles, in their order, as an index list.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct DeviceCurve {
    pub(crate) lods: Vec<u32>,
    pub(crate) triangles: Vec<u32>,
    /// By name: a value for each LOD.
    pub(crate) structures: BTreeMap<String, DrawnCurve>,
}

/// One structure over LODs.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct DrawnCurve {
    /// Of drawing the LOD.
    pub(crate) draw_ms: Vec<f64>,
    /// Bytes that the update before it sends.
    pub(crate) bytes: Vec<u64>,
    /// Of sending these bytes, by the host's clock.
    pub(crate) upload_ms: Vec<f64>,
    /// Bytes that algorithm 1 of the thesis sends for that update: of Speed Strips single indices
    /// and tails of strips, of other structures the same as `bytes`.
    pub(crate) single_bytes: Vec<u64>,
    /// Of sending these bytes, in one piece.
    pub(crate) single_upload_ms: Vec<f64>,
}

/// Words on a device for each vertex of LOD 0.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct MemoryReport {
    pub(crate) positions: f64,
    pub(crate) normals: f64,
}

/// One thing that was timed on a graphics device.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct CaseReport {
    /// Number of updates or views.
    pub(crate) runs: u64,
    /// Of one run, on average.
    pub(crate) milliseconds: f64,
    /// The same over all rounds.
    pub(crate) spread: Spread,
    /// Bytes that a host sends for one run.
    pub(crate) bytes: f64,
    /// Vertices that kernels process; null for draws, and where kernels process none.
    pub(crate) million_vertices_per_second: Option<f64>,
}

/// One model or baseline.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct StructureReport {
    pub(crate) baseline: bool,
    pub(crate) bits_per_vertex: Bits,
    /// Null for what has no levels of detail.
    pub(crate) drawn: Option<DrawnReport>,
    /// Null for what does not show every LOD.
    pub(crate) traffic: Option<TrafficReport>,
    /// Null for what does not show every LOD, and if nothing was timed.
    pub(crate) extraction: Option<ExtractionReport>,
}

/// Bits per vertex of LOD 0.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Bits {
    /// As the thesis counts them, with positions only and with normals.
    pub(crate) thesis: f64,
    pub(crate) thesis_normals: f64,
    /// The same down to 95 % of the LODs.
    pub(crate) thesis_95: f64,
    pub(crate) thesis_normals_95: f64,
    /// In a file; null for what is not stored.
    pub(crate) file: Option<f64>,
    /// The bits that the structure really holds; null where that is what `thesis` counts.
    pub(crate) tight: Option<f64>,
}

/// LODs over which models have curves, up to a hundred from fine to coarse.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CurveReport {
    pub(crate) lods: Vec<u32>,
    pub(crate) triangles: Vec<u32>,
}

/// Indices drawn over all LODs.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct DrawnReport {
    pub(crate) indices_per_lod: f64,
    pub(crate) indices_per_triangle: f64,
    /// Indices at each LOD of the object's curve.
    pub(crate) curve: Vec<u64>,
    /// Share of the degenerate triangles of strips that is taken out; null but for Speed Strips.
    pub(crate) degenerates_removed: Option<f64>,
}

/// The traffic of an update, on average.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct TrafficReport {
    /// Of Speed Strips whole strips that changed.
    pub(crate) bytes_per_update: f64,
    /// As algorithm 1 of the thesis uploads them: single indices, and tails of strips that change
    /// their length; of other structures the same as `bytes_per_update`.
    pub(crate) upload_bytes_per_update: f64,
    pub(crate) rewritten_per_update: f64,
    /// Share of the records that change the length of a strip; null but for Speed Strips.
    pub(crate) length_changes: Option<f64>,
}

/// Times of moves, the best of all rounds. Ratios below 1 are faster than what they name.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ExtractionReport {
    pub(crate) coarser_us: f64,
    pub(crate) finer_us: f64,
    pub(crate) mean_us: f64,
    /// `mean_us` as a multiple of that of a baseline in the same run; null if it took no part.
    pub(crate) per_progressive_mesh: Option<f64>,
    pub(crate) per_lodstrips: Option<f64>,
    pub(crate) jump_us: f64,
    pub(crate) jump_per_rebuild: f64,
    /// Of an update, both ways, at each LOD of the object's curve.
    pub(crate) curve_us: Vec<f64>,
    pub(crate) spread: ExtractionSpread,
}

/// Microseconds of moves over all rounds.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct ExtractionSpread {
    pub(crate) coarser: Spread,
    pub(crate) finer: Spread,
    pub(crate) jump: Spread,
}

/// A row as JSON.
pub(crate) fn value(row: &impl Serialize) -> Value {
    serde_json::to_value(row).expect("a struct of numbers is JSON")
}
