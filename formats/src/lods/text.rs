//! Text and other small things of a stream's head, packed: every byte in the light of the one
//! before it.

use super::chances::Symbol;
use super::coder::{Coder, Decoder, Encoder};

/// How much more text than bytes there may be: what says the same again and again is not worth
/// more.
const MOST: usize = 64;
const FREE: usize = 1 << 16;

/// Packs bytes; not, if they would be too easy.
pub(super) fn pack(text: &[u8]) -> Option<Vec<u8>> {
    let mut encoder = Encoder::default();
    say(&mut encoder, text, text.len());
    let packed = encoder.finish().bytes(0);
    may_be(text.len(), packed.len()).then_some(packed)
}

/// Unpacks so many bytes; none if they cannot be in there.
pub(super) fn unpack(packed: &[u8], length: usize) -> Option<Vec<u8>> {
    if !may_be(length, packed.len()) {
        return None;
    }
    let mut decoder = Decoder::new(packed);
    let text = say(&mut decoder, &[], length);
    decoder.is_done().then_some(text)
}

fn may_be(length: usize, packed: usize) -> bool {
    length <= FREE.saturating_add(packed.saturating_mul(MOST))
}

fn say<C: Coder>(coder: &mut C, text: &[u8], length: usize) -> Vec<u8> {
    // The upper half of a byte by the byte before it, the lower half by the upper one too.
    let mut models = vec![[Symbol::NEW; 17]; 256];
    let mut said = Vec::with_capacity(length);
    let mut before = 0;
    for i in 0..length {
        let byte = text.get(i).copied().unwrap_or_default();
        let models = &mut models[usize::from(before)];
        let high = coder.symbol(&mut models[16], u32::from(byte >> 4));
        let byte =
            (high << 4 | coder.symbol(&mut models[high as usize], u32::from(byte & 15))) as u8;
        said.push(byte);
        before = byte;
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_comes_back_and_takes_less_room() {
        let text =
            r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"material":0}]}]}"#.repeat(20);
        let packed = pack(text.as_bytes()).expect("it is no bomb");
        assert!(packed.len() < text.len() / 2, "{} of {}", packed.len(), text.len());
        assert_eq!(unpack(&packed, text.len()).as_deref(), Some(text.as_bytes()));
        assert_eq!(unpack(&packed, 1 << 40), None);
        assert_eq!(unpack(&packed, 60_000), None, "more than was said");
        assert_eq!(pack(&[]), Some(vec![]));
        assert_eq!(unpack(&[], 0), Some(vec![]));
    }

    #[test]
    fn what_is_too_easy_stays_as_it_is() {
        assert_eq!(pack(&vec![0; 10 << 20]), None);
    }
}
