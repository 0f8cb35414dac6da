//! A text codec for JSON and material files, byte by byte. The prediction of a byte is the one that
//! followed the last occurrence of the preceding four or eight bytes; a bit says whether it is
//! right. If not, the byte is coded in the context of the byte before it. (Prediction by matching,
//! Bloom 1996, over an order-1 model.)
//!
//! The model starts from a typical text, since most documents are short and use the same words. So
//! they take 0.3 to 0.6 of what they take with the order-1 model alone.

use crate::entropy::adaptive_probability::{AdaptiveBit, AdaptiveSymbol};
use crate::entropy::coder::Coder;
use crate::entropy::decoder::Decoder;
use crate::entropy::encoder::Encoder;
use std::fmt::{self, Formatter};

/// A decoder refuses a text longer than this many times its encoding, plus [`EXPANSION_ALLOWANCE`]:
/// few bytes must not ask for much memory. Chosen by hand; encodings that would be smaller are
/// padded.
const MAX_EXPANSION: usize = 64;
/// Bytes that a text may have beyond [`MAX_EXPANSION`] times its encoding, so that short documents
/// need no padding. Chosen by hand.
const EXPANSION_ALLOWANCE: usize = 1 << 16;
/// The text that both sides code before any other: words of glTF, and of materials of OBJ files.
const TYPICAL: &[u8] = include_bytes!("typical_text.txt");

/// Codes texts one after another; each is predicted from those before it.
pub struct TextCodec {
    model: Model,
}

impl Default for TextCodec {
    fn default() -> Self {
        let mut model = Model::new();
        // The encoding of the typical text itself is dropped.
        let mut unused = Encoder::default();
        for &byte in TYPICAL {
            model.code(&mut unused, byte);
        }
        Self { model }
    }
}

impl fmt::Debug for TextCodec {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.debug_struct("TextCodec").field("bytes", &self.model.text.len()).finish_non_exhaustive()
    }
}

impl TextCodec {
    /// Encodes a text.
    #[must_use]
    pub fn encode(&mut self, text: &[u8]) -> Vec<u8> {
        let mut encoder = Encoder::default();
        for &byte in text {
            self.model.code(&mut encoder, byte);
        }
        let substream = encoder.finish();
        let min_length = text.len().saturating_sub(EXPANSION_ALLOWANCE).div_ceil(MAX_EXPANSION);
        let padding = min_length.saturating_sub(substream.len());
        substream.into_bytes(padding)
    }

    /// Decodes a text of `length` bytes. Returns `None` if the bytes hold none of that length.
    #[must_use]
    pub fn decode(&mut self, encoded: &[u8], length: usize) -> Option<Vec<u8>> {
        // Bounds the memory that a few bytes can ask for.
        if length > EXPANSION_ALLOWANCE.saturating_add(encoded.len().saturating_mul(MAX_EXPANSION))
        {
            return None;
        }
        let mut decoder = Decoder::new(encoded);
        let start = self.model.text.len();
        for _ in 0..length {
            self.model.code(&mut decoder, 0);
        }
        decoder.is_finished().then(|| self.model.text[start..].to_vec())
    }
}

/// Bits of the hashes by which earlier occurrences are found. A newer occurrence replaces an older
/// one of the same hash; that does no harm, since JSON mostly repeats recent text. A constant of
/// the format, chosen by hand.
const HASH_BITS: u32 = 16;
/// Contexts for the number of right predictions in a row: 0 to one fewer, or more. A constant of
/// the format, chosen by hand.
const RUN_CONTEXTS: usize = 16;

/// A model of text, and the text so far.
struct Model {
    text: Vec<u8>,
    /// By hashes of the last four and of the last eight bytes: the index in the text of the byte
    /// that followed them the last time; 0 if there was none.
    followers: [Vec<u32>; 2],
    /// The prediction is right: by the hash that found it (0: four bytes, 1: eight), and by how
    /// many predictions in a row were right.
    matches: [[AdaptiveBit; RUN_CONTEXTS]; 2],
    /// Number of right predictions in a row.
    run: usize,
    /// Bytes that were not predicted. By the byte before: 0 to 15 for the lower half of the byte,
    /// one for each upper half, and 16 for the upper half.
    literals: Vec<[AdaptiveSymbol; 17]>,
}

impl Model {
    fn new() -> Self {
        Self {
            text: Vec::new(),
            followers: [vec![0; 1 << HASH_BITS], vec![0; 1 << HASH_BITS]],
            matches: [[AdaptiveBit::NEW; RUN_CONTEXTS]; 2],
            run: 0,
            literals: vec![[AdaptiveSymbol::NEW; 17]; 256],
        }
    }

    /// Codes the next byte.
    fn code<C: Coder>(&mut self, coder: &mut C, byte: u8) {
        let hashes = self.hashes();
        let [after_short, after_long] = [0, 1].map(|i| self.followers[i][hashes[i]] as usize);
        let (kind, follower) = if after_long > 0 { (1, after_long) } else { (0, after_short) };
        let mut predicted = None;
        if follower > 0 {
            let expected = self.text[follower];
            let context = &mut self.matches[kind][self.run.min(RUN_CONTEXTS - 1)];
            predicted = coder.bit(context, expected == byte).then_some(expected);
        }
        self.run = if predicted.is_some() { self.run + 1 } else { 0 };
        let byte = predicted.unwrap_or_else(|| {
            let previous = self.text.last().copied().unwrap_or_default();
            let contexts = &mut self.literals[usize::from(previous)];
            let high = coder.symbol(&mut contexts[16], u32::from(byte >> 4));
            let low = coder.symbol(&mut contexts[high as usize], u32::from(byte & 15));
            (high << 4 | low) as u8
        });
        for (followers, hash) in self.followers.iter_mut().zip(hashes) {
            followers[hash] = self.text.len() as u32;
        }
        self.text.push(byte);
    }

    /// Returns hashes of the last four and of the last eight bytes, zeros before the first one.
    fn hashes(&self) -> [usize; 2] {
        let end = self.text.len();
        // The four bytes that begin `back` bytes before the end.
        let word = |back: usize| {
            let bytes4 = end.checked_sub(back).and_then(|at| self.text[at..].first_chunk());
            u32::from_le_bytes(bytes4.copied().unwrap_or_default())
        };
        // The multipliers are primes of XXH32.
        let short = word(4).wrapping_mul(0x9e37_79b1);
        let long = short.wrapping_add(word(8)).wrapping_mul(0x85eb_ca77);
        [short, long].map(|hash| (hash >> (32 - HASH_BITS)) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encode(text: &[u8]) -> Vec<u8> {
        TextCodec::default().encode(text)
    }

    fn decode(encoded: &[u8], length: usize) -> Option<Vec<u8>> {
        TextCodec::default().decode(encoded, length)
    }

    #[test]
    fn text_is_decoded_and_shrinks() {
        let text =
            r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"material":0}]}]}"#.repeat(20);
        let encoded = encode(text.as_bytes());
        assert!(encoded.len() < 60, "{} of {}", encoded.len(), text.len());
        assert_eq!(decode(&encoded, text.len()).as_deref(), Some(text.as_bytes()));
        assert_eq!(decode(&encoded, 1 << 40), None);
        assert_eq!(decode(&encoded, 60_000), None, "longer than the text");
        assert!(encode(&[]).is_empty());
        assert_eq!(decode(&[], 0), Some(vec![]));
    }

    #[test]
    fn a_text_is_shorter_after_its_like() {
        let text = b"\x05\x03any words that repeat nothing";
        let (mut encoder, mut decoder) = (TextCodec::default(), TextCodec::default());
        let [first, second] = [0, 1].map(|_| encoder.encode(text));
        assert!(second.len() < first.len() / 2, "{} {}", first.len(), second.len());
        for encoded in [first, second] {
            assert_eq!(decoder.decode(&encoded, text.len()).as_deref(), Some(&text[..]));
        }
    }

    #[test]
    fn any_bytes_are_decoded() {
        let bytes: Vec<u8> = (0..70_000u32).map(|i| (i.wrapping_mul(i) >> 9) as u8).collect();
        for length in (0..40).chain([bytes.len()]) {
            let encoded = encode(&bytes[..length]);
            assert_eq!(decode(&encoded, length).as_deref(), Some(&bytes[..length]));
        }
    }

    #[test]
    fn extreme_redundancy_is_padded() {
        let text = vec![0; 10 << 20];
        let encoded = encode(&text);
        assert_eq!(encoded.len(), (text.len() - EXPANSION_ALLOWANCE).div_ceil(MAX_EXPANSION));
        assert!(decode(&encoded, text.len()) == Some(text));
    }
}
