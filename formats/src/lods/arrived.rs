//! The scene of a stream's prefix, ready to be exported: the document as far as it has arrived,
//! without references to missing bytes, and the objects so far.

use super::received::{Received, ReceivedObject};
use crate::gltf::{bare_gltf, gltf_without_missing};
use crate::{Document, FormatError, ObjDocument, ObjectInfo, SourceFormat};
use std::borrow::Cow;

/// Largest number of morph targets, of all submeshes of an object together, that a prefix is
/// written with before the document has said how many there are: a crafted header may name any
/// number. Chosen by hand.
const MAX_TARGETS: usize = 1 << 20;

/// The document and the names of a prefix.
#[derive(Clone, Debug)]
pub struct Arrived<'a> {
    /// The document; of a glTF without what refers to bytes that are still to come.
    pub document: Cow<'a, Document>,
    /// The objects so far.
    pub infos: Vec<ObjectInfo>,
    /// Parts that the stream has still to bring, with counts: `3 textures`.
    pub left_out: Vec<String>,
}

impl<'a> Arrived<'a> {
    pub(super) fn new(received: &'a Received) -> Result<Self, FormatError> {
        let infos = received.objects.iter().map(|o| o.info.clone()).collect();
        if let Some(document) = received.complete_document() {
            return Ok(Self { document: Cow::Borrowed(document), infos, left_out: Vec::new() });
        }
        if let Some((json, buffer)) = received.partial_gltf()
            && let Some((document, left_out)) = gltf_without_missing(json, buffer)?
        {
            return Ok(Self { document: Cow::Owned(Document::Gltf(document)), infos, left_out });
        }
        let targets: Vec<usize> = received.objects.iter().map(morph_targets).collect();
        Ok(Self::bare(infos, &targets, received.head.format))
    }

    /// A document that shows each object once and has nothing else.
    fn bare(mut infos: Vec<ObjectInfo>, targets: &[usize], format: SourceFormat) -> Self {
        let (missing_parts, document) = if format.is_gltf() {
            let missing_parts = "names, nodes, materials, textures, skins and animations";
            (missing_parts, Document::Gltf(bare_gltf(&mut infos, targets)))
        } else {
            ("names and materials", Document::Obj(ObjDocument::default()))
        };
        Self { document: Cow::Owned(document), infos, left_out: vec![missing_parts.to_owned()] }
    }
}

/// Returns the number of morph targets of each submesh of an object: that of its vertices' streams,
/// or 0 if it is above the limit.
fn morph_targets(object: &ReceivedObject) -> usize {
    let header = object.decoder.header();
    let last = header.attributes.iter().filter_map(|a| a.morph_target).max();
    let number = last.map_or(0, |last| last as usize + 1);
    if number.saturating_mul(header.submeshes.len()) > MAX_TARGETS { 0 } else { number }
}
