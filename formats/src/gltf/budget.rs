//! The limit on memory that an import may allocate. Many accessors can refer to the same bytes, so
//! a small crafted file could ask for any amount without it.

use crate::{Fault, FormatError};
use std::cell::Cell;

/// Bytes that any file may need, however small it is. Chosen by hand.
const BASE: u64 = 32 << 20;
/// Bytes per byte of input: enough for strips of 8-bit indices unrolled and for well compressed
/// buffer views. Chosen by hand.
const PER_BYTE: u64 = 16;

/// What remains of the memory that an import may allocate for geometry: 32 MiB plus 16 bytes per
/// byte of input. Every allocation is charged before it is made.
#[derive(Debug)]
pub(super) struct Budget {
    remaining: Cell<u64>,
    total: u64,
}

impl Budget {
    /// The budget for this many bytes of input.
    pub(super) fn new(input_bytes: u64) -> Self {
        let total = BASE.saturating_add(input_bytes.saturating_mul(PER_BYTE));
        Self { remaining: Cell::new(total), total }
    }

    /// Takes `count` elements of `size` bytes off the budget.
    pub(super) fn charge(&self, count: u64, size: u64, location: &str) -> Result<(), FormatError> {
        let remaining =
            count.checked_mul(size).and_then(|bytes| self.remaining.get().checked_sub(bytes));
        let over = || {
            let problem = format!(
                "unpacks to more than {} MiB, too much for a file of this size",
                self.total >> 20
            );
            FormatError::new(Fault::Limit, location, problem)
        };
        self.remaining.set(remaining.ok_or_else(over)?);
        Ok(())
    }
}
