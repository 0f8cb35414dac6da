//! The JSON documents of commands. Their keys are a contract with scripts (docs/CLI.md): more may
//! be added, none may change.
#![expect(missing_docs, reason = "docs/CLI.md says what each key means")]

use crate::{Case, ErrorsOver, MissingPart, Suite, Verdict};
use indexmap::IndexMap;
use serde::Serialize;

/// `build --report json`.
#[derive(Debug, Serialize)]
pub struct BuildReport {
    pub schema_version: u32,
    pub tool_version: &'static str,
    pub inputs: Vec<InputReport>,
    pub summary: Summary,
}

/// `build --estimate --report json`.
#[derive(Debug, Serialize)]
pub struct EstimateReport {
    pub schema_version: u32,
    pub tool_version: &'static str,
    pub inputs: Vec<InputEstimate>,
}

/// What a build needs. Numbers are null if the input could not be read.
#[derive(Debug, Default, Serialize)]
pub struct InputEstimate {
    pub input: String,
    /// The exit status of this input alone.
    pub status: u8,
    pub triangles: Option<u64>,
    pub vertices: Option<u64>,
    /// Bytes of the file and of the buffers that it names, decompressed.
    pub bytes: Option<u64>,
    /// Bytes of memory at the peak, with one thread.
    pub memory: Option<u64>,
    /// Processor seconds, roughly: a third to three times as long. Animated models take longer.
    pub seconds: Option<f64>,
    pub error: Option<String>,
}

/// The last line of `build --report jsonl`.
#[derive(Debug, Serialize)]
pub struct SummaryReport {
    pub summary: Summary,
}

/// Numbers of assets by what became of them.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Summary {
    pub built: usize,
    pub up_to_date: usize,
    pub failed: usize,
}

/// One input of a build. Counts are null if the work did not get that far.
#[derive(Debug, Default, Serialize)]
pub struct InputReport {
    pub input: String,
    pub output: String,
    /// The exit status of this input alone.
    pub status: u8,
    /// Nothing had changed since its result was made, which was left alone.
    pub up_to_date: bool,
    pub seconds: f64,
    pub vertices: Option<u64>,
    pub referenced_vertices: Option<u64>,
    pub triangles: Option<u64>,
    pub submeshes: Option<u64>,
    pub fakes: Option<u64>,
    pub records: Option<u64>,
    pub steps: Option<u64>,
    pub last_legal_lod: Option<u64>,
    pub bytes: Option<u64>,
    pub models: Vec<&'static str>,
    pub objects: Vec<ObjectCounts>,
    pub stages: Vec<StageReport>,
    pub peak_bytes: u64,
    pub warnings: Vec<String>,
    pub error: Option<String>,
}

impl InputReport {
    /// The build of one input as CI systems show it.
    #[must_use]
    pub fn suite(&self) -> Suite {
        let verdict = match &self.error {
            Some(what) => Verdict::Error(what.clone()),
            None => Verdict::Passed,
        };
        Suite { name: self.input.clone(), cases: vec![Case { name: "build".to_owned(), verdict }] }
    }
}

/// Seconds of one stage.
#[derive(Clone, Debug, Serialize)]
pub struct StageReport {
    pub name: &'static str,
    pub seconds: f64,
}

/// Counts of an object's elements.
#[derive(Clone, Debug, Serialize)]
pub struct ObjectCounts {
    pub name: String,
    /// All vertices, those made by the simplifier included.
    pub vertices: u64,
    /// Vertices that a triangle of LOD 0 uses.
    pub referenced_vertices: u64,
    pub triangles: u64,
    pub submeshes: u64,
    pub fakes: u64,
    pub records: u64,
    pub steps: u64,
    pub last_legal_lod: u32,
    /// Steps that changed the topology before the terminal phase.
    pub topology_changes: u32,
    pub first_topology_change: Option<u32>,
}

/// `chain --json`.
#[derive(Debug, Serialize)]
pub struct ChainReport {
    pub schema_version: u32,
    pub input: String,
    pub outputs: Vec<OutputReport>,
    /// The poses that errors hold in.
    pub errors_over: ErrorsOver,
    /// The finest first.
    pub levels: Vec<ChainLevel>,
    /// Null unless levels move to the next.
    pub geomorph: Option<GeomorphReport>,
    pub warnings: Vec<String>,
}

/// How the levels of a chain move to the next.
#[derive(Debug, Serialize)]
pub struct GeomorphReport {
    /// Pairs of neighbouring levels of which the finer moves to the coarser.
    pub pairs: u64,
    /// The largest `geomorph_pose_error` of a level; null if none bends.
    pub max_pose_error: Option<f64>,
}

/// A file that was written.
#[derive(Debug, Serialize)]
pub struct OutputReport {
    pub path: String,
    pub bytes: u64,
}

impl From<&lodc_formats::OutputFile> for OutputReport {
    fn from(file: &lodc_formats::OutputFile) -> Self {
        Self { path: file.path.display().to_string(), bytes: file.bytes.len() as u64 }
    }
}

/// One level of a chain.
#[derive(Debug, Serialize)]
pub struct ChainLevel {
    /// From 0, the finest.
    pub level: usize,
    /// The LOD; null if several objects each have their own.
    pub lod: Option<u32>,
    pub triangles: u64,
    /// Vertices that the level needs: a prefix of the vertex buffers where levels share them.
    pub vertices: u64,
    /// The largest error of an object, as `extract --json` has it; null if infinite.
    pub error: Option<f64>,
    pub rms: Option<f64>,
    /// The distance that the level suits from; null unless pixels or geomorphing were asked for.
    pub distance: Option<f64>,
    /// The distance from which it moves towards the next level; null unless it does.
    pub morph_from: Option<f64>,
    /// How far in poses it is from the next level once it has moved; null unless it does and bends.
    pub geomorph_pose_error: Option<f64>,
    /// Vertices that stay, as moving them would spoil a shape in motion; null unless it moves.
    pub geomorph_staying: Option<u64>,
    /// What it no longer shows.
    pub gone: Vec<MissingPart>,
    /// The file with the level.
    pub output: String,
}

/// `info --json`.
#[derive(Debug, Serialize)]
pub struct InfoReport {
    pub schema_version: u32,
    /// `lodc`.
    pub format: &'static str,
    pub format_version: u16,
    pub key: String,
    pub bytes: u64,
    /// `packed` or `gpu`.
    pub layout: &'static str,
    pub source: SourceReport,
    /// The lowest and the highest corner of what the scene shows at rest, in world units; null if
    /// it shows nothing.
    pub bounds: Option<[[f64; 3]; 2]>,
    /// Levels of the whole scene, the finest first.
    pub levels_table: Vec<SceneLevelReport>,
    pub objects: Vec<ObjectReport>,
}

/// A level of a whole scene.
#[derive(Debug, Serialize)]
pub struct SceneLevelReport {
    /// The share of triangles that was asked for.
    pub ratio: f64,
    pub triangles: u64,
    /// In world units; null if infinite.
    pub error: Option<f64>,
}

/// Origin of a file; never a path.
#[derive(Debug, Serialize)]
pub struct SourceReport {
    pub format: &'static str,
    pub content_hash: String,
}

/// One object of a file.
#[derive(Debug, Serialize)]
pub struct ObjectReport {
    #[serde(flatten)]
    pub counts: ObjectCounts,
    pub world_scale: f64,
    pub diagonal: f64,
    pub errors: ErrorOrigin,
    /// The poses that they hold in.
    pub errors_over: ErrorsOver,
    pub collapse_lists: ListsReport,
    pub lods: Vec<LodReport>,
    /// Strips by generator; empty until the file has strip models.
    pub strips: IndexMap<&'static str, StripsReport>,
    /// Models by name.
    pub models: IndexMap<&'static str, ModelReport>,
}

/// Where the errors of an object's levels come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorOrigin {
    Measured,
    Estimate,
}

/// Entries of the collapse lists of an object, over the whole sequence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ListsReport {
    /// Mean over the vertices.
    pub mean: f64,
    pub longest: u32,
    /// The same of lists that end earlier.
    pub down_to: Vec<ListsToReport>,
}

/// Entries of collapse lists down to a LOD (thesis 5.2 stops at 95 %).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ListsToReport {
    /// Share of the LODs, in percent.
    pub percent: u32,
    pub lod: u32,
    pub mean: f64,
    pub longest: u32,
}

/// One line of the table of LODs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LodReport {
    pub lod: u32,
    pub triangles: u32,
    /// In the object's own units.
    pub error: f64,
    /// Likewise; null if it was not measured.
    pub rms: Option<f64>,
    /// The same in world units.
    pub world_error: f64,
    pub world_rms: Option<f64>,
}

/// Strips as they are stored.
#[derive(Debug, Serialize)]
pub struct StripsReport {
    pub strips: Option<u64>,
    pub indices: u64,
    pub acmr_fifo16: f64,
}

/// Storage cost of one model.
#[derive(Debug, Serialize)]
pub struct ModelReport {
    pub bits_per_vertex: BitsPerVertex,
}

/// Bits per input vertex, counted three ways.
#[derive(Debug, Serialize)]
pub struct BitsPerVertex {
    /// As the thesis counts: structure and positions.
    pub thesis: f64,
    /// The same with normals.
    pub thesis_normals: f64,
    /// Bits per vertex of this model in the file; null if it is not stored.
    pub file: Option<f64>,
}

/// `extract --json`.
#[derive(Debug, Serialize)]
pub struct ExtractReport {
    pub schema_version: u32,
    /// 0: done.
    pub status: u8,
    /// The LOD shown; null if several objects, or all parts of the surface, each have their own.
    pub lod: Option<u32>,
    /// The rule that gave each part of the surface a level of its own; null if there is one level
    /// for each object.
    pub criterion: Option<&'static str>,
    pub triangles: u64,
    /// Share of the triangles of LOD 0.
    pub kept_share: f64,
    pub vertices: u64,
    /// The largest error of an object, in world units; null if infinite.
    pub error: Option<f64>,
    /// The largest root mean square distance of an object, in world units; null if it was not
    /// measured.
    pub rms: Option<f64>,
    /// The poses that both hold in.
    pub errors_over: ErrorsOver,
    /// True if the vertices were moved: then errors are measured on the result.
    pub refitted: bool,
    pub output: String,
    pub input: String,
    pub model: &'static str,
    pub objects: Vec<ExtractedObject>,
    /// What the level no longer shows; null in a view.
    pub gone: Option<Vec<MissingPart>>,
    pub warnings: Vec<String>,
}

/// One object of an extraction.
#[derive(Debug, Serialize)]
pub struct ExtractedObject {
    pub name: String,
    /// Null in a view.
    pub lod: Option<u32>,
    pub triangles: u64,
    pub vertices: u64,
    /// In the object's own units; null if infinite.
    pub error: Option<f64>,
    /// In the object's own units; null if it was not measured.
    pub rms: Option<f64>,
    /// The same in world units.
    pub world_error: Option<f64>,
    pub world_rms: Option<f64>,
}

/// `pack --json`.
#[derive(Clone, Debug, Serialize)]
pub struct PackReport {
    pub schema_version: u32,
    pub input: String,
    pub output: String,
    pub bytes: u64,
    /// Bytes of all that is not a growing mesh.
    pub head_bytes: u64,
    pub objects: Vec<PackedReport>,
}

/// One object of a stream.
#[derive(Clone, Debug, Serialize)]
pub struct PackedReport {
    #[serde(flatten)]
    pub counts: ObjectCounts,
    /// Levels of the file, and those of them that the stream is sure to have.
    pub levels: u32,
    pub exact_levels: u32,
    pub bytes: u64,
    pub bits_per_vertex: StreamBits,
    /// Largest changes that quantising may have made.
    pub bounds: Vec<BoundReport>,
}

/// Bits per input vertex of a stream.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct StreamBits {
    /// In the stream.
    pub stream: f64,
    /// Packages as plain words and bytes, as the thesis counts: positions only, and with normals.
    pub packages: f64,
    pub packages_normals: f64,
}

/// Largest change of one stream by quantising.
#[derive(Clone, Debug, Serialize)]
pub struct BoundReport {
    pub stream: String,
    pub bits: u8,
    pub coordinate: f64,
    pub distance: f64,
}

/// `info --json` of a stream.
#[derive(Clone, Debug, Serialize)]
pub struct StreamInfoReport {
    pub schema_version: u32,
    /// `lods`.
    pub format: &'static str,
    pub format_version: u16,
    /// Bytes of the file, and those of them that are whole blocks.
    pub bytes: u64,
    pub used: u64,
    /// True if the stream is complete.
    pub whole: bool,
    /// Fault of the first part that was not used; null if there is none.
    pub damaged: Option<String>,
    /// Bytes of names, nodes, materials and buffers, so far and in all.
    pub document_bytes: u64,
    pub of_document_bytes: u64,
    /// Objects of the whole stream; null before the first block. `objects` has those that have
    /// begun or are named.
    pub all_objects: Option<u32>,
    pub objects: Vec<UnpackedReport>,
}

/// `unpack --json`.
#[derive(Clone, Debug, Serialize)]
pub struct UnpackReport {
    pub schema_version: u32,
    pub input: String,
    pub output: String,
    /// True if the stream was complete.
    pub whole: bool,
    /// Fault of the first part that was not used; null if there is none.
    pub damaged: Option<String>,
    /// Bytes of the stream that were used.
    pub bytes: u64,
    /// Objects of the whole stream; `objects` has those that have come.
    pub all_objects: u32,
    /// Parts of the scene that are still to come.
    pub left_out: Vec<String>,
    pub objects: Vec<UnpackedReport>,
    pub warnings: Vec<String>,
}

/// One object of a stream: what has come, of how much.
#[derive(Clone, Debug, Serialize)]
pub struct UnpackedReport {
    pub name: String,
    pub vertices: u32,
    pub of_vertices: u32,
    pub triangles: u32,
    pub of_triangles: u32,
    pub steps: u32,
    pub of_steps: u32,
    /// In the object's own units.
    pub error: f64,
    /// Likewise; none if the stream has none.
    pub rms: Option<f64>,
    /// The same in world units.
    pub world_error: f64,
    pub world_rms: Option<f64>,
    pub errors_over: ErrorsOver,
}
