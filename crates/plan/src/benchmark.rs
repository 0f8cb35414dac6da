//! The cases of a model that are timed on a graphics device: passes or draws, and the memory that
//! its variants take.

use crate::program::{BufferId, Pass, Program};
use lodc_mesh::Lod;

/// A program and the cases in which it is timed.
#[derive(Clone, Debug)]
pub struct Benchmark {
    /// Buffers and kernels.
    pub program: Program,
    /// Run once, before anything is timed.
    pub setup: Vec<Pass>,
    /// The timed cases, in order. Each leaves all buffers as it found them.
    pub cases: Vec<Case>,
    /// The memory of the variants of the structure.
    pub memory: Vec<Memory>,
}

/// Runs that are timed, each alone, under one name.
#[derive(Clone, Debug)]
pub struct Case {
    /// The name of the case.
    pub name: &'static str,
    /// Passes of each run; runs follow one another.
    pub runs: Vec<Vec<Pass>>,
    /// Passes before each run that are not timed; none at all if every run begins where the one
    /// before it ended.
    pub before: Vec<Vec<Pass>>,
    /// Number of vertices that all runs together process, for rates.
    pub vertices: u64,
    /// If set, drawing is timed instead of the passes, which prepare it.
    pub drawn: Option<DrawInput>,
}

impl Case {
    /// Passes that are timed.
    #[must_use]
    pub fn new(name: &'static str, runs: Vec<Vec<Pass>>, vertices: u64) -> Self {
        Self { name, runs, before: vec![], vertices, drawn: None }
    }

    /// Updates that are timed, each as the LODs before and after it. Moves from LOD 0 to the first
    /// and from each to the next are not timed. `passes` lead from a LOD to another.
    #[must_use]
    pub fn updates(
        name: &'static str,
        updates: &[[Lod; 2]],
        passes: impl Fn(Lod, Lod) -> Vec<Pass>,
    ) -> Self {
        let starts = std::iter::once(Lod(0)).chain(updates.iter().map(|&[_, to]| to));
        let gaps: Vec<[Lod; 2]> = starts.zip(updates).map(|(at, &[from, _])| [at, from]).collect();
        let before = if gaps.iter().all(|[at, from]| at == from) {
            vec![]
        } else {
            let lead = |&[at, from]: &[Lod; 2]| if at == from { vec![] } else { passes(at, from) };
            gaps.iter().map(lead).collect()
        };
        // A move looks at every vertex that is gone at the coarser of its two LODs.
        let vertices = updates.iter().map(|&[from, to]| u64::from(from.max(to).0)).sum();
        let runs = updates.iter().map(|&[from, to]| passes(from, to)).collect();
        Self { before, ..Self::new(name, runs, vertices) }
    }

    /// Drawing that is timed, after the passes of each run.
    #[must_use]
    pub fn drawing(name: &'static str, runs: Vec<Vec<Pass>>, drawn: DrawInput) -> Self {
        Self { name, runs, before: vec![], vertices: 0, drawn: Some(drawn) }
    }

    /// Bytes that a host sends to the device for all runs: the parameters of the passes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.runs.iter().flatten().map(|pass| 4 * pass.parameters.len() as u64).sum()
    }
}

/// The input of a draw: indexed triangles, by indirect draws.
#[derive(Clone, Copy, Debug)]
pub struct DrawInput {
    /// Vertex records that start with a position.
    pub vertices: BufferId,
    /// Words of a record.
    pub stride: usize,
    /// The index buffer.
    pub indices: BufferId,
    /// True if it holds strips, separated by restart indices; else triangles.
    pub strips: bool,
    /// Arguments of indexed indirect draws, five words each.
    pub draws: BufferId,
    /// The first draw.
    pub first: usize,
    /// Number of draws.
    pub count: usize,
    /// Lowest and highest corner of the bounding box.
    pub bounds: ([f32; 3], [f32; 3]),
}

/// The memory of a variant of a structure on a device, in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// The variant.
    pub variant: &'static str,
    /// With positions only.
    pub positions: u64,
    /// With positions and normals.
    pub normals: u64,
}
