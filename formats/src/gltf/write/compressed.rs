//! Buffer views compressed by EXT_meshopt_compression.

use crate::gltf::extensions;
use crate::gltf::json::Object;
use crate::gltf::meshopt::Content;
use serde_json::{Value, json};

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
        let buffers = root.get("buffers").and_then(Value::as_array).map_or(0, Vec::len);
        Self { buffer: buffers.max(1), length: 0 }
    }

    /// Puts a view's compressed bytes behind what `blob` holds; returns the view.
    pub(super) fn view(
        &mut self,
        content: &Content<'_>,
        length: usize,
        blob: &mut Vec<u8>,
    ) -> Value {
        let (bytes, layout) = content.encoded();
        let mut layout = layout.json();
        blob.resize(blob.len().next_multiple_of(4), 0);
        layout["buffer"] = 0.into();
        layout["byteOffset"] = blob.len().into();
        layout["byteLength"] = bytes.len().into();
        blob.extend(bytes);
        let view = json!({
            "buffer": self.buffer, "byteOffset": self.length, "byteLength": length,
            "extensions": { NAME: layout }
        });
        self.length = (self.length + length).next_multiple_of(4);
        view
    }

    /// Adds the buffer without bytes and names the extension, if there is a view.
    pub(super) fn finish(&self, root: &mut Object) {
        if self.length == 0 {
            return;
        }
        if let Some(Value::Array(buffers)) = root.get_mut("buffers") {
            let fallback = json!({ NAME: { "fallback": true } });
            buffers.push(json!({ "byteLength": self.length, "extensions": fallback }));
        }
        for key in ["extensionsUsed", "extensionsRequired"] {
            extensions::add(root, key, NAME);
        }
    }
}
