//! Bytes of a manifest: bincode's legacy encoding (fixed-width little-endian integers).

use super::manifest::Manifest;
use super::old::OldManifest;
use super::record::LIMIT;
use crate::{Fault, FormatError};
use serde::de::DeserializeOwned;

const PLACE: &str = "section MANI";

/// Encodes a manifest of the present version.
pub(super) fn encode(manifest: &Manifest) -> Vec<u8> {
    bincode::serde::encode_to_vec(manifest, bincode::config::legacy())
        .expect("plain data can be written to memory")
}

/// Decodes the manifest of a file of some version.
pub(super) fn decode(bytes: &[u8], version: u32) -> Result<Manifest, FormatError> {
    if bytes.len() > LIMIT {
        return Err(FormatError::new(Fault::Limit, PLACE, format!("has more than {LIMIT} bytes")));
    }
    if version >= 3 {
        // What follows the known fields belongs to later versions.
        return decode_front(bytes).map(|(manifest, _)| manifest);
    }
    let (old, used): (OldManifest, _) = decode_front(bytes)?;
    if used != bytes.len() {
        let what = format!("{} bytes are left over", bytes.len() - used);
        return Err(FormatError::new(Fault::Malformed, PLACE, what));
    }
    Ok(old.into())
}

/// Decodes what the bytes begin with, and says how many bytes that took.
fn decode_front<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, usize), FormatError> {
    let config = bincode::config::legacy().with_limit::<LIMIT>();
    bincode::serde::decode_from_slice(bytes, config)
        .map_err(|e| FormatError::new(Fault::Malformed, PLACE, format!("cannot be decoded: {e}")))
}
