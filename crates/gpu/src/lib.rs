//! The only package that sees a graphics device: it runs any [`Plan`](lodc_plan::Plan)
//! and compares what comes back bit for bit. It knows no model.
//!
//! ```
//! use lodc_gpu::{Device, GpuError, Session};
//! use lodc_plan::{Program, Scan};
//!
//! let device = match Device::open(None) {
//!     Ok(device) => device,
//!     Err(GpuError::NoAdapter { .. }) => return Ok(()),
//!     Err(error) => return Err(error),
//! };
//! let mut program = Program::default();
//! let words = program.words("words", [1, 2, 3, 4, 5]);
//! let passes = Scan::new(&mut program, words, 5).passes();
//! let mut session = Session::new(&device, &program)?;
//! session.run(&passes)?;
//! assert_eq!(session.read(words)?, [0, 1, 3, 6, 10]);
//! # Ok::<(), GpuError>(())
//! ```

mod device;
mod draw;
mod error;
mod instanced;
mod measure;
mod pipelines;
mod replay;
mod session;
mod timer;

pub use device::{Adapter, Device, LimitOverrides};
pub use error::GpuError;
pub use instanced::{Instance, Instanced, InstancedDraw, InstancedFrame};
/// Which updates and draws of a sweep over all LODs are timed: fewer of a large mesh.
pub use lodc_plan::{DRAWN_UPDATES, SWEEP_UPDATES, drawn_stops, timed_updates};
pub use measure::{Figure, measure};
pub use replay::{Difference, Replayed, Replays, replay};
pub use session::Session;
/// The interface to devices that all of this uses.
pub use wgpu;
pub use wgpu::{CommandEncoder, RenderPass};
