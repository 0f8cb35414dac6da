//! Memory that an import may take in all: files can point to the same bytes many times, and
//! memory must not follow them.

use crate::{Fault, FormatError};
use std::cell::Cell;

/// Bytes that any file may need, however small it is.
const BASE: u64 = 32 << 20;
/// Bytes per byte of input: enough for strips of 8-bit indices unrolled and for well compressed
/// buffer views.
const PER_BYTE: u64 = 16;

/// The rest of 32 MiB plus 16 bytes per byte of input. Everything that is allocated for
/// geometry is charged before it is allocated.
#[derive(Debug)]
pub(super) struct Budget {
    left: Cell<u64>,
    whole: u64,
}

impl Budget {
    /// The budget for this many bytes of input.
    pub(super) fn new(input_bytes: u64) -> Self {
        let whole = BASE.saturating_add(input_bytes.saturating_mul(PER_BYTE));
        Self { left: Cell::new(whole), whole }
    }

    /// Takes `count` elements of `size` bytes off the budget.
    pub(super) fn charge(&self, count: u64, size: u64, place: &str) -> Result<(), FormatError> {
        let left = count.checked_mul(size).and_then(|bytes| self.left.get().checked_sub(bytes));
        let over = || {
            let what = format!(
                "unpacks to more than {} MiB, too much for a file of this size",
                self.whole >> 20
            );
            FormatError::new(Fault::Limit, place, what)
        };
        self.left.set(left.ok_or_else(over)?);
        Ok(())
    }
}
