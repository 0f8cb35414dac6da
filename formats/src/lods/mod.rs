//! The `.lods` stream, version 1 (docs/STREAM.md): a mesh that grows from a single vertex to what
//! it was, as bytes come.
//!
//! Thesis 4.3.3. [`pack()`] writes a stream; an [`Unpacker`] is fed one, piece by piece, and shows
//! the mesh of every prefix. What a vertex brings is said once, by code that writes and reads alike
//! (`record.rs`, `strips.rs`, `values.rs`); a `Script` is what only a writer knows.

mod births;
mod block;
mod chances;
mod coder;
mod fans;
mod growth;
mod head;
mod layout;
mod model;
mod moves;
mod numbers;
mod pack;
mod quantize;
mod record;
mod script;
mod strips;
#[cfg(test)]
mod tests;
mod text;
mod unpack;
mod values;

pub use pack::{PackOptions, Packed, PackedObject, pack};
pub use quantize::{Bound, Quantize};
pub use unpack::{State, Unpacker};

/// The version that this program writes, and the newest that it reads.
pub const VERSION: u32 = 1;

/// Bytes with the checksums that they should have as a stream: for tests with forged streams, and
/// for fuzzing.
#[doc(hidden)]
#[must_use]
pub fn repaired(bytes: &[u8]) -> Vec<u8> {
    let mut out = bytes[..bytes.len().min(block::PREAMBLE)].to_vec();
    let mut rest = &bytes[out.len()..];
    for number in 0.. {
        let Some((block, length)) = block::believed(rest) else { break };
        block::put(&mut out, number, block);
        rest = &rest[length..];
    }
    out
}

/// Why what was heard cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Broken(&'static str);

/// Bits of an error that are left out; it is rounded up.
const ERROR_BITS: u32 = 19;

/// An error as it is told: the upper bits of the float.
fn error_code(error: f32) -> u32 {
    // Adding zero makes 0 of −0.
    ((error + 0.0).to_bits() + (1 << ERROR_BITS) - 1) >> ERROR_BITS
}

fn error_value(code: u32) -> f32 {
    f32::from_bits(code << ERROR_BITS).min(f32::MAX)
}

/// Whether so many bytes of a stream may have made so large an object with so much work. Real ones
/// take a hundredth of it; without a bound a few bytes could ask for any amount of memory and time.
fn may_hold(bytes: usize, object: &record::Object) -> bool {
    let growth = &object.growth;
    let size = growth.numbers.len() as u64
        + 8 * u64::from(growth.vertices())
        + 8 * u64::from(growth.faces());
    let bytes = bytes as u64;
    let most = |free: u64, each: u64| free.saturating_add(bytes.saturating_mul(each));
    size <= most(1 << 20, 1024) && object.work <= most(1 << 26, 1 << 16)
}
