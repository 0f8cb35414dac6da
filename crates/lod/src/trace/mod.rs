//! Traces strips through a collapse sequence, each by itself: what every record changes in a strip,
//! until it draws nothing any more. Speed Strips are made of it.
//!
//! Element `p` of a strip holds `strip[p]`, then what that becomes, and so on, and changes at
//! exactly the records of these vertices. So strips need not know of each other, and all work on
//! one touches little memory.

mod filter;
mod history;
mod ranks;
mod tracer;
mod working;

pub use history::{Event, History, Removal, RemovalKind};
pub(crate) use tracer::{RemovalSource, TraceInput, in_parallel};
pub(crate) use working::{RemovedRun, WorkingStrip};

use filter::Filter;
use lodc_mesh::{PositionIds, Simplified};
use lodc_model::BuildError;
use lodc_strip::StripSet;

/// Traces all strips, removing repetitions and, if `with_dead_ends`, dead ends. Parallel over runs
/// of strips; the result does not depend on the threads.
///
/// # Errors
/// If strips change more often than those of any real mesh.
pub fn histories(
    simplified: &Simplified,
    strips: &StripSet,
    positions: &PositionIds,
    with_dead_ends: bool,
) -> Result<Vec<History>, BuildError> {
    let targets = simplified.collapses().targets();
    let input = TraceInput { targets, strips, positions };
    in_parallel(&input, |tracer, range| {
        tracer.trace(&input, range, &mut Filter::new(targets, with_dead_ends))
    })
}
