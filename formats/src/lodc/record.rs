//! Records of the manifest with their length in front: a reader passes over fields that it does not
//! know.

use serde::de::{SeqAccess, Visitor};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer, de::DeserializeOwned, ser::Error as _,
};
use std::fmt;
use std::marker::PhantomData;
use std::ops::Deref;

/// Bytes of a manifest; a reader refuses more, whatever the file says.
pub(super) const LIMIT: usize = 256 << 20;

/// A value with the number of its bytes (u64) in front. Bytes behind its known fields belong to
/// later versions.
pub(super) struct Record<T>(pub(super) T);

impl<T> Deref for Record<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: Serialize> Serialize for Record<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let bytes = bincode::serde::encode_to_vec(&self.0, bincode::config::legacy());
        serializer.serialize_bytes(&bytes.map_err(S::Error::custom)?)
    }
}

impl<'de, T: DeserializeOwned> Deserialize<'de> for Record<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_byte_buf(RecordVisitor(PhantomData))
    }
}

struct RecordVisitor<T>(PhantomData<T>);

impl<'de, T: DeserializeOwned> Visitor<'de> for RecordVisitor<T> {
    type Value = Record<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a record with its length in front")
    }

    fn visit_bytes<E: serde::de::Error>(self, bytes: &[u8]) -> Result<Self::Value, E> {
        let config = bincode::config::legacy().with_limit::<LIMIT>();
        let decoded = bincode::serde::decode_from_slice::<T, _>(bytes, config);
        decoded.map(|(value, _)| Record(value)).map_err(E::custom)
    }

    fn visit_byte_buf<E: serde::de::Error>(self, bytes: Vec<u8>) -> Result<Self::Value, E> {
        self.visit_bytes(&bytes)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut bytes = Vec::new();
        while let Some(byte) = seq.next_element()? {
            bytes.push(byte);
        }
        self.visit_bytes(&bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize, Deserialize, PartialEq, Debug)]
    struct Later {
        known: u32,
        name: String,
        added: Vec<u64>,
    }

    #[derive(Serialize, Deserialize, PartialEq, Debug)]
    struct Known {
        known: u32,
        name: String,
    }

    #[test]
    fn fields_of_later_versions_are_passed_over() {
        let config = bincode::config::legacy();
        let later = |known| Later { known, name: "n".to_owned(), added: vec![7; 3] };
        let written = vec![Record(later(1)), Record(later(2))];
        let bytes = bincode::serde::encode_to_vec(&written, config).expect("plain data");
        let (read, used): (Vec<Record<Known>>, _) =
            bincode::serde::decode_from_slice(&bytes, config).expect("records of a later version");
        assert_eq!((read.len(), used), (2, bytes.len()));
        assert_eq!(read[1].0, Known { known: 2, name: "n".to_owned() });
        // A number of records, then the length of the first, then its fields.
        assert_eq!(
            bytes[..24],
            [2, 0, 0, 0, 0, 0, 0, 0, 45, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]
        );
    }

    #[test]
    fn a_record_that_ends_too_early_is_refused() {
        let config = bincode::config::legacy();
        let known = Record(Known { known: 1, name: "name".to_owned() });
        let bytes = bincode::serde::encode_to_vec(&known, config).expect("plain data");
        for cut in 0..8 {
            let mut shorter = bytes.clone();
            shorter[0] -= 1 + cut;
            let read: Result<(Record<Known>, _), _> =
                bincode::serde::decode_from_slice(&shorter, config);
            assert!(read.is_err(), "{cut}");
        }
    }
}
