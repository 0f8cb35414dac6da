//! The JSON documents. Their keys are a contract with scripts (docs/CLI.md): more may be added,
//! none may change.

use indexmap::IndexMap;
use lodc_report::{ErrorsOver, Gone};
use serde::Serialize;

/// `build --report json`.
#[derive(Debug, Serialize)]
pub(crate) struct BuildReport {
    pub(crate) schema_version: u32,
    pub(crate) tool_version: &'static str,
    pub(crate) inputs: Vec<InputReport>,
    pub(crate) summary: Summary,
}

/// The last line of `build --report jsonl`.
#[derive(Debug, Serialize)]
pub(crate) struct SummaryReport {
    pub(crate) summary: Summary,
}

/// Numbers of assets by what became of them.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Summary {
    pub(crate) built: usize,
    pub(crate) up_to_date: usize,
    pub(crate) failed: usize,
}

/// One input of a build. Counts are null if the work did not get that far.
#[derive(Debug, Default, Serialize)]
pub(crate) struct InputReport {
    pub(crate) input: String,
    pub(crate) output: String,
    /// The exit status of this input alone.
    pub(crate) status: u8,
    /// Nothing had changed since its result was made, which was left alone.
    pub(crate) up_to_date: bool,
    pub(crate) seconds: f64,
    pub(crate) vertices: Option<u64>,
    pub(crate) referenced_vertices: Option<u64>,
    pub(crate) triangles: Option<u64>,
    pub(crate) submeshes: Option<u64>,
    pub(crate) fakes: Option<u64>,
    pub(crate) records: Option<u64>,
    pub(crate) steps: Option<u64>,
    pub(crate) last_legal_lod: Option<u64>,
    pub(crate) bytes: Option<u64>,
    pub(crate) models: Vec<&'static str>,
    pub(crate) objects: Vec<ObjectCounts>,
    pub(crate) stages: Vec<StageReport>,
    pub(crate) peak_bytes: u64,
    pub(crate) warnings: Vec<String>,
    pub(crate) error: Option<String>,
}

/// Seconds of one stage.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct StageReport {
    pub(crate) name: &'static str,
    pub(crate) seconds: f64,
}

/// Counts of an object's elements.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ObjectCounts {
    pub(crate) name: String,
    /// All vertices, those made by the simplifier included.
    pub(crate) vertices: u64,
    /// Vertices that a triangle of LOD 0 uses.
    pub(crate) referenced_vertices: u64,
    pub(crate) triangles: u64,
    pub(crate) submeshes: u64,
    pub(crate) fakes: u64,
    pub(crate) records: u64,
    pub(crate) steps: u64,
    pub(crate) last_legal_lod: u32,
    /// Steps that changed the topology before the terminal phase.
    pub(crate) topology_changes: u32,
    pub(crate) first_topology_change: Option<u32>,
}

/// `chain --json`.
#[derive(Debug, Serialize)]
pub(crate) struct ChainReport {
    pub(crate) schema_version: u32,
    pub(crate) input: String,
    pub(crate) outputs: Vec<OutputReport>,
    pub(crate) errors_over: ErrorsOver,
    /// The finest first.
    pub(crate) levels: Vec<ChainLevel>,
    pub(crate) warnings: Vec<String>,
}

/// A file that was written.
#[derive(Debug, Serialize)]
pub(crate) struct OutputReport {
    pub(crate) path: String,
    pub(crate) bytes: u64,
}

impl From<&lodc_formats::OutputFile> for OutputReport {
    fn from(file: &lodc_formats::OutputFile) -> Self {
        Self { path: file.path.display().to_string(), bytes: file.bytes.len() as u64 }
    }
}

/// One level of a chain.
#[derive(Debug, Serialize)]
pub(crate) struct ChainLevel {
    /// From 0, the finest.
    pub(crate) level: usize,
    /// The LOD; null if several objects each have their own.
    pub(crate) lod: Option<u32>,
    pub(crate) triangles: u64,
    /// Vertices that the level needs: a prefix of the vertex buffers where levels share them.
    pub(crate) vertices: u64,
    /// The largest error of an object, as `extract --json` has it; null if infinite.
    pub(crate) error: Option<f64>,
    pub(crate) rms: Option<f64>,
    /// The distance that the level was chosen for; null unless pixels were asked for.
    pub(crate) distance: Option<f64>,
    /// What it no longer shows.
    pub(crate) gone: Vec<Gone>,
    /// The file with the level.
    pub(crate) output: String,
}

/// `info --json`.
#[derive(Debug, Serialize)]
pub(crate) struct InfoReport {
    pub(crate) schema_version: u32,
    /// `lodc`.
    pub(crate) format: &'static str,
    pub(crate) format_version: u16,
    pub(crate) key: String,
    pub(crate) bytes: u64,
    /// `packed` or `gpu`.
    pub(crate) layout: &'static str,
    pub(crate) source: SourceReport,
    pub(crate) objects: Vec<ObjectReport>,
}

/// Origin of a file; never a path.
#[derive(Debug, Serialize)]
pub(crate) struct SourceReport {
    pub(crate) format: &'static str,
    pub(crate) content_hash: String,
}

/// One object of a file.
#[derive(Debug, Serialize)]
pub(crate) struct ObjectReport {
    #[serde(flatten)]
    pub(crate) counts: ObjectCounts,
    pub(crate) world_scale: f64,
    pub(crate) diagonal: f64,
    /// `measured` or `estimate`.
    pub(crate) errors: &'static str,
    pub(crate) errors_over: ErrorsOver,
    pub(crate) collapse_lists: ListsReport,
    pub(crate) lods: Vec<LodReport>,
    /// Strips by generator; empty until the file has strip models.
    pub(crate) strips: IndexMap<&'static str, StripsReport>,
    /// Models by name.
    pub(crate) models: IndexMap<&'static str, ModelReport>,
}

/// Entries of the collapse lists of an object, over the whole sequence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ListsReport {
    /// Mean over the vertices.
    pub(crate) mean: f64,
    pub(crate) longest: u32,
    /// The same of lists that end earlier.
    pub(crate) down_to: Vec<ListsToReport>,
}

/// Entries of collapse lists down to a LOD (thesis 5.2 stops at 95 %).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct ListsToReport {
    /// Share of the LODs, in percent.
    pub(crate) percent: u32,
    pub(crate) lod: u32,
    pub(crate) mean: f64,
    pub(crate) longest: u32,
}

/// One line of the table of LODs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct LodReport {
    pub(crate) lod: u32,
    pub(crate) triangles: u32,
    pub(crate) error: f64,
    /// Null if it was not measured.
    pub(crate) rms: Option<f64>,
}

/// Strips as they are stored.
#[derive(Debug, Serialize)]
pub(crate) struct StripsReport {
    pub(crate) strips: Option<u64>,
    pub(crate) indices: u64,
    pub(crate) acmr_fifo16: f64,
}

/// Storage cost of one model.
#[derive(Debug, Serialize)]
pub(crate) struct ModelReport {
    pub(crate) bits_per_vertex: BitsPerVertex,
}

/// Bits per input vertex, counted three ways.
#[derive(Debug, Serialize)]
pub(crate) struct BitsPerVertex {
    /// As the thesis counts: structure and positions.
    pub(crate) thesis: f64,
    /// The same with normals.
    pub(crate) thesis_normals: f64,
    /// Bits per vertex of this model in the file; null if it is not stored.
    pub(crate) file: Option<f64>,
}

/// `extract --json`.
#[derive(Debug, Serialize)]
pub(crate) struct ExtractReport {
    pub(crate) schema_version: u32,
    /// 0: done.
    pub(crate) status: u8,
    /// The LOD shown; null if several objects, or all parts of the surface, each have their own.
    pub(crate) lod: Option<u32>,
    /// The rule that gave each part of the surface a level of its own; null if there is one level
    /// for each object.
    pub(crate) criterion: Option<&'static str>,
    pub(crate) triangles: u64,
    /// Share of the triangles of LOD 0.
    pub(crate) kept_share: f64,
    pub(crate) vertices: u64,
    /// The largest error of an object: in mesh units for one object, in world units for several;
    /// null if infinite, and of a view.
    pub(crate) error: Option<f64>,
    /// The largest root mean square distance of an object, in the same units; null if it was not
    /// measured.
    pub(crate) rms: Option<f64>,
    pub(crate) errors_over: ErrorsOver,
    /// True if the vertices were moved: then errors are measured on the result.
    pub(crate) refitted: bool,
    pub(crate) output: String,
    pub(crate) input: String,
    pub(crate) model: &'static str,
    pub(crate) objects: Vec<ExtractedObject>,
    /// What the level no longer shows; null in a view.
    pub(crate) gone: Option<Vec<Gone>>,
    pub(crate) warnings: Vec<String>,
}

/// One object of an extraction.
#[derive(Debug, Serialize)]
pub(crate) struct ExtractedObject {
    pub(crate) name: String,
    /// Null in a view.
    pub(crate) lod: Option<u32>,
    pub(crate) triangles: u64,
    pub(crate) vertices: u64,
    /// In the object's own units; null if infinite, and in a view.
    pub(crate) error: Option<f64>,
    /// In the object's own units; null if it was not measured.
    pub(crate) rms: Option<f64>,
}

/// `pack --json`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PackReport {
    pub(crate) schema_version: u32,
    pub(crate) input: String,
    pub(crate) output: String,
    pub(crate) bytes: u64,
    /// Bytes of all that is not a growing mesh.
    pub(crate) head_bytes: u64,
    pub(crate) objects: Vec<PackedReport>,
}

/// One object of a stream.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PackedReport {
    #[serde(flatten)]
    pub(crate) counts: ObjectCounts,
    pub(crate) strips: Option<u64>,
    pub(crate) bytes: u64,
    pub(crate) bits_per_vertex: StreamBits,
    /// Largest changes that quantising may have made.
    pub(crate) bounds: Vec<BoundReport>,
}

/// Bits per input vertex of a stream.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct StreamBits {
    /// In the stream.
    pub(crate) stream: f64,
    /// Packages as plain words and bytes, as the thesis counts: positions only, and with normals.
    pub(crate) packages: f64,
    pub(crate) packages_normals: f64,
}

/// Largest change of one stream by quantising.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct BoundReport {
    pub(crate) stream: String,
    pub(crate) bits: u8,
    pub(crate) coordinate: f64,
    pub(crate) distance: f64,
}

/// `info --json` of a stream.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct StreamInfoReport {
    pub(crate) schema_version: u32,
    /// `lods`.
    pub(crate) format: &'static str,
    pub(crate) format_version: u16,
    /// Bytes of the file, and those of them that are whole blocks.
    pub(crate) bytes: u64,
    pub(crate) used: u64,
    /// True if the stream is complete.
    pub(crate) whole: bool,
    /// Fault of the first part that was not used; null if there is none.
    pub(crate) damaged: Option<String>,
    /// Bytes of names, nodes, materials and buffers, so far and in all.
    pub(crate) document_bytes: u64,
    pub(crate) of_document_bytes: u64,
    /// Objects of the whole stream; null before the first block. `objects` has those that have
    /// begun or are named.
    pub(crate) all_objects: Option<u32>,
    pub(crate) objects: Vec<UnpackedReport>,
}

/// `unpack --json`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct UnpackReport {
    pub(crate) schema_version: u32,
    pub(crate) input: String,
    pub(crate) output: String,
    /// True if the stream was complete.
    pub(crate) whole: bool,
    /// Fault of the first part that was not used; null if there is none.
    pub(crate) damaged: Option<String>,
    /// Bytes of the stream that were used.
    pub(crate) bytes: u64,
    /// Objects of the whole stream; `objects` has those that have come.
    pub(crate) all_objects: u32,
    /// Parts of the scene that are still to come.
    pub(crate) left_out: Vec<String>,
    pub(crate) objects: Vec<UnpackedReport>,
    pub(crate) warnings: Vec<String>,
}

/// One object of a stream: what has come, of how much.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct UnpackedReport {
    pub(crate) name: String,
    pub(crate) vertices: u32,
    pub(crate) of_vertices: u32,
    pub(crate) triangles: u32,
    pub(crate) of_triangles: u32,
    pub(crate) steps: u32,
    pub(crate) of_steps: u32,
    /// In the object's own units.
    pub(crate) error: f64,
    /// Likewise; none if the stream has none.
    pub(crate) rms: Option<f64>,
}
