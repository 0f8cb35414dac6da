//! Encodes and decodes a stream's document (everything but the meshes) in pieces that are sent
//! between blocks of steps: first the compressed text, then buffer 0 of a glTF in the order in
//! which a viewer needs its parts.

use super::head::Head;
use crate::fields::{decode_front, to_bytes};
use crate::gltf::{BufferRun, PartialBuffer, Purpose, buffer_runs};
use crate::lodc::manifest::{DocumentEntry, format_code, source_of};
use crate::{Document, Fault, FormatError, GltfDocument, ObjectInfo, Source, SubmeshInfo};
use bincode::{Decode, Encode};
use lodc_mesh::CollapseSequence;
use lodc_progressive::TextCodec;
use std::ops::Range;

const LOCATION: &str = "document";

/// Facts of an object's collapse sequence that its steps do not say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Encode, Decode)]
pub struct SequenceFacts {
    /// The last LOD reached without breaking a rule of legality.
    pub last_legal_lod: u32,
    /// Number of steps that changed the topology before the terminal phase.
    pub topology_changes: u32,
    /// The first LOD after such a step.
    pub first_topology_change: Option<u32>,
}
impl SequenceFacts {
    /// The facts of a sequence.
    #[must_use]
    pub fn of(collapses: &CollapseSequence) -> Self {
        let parts = collapses.parts();
        Self {
            last_legal_lod: parts.last_legal_lod.0,
            topology_changes: parts.topology_changes,
            first_topology_change: parts.first_topology_change.map(|lod| lod.0),
        }
    }
}

/// What the text of a document says: the document without its buffer, and the names of the scene's
/// objects.
#[derive(Clone, Debug)]
pub(super) struct ParsedText {
    pub(super) source: Source,
    pub(super) document: Document,
    pub(super) objects: Vec<(ObjectInfo, SequenceFacts)>,
}

/// A document as a stream has it.
#[derive(Debug)]
pub(super) struct EncodedDocument {
    /// Bytes of the text before it is compressed.
    pub(super) text_bytes: u32,
    /// Bytes of the text as it is stored: compressed where that is shorter.
    pub(super) stored: u32,
    /// The text as it is stored, then buffer 0 of a glTF in the order of the stream.
    pub(super) bytes: Vec<u8>,
    /// The first bytes, which the stream sends before any triangle.
    pub(super) leading: usize,
    /// End of the bytes that come at once behind the first triangles, if they have not come before:
    /// the text and, unless they are many, the matrices of skins.
    pub(super) prompt_end: usize,
    /// End of the bytes that say where everything is: the text and the matrices of skins.
    pub(super) placement_end: usize,
    /// End of the bytes that a picture of the scene at rest needs: animations follow.
    pub(super) picture_end: usize,
}

/// What a document sends before the first triangles, and these with it, take at most one part in so
/// many of a stream. Chosen by hand.
pub(super) const LEADING_SHARE: u64 = 20;
/// The largest number of bytes of that part, chosen by hand.
const MAX_LEADING: u64 = 16 << 10;
/// More than the bytes of the file header, the first block and the fields of a block.
const CONTAINER_BYTES: u64 = 64;

/// What precedes the JSON in a document's text. These records are the file format.
#[derive(Encode, Decode)]
struct TextEntry {
    format: u8,
    content_hash: u128,
    document: DocumentEntry,
    objects: Vec<ObjectEntry>,
    /// Start and length of the runs of the buffer that come first, in their order.
    runs: Vec<(u64, u64)>,
}
#[derive(Encode, Decode)]
struct ObjectEntry {
    name: String,
    world_scale: f64,
    document_mesh: u32,
    facts: SequenceFacts,
    submeshes: Vec<SubmeshEntry>,
}
#[derive(Encode, Decode)]
struct SubmeshEntry {
    name: String,
    material: Option<String>,
    document_primitive: u32,
}
impl EncodedDocument {
    /// Encodes a document for a stream whose steps have `step_bytes`, those up to the first
    /// triangle `first_bytes`; `None` if its text would be too long.
    pub(super) fn new<'a>(
        source: &Source,
        document: &Document,
        objects: impl Iterator<Item = (&'a ObjectInfo, SequenceFacts)> + Clone,
        step_bytes: u64,
        first_bytes: u64,
    ) -> Option<Self> {
        let mut entry = TextEntry {
            format: format_code(source.format),
            content_hash: source.content_hash,
            document: DocumentEntry::of(document),
            objects: objects.clone().map(|(info, facts)| object_entry(info, facts)).collect(),
            runs: Vec::new(),
        };
        let (json, buffer, mut runs) = match document {
            Document::Gltf(gltf) => {
                let runs = buffer_runs(gltf, objects.map(|(info, _)| info));
                (gltf.json().as_bytes(), gltf.blob(), runs)
            }
            Document::Obj(_) => (&[][..], &[][..], Vec::new()),
        };
        entry.runs = merged_runs(&runs);
        let length = |run: &BufferRun| run.bytes.end - run.bytes.start;
        let (_, text) = stored_text(&entry, json)?;
        let placement = runs.iter().filter(|r| r.purpose == Purpose::Placement);
        let placement: u64 = placement.map(length).sum();
        let total = step_bytes + text.len() as u64 + buffer.len() as u64;
        let max_leading = (total / LEADING_SHARE).saturating_sub(first_bytes + CONTAINER_BYTES);
        let max_leading = max_leading.min(MAX_LEADING);
        let mut leading = text.len() as u64 + placement;
        let text_leads = leading <= max_leading;
        // Small images lead, too, as far as they fit.
        let mut is_leading = |run: &BufferRun| match run.purpose {
            Purpose::Placement => true,
            Purpose::Animation => false,
            Purpose::BaseColor | Purpose::Texture => {
                let fits = text_leads && leading + length(run) + MAX_TEXT_GROWTH <= max_leading;
                leading += if fits { length(run) } else { 0 };
                fits
            }
        };
        let (first, later): (Vec<_>, Vec<_>) = runs.drain(..).partition(|run| is_leading(run));
        let leading_runs: u64 = first.iter().map(length).sum();
        let animation_bytes = later.iter().filter(|r| r.purpose == Purpose::Animation);
        let animation_bytes: u64 = animation_bytes.map(length).sum();
        runs.extend(first.into_iter().chain(later));
        entry.runs = merged_runs(&runs);
        let (text_bytes, mut bytes) = stored_text(&entry, json)?;
        let stored = bytes.len();
        for run in buffer_order(&entry.runs, buffer.len() as u64)? {
            bytes.extend_from_slice(&buffer[run.start as usize..run.end as usize]);
        }
        let unlisted = buffer.len() as u64 - runs.iter().map(length).sum::<u64>();
        let unlisted_bytes = if runs.is_empty() { 0 } else { unlisted };
        Some(Self {
            text_bytes,
            stored: u32::try_from(stored).ok()?,
            leading: if text_leads { stored + leading_runs as usize } else { 0 },
            prompt_end: stored + if placement <= MAX_LEADING { placement as usize } else { 0 },
            placement_end: stored + placement as usize,
            picture_end: bytes.len() - (animation_bytes + unlisted_bytes) as usize,
            bytes,
        })
    }
}

/// Bytes that a stored text may grow by when the runs that it lists change their order. Chosen by
/// hand.
const MAX_TEXT_GROWTH: u64 = 32;

/// Returns the length of a text, and the text as it is stored.
fn stored_text(entry: &TextEntry, json: &[u8]) -> Option<(u32, Vec<u8>)> {
    let mut text = to_bytes(entry);
    text.extend_from_slice(json);
    let length = u32::try_from(text.len()).ok()?;
    let coded = Some(TextCodec::default().encode(&text)).filter(|coded| coded.len() < text.len());
    Some((length, coded.unwrap_or(text)))
}

/// Returns start and length of runs, neighbours as one; none if that is the order of the buffer.
fn merged_runs(runs: &[BufferRun]) -> Vec<(u64, u64)> {
    let mut merged: Vec<(u64, u64)> = Vec::new();
    for Range { start, end } in runs.iter().map(|run| run.bytes.clone()) {
        match merged.last_mut() {
            Some((first, length)) if *first + *length == start => *length = end - *first,
            _ => merged.push((start, end - start)),
        }
    }
    if matches!(merged[..], [(0, _)]) { Vec::new() } else { merged }
}

/// Returns the order in which the bytes of a buffer come: the runs that are named, then those
/// between them. `None` if these share bytes, or are not in the buffer.
fn buffer_order(listed: &[(u64, u64)], length: u64) -> Option<Vec<Range<u64>>> {
    let range = |&(start, length): &(u64, u64)| Some(start..start.checked_add(length)?);
    let mut order: Vec<Range<u64>> = listed.iter().map(range).collect::<Option<_>>()?;
    let mut sorted = order.clone();
    sorted.sort_unstable_by_key(|run| (run.start, run.end));
    let mut end = 0;
    for run in sorted {
        if run.start < end || run.end > length {
            return None;
        }
        order.extend((run.start > end).then_some(end..run.start));
        end = run.end;
    }
    order.extend((length > end).then_some(end..length));
    Some(order)
}

fn object_entry(info: &ObjectInfo, facts: SequenceFacts) -> ObjectEntry {
    let submesh = |s: &SubmeshInfo| SubmeshEntry {
        name: s.name.clone(),
        material: s.material.clone(),
        document_primitive: s.document_primitive,
    };
    ObjectEntry {
        name: info.name.clone(),
        world_scale: info.world_scale,
        document_mesh: info.document_mesh,
        facts,
        submeshes: info.submeshes.iter().map(submesh).collect(),
    }
}

/// Collects the pieces of a document.
#[derive(Debug, Default)]
pub(super) struct ReceivedDocument {
    /// The bytes of the text that have arrived, as it is stored.
    stored_text: Vec<u8>,
    /// The text, once all of it has come; its document has its buffer once that has come as well.
    pub(super) parsed: Option<ParsedText>,
    /// The order in which the runs of the buffer come.
    order: Vec<Range<u64>>,
    /// The bytes of the buffer that have arrived, in that order.
    buffer: Vec<u8>,
    /// Bytes so far, text and buffer.
    pub(super) bytes: u64,
}

impl ReceivedDocument {
    /// Returns whether everything that the head announces has come.
    pub(super) fn is_complete(&self, head: Head) -> bool {
        self.parsed.is_some() && self.bytes == u64::from(head.stored) + head.buffer
    }

    /// Bytes of the buffer that have come, without the first `from` of them: where each piece
    /// belongs, and the piece.
    pub(super) fn buffer_pieces(&self, from: usize) -> impl Iterator<Item = (u64, &[u8])> {
        let complete = match self.parsed.as_ref().map(|parsed| &parsed.document) {
            Some(Document::Gltf(gltf)) => gltf.blob(),
            _ => &[],
        };
        let mut before = 0;
        self.order.iter().filter_map(move |run| {
            let first = before;
            before += (run.end - run.start) as usize;
            let skipped = from.saturating_sub(first);
            let start = run.start + skipped as u64;
            let piece = match complete {
                [] => self.buffer.get(first + skipped..self.buffer.len().min(before)),
                complete => complete.get(start as usize..run.end as usize),
            };
            piece.filter(|piece| !piece.is_empty()).map(|piece| (start, piece))
        })
    }

    /// The bytes of the buffer that have come.
    pub(super) fn partial_buffer(&self) -> PartialBuffer {
        PartialBuffer::new(self.order.iter().cloned(), &self.buffer)
    }

    /// Takes the next piece. Returns whether the text became complete with it.
    pub(super) fn feed(&mut self, head: Head, piece: &[u8]) -> Result<bool, FormatError> {
        let total = u64::from(head.stored) + head.buffer;
        if total - self.bytes < piece.len() as u64 {
            return Err(malformed("is longer than the head says"));
        }
        self.bytes += piece.len() as u64;
        let text_missing = head.stored as usize - self.stored_text.len();
        let (text, buffer) = piece.split_at(text_missing.min(piece.len()));
        self.stored_text.extend_from_slice(text);
        let now_complete = self.parsed.is_none() && self.stored_text.len() == head.stored as usize;
        if now_complete {
            let (parsed, order) = ParsedText::parse(&self.stored_text, head)?;
            (self.parsed, self.order) = (Some(parsed), order);
        }
        self.buffer.extend_from_slice(buffer);
        let is_complete = self.is_complete(head);
        match self.parsed.as_mut().map(|parsed| &mut parsed.document) {
            Some(Document::Gltf(gltf)) if is_complete => {
                let blob = in_buffer_order(&self.order, std::mem::take(&mut self.buffer));
                *gltf = GltfDocument::new(gltf.json().to_owned(), blob);
            }
            Some(Document::Obj(_)) if !self.buffer.is_empty() => {
                return Err(malformed("has a buffer, but is not glTF"));
            }
            _ => {}
        }
        Ok(now_complete)
    }
}

/// Turns a buffer that was received run by run, in this order, back into the order of the glTF.
fn in_buffer_order(order: &[Range<u64>], received: Vec<u8>) -> Vec<u8> {
    if order.len() <= 1 {
        return received;
    }
    let (mut buffer, mut read) = (vec![0; received.len()], 0);
    for run in order {
        let (start, end) = (run.start as usize, run.end as usize);
        buffer[start..end].copy_from_slice(&received[read..][..end - start]);
        read += end - start;
    }
    buffer
}

impl ParsedText {
    /// Parses a text. Returns with it the order in which the buffer comes.
    fn parse(stored: &[u8], head: Head) -> Result<(Self, Vec<Range<u64>>), FormatError> {
        let decoded;
        let text = if stored.len() == head.text as usize {
            stored
        } else {
            decoded = TextCodec::default()
                .decode(stored, head.text as usize)
                .ok_or_else(|| malformed("cannot be decoded"))?;
            &decoded
        };
        let (entry, used) = decode_front::<TextEntry>(text)
            .ok_or_else(|| malformed("is truncated or has invalid values"))?;
        let json = &text[used..];
        let source =
            source_of(entry.format, entry.content_hash).map_err(|problem| malformed(&problem))?;
        if source.format != head.format || entry.objects.len() != head.objects as usize {
            return Err(malformed("has another format or number of objects than the head"));
        }
        let order = buffer_order(&entry.runs, head.buffer)
            .ok_or_else(|| malformed("has invalid runs of the buffer"))?;
        let document = document(entry.document, json)?;
        let objects = entry.objects.into_iter().map(object_info).collect::<Result<_, _>>()?;
        Ok((Self { source, document, objects }, order))
    }
}

fn document(entry: DocumentEntry, json: &[u8]) -> Result<Document, FormatError> {
    match entry.obj().map_err(malformed)? {
        Some(obj) if json.is_empty() => Ok(Document::Obj(obj)),
        Some(_) => Err(malformed("has JSON for an OBJ")),
        None => {
            let json = String::from_utf8(json.to_vec())
                .map_err(|_| malformed("has JSON that is not UTF-8"))?;
            Ok(Document::Gltf(GltfDocument::new(json, Vec::new())))
        }
    }
}

fn object_info(entry: ObjectEntry) -> Result<(ObjectInfo, SequenceFacts), FormatError> {
    if !(entry.world_scale.is_finite() && entry.world_scale > 0.0) {
        return Err(malformed("has an object whose scale is not a number above 0"));
    }
    let submesh = |s: SubmeshEntry| SubmeshInfo {
        name: s.name,
        material: s.material,
        document_primitive: s.document_primitive,
    };
    let info = ObjectInfo {
        name: entry.name,
        submeshes: entry.submeshes.into_iter().map(submesh).collect(),
        world_scale: entry.world_scale,
        document_mesh: entry.document_mesh,
        poses: vec![],
    };
    Ok((info, entry.facts))
}

fn malformed(problem: &str) -> FormatError {
    FormatError::new(Fault::Malformed, LOCATION, problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_buffer_comes_in_runs_and_goes_to_its_place() {
        let order = buffer_order(&[(4, 3), (0, 2)], 9).expect("runs that can be");
        assert_eq!(order, [4..7, 0..2, 2..4, 7..9]);
        assert_eq!(
            in_buffer_order(&order, vec![4, 5, 6, 0, 1, 2, 3, 7, 8]),
            (0..9).collect::<Vec<u8>>()
        );
        assert_eq!(buffer_order(&[], 0), Some(vec![]));
        for wrong in [&[(0, 3), (2, 1)][..], &[(8, 2)], &[(u64::MAX, 2)], &[(3, 0), (2, 2)]] {
            assert_eq!(buffer_order(wrong, 9), None, "{wrong:?}");
        }
    }
}
