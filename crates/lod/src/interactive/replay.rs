//! The continuous variant of Interactive Meshes on a graphics device as a [`Plan`]: construction of
//! collapse lists, extraction, and live counts, each compared with the CPU version.

use super::{CollapseLists, Counting, Extraction, Interactive, ListsTooLong, shaders};
use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use lodc_model::Model;
use lodc_plan::{
    BufferId, Expected, KernelId, LONGEST_LOOP, Pass, Plan, PlanError, Program, Scan, Step,
    VertexRecords,
};
use lodc_verify::{Failure, Reference};
use std::sync::Arc;

/// Buffers and kernels of the continuous variant.
#[derive(Clone, Debug)]
pub struct Continuous {
    collapse_to: BufferId,
    /// Records of the mesh.
    pub source: BufferId,
    /// Start of each collapse list.
    pub offsets: BufferId,
    /// The collapse lists.
    pub entries: BufferId,
    current: BufferId,
    /// The records that are drawn.
    pub vertices: BufferId,
    error_flag: BufferId,
    length: KernelId,
    fill: KernelId,
    extract: KernelId,
    scan: Scan,
    sizes: Sizes,
}

/// Numbers that passes are given.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    vertices: u32,
    coarsest: u32,
    longest: u32,
    stride: u32,
}

impl Continuous {
    /// Uploads what is stored (records, triangles, `collapse_to`) and makes room for the rest.
    ///
    /// # Errors
    /// If the lists are too long for a device.
    pub fn new(
        program: &mut Program,
        simplified: &Simplified,
        lists: &CollapseLists,
        records: &VertexRecords,
    ) -> Result<Self, PlanError> {
        let mesh = simplified.mesh();
        let vertices = mesh.vertex_count();
        let longest = checked_depth(lists)?;
        let sizes = Sizes {
            vertices: vertices as u32,
            coarsest: simplified.collapses().records(),
            longest,
            stride: records.stride as u32,
        };
        let offsets = program.zeros("offsets", vertices + 1);
        Ok(Self {
            collapse_to: program.words("collapse_to", simplified.collapses().targets()),
            source: program.words("source", records.words.as_slice()),
            offsets,
            entries: program.zeros("entries", lists.entries().len()),
            current: program.zeros("current", vertices),
            vertices: program.words("vertices", records.words.as_slice()),
            error_flag: program.zeros("error_flag", 1),
            length: program.kernel(shaders::LISTS_LENGTH),
            fill: program.kernel(shaders::LISTS_FILL),
            extract: program.kernel(shaders::EXTRACT),
            scan: Scan::new(program, offsets, vertices + 1),
            sizes,
        })
    }

    /// The construction pass.
    #[must_use]
    pub fn construction(&self) -> Vec<Pass> {
        let s = self.sizes;
        let length = Pass {
            kernel: self.length,
            buffers: vec![self.collapse_to, self.offsets, self.error_flag],
            threads: s.vertices + 1,
            parameters: vec![s.vertices, s.coarsest, s.longest],
        };
        let fill = Pass {
            kernel: self.fill,
            buffers: vec![self.collapse_to, self.offsets, self.entries, self.current],
            threads: s.vertices,
            parameters: vec![s.vertices],
        };
        std::iter::once(length).chain(self.scan.passes()).chain([fill]).collect()
    }

    /// The extraction pass between two LODs, near or far, coarser or finer.
    #[must_use]
    pub fn extraction(&self, from: Lod, to: Lod) -> Pass {
        let touched = from.max(to).0.min(self.sizes.vertices);
        Pass {
            kernel: self.extract,
            buffers: vec![
                self.offsets,
                self.entries,
                self.source,
                self.current,
                self.vertices,
                self.error_flag,
            ],
            threads: touched,
            parameters: vec![touched, to.0, self.sizes.stride],
        }
    }

    /// The buffers that extraction writes to, but for the flag of errors.
    #[must_use]
    pub fn written(&self) -> [BufferId; 2] {
        [self.current, self.vertices]
    }

    /// Returns the words that the construction pass makes.
    #[must_use]
    pub fn constructed(&self, lists: &CollapseLists) -> Vec<Expected> {
        vec![
            Expected::new(self.offsets, lists.offsets()),
            Expected::new(self.entries, lists.entries()),
            Expected::new(self.current, &lists.offsets()[..lists.vertices()]),
            Expected::new(self.error_flag, [0]),
        ]
    }
}

impl Interactive {
    /// The continuous variant over some LODs, each compared in full: collapse pointers, drawn
    /// records and draw arguments with the CPU version, the CPU version's triangles with the
    /// reference.
    ///
    /// # Errors
    /// If the mesh is too large or its lists too long.
    pub fn continuous<'a>(
        &'a self,
        stops: Vec<Lod>,
        reference: &'a Reference<'_>,
    ) -> Result<Plan<'a>, PlanError> {
        let simplified = self.simplified().as_ref();
        let mesh = simplified.mesh();
        let lists = lists(simplified)?;
        let records = VertexRecords::whole(mesh)?;
        let mut program = Program::default();
        let device = Continuous::new(&mut program, simplified, &lists, &records)?;
        let counting = Counting::new(&mut program, mesh, device.vertices, &records);
        let mut constructed_words = program.uploaded(&[]);
        constructed_words.extend(device.constructed(&lists));
        let construction =
            Step { passes: device.construction(), ..Step::look("construction", constructed_words) };
        // What extraction must not write to is looked at again at the end.
        let mut unchanged_words = program.uploaded(&[device.vertices]);
        unchanged_words.extend([
            Expected::new(device.offsets, lists.offsets()),
            Expected::new(device.entries, lists.entries()),
        ]);
        let unchanged = Step::look("the end", unchanged_words);
        let words = vec![device.current, device.offsets, device.collapse_to];
        let whole = [device.vertices, device.source];
        let locate =
            locate(simplified, whole, words, [counting.triangles, counting.draws], records.stride);
        let mut cpu = CpuVersion {
            model: self,
            reference,
            extraction: Extraction::new(&lists),
            lists,
            vertices: records.words.clone(),
            records,
            device,
            counting,
            lod: Lod(0),
        };
        let moves = stops.into_iter().map(move |lod| cpu.step(lod));
        let steps = std::iter::once(construction).chain(moves).chain([unchanged]);
        Ok(Plan {
            model: self.name(),
            name: "continuous",
            program,
            steps: Box::new(steps),
            locate: Box::new(locate),
        })
    }
}

/// The full collapse lists of a sequence.
pub(super) fn lists(simplified: &Simplified) -> Result<CollapseLists, PlanError> {
    let collapses = simplified.collapses();
    CollapseLists::new(collapses.targets(), collapses.last(), u32::MAX as usize / 4).map_err(
        |ListsTooLong { entries }| PlanError::TooLarge {
            what: "the collapse lists",
            words: entries,
        },
    )
}

/// The length of the longest list.
///
/// # Errors
/// If a kernel may not loop that often.
pub(super) fn checked_depth(lists: &CollapseLists) -> Result<u32, PlanError> {
    let longest = lists.offsets().windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
    if longest > LONGEST_LOOP {
        let what = "a vertex that collapses again and again";
        return Err(PlanError::TooDeep { what, rounds: longest, most: LONGEST_LOOP });
    }
    Ok(longest)
}

/// The same work on the CPU.
struct CpuVersion<'a> {
    model: &'a Interactive,
    reference: &'a Reference<'a>,
    extraction: Extraction,
    lists: CollapseLists,
    records: VertexRecords,
    /// The records that are drawn.
    vertices: Vec<u32>,
    device: Continuous,
    counting: Counting,
    lod: Lod,
}

impl CpuVersion<'_> {
    fn step(&mut self, wanted: Lod) -> Step {
        let simplified = self.model.simplified();
        let lod = simplified.collapses().floor(wanted);
        let passes = vec![self.device.extraction(self.lod, lod), self.counting.pass()];
        self.extraction.seek(&self.lists, lod, |v, shown| {
            let to = v as usize * self.records.stride;
            self.vertices[to..to + self.records.stride].copy_from_slice(self.records.at(shown));
        });
        self.lod = lod;
        let mut draws = Vec::new();
        for (s, submesh) in simplified.mesh().submeshes().iter().enumerate() {
            draws.extend([3 * self.model.live(s, lod), 1, 3 * submesh.first_triangle, 0, 0]);
        }
        let difference = self.judge(lod);
        let checks = vec![
            Expected::new(self.device.current, self.extraction.pointers()),
            Expected::new(self.device.vertices, self.vertices.as_slice()),
            Expected::new(self.counting.draws, draws),
            Expected::new(self.device.error_flag, [0]),
        ];
        Step::show(lod, passes, checks, difference.map(|d| d.to_string()))
    }

    /// What the CPU version shows other than the reference.
    fn judge(&self, lod: Lod) -> Option<Failure> {
        let mesh = self.model.simplified().mesh();
        let shown = |v: u32| self.extraction.shown(&self.lists, v);
        let drawn = || {
            mesh.submeshes().iter().enumerate().flat_map(move |(s, submesh)| {
                let live = self.model.live(s, lod) as usize;
                let triangles = &mesh.triangles()[submesh.triangles()][..live];
                triangles.iter().map(move |t| OrientedTriangle::new(s as u32, t.map(shown)))
            })
        };
        self.reference.judge(lod, drawn().collect(), || drawn().collect())
    }
}

/// Names the vertex, triangle or submesh of a word, and the first triangle that has the vertex.
/// `records` have `stride` words for each vertex, `words` one.
pub(super) fn locate(
    simplified: &Simplified,
    records: [BufferId; 2],
    words: Vec<BufferId>,
    [triangle_words, draws]: [BufferId; 2],
    stride: usize,
) -> impl Fn(BufferId, usize) -> String + use<> {
    let triangles: Arc<[[u32; 3]]> = simplified.mesh().triangles().into();
    let submeshes: Vec<_> = simplified.mesh().submeshes().iter().map(|s| s.triangles()).collect();
    move |buffer, word| {
        let vertex = if buffer == draws {
            return format!("submesh {}", word / 5);
        } else if buffer == triangle_words {
            return format!("triangle {}", word / 3);
        } else if records.contains(&buffer) {
            word / stride
        } else if words.contains(&buffer) {
            word
        } else {
            return format!("word {word}");
        };
        let user = triangles.iter().position(|t| t.contains(&(vertex as u32)));
        user.map_or(format!("vertex {vertex}"), |t| {
            let submesh = submeshes.iter().position(|range| range.contains(&t)).unwrap_or_default();
            format!("vertex {vertex}, a corner of triangle {t} of submesh {submesh}")
        })
    }
}
