//! Variable-length numbers: seven bits a byte, the lowest first (LEB128).

/// Appends a number; all its bytes but the last have their top bit set.
pub fn put_leb128(out: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

/// Reads a number off the front of `bytes` and moves `bytes` past it.
///
/// Returns `None` if the number does not end, is not written in the fewest bytes, or is above
/// `max`; `bytes` must not be used after that.
pub fn take_leb128(bytes: &mut &[u8], max: u64) -> Option<u64> {
    let mut number = 0u64;
    // Ten bytes hold 64 bits; the tenth holds the highest one.
    for (i, &byte) in bytes.iter().take(10).enumerate() {
        let bits = u64::from(byte & 0x7f);
        if i == 9 && bits > 1 || byte == 0 && i > 0 {
            return None;
        }
        number |= bits << (7 * i);
        if byte < 0x80 {
            *bytes = &bytes[i + 1..];
            return (number <= max).then_some(number);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_back_and_nothing_else_is_accepted() {
        let max = u64::from(u32::MAX);
        let numbers = [0, 1, 127, 128, 300, 16_383, 16_384, 0x1f_ffff, 0x20_0000, max - 1, max];
        let mut bytes = Vec::new();
        numbers.iter().chain([&u64::MAX]).for_each(|&n| put_leb128(&mut bytes, n));
        let mut rest = &bytes[..];
        for n in numbers {
            assert_eq!(take_leb128(&mut rest, max), Some(n));
        }
        assert_eq!(take_leb128(&mut rest.to_vec().as_slice(), max), None);
        assert_eq!((take_leb128(&mut rest, u64::MAX), rest.len()), (Some(u64::MAX), 0));
        for wrong in [&[0x80u8][..], &[0x80, 0], &[0xff, 0xff, 0xff, 0xff, 0x10], &[0x81; 11], &[]]
        {
            assert_eq!(take_leb128(&mut &*wrong, max), None, "{wrong:?}");
        }
    }
}
