//! The compression of EXT_meshopt_compression, encoded. Source: the published specification of the
//! extension (bitstreams); the decoder of imports is its twin.

mod exponential;
mod index;
pub(super) mod octahedral;
#[cfg(test)]
mod tests;
mod vertex;

use crate::import::gltf::json::Object;
use serde_json::{Value, json};

const NAME: &str = "EXT_meshopt_compression";

/// A buffer view to compress.
pub(super) enum Content<'a> {
    /// Elements of a stride: a multiple of 4 up to 256.
    Attributes { stride: usize, bytes: &'a [u8] },
    /// Elements of floats, which may be multiples of powers of two.
    Floats { stride: usize, bytes: &'a [u8] },
    /// Unit vectors that may have been rounded to so many bits on an octahedron.
    Directions { bits: u8, stride: usize, bytes: &'a [u8] },
    /// Triangle lists of 2 or 4 bytes per index.
    Triangles { size: usize, bytes: &'a [u8] },
}

impl Content<'_> {
    /// Returns whether there is a codec for it.
    pub(super) fn fits(&self) -> bool {
        match self {
            Self::Attributes { stride, bytes }
            | Self::Floats { stride, bytes }
            | Self::Directions { stride, bytes, .. } => {
                stride.is_multiple_of(4) && *stride <= 256 && bytes.len().is_multiple_of(*stride)
            }
            Self::Triangles { size, bytes } => bytes.len().is_multiple_of(3 * size),
        }
    }

    /// Returns the compressed bytes, and what the view's extension says besides where they are.
    pub(super) fn encoded(&self) -> (Vec<u8>, Value) {
        match *self {
            Self::Attributes { stride, bytes } => {
                let count = bytes.len() / stride;
                let layout = json!({ "byteStride": stride, "count": count, "mode": "ATTRIBUTES" });
                (vertex::encode(stride, bytes), layout)
            }
            Self::Floats { stride, bytes } => {
                filtered(stride, bytes, "EXPONENTIAL", exponential::encode(stride, bytes))
            }
            Self::Directions { bits, stride, bytes } => {
                filtered(stride, bytes, "OCTAHEDRAL", octahedral::encode(bits, stride, bytes))
            }
            Self::Triangles { size, bytes } => {
                let index = |b: &[u8]| b.iter().rev().fold(0, |v, &b| v << 8 | u32::from(b));
                let indices: Vec<u32> = bytes.chunks_exact(size).map(index).collect();
                let layout =
                    json!({ "byteStride": size, "count": indices.len(), "mode": "TRIANGLES" });
                (index::encode(indices.as_chunks().0), layout)
            }
        }
    }
}

/// Elements as a filter packs them, where it can and that takes fewer bytes.
fn filtered(
    stride: usize,
    bytes: &[u8],
    filter: &str,
    packed: Option<Vec<u8>>,
) -> (Vec<u8>, Value) {
    let plain = Content::Attributes { stride, bytes }.encoded();
    let Some(packed) = packed else { return plain };
    let (encoded, mut layout) = Content::Attributes { stride, bytes: &packed }.encoded();
    layout["filter"] = filter.into();
    if encoded.len() < plain.0.len() { (encoded, layout) } else { plain }
}

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
        let (bytes, mut layout) = content.encoded();
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
            super::add_extension(root, key, NAME);
        }
    }
}
