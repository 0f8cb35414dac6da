//! Replay on a graphics device as plain data: words, WGSL, and what must come out.
//!
//! A model that can live on a graphics device says so by making a [`Plan`]. `lodc-gpu` runs any
//! plan and knows no model; nothing here knows a graphics API. Every kernel stands beside its twin,
//! the Rust code that does the same.

mod benchmark;
mod packed;
mod program;
mod records;
mod scan;
mod schedule;

pub use benchmark::{Benchmark, Case, Drawn, Memory};
pub use packed::{Packed, RESTART, STRIP_DRAWS};
pub use program::{Buffer, BufferId, Contents, Kernel, KernelId, Pass, Program, Shader, WORKGROUP};
pub use records::VertexRecords;
pub use scan::{SCAN, SCAN_ADD, Scan};
pub use schedule::{DRAWS, SWEEP, schedule, stops, sweep};

use crate::Failure;
use lodc_mesh::Lod;
use std::{fmt, sync::Arc};

/// What to run and what to expect. Steps are made one by one, because all expectations of a large
/// mesh together would not fit into memory.
pub struct Plan<'a> {
    /// The model, as reports name it.
    pub model: &'static str,
    /// What is checked.
    pub name: &'static str,
    /// Buffers and kernels.
    pub program: Program,
    /// What to do, in order.
    pub steps: Box<dyn Iterator<Item = Step> + 'a>,
    /// Says which part of the mesh a word of a buffer belongs to.
    pub locate: Box<dyn Fn(BufferId, usize) -> String + 'a>,
}

impl<'a> Plan<'a> {
    /// A plan of `moves`, between a look at what was uploaded and one at what no pass may have
    /// written to: all of that but `written`.
    pub fn of_moves(
        [model, name]: [&'static str; 2],
        program: Program,
        written: &[BufferId],
        moves: impl Iterator<Item = Step> + 'a,
        locate: impl Fn(BufferId, usize) -> String + 'a,
    ) -> Self {
        let uploaded = Step::look("upload", program.uploaded(&[]));
        let kept = Step::look("the end", program.uploaded(written));
        let steps = Box::new(std::iter::once(uploaded).chain(moves).chain([kept]));
        Self { model, name, program, steps, locate: Box::new(locate) }
    }
}

/// Some passes, and what must be in the buffers after them.
#[derive(Clone, Debug, Default)]
pub struct Step {
    /// Where this is, for messages.
    pub at: String,
    /// Whether this is a LOD or a view, as reports count them; else it prepares or cleans up.
    pub counts: bool,
    /// Run in order; each sees what the ones before it wrote.
    pub passes: Vec<Pass>,
    /// Compared word by word.
    pub checks: Vec<Expected>,
    /// What is wrong with the twin itself: it is compared with the reference before a device is
    /// compared with it.
    pub twin: Option<Failure>,
}

impl Step {
    /// Shows a LOD; `twin` is what is wrong with it on the CPU.
    #[must_use]
    pub fn show(lod: Lod, passes: Vec<Pass>, checks: Vec<Expected>, twin: Option<Failure>) -> Self {
        Self { at: format!("LOD {}", lod.0), counts: true, passes, checks, twin }
    }

    /// Runs nothing and looks whether buffers hold what they should.
    #[must_use]
    pub fn look(at: &str, checks: Vec<Expected>) -> Self {
        Self { at: at.to_owned(), checks, ..Self::default() }
    }
}

/// Words that a buffer must hold.
#[derive(Clone, Debug)]
pub struct Expected {
    /// The buffer.
    pub buffer: BufferId,
    /// They start at this word of it.
    pub first: usize,
    /// The words.
    pub words: Arc<[u32]>,
    /// Floats in them that may be off by one unit in the last place on hardware.
    pub tolerance: Option<Tolerance>,
}

/// Which words are results of floating-point arithmetic. Adapters that are software must agree in
/// them bit for bit, too; of hardware WGSL does not demand it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tolerance {
    /// Words of a record.
    pub stride: usize,
    /// The first so many words of each are computed; the others are copies.
    pub floats: usize,
}

impl Expected {
    /// A buffer from its first word on.
    pub fn new(buffer: BufferId, words: impl Into<Arc<[u32]>>) -> Self {
        Self { buffer, first: 0, words: words.into(), tolerance: None }
    }
}

/// Why there is no plan for a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PlanError {
    /// A buffer would be larger than words can be numbered.
    TooLarge {
        /// What would be in it.
        what: &'static str,
        /// How many words.
        words: u64,
    },
    /// A chain of collapses is longer than a kernel may loop on every device.
    TooDeep {
        /// Its length.
        length: u32,
    },
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLarge { what, words } => write!(f, "{what} would take {words} words"),
            Self::TooDeep { length } => {
                write!(
                    f,
                    "a vertex collapses {length} times, more than the {LONGEST_LOOP} a kernel may loop"
                )
            }
        }
    }
}

impl std::error::Error for PlanError {}

/// How often a kernel may loop. Mesa's lavapipe silently leaves all loops of an invocation after
/// 65,535 rounds.
pub const LONGEST_LOOP: u32 = 60_000;
