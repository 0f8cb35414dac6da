//! A plan for a graphics device: passes to run step by step, and the words that must be in its
//! buffers after each.

use crate::program::{BufferId, Expected, Pass, Program};
use lodc_mesh::Lod;

/// Work with what must come out. Steps are made one by one, because all expectations of a large
/// mesh together would not fit into memory.
pub struct Plan<'a> {
    /// The model, as reports name it.
    pub model: &'static str,
    /// The variant that is checked.
    pub name: &'static str,
    /// Buffers and kernels.
    pub program: Program,
    /// The steps, in order.
    pub steps: Box<dyn Iterator<Item = Step> + 'a>,
    /// Says which part of the mesh a word of a buffer belongs to.
    pub locate: Box<dyn Fn(BufferId, usize) -> String + 'a>,
}

impl<'a> Plan<'a> {
    /// A plan of `moves`. Before them all uploaded words are checked; after them again those of all
    /// buffers but `written`, as no pass may have changed them.
    pub fn of_moves(
        [model, name]: [&'static str; 2],
        program: Program,
        written: &[BufferId],
        moves: impl Iterator<Item = Step> + 'a,
        locate: impl Fn(BufferId, usize) -> String + 'a,
    ) -> Self {
        let uploaded = Step::look("upload", program.uploaded(&[]));
        let unchanged = Step::look("the end", program.uploaded(written));
        let steps = Box::new(std::iter::once(uploaded).chain(moves).chain([unchanged]));
        Self { model, name, program, steps, locate: Box::new(locate) }
    }
}

/// Some passes, and what must be in the buffers after them.
#[derive(Clone, Debug, Default)]
pub struct Step {
    /// The LOD or view, for messages.
    pub at: String,
    /// True if this is a LOD or a view, as reports count them; else it prepares or cleans up.
    pub counts: bool,
    /// Run in order; each sees what the ones before it wrote.
    pub passes: Vec<Pass>,
    /// Compared word by word.
    pub checks: Vec<Expected>,
    /// What is wrong with the CPU's version of the kernels, if anything: it is compared with the
    /// reference before a device is compared with it.
    pub cpu_failure: Option<String>,
}

impl Step {
    /// Shows a LOD; `cpu_failure` is what is wrong with it on the CPU.
    #[must_use]
    pub fn show(
        lod: Lod,
        passes: Vec<Pass>,
        checks: Vec<Expected>,
        cpu_failure: Option<String>,
    ) -> Self {
        Self { at: format!("LOD {}", lod.0), counts: true, passes, checks, cpu_failure }
    }

    /// Runs nothing and looks whether buffers hold what they should.
    #[must_use]
    pub fn look(at: &str, checks: Vec<Expected>) -> Self {
        Self { at: at.to_owned(), checks, ..Self::default() }
    }
}
