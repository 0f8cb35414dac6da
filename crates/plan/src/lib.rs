//! Work on a graphics device as plain data: words, WGSL, and what must come out.
//!
//! A model that can live on a graphics device says so by making a [`Plan`]. `lodc-gpu` runs any
//! plan and knows no model; nothing here knows a graphics API. Every kernel (compute shader) is
//! beside its CPU version, the Rust code that does the same.
//!
//! ```
//! use lodc_plan::{Expected, Pass, Program, Scan};
//!
//! // Prefix sums of five words, as a device makes them.
//! let mut program = Program::default();
//! let words = program.words("words", [1, 2, 3, 4, 5]);
//! let passes: Vec<Pass> = Scan::new(&mut program, words, 5).passes();
//! let expected = Expected::new(words, [0, 1, 3, 6, 10]);
//! assert_eq!((passes.len(), expected.words.len()), (1, 5));
//! ```

mod benchmark;
mod error;
mod packed;
mod plan;
mod program;
mod records;
mod scan;
mod schedule;

pub use benchmark::{Benchmark, Case, DrawInput, Memory};
pub use error::{LONGEST_LOOP, PlanError};
pub use packed::{PackedStrips, RESTART, STRIP_DRAWS};
pub use plan::{Plan, Step};
pub use program::{
    Buffer, BufferId, Contents, Expected, Kernel, KernelId, Pass, Program, Shader, Tolerance,
    WORKGROUP,
};
pub use records::VertexRecords;
pub use scan::{SCAN, SCAN_ADD, Scan};
pub use schedule::{
    DRAWN_UPDATES, SWEEP_UPDATES, drawn_stops, schedule, stops, sweep, timed_updates,
};
