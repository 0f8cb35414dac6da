use crate::entropy::adaptive_probability::{AdaptiveBit, AdaptiveSymbol};
use crate::entropy::coder::Coder;
use crate::entropy::decoder::Decoder;
use crate::entropy::encoder::Encoder;
use crate::entropy::integer_codes::{BoundedCode, GammaCode, ResidualCode};
use lodc_mesh::SplitMix64;

/// Codes pseudo-random values of every kind. A decoder is given wrong values.
fn code_primitives<C: Coder>(coder: &mut C, random: &mut SplitMix64) -> Vec<u32> {
    let wrong = !C::ENCODES;
    let mut bits = [AdaptiveBit::NEW; 4];
    let mut symbols = [AdaptiveSymbol::NEW; 4];
    let mut coded = Vec::new();
    for i in 0..20_000 {
        let skew = [2, 10, 1000, 100_000][i % 4];
        coded.push(u32::from(coder.bit(&mut bits[i % 4], (random.below(skew) == 0) ^ wrong)));
        let symbol = random.below([1, 2, 9, 16][i % 4] + usize::from(i % 1000 == 3)) as u32 & 15;
        coded.push(coder.symbol(&mut symbols[i % 4], if wrong { 0 } else { symbol }));
        let length = random.below(33) as u32;
        let end = (1 + random.bits() % u64::from(u32::MAX >> random.below(32))) as u32;
        let value = (random.bits() & ((1u64 << length) - 1)) as u32;
        coded.push(coder.raw(length, if wrong { 0 } else { value }));
        let below = (random.bits() % u64::from(end)) as u32;
        coded.push(coder.uniform(end, if wrong { 0 } else { below }));
    }
    coded
}

#[test]
fn coded_values_are_decoded() {
    for seed in 0..20 {
        let mut encoder = Encoder::default();
        let coded = code_primitives(&mut encoder, &mut SplitMix64::new(seed));
        let estimate = encoder.len();
        let substream = encoder.finish();
        let length = substream.len();
        assert!(length.abs_diff(estimate) < estimate / 50, "{length} bytes, not {estimate}");
        let bytes = substream.into_bytes(seed as usize);
        let mut decoder = Decoder::new(&bytes);
        assert!(!decoder.is_finished(), "seed {seed}");
        let decoded = code_primitives(&mut decoder, &mut SplitMix64::new(seed));
        assert_eq!(decoded, coded, "seed {seed}");
        assert!(decoder.is_finished(), "seed {seed}");
        let mut decoder = Decoder::new(&bytes[..bytes.len() / 2]);
        code_primitives(&mut decoder, &mut SplitMix64::new(seed));
        assert!(!decoder.is_finished(), "seed {seed}");
    }
}

#[test]
fn likely_values_take_few_bytes() {
    let mut encoder = Encoder::default();
    let (mut bit, mut symbol) = (AdaptiveBit::NEW, AdaptiveSymbol::NEW);
    for _ in 0..40_000 {
        encoder.bit(&mut bit, true);
        encoder.symbol(&mut symbol, 7);
    }
    let bytes = encoder.finish().len();
    assert!(bytes < 200, "{bytes} bytes");
    assert_eq!(Encoder::default().finish().len(), 0);
}

fn code_integers<C: Coder>(coder: &mut C, random: &mut SplitMix64) -> Vec<i64> {
    let hidden = |value: u32| if C::ENCODES { value } else { 0 };
    let mut residual = ResidualCode::NEW;
    let (mut gamma, mut bounded) = (GammaCode::NEW, BoundedCode::NEW);
    let mut coded = Vec::new();
    for _ in 0..5_000 {
        let expected = random.below(33) as u32;
        let magnitude = (random.bits() >> 32 >> random.below(33)) as u32;
        let sign = if random.below(2) == 0 { 1 } else { -1 };
        let value = sign * i64::from(hidden(magnitude));
        coded.push(residual.code(coder, expected, value).value);
        let natural = (random.bits() >> 32 >> random.below(33)) as u32;
        coded.push(i64::from(gamma.code(coder, hidden(natural))));
        let end = (random.bits() >> 32 >> random.below(32)).max(1) as u32;
        let value = (random.bits() % u64::from(end)) as u32;
        coded.push(i64::from(bounded.code(coder, end, hidden(value))));
    }
    for edge in [0, 1, -1, i64::from(u32::MAX), -i64::from(u32::MAX)] {
        for expected in 0..33 {
            let value = if C::ENCODES { edge } else { 0 };
            coded.push(residual.code(coder, expected, value).value);
        }
    }
    coded
}

#[test]
fn coded_integers_are_decoded() {
    for seed in 0..10 {
        let mut encoder = Encoder::default();
        let coded = code_integers(&mut encoder, &mut SplitMix64::new(seed));
        let bytes = encoder.finish().into_bytes(0);
        let mut decoder = Decoder::new(&bytes);
        assert_eq!(code_integers(&mut decoder, &mut SplitMix64::new(seed)), coded, "seed {seed}");
        assert!(decoder.is_finished());
    }
}
