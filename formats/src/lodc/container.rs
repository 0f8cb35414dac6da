//! The section table of a `.lodc` file: sections are found by kind, object and index and checked by
//! their checksums; what they contain is read elsewhere.

use super::skipped::SkippedParts;
use super::table::{
    ENTRY_BYTES, Entry, HEADER_BYTES, Id, REQUIRED, Tag, WIDE, location, put_header, section_start,
    table, tag,
};
use crate::{Fault, FormatError};
use lodc_model::{Array, Layout};
use xxhash_rust::xxh3::xxh3_64;

/// A file whose header, table and checksums are right, and whose sections follow each other without
/// gaps.
pub(super) struct Container<'a> {
    /// Sections of known kinds, in the order of their ids; `None` for those that were taken.
    sections: Vec<(Id, Option<Section<'a>>)>,
    /// Sections of unknown kinds, none of them required.
    unknown: Vec<Id>,
}

/// A section of a container.
pub(super) struct Section<'a> {
    pub(super) bytes: &'a [u8],
    required: bool,
    pub(super) wide: bool,
}

impl<'a> Container<'a> {
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let table = table(bytes)?;
        let (mut sections, mut unknown) = (Vec::new(), Vec::new());
        let mut end = HEADER_BYTES + table.len();
        for entry in table.chunks_exact(ENTRY_BYTES).map(Entry::read) {
            entry.check_flags()?;
            let content = entry.content(bytes, end)?;
            end = section_start(end, entry.is_wide()) + content.len();
            let (required, wide) = (entry.is_required(), entry.is_wide());
            if tag::KNOWN.contains(&entry.id.0) {
                let section = Section { bytes: content, required, wide };
                sections.push((entry.id, Some(section)));
            } else if required {
                let problem =
                    "is required, and this program does not know it: a newer one is needed";
                return Err(entry.error(Fault::Unsupported, problem));
            } else {
                unknown.push(entry.id);
            }
        }
        if end != bytes.len() {
            let problem = format!("{} bytes follow the last section", bytes.len() - end);
            return Err(FormatError::new(Fault::Malformed, "header", problem));
        }
        sections.sort_unstable_by_key(|&(id, _)| id);
        if let Some(duplicate) = sections.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let (tag, object, index) = duplicate[0].0;
            let location = location(tag, object, index);
            return Err(FormatError::new(Fault::Malformed, location, "occurs twice"));
        }
        Ok(Self { sections, unknown })
    }

    /// Returns the layout that the file was written in.
    pub(super) fn layout(&self) -> Layout {
        if self.remaining().any(|(_, section)| section.wide) { Layout::Gpu } else { Layout::Packed }
    }

    /// The sections of known kinds, in the order of their ids.
    pub(super) fn into_sections(self) -> impl Iterator<Item = (Id, Section<'a>)> {
        self.sections.into_iter().filter_map(|(id, section)| Some((id, section?)))
    }

    /// The sections that were not taken.
    fn remaining(&self) -> impl Iterator<Item = (Id, &Section<'a>)> {
        self.sections.iter().filter_map(|(id, section)| Some((*id, section.as_ref()?)))
    }

    fn remove(&mut self, id: Id) -> Option<Section<'a>> {
        let index = self.sections.binary_search_by_key(&id, |&(id, _)| id).ok()?;
        self.sections[index].1.take()
    }

    /// The bytes of a section that has to be there.
    pub(super) fn take(
        &mut self,
        tag: Tag,
        object: u32,
        index: u32,
    ) -> Result<&'a [u8], FormatError> {
        self.take_section(tag, object, index).map(|section| section.bytes)
    }

    /// A section that has to be there.
    pub(super) fn take_section(
        &mut self,
        tag: Tag,
        object: u32,
        index: u32,
    ) -> Result<Section<'a>, FormatError> {
        let missing =
            || FormatError::new(Fault::Malformed, location(tag, object, index), "is missing");
        self.remove((tag, object, index)).ok_or_else(missing)
    }

    /// A section that may be missing.
    pub(super) fn take_optional(&mut self, tag: Tag, object: u32, index: u32) -> Option<&'a [u8]> {
        self.remove((tag, object, index)).map(|section| section.bytes)
    }

    /// Drops a section of a part that this version does not know.
    pub(super) fn skip(&mut self, tag: Tag, object: u32, index: u32) {
        self.remove((tag, object, index));
    }

    /// Refuses required sections that were not taken, and notes the others.
    pub(super) fn finish(self, skipped: &mut SkippedParts) -> Result<(), FormatError> {
        let nothing = "belongs to nothing that the manifest names";
        if let Some(((tag, object, index), _)) =
            self.remaining().find(|(_, section)| section.required)
        {
            return Err(FormatError::new(Fault::Malformed, location(tag, object, index), nothing));
        }
        let unknown = self.unknown.iter().map(|&id| (id, "is not known to this version"));
        let unused = self.remaining().map(|(id, _)| (id, nothing));
        for ((tag, object, index), problem) in unknown.chain(unused) {
            skipped.add(|| format!("{} {problem} and was left out", location(tag, object, index)));
        }
        Ok(())
    }
}

/// The flag that says whether a section is wide.
fn wide_flag(is_wide: bool) -> u32 {
    if is_wide { WIDE } else { 0 }
}

pub(super) type Content<'a> = Box<dyn FnOnce(&mut Vec<u8>) + 'a>;

/// Collects sections and lays them out.
#[derive(Default)]
pub(super) struct Writer<'a> {
    /// Each with its id, its flags and what appends its bytes.
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

    /// A section that has to be there, as a device takes it in the gpu layout.
    pub(super) fn for_device(
        &mut self,
        tag: Tag,
        object: u32,
        index: u32,
        layout: Layout,
        content: impl FnOnce(&mut Vec<u8>) + 'a,
    ) {
        let flags = REQUIRED | wide_flag(layout == Layout::Gpu);
        self.sections.push(((tag, object, index), flags, Box::new(content)));
    }

    /// An array of a model.
    pub(super) fn array(&mut self, object: u32, index: u32, array: Array) {
        let content = Box::new(move |out: &mut Vec<u8>| out.extend_from_slice(&array.bytes));
        let flags = REQUIRED | wide_flag(array.wide);
        self.sections.push(((tag::MODEL_ARRAY, object, index), flags, content));
    }

    pub(super) fn finish(self) -> Vec<u8> {
        let count = self.sections.len();
        let mut out = vec![0; HEADER_BYTES + ENTRY_BYTES * count];
        for (i, ((tag, object, index), flags, content)) in self.sections.into_iter().enumerate() {
            let start = section_start(out.len(), flags & WIDE != 0);
            out.resize(start, 0);
            content(&mut out);
            let (length, checksum) = ((out.len() - start) as u64, xxh3_64(&out[start..]));
            let entry = &mut out[HEADER_BYTES + i * ENTRY_BYTES..][..ENTRY_BYTES];
            entry[..4].copy_from_slice(&tag);
            entry[4..8].copy_from_slice(&flags.to_le_bytes());
            entry[8..12].copy_from_slice(&object.to_le_bytes());
            entry[12..16].copy_from_slice(&index.to_le_bytes());
            entry[16..24].copy_from_slice(&(start as u64).to_le_bytes());
            entry[24..32].copy_from_slice(&length.to_le_bytes());
            entry[32..].copy_from_slice(&checksum.to_le_bytes());
        }
        put_header(&mut out, count as u32);
        out
    }
}
