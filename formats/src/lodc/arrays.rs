//! Arrays of numbers as little-endian bytes: on little-endian machines the loops below are plain
//! copies.

use crate::{Fault, FormatError};

pub(super) fn put_u32s(out: &mut Vec<u8>, values: &[u32]) {
    let start = out.len();
    out.resize(start + 4 * values.len(), 0);
    for (bytes, value) in out[start..].chunks_exact_mut(4).zip(values) {
        bytes.copy_from_slice(&value.to_le_bytes());
    }
}

pub(super) fn put_f32s(out: &mut Vec<u8>, values: &[f32]) {
    let start = out.len();
    out.resize(start + 4 * values.len(), 0);
    for (bytes, value) in out[start..].chunks_exact_mut(4).zip(values) {
        bytes.copy_from_slice(&value.to_le_bytes());
    }
}

/// `width` bytes for each value: 1 to 4, chosen by the caller so that every value fits.
pub(super) fn put_narrow(out: &mut Vec<u8>, values: &[u32], width: usize) {
    out.reserve(width * values.len());
    for value in values {
        out.extend_from_slice(&value.to_le_bytes()[..width]);
    }
}

pub(super) fn f32_triples(
    bytes: &[u8],
    location: impl Fn() -> String,
) -> Result<Vec<[f32; 3]>, FormatError> {
    check_whole_entries(bytes, 12, location)?;
    Ok(bytes.chunks_exact(12).map(|b| triple(b).map(f32::from_bits)).collect())
}

/// The values of [`put_narrow`].
pub(super) fn narrow(
    bytes: &[u8],
    width: usize,
    location: impl Fn() -> String,
) -> Result<Vec<u32>, FormatError> {
    check_whole_entries(bytes, width, location)?;
    Ok(bytes.chunks_exact(width).map(little_endian).collect())
}

pub(super) fn narrow_triples(
    bytes: &[u8],
    width: usize,
    location: impl Fn() -> String,
) -> Result<Vec<[u32; 3]>, FormatError> {
    check_whole_entries(bytes, 3 * width, location)?;
    let entry = |b: &[u8]| {
        [
            little_endian(&b[..width]),
            little_endian(&b[width..2 * width]),
            little_endian(&b[2 * width..]),
        ]
    };
    Ok(bytes.chunks_exact(3 * width).map(entry).collect())
}

fn little_endian(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}

fn triple(b: &[u8]) -> [u32; 3] {
    [
        u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        u32::from_le_bytes([b[4], b[5], b[6], b[7]]),
        u32::from_le_bytes([b[8], b[9], b[10], b[11]]),
    ]
}

pub(super) fn check_whole_entries(
    bytes: &[u8],
    size: usize,
    location: impl Fn() -> String,
) -> Result<(), FormatError> {
    if bytes.len().is_multiple_of(size) {
        return Ok(());
    }
    let problem = format!("{} bytes are not a whole number of entries of {size}", bytes.len());
    Err(FormatError::new(Fault::Malformed, location(), problem))
}

/// One bit for each flag, the lowest of a byte first.
pub(super) fn put_bits(out: &mut Vec<u8>, flags: &[bool]) {
    let byte = |flags: &[bool]| {
        flags.iter().enumerate().fold(0, |byte, (bit, &flag)| byte | u8::from(flag) << bit)
    };
    out.extend(flags.chunks(8).map(byte));
}

/// The flags of [`put_bits`].
pub(super) fn bits(
    bytes: &[u8],
    count: usize,
    location: impl Fn() -> String,
) -> Result<Vec<bool>, FormatError> {
    let wrong = |problem| Err(FormatError::new(Fault::Malformed, location(), problem));
    if bytes.len() != count.div_ceil(8) {
        return wrong(format!("{} bytes are not one bit for each of {count}", bytes.len()));
    }
    let bit = |i: usize| bytes[i / 8] >> (i % 8) & 1 == 1;
    if (count..8 * bytes.len()).any(bit) {
        return wrong("bits behind the last one are set".to_owned());
    }
    Ok((0..count).map(bit).collect())
}
