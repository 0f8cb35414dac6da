//! Header, section table, checksums and padding: the container without the meaning of its sections.

use super::VERSION;
use super::left_out::LeftOut;
use crate::{Fault, FormatError};
use std::collections::BTreeMap;
use xxhash_rust::xxh3::xxh3_64;

/// First bytes of a file. Not text, not valid UTF-8, and damaged by a transfer that changes line
/// ends.
const MAGIC: [u8; 8] = *b"\x89LODC\r\n\x1a";
const HEADER: usize = 32;
/// Bytes of the header before its checksum.
const CHECKED: usize = 24;
const ENTRY: usize = 40;
const ALIGN: usize = 16;
/// Flag of a section without which the file cannot be understood.
const REQUIRED: u32 = 1;
/// Flags that a reader may pass over where it does not know them, from version 3 on.
const OPTIONAL: u32 = 0xffff_0000;

/// The object number of sections that belong to no object.
pub(super) const SCENE: u32 = u32::MAX;

/// Tag of a section: four ASCII characters.
pub(super) type Tag = [u8; 4];

pub(super) mod tag {
    use super::Tag;
    pub(crate) const MANIFEST: Tag = *b"MANI";
    pub(crate) const DOCUMENT_JSON: Tag = *b"DJSN";
    pub(crate) const DOCUMENT_BLOB: Tag = *b"DBLB";
    pub(crate) const POSITIONS: Tag = *b"POSI";
    pub(crate) const VERTEX_SUBMESH: Tag = *b"VSUB";
    pub(crate) const ATTRIBUTE: Tag = *b"ATTR";
    pub(crate) const TRIANGLES: Tag = *b"TRIS";
    pub(crate) const TARGETS: Tag = *b"TARG";
    pub(crate) const JOINED: Tag = *b"JOIN";
    pub(crate) const STEP_ERRORS: Tag = *b"SERR";
    pub(crate) const STEP_RMS: Tag = *b"SRMS";
    pub(crate) const STEP_TRIANGLES: Tag = *b"STRI";
    pub(crate) const MODEL_ARRAY: Tag = *b"MODA";
    pub(super) const KNOWN: [Tag; 13] = [
        MANIFEST,
        DOCUMENT_JSON,
        DOCUMENT_BLOB,
        POSITIONS,
        VERTEX_SUBMESH,
        ATTRIBUTE,
        TRIANGLES,
        TARGETS,
        JOINED,
        STEP_ERRORS,
        STEP_RMS,
        STEP_TRIANGLES,
        MODEL_ARRAY,
    ];
}

/// Key of a section: its tag, its object, its number among those of one tag and object.
type Id = (Tag, u32, u32);

/// Name of a section in messages.
pub(super) fn place(tag: Tag, object: u32, index: u32) -> String {
    let tag = tag.escape_ascii();
    match object {
        SCENE => format!("section {tag}"),
        _ if index == 0 => format!("section {tag} of object {object}"),
        _ => format!("section {tag} {index} of object {object}"),
    }
}

/// A file whose header, table and checksums are right, and whose sections lie one after another
/// without gaps.
pub(super) struct Container<'a> {
    version: u32,
    /// Sections of known kinds that nobody has taken yet, and whether they are required.
    sections: BTreeMap<Id, (&'a [u8], bool)>,
    /// Sections of unknown kinds, none of them required.
    unknown: Vec<Id>,
}

impl<'a> Container<'a> {
    /// The version that the file says it is of.
    pub(super) fn version(&self) -> u32 {
        self.version
    }

    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let malformed = |what: String| FormatError::new(Fault::Malformed, "header", what);
        let u32_at = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| bytes[at + i]));
        let u64_at = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]));
        if bytes.len() < MAGIC.len() || bytes[..MAGIC.len()] != MAGIC {
            return Err(malformed("this is not a .lodc file".to_owned()));
        }
        if bytes.len() < HEADER {
            return Err(malformed(format!(
                "the file ends after {} bytes, within its header",
                bytes.len()
            )));
        }
        let (version, count, length, checksum) =
            (u32_at(8), u32_at(12) as usize, u64_at(16), u64_at(24));
        if version > VERSION {
            let what = format!(
                "version {version} is newer than this program, which reads up to version {VERSION}"
            );
            return Err(FormatError::new(Fault::Unsupported, "header", what));
        }
        if version == 0 {
            return Err(malformed("there is no version 0".to_owned()));
        }
        if (bytes.len() as u64) < length {
            return Err(malformed(format!(
                "the file is cut off: {} of {length} bytes are there",
                bytes.len()
            )));
        }
        if bytes.len() as u64 > length {
            let more = bytes.len() as u64 - length;
            return Err(malformed(format!("{more} bytes follow the end of the file at {length}")));
        }
        let fits = count
            .checked_mul(ENTRY)
            .and_then(|n| n.checked_add(HEADER))
            .filter(|&end| end <= bytes.len());
        let Some(table_end) = fits else {
            return Err(malformed(format!(
                "a table of {count} sections does not fit into {length} bytes"
            )));
        };
        if header_checksum(bytes, table_end) != checksum {
            return Err(malformed(
                "the header or the section table is damaged (checksum)".to_owned(),
            ));
        }

        let (mut sections, mut unknown) = (BTreeMap::new(), Vec::new());
        let mut end = table_end;
        for entry in (HEADER..table_end).step_by(ENTRY) {
            let id: Id =
                (std::array::from_fn(|i| bytes[entry + i]), u32_at(entry + 8), u32_at(entry + 12));
            let flags = u32_at(entry + 4);
            let (offset, length, checksum) =
                (u64_at(entry + 16), u64_at(entry + 24), u64_at(entry + 32));
            let place = || place(id.0, id.1, id.2);
            let malformed = |what: String| FormatError::new(Fault::Malformed, place(), what);
            let start = end.next_multiple_of(ALIGN) as u64;
            if offset != start {
                let how = if offset < start {
                    "overlaps what is before it"
                } else {
                    "leaves a gap before it"
                };
                return Err(malformed(format!("starts at {offset}, not at {start}: it {how}")));
            }
            let stop = offset.checked_add(length).filter(|&stop| stop <= bytes.len() as u64);
            let Some(stop) = stop else {
                return Err(malformed(format!(
                    "{length} bytes at {offset} do not fit into the file"
                )));
            };
            let content = &bytes[offset as usize..stop as usize];
            if bytes[end..offset as usize].iter().any(|&b| b != 0) {
                return Err(malformed("the padding before it is not zero".to_owned()));
            }
            if xxh3_64(content) != checksum {
                return Err(malformed("is damaged (checksum)".to_owned()));
            }
            end = stop as usize;
            let known = if version < 3 { REQUIRED } else { REQUIRED | OPTIONAL };
            if flags & !known != 0 {
                return Err(FormatError::new(
                    Fault::Unsupported,
                    place(),
                    format!("has unknown flags {flags:#x}"),
                ));
            }
            if !tag::KNOWN.contains(&id.0) {
                if flags & REQUIRED != 0 {
                    let what =
                        "is required, and this program does not know it: a newer one is needed";
                    return Err(FormatError::new(Fault::Unsupported, place(), what));
                }
                unknown.push(id);
            } else if sections.insert(id, (content, flags & REQUIRED != 0)).is_some() {
                return Err(malformed("is there twice".to_owned()));
            }
        }
        if end != bytes.len() {
            return Err(malformed(format!("{} bytes follow the last section", bytes.len() - end)));
        }
        Ok(Self { version, sections, unknown })
    }

    /// A section that has to be there.
    pub(super) fn take(
        &mut self,
        tag: Tag,
        object: u32,
        index: u32,
    ) -> Result<&'a [u8], FormatError> {
        let missing =
            || FormatError::new(Fault::Malformed, place(tag, object, index), "is missing");
        self.sections.remove(&(tag, object, index)).map(|(content, _)| content).ok_or_else(missing)
    }

    /// A section that may be missing.
    pub(super) fn take_optional(&mut self, tag: Tag, object: u32, index: u32) -> Option<&'a [u8]> {
        self.sections.remove(&(tag, object, index)).map(|(content, _)| content)
    }

    /// Leaves a section out: what it belongs to is not known.
    pub(super) fn skip(&mut self, tag: Tag, object: u32, index: u32) {
        self.sections.remove(&(tag, object, index));
    }

    /// Every required section must have been taken. Names the others that were not.
    pub(super) fn finish(self, left_out: &mut LeftOut) -> Result<(), FormatError> {
        let nothing = "belongs to nothing that the manifest names";
        if let Some(((tag, object, index), _)) =
            self.sections.iter().find(|(_, (_, required))| *required)
        {
            return Err(FormatError::new(Fault::Malformed, place(*tag, *object, *index), nothing));
        }
        let unknown = self.unknown.into_iter().map(|id| (id, "is not known to this version"));
        let idle = self.sections.into_keys().map(|id| (id, nothing));
        for ((tag, object, index), what) in unknown.chain(idle) {
            left_out.tell(|| format!("{} {what} and was left out", place(tag, object, index)));
        }
        Ok(())
    }
}

/// Covers the header up to the checksum and the table.
fn header_checksum(bytes: &[u8], table_end: usize) -> u64 {
    let mut state = xxhash_rust::xxh3::Xxh3::new();
    state.update(&bytes[..CHECKED]);
    state.update(&bytes[HEADER..table_end]);
    state.digest()
}

pub(super) type Content<'a> = Box<dyn FnOnce(&mut Vec<u8>) + 'a>;

/// Collects sections and lays them out.
#[derive(Default)]
pub(super) struct Writer<'a> {
    sections: Vec<(Id, u32, Content<'a>)>,
}

impl<'a> Writer<'a> {
    /// A section without which the file cannot be understood. `content` appends its bytes.
    pub(super) fn required(
        &mut self,
        tag: Tag,
        object: u32,
        index: u32,
        content: impl FnOnce(&mut Vec<u8>) + 'a,
    ) {
        self.sections.push(((tag, object, index), REQUIRED, Box::new(content)));
    }

    /// A section that a reader may skip.
    pub(super) fn optional(
        &mut self,
        tag: Tag,
        object: u32,
        index: u32,
        content: impl FnOnce(&mut Vec<u8>) + 'a,
    ) {
        self.sections.push(((tag, object, index), 0, Box::new(content)));
    }

    pub(super) fn finish(self) -> Vec<u8> {
        let table_end = HEADER + ENTRY * self.sections.len();
        let mut out = vec![0; table_end];
        out[..8].copy_from_slice(&MAGIC);
        out[8..12].copy_from_slice(&VERSION.to_le_bytes());
        out[12..16].copy_from_slice(&(self.sections.len() as u32).to_le_bytes());
        for (i, ((tag, object, index), flags, content)) in self.sections.into_iter().enumerate() {
            let start = out.len().next_multiple_of(ALIGN);
            out.resize(start, 0);
            content(&mut out);
            let (length, checksum) = ((out.len() - start) as u64, xxh3_64(&out[start..]));
            let entry = &mut out[HEADER + i * ENTRY..][..ENTRY];
            entry[..4].copy_from_slice(&tag);
            entry[4..8].copy_from_slice(&flags.to_le_bytes());
            entry[8..12].copy_from_slice(&object.to_le_bytes());
            entry[12..16].copy_from_slice(&index.to_le_bytes());
            entry[16..24].copy_from_slice(&(start as u64).to_le_bytes());
            entry[24..32].copy_from_slice(&length.to_le_bytes());
            entry[32..].copy_from_slice(&checksum.to_le_bytes());
        }
        let length = (out.len() as u64).to_le_bytes();
        out[16..24].copy_from_slice(&length);
        let checksum = header_checksum(&out, table_end).to_le_bytes();
        out[CHECKED..HEADER].copy_from_slice(&checksum);
        out
    }
}

/// Makes checksums right again after bytes were changed, as far as the table can be followed: for
/// tests that have to get past them.
#[cfg(test)]
pub(super) fn repair_checksums(bytes: &mut [u8]) {
    if bytes.len() < HEADER {
        return;
    }
    let count = u32::from_le_bytes(std::array::from_fn(|i| bytes[12 + i])) as usize;
    let table_end = (HEADER + count.saturating_mul(ENTRY)).min(bytes.len());
    for entry in (HEADER..table_end).step_by(ENTRY).filter(|entry| entry + ENTRY <= table_end) {
        let u64_at =
            |at: usize| u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i])) as usize;
        let (start, length) = (u64_at(entry + 16), u64_at(entry + 24));
        if let Some(content) = start.checked_add(length).and_then(|stop| bytes.get(start..stop)) {
            let checksum = xxh3_64(content).to_le_bytes();
            bytes[entry + 32..entry + 40].copy_from_slice(&checksum);
        }
    }
    let checksum = header_checksum(bytes, table_end).to_le_bytes();
    bytes[CHECKED..HEADER].copy_from_slice(&checksum);
}
