//! What a file was made from, so that a later run can tell whether it is up to date.

use super::record::LIMIT;
use crate::{Fault, FormatError};
use serde::{Deserialize, Serialize};

/// Origin of a file's content: the optional section `MADE`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MadeFrom {
    /// A hash of everything that the content depends on: the input, the files that it names, the
    /// options, the versions of program and format.
    pub key: u128,
    /// The files that the input names, relative to its folder, in the order in which the key
    /// covers them.
    pub files: Vec<String>,
}

impl MadeFrom {
    pub(super) fn bytes(&self) -> Vec<u8> {
        bincode::serde::encode_to_vec(self, bincode::config::legacy())
            .expect("plain data can be written to memory")
    }

    /// Reads the section; what follows the known fields belongs to later versions.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, FormatError> {
        let config = bincode::config::legacy().with_limit::<LIMIT>();
        bincode::serde::decode_from_slice(bytes, config).map(|(made, _)| made).map_err(|e| {
            FormatError::new(Fault::Malformed, "section MADE", format!("cannot be decoded: {e}"))
        })
    }
}
