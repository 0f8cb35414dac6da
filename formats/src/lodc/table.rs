//! Header and section table of a container: their layout, and what must hold of them.

use super::VERSION;
use crate::file_header::FileHeader;
use crate::{Fault, FormatError};
use xxhash_rust::xxh3::xxh3_64;

/// Bytes of the header: after what [`FileHeader`] begins with, the number of sections at offset 12,
/// the length of the file at 16, the checksum of the table at 24.
pub(super) const HEADER_BYTES: usize = 40;
const FILE_HEADER: FileHeader<8> = FileHeader {
    name: ".lodc file",
    magic: *b"\x89LODC\r\n\x1a",
    version: VERSION,
    length: HEADER_BYTES,
    checksum: |header| xxh3_64(header).to_le_bytes(),
};
/// Bytes of an entry of the table.
pub(super) const ENTRY_BYTES: usize = 40;
/// Sections begin at multiples of this number of bytes. Chosen by hand.
const ALIGN: usize = 16;
/// Wide sections begin at multiples of this number of bytes, which every device of WebGPU takes as
/// an offset: so they can be bound in place.
const WIDE_ALIGN: usize = 256;
/// Flag of a section without which the file cannot be understood.
pub(super) const REQUIRED: u32 = 1;
/// Flag of a section laid out for graphics devices: indices are `u32`, vertices take a multiple of
/// four bytes. Only sections of [`tag::MAY_BE_WIDE`] have it.
pub(super) const WIDE: u32 = 2;
/// Flags that a reader may ignore if it does not know them: the upper half.
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
    pub(crate) const POSES: Tag = *b"POSE";
    pub(crate) const MADE_FROM: Tag = *b"MADE";
    pub(crate) const LEVELS: Tag = *b"LEVL";
    pub(crate) const LOCKED: Tag = *b"LOCK";
    pub(crate) const MAY_BE_WIDE: [Tag; 5] =
        [POSITIONS, TRIANGLES, TARGETS, ATTRIBUTE, MODEL_ARRAY];
    pub(crate) const KNOWN: [Tag; 17] = [
        MANIFEST,
        LEVELS,
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
        POSES,
        MADE_FROM,
        LOCKED,
    ];
}

/// Key of a section: its tag, its object, its number among those of one tag and object.
pub(super) type Id = (Tag, u32, u32);

/// Name of a section in messages.
pub(super) fn location(tag: Tag, object: u32, index: u32) -> String {
    let tag = tag.escape_ascii();
    match object {
        SCENE => format!("section {tag}"),
        _ if index == 0 => format!("section {tag} of object {object}"),
        _ => format!("section {tag} {index} of object {object}"),
    }
}

/// The section table of a file whose header is sound and states the file's length.
pub(super) fn table(bytes: &[u8]) -> Result<&[u8], FormatError> {
    if !FILE_HEADER.check(bytes)? {
        let problem = format!("the file ends after {} bytes, within its header", bytes.len());
        return Err(malformed(problem));
    }
    check_length(bytes.len() as u64, u64_at(bytes, 16))?;
    let count = u32_at(bytes, 12) as usize;
    let table =
        count.checked_mul(ENTRY_BYTES).and_then(|length| bytes[HEADER_BYTES..].get(..length));
    let table = table.ok_or_else(|| {
        let length = bytes.len();
        malformed(format!("a table of {count} sections does not fit into {length} bytes"))
    })?;
    if xxh3_64(table) != u64_at(bytes, 24) {
        return Err(malformed("the section table is damaged (checksum)"));
    }
    Ok(table)
}

/// Puts the header in front of a file, which has a place for it and its table.
pub(super) fn put_header(file: &mut [u8], sections: u32) {
    file[..HEADER_BYTES].copy_from_slice(&FILE_HEADER.start());
    file[12..16].copy_from_slice(&sections.to_le_bytes());
    let length = (file.len() as u64).to_le_bytes();
    file[16..24].copy_from_slice(&length);
    seal(file);
}

/// Makes the checksums of the table and the header right.
fn seal(file: &mut [u8]) {
    let table =
        (u32_at(file, 12) as usize).saturating_mul(ENTRY_BYTES).min(file.len() - HEADER_BYTES);
    let checksum = xxh3_64(&file[HEADER_BYTES..HEADER_BYTES + table]).to_le_bytes();
    file[24..32].copy_from_slice(&checksum);
    FILE_HEADER.seal(file);
}

/// Returns where a section begins behind what ends at `end`.
pub(super) fn section_start(end: usize, is_wide: bool) -> usize {
    end.next_multiple_of(if is_wide { WIDE_ALIGN } else { ALIGN })
}

fn malformed(problem: impl Into<String>) -> FormatError {
    FormatError::new(Fault::Malformed, "header", problem.into())
}

/// Compares the bytes that are there with the length that the header states.
fn check_length(actual: u64, stated: u64) -> Result<(), FormatError> {
    if actual < stated {
        return Err(malformed(format!(
            "the file is cut off: {actual} of {stated} bytes are there"
        )));
    }
    if actual > stated {
        let excess = actual - stated;
        return Err(malformed(format!("{excess} bytes follow the end of the file at {stated}")));
    }
    Ok(())
}

/// One section as the table states it.
pub(super) struct Entry {
    pub(super) id: Id,
    flags: u32,
    offset: u64,
    length: u64,
    checksum: u64,
}

impl Entry {
    pub(super) fn read(entry: &[u8]) -> Self {
        Self {
            id: (std::array::from_fn(|i| entry[i]), u32_at(entry, 8), u32_at(entry, 12)),
            flags: u32_at(entry, 4),
            offset: u64_at(entry, 16),
            length: u64_at(entry, 24),
            checksum: u64_at(entry, 32),
        }
    }

    /// Returns whether the file cannot be understood without the section.
    pub(super) fn is_required(&self) -> bool {
        self.flags & REQUIRED != 0
    }

    /// Returns whether the section is laid out for graphics devices ([`WIDE`]).
    pub(super) fn is_wide(&self) -> bool {
        self.flags & WIDE != 0
    }

    /// An error that names the section.
    pub(super) fn error(&self, fault: Fault, problem: impl Into<String>) -> FormatError {
        let (tag, object, index) = self.id;
        FormatError::new(fault, location(tag, object, index), problem.into())
    }

    /// The bytes of the section, which begins at the next aligned offset after `end`, the end of
    /// what comes before it.
    ///
    /// # Errors
    /// If it lies elsewhere, does not fit into the file, or its bytes or the padding are damaged.
    pub(super) fn content<'a>(&self, bytes: &'a [u8], end: usize) -> Result<&'a [u8], FormatError> {
        let wrong = |problem: String| self.error(Fault::Malformed, problem);
        let (offset, length) = (self.offset, self.length);
        let start = section_start(end, self.is_wide()) as u64;
        if offset != start {
            let how = if offset < start {
                "overlaps what is before it"
            } else {
                "leaves a gap before it"
            };
            return Err(wrong(format!("starts at {offset}, not at {start}: it {how}")));
        }
        let section_end =
            offset.checked_add(length).filter(|&section_end| section_end <= bytes.len() as u64);
        let section_end = section_end
            .ok_or_else(|| wrong(format!("{length} bytes at {offset} do not fit into the file")))?;
        let content = &bytes[offset as usize..section_end as usize];
        if bytes[end..offset as usize].iter().any(|&b| b != 0) {
            return Err(wrong("the padding before it is not zero".to_owned()));
        }
        if xxh3_64(content) != self.checksum {
            return Err(wrong("is damaged (checksum)".to_owned()));
        }
        Ok(content)
    }

    /// Refuses flags that this version does not know, but for those that it may pass over.
    pub(super) fn check_flags(&self) -> Result<(), FormatError> {
        let wide = if tag::MAY_BE_WIDE.contains(&self.id.0) { WIDE } else { 0 };
        if self.flags & !(REQUIRED | wide | OPTIONAL) != 0 {
            let problem = format!("has unknown flags {:#x}", self.flags);
            return Err(self.error(Fault::Unsupported, problem));
        }
        Ok(())
    }
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}

/// Returns the bytes with the checksums that they should have as a file, as far as their table can
/// be followed.
pub(super) fn with_valid_checksums(bytes: &[u8]) -> Vec<u8> {
    let mut file = bytes.to_vec();
    if file.len() < HEADER_BYTES {
        return file;
    }
    let count = u32_at(&file, 12) as usize;
    for at in
        (HEADER_BYTES..=file.len().saturating_sub(ENTRY_BYTES)).step_by(ENTRY_BYTES).take(count)
    {
        let (start, length) = (u64_at(&file, at + 16) as usize, u64_at(&file, at + 24) as usize);
        if let Some(content) =
            start.checked_add(length).and_then(|section_end| file.get(start..section_end))
        {
            let checksum = xxh3_64(content).to_le_bytes();
            file[at + 32..at + ENTRY_BYTES].copy_from_slice(&checksum);
        }
    }
    seal(&mut file);
    file
}
