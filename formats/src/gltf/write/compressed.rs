//! Buffer views compressed by EXT_meshopt_compression.

use crate::gltf::extensions;
use crate::gltf::json::{Json, Object, object};
use crate::gltf::meshopt::Content;
use crate::gltf::views::put;

/// The extension that is written.
const NAME: &str = extensions::MESHOPT[0];

/// The views of a document that are compressed, and the buffer that they would be in if they were
/// not.
#[derive(Debug)]
pub(super) struct Compressed {
    /// Number of the buffer without bytes.
    buffer: usize,
    length: usize,
}

impl Compressed {
    /// No view yet.
    pub(super) fn new(root: &Object) -> Self {
        let buffers = root.list("buffers").len();
        Self { buffer: buffers.max(1), length: 0 }
    }

    /// Puts a view's compressed bytes behind what `blob` holds; returns the view.
    pub(super) fn view(
        &mut self,
        content: &Content<'_>,
        length: usize,
        blob: &mut Vec<u8>,
    ) -> Json {
        let (bytes, layout) = content.encoded();
        let view = put(blob, &bytes);
        let mut packed = layout.json();
        for key in ["buffer", "byteOffset", "byteLength"] {
            packed[key] = view[key].clone();
        }
        let view = object! {
            "buffer" => self.buffer, "byteOffset" => self.length, "byteLength" => length,
            "extensions" => object! { NAME => packed },
        };
        self.length = (self.length + length).next_multiple_of(4);
        view
    }

    /// Adds the buffer without bytes and names the extension, if there is a view.
    pub(super) fn finish(&self, root: &mut Object) {
        if self.length == 0 {
            return;
        }
        let fallback = object! { NAME => object! { "fallback" => true } };
        let buffer = object! { "byteLength" => self.length, "extensions" => fallback };
        root.append("buffers", vec![buffer]);
        for key in ["extensionsUsed", "extensionsRequired"] {
            extensions::add(root, key, NAME);
        }
    }
}
