//! Text, such as JSON, coded byte by byte in the context of the byte before (an order-1 model).

use crate::entropy::adaptive_probability::AdaptiveSymbol;
use crate::entropy::coder::Coder;
use crate::entropy::decoder::Decoder;
use crate::entropy::encoder::Encoder;

/// A text may be this many times as long as its encoding ...
const MAX_EXPANSION: usize = 64;
/// ... and this many bytes longer.
const FREE_BYTES: usize = 1 << 16;

/// Encodes a text. Returns `None` if it would shrink more than a decoder accepts; store such a text
/// as it is.
#[must_use]
pub fn encode(text: &[u8]) -> Option<Vec<u8>> {
    let mut encoder = Encoder::default();
    code(&mut encoder, text, text.len());
    let encoded = encoder.finish().into_bytes(0);
    is_plausible(text.len(), encoded.len()).then_some(encoded)
}

/// Decodes a text of `length` bytes. Returns `None` if the bytes hold none of that length.
#[must_use]
pub fn decode(encoded: &[u8], length: usize) -> Option<Vec<u8>> {
    if !is_plausible(length, encoded.len()) {
        return None;
    }
    let mut decoder = Decoder::new(encoded);
    let text = code(&mut decoder, &[], length);
    decoder.is_finished().then_some(text)
}

/// Bounds the memory that a few bytes can ask for.
fn is_plausible(length: usize, encoded: usize) -> bool {
    length <= FREE_BYTES.saturating_add(encoded.saturating_mul(MAX_EXPANSION))
}

fn code<C: Coder>(coder: &mut C, text: &[u8], length: usize) -> Vec<u8> {
    // By the byte before: the lower half of a byte by its upper half (0 to 15), and the upper half.
    let mut contexts = vec![[AdaptiveSymbol::NEW; 17]; 256];
    let mut coded = Vec::with_capacity(length);
    let mut previous = 0;
    for i in 0..length {
        let byte = text.get(i).copied().unwrap_or_default();
        let contexts = &mut contexts[usize::from(previous)];
        let high = coder.symbol(&mut contexts[16], u32::from(byte >> 4));
        let low = coder.symbol(&mut contexts[high as usize], u32::from(byte & 15));
        previous = (high << 4 | low) as u8;
        coded.push(previous);
    }
    coded
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_decoded_and_shrinks() {
        let text =
            r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"material":0}]}]}"#.repeat(20);
        let encoded = encode(text.as_bytes()).expect("it does not shrink too much");
        assert!(encoded.len() < text.len() / 2, "{} of {}", encoded.len(), text.len());
        assert_eq!(decode(&encoded, text.len()).as_deref(), Some(text.as_bytes()));
        assert_eq!(decode(&encoded, 1 << 40), None);
        assert_eq!(decode(&encoded, 60_000), None, "longer than the text");
        assert_eq!(encode(&[]), Some(vec![]));
        assert_eq!(decode(&[], 0), Some(vec![]));
    }

    #[test]
    fn extreme_redundancy_is_not_encoded() {
        assert_eq!(encode(&vec![0; 10 << 20]), None);
    }
}
