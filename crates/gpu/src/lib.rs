//! The only package that sees a graphics device: it runs any [`Plan`](lodc_plan::Plan),
//! compares what comes back bit for bit, and draws pictures. It knows no model.

mod device;
mod draw;
mod error;
mod measure;
pub mod picture;
mod replay;
mod session;
mod timer;

pub use device::{Adapter, Device, Lowered};
pub use error::GpuError;
pub use measure::{Figure, measure};
pub use replay::{Difference, Replayed, replay};
pub use session::Session;
