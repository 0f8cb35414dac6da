//! Buffers and buffer views: checked byte ranges, decompressed on first use.

use super::budget::Budget;
use super::extensions;
use super::json::{Json, Object, malformed, object};
use super::meshopt::{self, Layout};
use super::typed;
use super::uri;
use crate::{Assets, FormatError};
use ::gltf::json::buffer as stated;
use std::cell::OnceCell;
use std::ops::Range;

/// The buffers of a document; `None` for one that has no bytes of its own (a placeholder).
pub(super) type Buffers<'a> = Vec<Option<std::borrow::Cow<'a, [u8]>>>;

/// Reads every buffer. The first one may be the binary chunk of a GLB.
pub(super) fn read_buffers<'a>(
    root: &Object,
    chunk: Option<&'a [u8]>,
    assets: &mut Assets,
) -> Result<Buffers<'a>, FormatError> {
    let mut buffers: Buffers<'a> = Vec::new();
    for (i, buffer) in root.entries("buffers").enumerate() {
        let location = format!("buffers[{i}]");
        let stated: ::gltf::json::Buffer = typed::entry(buffer, &location)?;
        let length = stated.byte_length.0;
        if length == 0 {
            return Err(malformed(location, "byteLength must be at least 1"));
        }
        let bytes: Option<std::borrow::Cow<'a, [u8]>> = match &stated.uri {
            _ if is_fallback(buffer) => None,
            Some(uri) => Some(uri::read(uri, &format!("{location}.uri"), assets)?.into()),
            None if i == 0 => chunk.map(Into::into),
            None => None,
        };
        if let Some(bytes) = &bytes
            && (bytes.len() as u64) < length
        {
            return Err(malformed(
                location,
                format!("says {length} bytes, but there are {}", bytes.len()),
            ));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

/// A placeholder buffer for what is compressed elsewhere is not read: nothing needs it.
fn is_fallback(buffer: &Object) -> bool {
    let marked = |name| buffer.extension(name)?.get("fallback")?.as_bool();
    extensions::MESHOPT.into_iter().filter_map(marked).any(|b| b)
}

/// One buffer view.
#[derive(Debug)]
struct View {
    buffer: usize,
    /// Its bytes in the buffer, compressed or not.
    range: Range<usize>,
    stride: Option<usize>,
    compressed: Option<Layout>,
    decoded: OnceCell<Vec<u8>>,
}

/// All buffer views of a document, each known to lie in its buffer.
#[derive(Debug)]
pub(super) struct Views<'a> {
    buffers: &'a Buffers<'a>,
    views: Vec<View>,
    pub(super) budget: &'a Budget,
}

impl<'a> Views<'a> {
    /// Checks every buffer view; decodes none yet.
    pub(super) fn new(
        root: &Object,
        buffers: &'a Buffers<'a>,
        budget: &'a Budget,
    ) -> Result<Self, FormatError> {
        let lengths: Vec<u64> = root
            .entries("buffers")
            .map(|b| b.optional("byteLength", "").ok().flatten().unwrap_or(0))
            .collect();
        let views = root.entries("bufferViews").enumerate();
        let views =
            views.map(|(i, view)| read_view(view, &format!("bufferViews[{i}]"), buffers, &lengths));
        Ok(Self { buffers, views: views.collect::<Result<_, _>>()?, budget })
    }

    /// The distance of elements, if the view says.
    pub(super) fn stride(&self, view: usize) -> Option<usize> {
        self.views[view].stride
    }

    /// Number of bytes of the view, decompressed.
    pub(super) fn len(&self, view: usize) -> usize {
        let view = &self.views[view];
        view.compressed.map_or(view.range.len(), |layout| layout.count * layout.stride)
    }

    /// Returns whether the view is compressed.
    pub(super) fn is_compressed(&self, view: usize) -> bool {
        self.views[view].compressed.is_some()
    }

    /// Returns whether the view's bytes are nowhere: its buffer is a placeholder.
    pub(super) fn is_placeholder(&self, view: usize) -> bool {
        self.buffers[self.views[view].buffer].is_none()
    }

    /// The buffer of the view and where in it the view is.
    pub(super) fn range(&self, view: usize) -> (usize, Range<usize>) {
        (self.views[view].buffer, self.views[view].range.clone())
    }

    /// The bytes of a view, decompressed.
    pub(super) fn bytes(&self, index: usize) -> Result<&[u8], FormatError> {
        let view = &self.views[index];
        let location = || format!("bufferViews[{index}]");
        let buffer = self.buffers[view.buffer].as_deref();
        let buffer = buffer.ok_or_else(|| {
            malformed(location(), format!("buffers[{}] has no bytes", view.buffer))
        })?;
        // Checked against the buffer's stated length, which is not more than it has.
        let raw = &buffer[view.range.clone()];
        let Some(layout) = &view.compressed else { return Ok(raw) };
        if let Some(decoded) = view.decoded.get() {
            return Ok(decoded);
        }
        // Twice: indices are decoded to 32 bits before they are narrowed.
        self.budget.charge(layout.count as u64, 2 * layout.stride.max(4) as u64, &location())?;
        let decoded = meshopt::decode(layout, raw).map_err(|problem| {
            malformed(location(), format!("compressed data cannot be decoded: {problem}"))
        })?;
        Ok(view.decoded.get_or_init(|| decoded))
    }
}

/// Puts bytes behind what a blob holds, at a multiple of four; returns the buffer view of them.
pub(super) fn put(blob: &mut Vec<u8>, bytes: &[u8]) -> Json {
    blob.resize(blob.len().next_multiple_of(4), 0);
    let offset = blob.len();
    blob.extend_from_slice(bytes);
    object! { "buffer" => 0u32, "byteOffset" => offset, "byteLength" => bytes.len() }
}

fn read_view(
    view: &Object,
    location: &str,
    buffers: &Buffers<'_>,
    lengths: &[u64],
) -> Result<View, FormatError> {
    let stated: stated::View = typed::entry(view, location)?;
    let buffer = stated.buffer.value();
    let offset = stated.byte_offset.map_or(0, |offset| offset.0);
    let range = byte_range(lengths, buffer, offset, stated.byte_length.0, location)?;
    let stride = stated.byte_stride.map(|stride| stride.0);
    let strides = stated::MIN_BYTE_STRIDE..=stated::MAX_BYTE_STRIDE;
    if stride.is_some_and(|s| !strides.contains(&s) || !s.is_multiple_of(4)) {
        return Err(malformed(location, "byteStride must be a multiple of 4 from 4 to 252"));
    }
    let plain = View { buffer, range, stride, compressed: None, decoded: OnceCell::new() };
    match extensions::meshopt(view) {
        Some((name, packed)) => {
            compressed(plain, packed, &format!("{location}.extensions.{name}"), buffers, lengths)
        }
        None => Ok(plain),
    }
}

/// The bytes of a buffer that a view says it has.
fn byte_range(
    lengths: &[u64],
    buffer: usize,
    offset: u64,
    length: u64,
    location: &str,
) -> Result<Range<usize>, FormatError> {
    if length == 0 {
        return Err(malformed(location, "byteLength must be at least 1"));
    }
    // A buffer without bytes may claim any length: nothing is allocated for it, and reading it is
    // refused.
    let limit = lengths.get(buffer).copied().unwrap_or(0);
    match offset.checked_add(length) {
        Some(end) if end <= limit => Ok(offset as usize..end as usize),
        _ => Err(malformed(
            location,
            format!("{offset} + {length} bytes do not fit buffers[{buffer}] of {limit}"),
        )),
    }
}

/// A view whose bytes are compressed elsewhere; `plain` is where it would be uncompressed.
fn compressed(
    plain: View,
    packed: &Object,
    location: &str,
    buffers: &Buffers<'_>,
    lengths: &[u64],
) -> Result<View, FormatError> {
    let buffer = packed.required("buffer", location)? as usize;
    let offset = packed.optional("byteOffset", location)?.unwrap_or(0);
    let length = packed.required("byteLength", location)?;
    let range = byte_range(lengths, buffer, offset, length, location)?;
    let layout = Layout::read(packed, location)?;
    // The uncompressed size is what accessors are checked against; it must be a size that memory
    // can have.
    if layout.count.checked_mul(layout.stride) != Some(plain.range.len()) {
        let problem = format!(
            "{} elements of {} bytes are not byteLength {}",
            layout.count,
            layout.stride,
            plain.range.len()
        );
        return Err(malformed(location, problem));
    }
    if buffers[buffer].is_none() {
        return Err(malformed(location, format!("buffers[{buffer}] has no bytes")));
    }
    Ok(View { buffer, range, compressed: Some(layout), ..plain })
}
