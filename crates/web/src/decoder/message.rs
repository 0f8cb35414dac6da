//! Messages to the page: chunks of words and bytes.
//!
//! A chunk is its tag (u32), the length of its content in bytes (u32), and the content, padded to a
//! multiple of four bytes, so that arrays in it can be used where they are. Numbers are
//! little-endian, as they are in WebAssembly and in every browser's typed arrays. The page reads
//! them in `loader/message.js`.

use lodc_formats::{Document, ObjectInfo};
use lodc_mesh::{Attribute, Component, Semantic};

/// Tags of chunks.
#[derive(Clone, Copy, Debug)]
pub(super) enum Tag {
    /// The number of objects, the length of buffer 0 in bytes, and the text of a glTF document.
    Json = 1,
    /// The number of objects, and the materials of an OBJ's document: for each its name, number of
    /// lines, lines.
    Materials = 2,
    /// Bytes of buffer 0: their offset in it, in bytes; the bytes.
    Buffer = 3,
    /// An object: see [`Message::object`].
    Object = 4,
    /// Vertices: object, first vertex, number; then the positions, and each attribute of the
    /// object, padded.
    Vertices = 5,
    /// Levels: see `levels.rs`.
    Levels = 6,
    /// The end: everything has arrived. No content.
    Complete = 7,
}

/// A message that is being written.
#[derive(Debug, Default)]
pub(super) struct Message {
    pub(super) bytes: Vec<u8>,
}

impl Message {
    /// Appends a chunk, whose content `content` writes.
    pub(super) fn chunk(&mut self, tag: Tag, content: impl FnOnce(&mut Self)) {
        self.word(tag as u32);
        let length_at = self.bytes.len();
        self.word(0);
        content(self);
        let length = (self.bytes.len() - length_at - 4) as u32;
        self.bytes[length_at..length_at + 4].copy_from_slice(&length.to_le_bytes());
        self.pad();
    }

    pub(super) fn word(&mut self, word: u32) {
        self.bytes.extend_from_slice(&word.to_le_bytes());
    }

    pub(super) fn words(&mut self, words: impl IntoIterator<Item = u32>) {
        words.into_iter().for_each(|word| self.word(word));
    }

    /// Appends zeros up to a multiple of four bytes.
    pub(super) fn pad(&mut self) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    /// Appends a text: its length in bytes, and its bytes in UTF-8, padded.
    pub(super) fn text(&mut self, text: &str) {
        self.word(text.len() as u32);
        self.bytes.extend_from_slice(text.as_bytes());
        self.pad();
    }

    /// Appends a document without its buffer 0, which has `buffer` bytes.
    pub(super) fn document(&mut self, document: &Document, objects: u32, buffer: u32) {
        match document {
            Document::Gltf(gltf) => self.chunk(Tag::Json, |m| {
                m.words([objects, buffer]);
                m.bytes.extend_from_slice(gltf.json().as_bytes());
            }),
            Document::Obj(obj) => self.chunk(Tag::Materials, |m| {
                m.word(objects);
                for material in &obj.materials {
                    m.text(&material.name);
                    m.word(material.lines.len() as u32);
                    material.lines.iter().for_each(|line| m.text(line));
                }
            }),
        }
    }

    /// Appends an object: its number, that of its mesh in the document, vertices, triangles, scale
    /// (f32), name; number of attributes, for each its meaning, set, morph target + 1 (0: none),
    /// type of a component, number of components, whether it is normalised, name; number of
    /// submeshes, for each its primitive in the document, whether it has a material by name, that
    /// name, number of attributes, their numbers. `counts` are vertices and triangles;
    /// `attributes_of` gives for a submesh the numbers of the `attributes` that it has.
    pub(super) fn object<'a>(
        &mut self,
        number: u32,
        info: &ObjectInfo,
        counts: [u32; 2],
        attributes: &[Attribute],
        attributes_of: impl Fn(usize) -> &'a [u32],
    ) {
        self.chunk(Tag::Object, |m| {
            m.words([number, info.document_mesh, counts[0], counts[1]]);
            m.word((info.world_scale as f32).to_bits());
            m.text(&info.name);
            m.word(attributes.len() as u32);
            for attribute in attributes {
                m.attribute(attribute);
            }
            m.word(info.submeshes.len() as u32);
            for (i, submesh) in info.submeshes.iter().enumerate() {
                m.word(submesh.document_primitive);
                m.word(submesh.material.is_some().into());
                m.text(submesh.material.as_deref().unwrap_or_default());
                m.word(attributes_of(i).len() as u32);
                m.words(attributes_of(i).iter().copied());
            }
        });
    }

    /// Appends what [`Message::object`] says of an attribute.
    fn attribute(&mut self, attribute: &Attribute) {
        let (meaning, set, name) = match &attribute.semantic {
            Semantic::Position => (0, 0, ""),
            Semantic::Normal => (1, 0, ""),
            Semantic::Tangent => (2, 0, ""),
            Semantic::TexCoord(set) => (3, *set, ""),
            Semantic::Color(set) => (4, *set, ""),
            Semantic::Joints(set) => (5, *set, ""),
            Semantic::Weights(set) => (6, *set, ""),
            Semantic::Custom(name) => (7, 0, name.as_str()),
        };
        let component = match attribute.component {
            Component::I8 => 0,
            Component::U8 => 1,
            Component::I16 => 2,
            Component::U16 => 3,
            Component::U32 => 4,
            Component::F32 => 5,
        };
        let target = attribute.morph_target.map_or(0, |target| target + 1);
        let components = attribute.components.into();
        self.words([meaning, set, target, component, components, attribute.normalized.into()]);
        self.text(name);
    }
}
