//! Numbers as bytes in stored arrays: variable-length, or as wide as the largest needs. The reader
//! checks every length.

use lodc_mesh::take_leb128;

/// The number of bytes that hold any number below `count`: 1 to 4.
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
pub fn put_narrow(out: &mut Vec<u8>, number: u32, width: usize) {
    out.extend_from_slice(&number.to_le_bytes()[..width]);
}

/// Reads numbers off the front of bytes. `None` where they end, or where a number is written in
/// another way than the writer's.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    unread: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Starts at the first byte.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { unread: bytes }
    }

    /// Number of bytes left: no more numbers than that can come.
    #[must_use]
    pub fn remaining(&self) -> usize {
        self.unread.len()
    }

    /// Reads a number written by [`put_leb128`](lodc_mesh::put_leb128), in the fewest bytes.
    pub fn varint(&mut self) -> Option<u32> {
        take_leb128(&mut self.unread, u32::MAX.into()).map(|number| number as u32)
    }

    /// Reads a number of `width` bytes, 1 to 4.
    pub fn narrow(&mut self, width: usize) -> Option<u32> {
        let (bytes, unread) = self.unread.split_at_checked(width)?;
        self.unread = unread;
        let mut word = [0; 4];
        word[..width].copy_from_slice(bytes);
        Some(u32::from_le_bytes(word))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_hold_every_number_below_a_count() {
        for count in [0, 1, 256, 257, 65_536, 65_537, 1 << 24, (1 << 24) + 1, u32::MAX as usize] {
            let (mut bytes, largest) = (Vec::new(), count.saturating_sub(1) as u32);
            put_narrow(&mut bytes, largest, width(count));
            let mut reader = Reader::new(&bytes);
            assert_eq!((reader.narrow(width(count)), reader.remaining()), (Some(largest), 0));
            assert_eq!(reader.narrow(1), None);
        }
    }
}
