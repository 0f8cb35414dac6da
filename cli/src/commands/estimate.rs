//! Memory that work on an input is likely to need.

use crate::exit::{Failure, Outcome};
use crate::jobs::expected_bytes;
use crate::limits::ImportArgs;
use crate::output;
use lodc::pipeline::{Need, Size};
use lodc_formats::import;
use lodc_formats::import::Counted;
use std::path::Path;

/// Jobs that are expected to need at most this much memory (a file of about half a megabyte) keep
/// freed memory until they end. Chosen by hand.
const MAX_SMALL_BYTES: u64 = 8_000_000;

/// Bytes of memory for each byte of an input, besides the stages': the byte itself, what it decodes
/// to, the document that the result holds, and the result.
const DOCUMENT_BYTES_PER_INPUT_BYTE: u64 = 4;

/// Counts what a mesh holds, and estimates the bytes of memory that work on it needs beside the
/// program's own. `needs` says what the stages need.
///
/// # Errors
/// If it cannot be read, or cannot be read twice.
pub(crate) fn estimate<const N: usize>(
    input: &Path,
    import: &ImportArgs,
    needs: impl FnOnce(Size) -> [Need; N],
) -> Outcome<(Counted, u64)> {
    if output::is_standard_stream(input) {
        let what = "standard input cannot be estimated: it can be read once only";
        return Err(Failure::usage(what));
    }
    let counted = import::count(input, &import.options())?;
    let size = Size { triangles: counted.triangles, vertices: counted.vertices, moving: 0 };
    let largest = needs(size).iter().map(|need| need.bytes).max().unwrap_or(0);
    let document = counted.bytes.saturating_mul(DOCUMENT_BYTES_PER_INPUT_BYTE);
    Ok((counted, largest.saturating_add(document)))
}

/// Returns whether an input is a file so small that its work need not give freed memory back.
pub(crate) fn is_small(input: &Path) -> bool {
    // 0 means that the size is unknown.
    (1..=MAX_SMALL_BYTES).contains(&expected_bytes(input))
}
