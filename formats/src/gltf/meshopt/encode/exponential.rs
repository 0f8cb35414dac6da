//! The exponential filter: floats as whole numbers times a power of two.

use crate::import::gltf::meshopt::{Filter, unfiltered};

/// Bits of a whole number besides its sign.
const BITS: u32 = 23;
/// Of a float's mantissa, without the leading one.
const MANTISSA: u32 = 23;
/// Of a float's exponent, and what it is more than the power of the last bit.
const BIAS: i32 = 127 + MANTISSA as i32;

/// Packs elements of floats, `stride` bytes each, with one power of two per component. None unless
/// the decoder will give back every byte.
pub(super) fn encode(stride: usize, bytes: &[u8]) -> Option<Vec<u8>> {
    let mut powers = vec![i32::MAX; stride / 4];
    for element in bytes.chunks_exact(stride) {
        for (power, b) in powers.iter_mut().zip(element.as_chunks::<4>().0) {
            *power = (*power).min(lowest_bit(u32::from_le_bytes(*b)));
        }
    }
    // A component that is 0 everywhere.
    powers.iter_mut().filter(|p| **p == i32::MAX).for_each(|p| *p = 0);
    if powers.iter().any(|power| !(-100..100).contains(power)) {
        return None;
    }
    let mut packed = Vec::with_capacity(bytes.len());
    for element in bytes.chunks_exact(stride) {
        for (power, b) in powers.iter().zip(element.as_chunks::<4>().0) {
            packed.extend(word(u32::from_le_bytes(*b), *power)?.to_le_bytes());
        }
    }
    let mut again = packed.clone();
    unfiltered(Filter::Exponential, stride, &mut again);
    (again == bytes).then_some(packed)
}

/// The power of two of the lowest bit of a float that is set; the largest number for 0.
fn lowest_bit(float: u32) -> i32 {
    if float & (u32::MAX >> 1) == 0 { i32::MAX } else { exponent(float) - BIAS + zeros(float) }
}

fn exponent(float: u32) -> i32 {
    (float >> MANTISSA & 0xff) as i32
}

fn mantissa(float: u32) -> u32 {
    float & ((1 << MANTISSA) - 1) | 1 << MANTISSA
}

fn zeros(float: u32) -> i32 {
    mantissa(float).trailing_zeros() as i32
}

/// A float as a whole number times a power of two: the power in the highest 8 bits. None if it has
/// too many bits.
fn word(float: u32, power: i32) -> Option<i32> {
    if float & (u32::MAX >> 1) == 0 {
        return Some(power << 24);
    }
    let shift = u32::try_from(lowest_bit(float) - power).ok()?;
    let odd = mantissa(float) >> zeros(float);
    let fits = shift < BITS && odd.checked_shl(shift)? >> shift == odd && odd << shift < 1 << BITS;
    let whole = (odd << (shift & 31)) as i32;
    let signed = if float >> 31 == 1 { -whole } else { whole };
    fits.then_some(power << 24 | signed & 0xff_ffff)
}
