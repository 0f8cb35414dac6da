//! The binary container (glTF 2.0, 4): a header, a JSON chunk and at most one binary chunk.

use super::json::malformed;
use crate::words::counted;
use crate::{Fault, FormatError};
use std::ops::Range;

/// The bytes that every GLB begins with.
const MAGIC: &[u8; 4] = b"glTF";
/// Type of the chunk with the document: `JSON` in ASCII.
const JSON: u32 = 0x4e4f_534a;
/// Type of the chunk with the first buffer: `BIN` and a zero in ASCII.
const BIN: u32 = 0x004e_4942;

/// Ranges of the chunks in the file.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Chunks {
    /// The JSON document.
    pub(super) json: Range<usize>,
    /// The first buffer.
    pub(super) bin: Option<Range<usize>>,
    /// Findings that are unusual but harmless.
    pub(super) warnings: Vec<String>,
}

/// Returns whether a file says that it is a GLB.
pub(super) fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Finds the chunks of a GLB.
pub(super) fn split(bytes: &[u8]) -> Result<Chunks, FormatError> {
    let word = |offset: usize| {
        bytes.get(offset..offset + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(malformed("header", "the file ends inside the GLB header"));
    };
    if version != 2 {
        return Err(FormatError::new(
            Fault::Unsupported,
            "header",
            format!("GLB version {version}, only 2 is read"),
        ));
    }
    let length = length as usize;
    if length < 12 || length > bytes.len() {
        let problem = format!("the header says {length} bytes, the file has {}", bytes.len());
        return Err(malformed("header", problem));
    }
    let mut warnings = Vec::new();
    if length < bytes.len() {
        let (one, several) =
            ("byte after the end of the GLB was", "bytes after the end of the GLB were");
        warnings.push(format!("{} ignored", counted(bytes.len() - length, one, several)));
    }
    let (mut json, mut bin): (Option<Range<usize>>, Option<Range<usize>>) = (None, None);
    let (mut offset, mut number, mut ignored) = (12, 0usize, 0usize);
    while offset < length {
        let location = || format!("chunk {number}");
        let (Some(size), Some(kind), true) = (word(offset), word(offset + 4), offset + 8 <= length)
        else {
            return Err(malformed(location(), "the file ends inside the chunk's header"));
        };
        let start = offset + 8;
        let end = start.checked_add(size as usize).filter(|&end| end <= length);
        let end = end.ok_or_else(|| {
            malformed(
                location(),
                format!("says {size} bytes, but only {} are left", length - start),
            )
        })?;
        match kind {
            JSON if json.is_some() => return Err(malformed(location(), "a second JSON chunk")),
            JSON if number == 0 => json = Some(start..end),
            _ if number == 0 => return Err(malformed(location(), "the first chunk is not JSON")),
            BIN if bin.is_some() => return Err(malformed(location(), "a second binary chunk")),
            BIN => bin = Some(start..end),
            _ => ignored += 1,
        }
        offset = end;
        number += 1;
    }
    if ignored > 0 {
        let (one, several) =
            ("GLB chunk of an unknown type was", "GLB chunks of unknown types were");
        warnings.push(format!("{} ignored", counted(ignored, one, several)));
    }
    let json = json.ok_or_else(|| malformed("", "the GLB has no JSON chunk"))?;
    Ok(Chunks { json, bin, warnings })
}

/// A GLB of a document and its buffer, which may be empty.
pub(super) fn joined(mut text: Vec<u8>, blob: &[u8]) -> Result<Vec<u8>, FormatError> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let padded = blob.len().next_multiple_of(4);
    let chunk = if blob.is_empty() { 0 } else { 8 + padded };
    let length = 12 + 8 + text.len() + chunk;
    let word = |n: usize| {
        let problem = "larger than the 4 GiB of a GLB: write .gltf instead";
        u32::try_from(n).map_err(|_| FormatError::new(Fault::Limit, "", problem))
    };
    let mut bytes = Vec::with_capacity(length);
    bytes.extend(MAGIC);
    for n in [2, word(length)?, word(text.len())?, JSON] {
        bytes.extend(n.to_le_bytes());
    }
    bytes.extend(text);
    if !blob.is_empty() {
        bytes.extend(word(padded)?.to_le_bytes());
        bytes.extend(BIN.to_le_bytes());
        bytes.extend_from_slice(blob);
        bytes.resize(length, 0);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(chunks: &[(u32, &[u8])]) -> Vec<u8> {
        let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        for (kind, body) in chunks {
            out.extend((body.len() as u32).to_le_bytes());
            out.extend(kind.to_le_bytes());
            out.extend_from_slice(body);
        }
        let length = (out.len() as u32).to_le_bytes();
        out[8..12].copy_from_slice(&length);
        out
    }

    #[test]
    fn chunks_are_found_and_unknown_ones_counted() {
        let file = glb(&[(JSON, b"{}  "), (BIN, b"1234"), (7, b"abcd")]);
        let chunks = split(&file).expect("a sound GLB");
        assert_eq!(
            (&file[chunks.json], chunks.bin.map(|r| &file[r])),
            (&b"{}  "[..], Some(&b"1234"[..]))
        );
        assert_eq!(chunks.warnings.len(), 1);
    }

    #[test]
    fn every_truncation_is_refused() {
        let file = glb(&[(JSON, b"{}  "), (BIN, b"1234")]);
        for end in 0..file.len() {
            assert!(split(&file[..end]).is_err(), "{end}");
        }
    }

    #[test]
    fn a_header_that_claims_four_gibibytes_is_refused() {
        let mut file = glb(&[]);
        file[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(split(&file).map_err(|e| e.fault), Err(Fault::Malformed));
        let mut file = glb(&[(JSON, b"{}  ")]);
        file[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(split(&file).map_err(|e| e.location), Err("chunk 0".to_owned()));
    }

    #[test]
    fn chunks_twice_or_in_the_wrong_order_are_refused() {
        for chunks in [
            vec![(JSON, &b"{}"[..]), (JSON, b"{}")],
            vec![(BIN, b"1")],
            vec![(JSON, b"{}"), (BIN, b""), (BIN, b"")],
        ] {
            assert!(split(&glb(&chunks)).is_err());
        }
        assert!(split(&glb(&[])).is_err());
    }
}
