//! Binary serialisation of the manifest's records (docs/FORMAT.md, section 4), field after field:
//! `bincode`'s legacy encoding, that is fixed-width little-endian integers, lengths before lists
//! and a number before each variant.
//!
//! The traits are `bincode`'s own: with those of `serde` a browser's decoder would be about twice
//! as large.

use bincode::de::{BorrowDecoder, Decoder};
use bincode::enc::Encoder;
use bincode::error::{DecodeError, EncodeError};
use bincode::{BorrowDecode, Decode, Encode, config};

/// Largest number of bytes of a manifest, and of its values in memory; a reader refuses more,
/// whatever the file says. Chosen by hand.
pub(crate) const MAX_BYTES: usize = 256 << 20;

/// Returns the bytes of a value.
pub(crate) fn to_bytes(value: &impl Encode) -> Vec<u8> {
    bincode::encode_to_vec(value, config::legacy()).expect("plain data can be written to memory")
}

/// Reads a value from the first bytes, whatever follows; none if bytes are missing or are no such
/// value.
pub(crate) fn decode<T: Decode<()>>(bytes: &[u8]) -> Option<T> {
    decode_front(bytes).map(|(value, _)| value)
}

/// As [`decode`]; returns with the value the number of bytes that were read.
pub(crate) fn decode_front<T: Decode<()>>(bytes: &[u8]) -> Option<(T, usize)> {
    bincode::decode_from_slice(bytes, config::legacy().with_limit::<MAX_BYTES>()).ok()
}

/// A value after the number of its bytes (u64). Bytes that follow its known fields belong to later
/// versions.
#[derive(Debug, PartialEq)]
pub(crate) struct Record<T>(pub(crate) T);

impl<T> std::ops::Deref for Record<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: Encode> Encode for Record<T> {
    fn encode<E: Encoder>(&self, encoder: &mut E) -> Result<(), EncodeError> {
        to_bytes(&self.0).encode(encoder)
    }
}

impl<C, T: Decode<()>> Decode<C> for Record<T> {
    fn decode<D: Decoder<Context = C>>(decoder: &mut D) -> Result<Self, DecodeError> {
        let bytes = Vec::<u8>::decode(decoder)?;
        decode(&bytes).map(Self).ok_or(DecodeError::Other("a record that is none"))
    }
}

// Derived `Decode` of a type with such a field needs this, too.
impl<'de, C, T: Decode<()>> BorrowDecode<'de, C> for Record<T> {
    fn borrow_decode<D: BorrowDecoder<'de, Context = C>>(
        decoder: &mut D,
    ) -> Result<Self, DecodeError> {
        Self::decode(decoder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(PartialEq, Debug, Encode, Decode)]
    struct Later {
        known: u32,
        name: String,
        added: Vec<u64>,
    }

    #[derive(PartialEq, Debug, Encode, Decode)]
    struct Known {
        known: u32,
        name: String,
    }

    #[test]
    fn fields_of_later_versions_are_passed_over() {
        let later = |known| Later { known, name: "n".to_owned(), added: vec![7; 3] };
        let bytes = to_bytes(&vec![Record(later(1)), Record(later(2))]);
        let (read, used) = decode_front::<Vec<Record<Known>>>(&bytes).expect("of a later version");
        assert_eq!((read.len(), used), (2, bytes.len()));
        assert_eq!(read[1].0, Known { known: 2, name: "n".to_owned() });
        // A number of records, then the length of the first, then its fields.
        assert_eq!(
            bytes[..24],
            [2, 0, 0, 0, 0, 0, 0, 0, 45, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]
        );
    }

    #[test]
    fn what_ends_too_early_or_cannot_be_is_refused() {
        let bytes = to_bytes(&Record(Known { known: 1, name: "name".to_owned() }));
        for cut in 0..8 {
            let mut shorter = bytes.clone();
            shorter[0] -= 1 + cut;
            assert_eq!(decode::<Record<Known>>(&shorter), None, "{cut}");
            assert_eq!(decode::<Record<Known>>(&bytes[..bytes.len() - 1 - cut as usize]), None);
        }
        assert_eq!(decode::<Option<u8>>(&[2, 0]), None);
        assert_eq!(decode::<Vec<u8>>(&[255; 20]), None);
        assert_eq!(decode::<String>(&[1, 0, 0, 0, 0, 0, 0, 0, 255]), None);
    }
}
