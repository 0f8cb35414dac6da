//! Numbers as bytes in stored arrays: variable-length, or as wide as the largest needs. Reading
//! trusts nothing.

/// Appends a number, seven bits a byte, the lowest first; all bytes but the last have their top bit
/// set (LEB128).
pub fn put_varint(out: &mut Vec<u8>, mut number: u32) {
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

/// Bytes for a number below `count`: 1 to 4.
#[must_use]
pub fn width(count: usize) -> usize {
    match count {
        0..=0x100 => 1,
        0x101..=0x1_0000 => 2,
        0x1_0001..=0x100_0000 => 3,
        _ => 4,
    }
}

/// Appends the lowest `width` bytes of a number.
pub(crate) fn put_narrow(out: &mut Vec<u8>, number: u32, width: usize) {
    out.extend_from_slice(&number.to_le_bytes()[..width]);
}

/// Reads numbers off the front of bytes. `None` where they end, or where a number is written in
/// another way than the writer's.
#[derive(Clone, Debug)]
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// How many bytes are left: more numbers than that cannot come.
    pub(crate) fn left(&self) -> usize {
        self.rest.len()
    }

    /// A number written by [`put_varint`], in the fewest bytes.
    pub(crate) fn varint(&mut self) -> Option<u32> {
        let mut number = 0u32;
        for shift in (0..35).step_by(7) {
            let (&byte, rest) = self.rest.split_first()?;
            self.rest = rest;
            let bits = u32::from(byte & 0x7f);
            if shift == 28 && bits > 0xf || byte == 0 && shift > 0 {
                return None;
            }
            number |= bits << shift;
            if byte < 0x80 {
                return Some(number);
            }
        }
        None
    }

    /// A number of `width` bytes, 1 to 4.
    pub(crate) fn narrow(&mut self, width: usize) -> Option<u32> {
        let (bytes, rest) = self.rest.split_at_checked(width)?;
        self.rest = rest;
        let mut four = [0; 4];
        four[..width].copy_from_slice(bytes);
        Some(u32::from_le_bytes(four))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_and_nothing_else_is_taken() {
        let numbers =
            [0, 1, 127, 128, 300, 16_383, 16_384, 0x1f_ffff, 0x20_0000, u32::MAX - 1, u32::MAX];
        let mut bytes = Vec::new();
        numbers.iter().for_each(|&n| put_varint(&mut bytes, n));
        let mut reader = Reader::new(&bytes);
        for n in numbers {
            assert_eq!(reader.varint(), Some(n));
        }
        assert_eq!((reader.left(), reader.varint()), (0, None));
        for wrong in [&[0x80u8][..], &[0x80, 0], &[0xff, 0xff, 0xff, 0xff, 0x10], &[0x81; 6]] {
            assert_eq!(Reader::new(wrong).varint(), None, "{wrong:?}");
        }
    }

    #[test]
    fn widths_hold_every_number_below_a_count() {
        for count in [0, 1, 256, 257, 65_536, 65_537, 1 << 24, (1 << 24) + 1, u32::MAX as usize] {
            let (mut bytes, largest) = (Vec::new(), count.saturating_sub(1) as u32);
            put_narrow(&mut bytes, largest, width(count));
            let mut reader = Reader::new(&bytes);
            assert_eq!((reader.narrow(width(count)), reader.left()), (Some(largest), 0));
            assert_eq!(reader.narrow(1), None);
        }
    }
}
