//! Triangle strips and triangle orders: what they draw, generators, vertex-cache models.
//!
//! [`stripe()`] makes few long strips, [`cache()`] short strips that reuse a vertex cache,
//! [`order()`] a triangle list for vertex caches, [`codec_order()`] one that compresses well. Every
//! generator draws exactly the oriented triangles of the mesh, whatever the mesh: edges with many
//! triangles, contradicting windings and doubled triangles only end strips earlier. Results depend
//! on the mesh and the options alone, not on the number of threads.
//!
//! ```
//! use lodc_strip::{Effort, stripe};
//!
//! let mesh = lodc_fixtures::torus();
//! let strips = stripe(&mesh, Effort::Fast);
//! assert_eq!(strips.check(&mesh), Ok(()));
//! assert!(strips.separate_indices() < 3 * mesh.triangles().len() as u64 / 2);
//! ```

mod adjacency;
mod anneal;
mod cache;
mod cache_model;
mod codec_order;
mod cover;
mod draw_state;
mod effort;
mod kind;
mod meter;
mod order;
mod strip_set;
mod stripe;

pub use cache::{CacheOptions, cache};
pub use cache_model::{CacheKind, CacheModel, CacheStatistics, measure};
pub use codec_order::{codec_order, codec_order_list};
pub use effort::Effort;
pub use kind::{StripKind, StripOptions, StripPool, Strips};
pub use meter::Report;
pub use order::{order, order_list};
pub use strip_set::{StripSet, StripSetError, live_triangles, restart_list, strip_triangles};
pub use stripe::stripe;

#[cfg(test)]
mod tests;
