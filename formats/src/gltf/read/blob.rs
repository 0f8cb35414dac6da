//! One buffer, the blob, for all the buffer views that a document keeps.

use crate::FormatError;
use crate::gltf::extensions::MESHOPT;
use crate::gltf::json::{self, Object};
use crate::gltf::schema::Pool;
use crate::gltf::uri;
use crate::gltf::views::Views;
use serde_json::Value;

/// Lays the kept views out in one buffer, the document's first; after it come buffers that have no
/// bytes, if a view still needs them. Overlapping views stay overlapping, so the blob is never
/// larger than what it is made from; offsets keep their remainder by 4.
pub(super) fn compact(
    root: &mut Object,
    kept: &[usize],
    views: &Views<'_>,
) -> Result<Vec<u8>, FormatError> {
    let mut layout = BlobLayout::new(kept.len());
    layout.add_plain(kept, views)?;
    layout.add_compressed(kept, views)?;
    let BlobLayout { mut blob, placeholders, located } = layout;
    relocate_views(root, &located);
    embed_data_images(root, &mut blob);
    replace_buffers(root, &placeholders, &mut blob);
    Ok(blob)
}

/// The place of a kept view in the new buffers.
#[derive(Clone, Copy, Default)]
struct Located {
    /// 0 is the blob; the placeholders follow.
    buffer: usize,
    offset: usize,
}

/// Overlapping views that are being laid out as one run of bytes.
#[derive(Clone, Copy)]
struct Run {
    /// The old buffer, and the range of bytes in it.
    buffer: usize,
    start: usize,
    end: usize,
    /// Offset of the first byte in the blob.
    at: usize,
}

/// The new buffers as far as they are laid out.
struct BlobLayout {
    blob: Vec<u8>,
    /// Old buffers without bytes that a view still needs.
    placeholders: Vec<usize>,
    /// By kept view.
    located: Vec<Located>,
}

impl BlobLayout {
    fn new(views: usize) -> Self {
        Self {
            blob: Vec::new(),
            placeholders: Vec::new(),
            located: vec![Located::default(); views],
        }
    }

    /// Adds the views that are not compressed, in the order of their bytes.
    fn add_plain(&mut self, kept: &[usize], views: &Views<'_>) -> Result<(), FormatError> {
        let mut plain: Vec<usize> =
            (0..kept.len()).filter(|&i| !views.is_compressed(kept[i])).collect();
        plain.sort_by_key(|&i| {
            let (buffer, range) = views.range(kept[i]);
            (buffer, range.start, range.end)
        });
        let mut run: Option<Run> = None;
        for i in plain {
            let (buffer, range) = views.range(kept[i]);
            if views.is_placeholder(kept[i]) {
                if self.placeholders.last() != Some(&buffer) {
                    self.placeholders.push(buffer);
                }
                self.located[i] = Located { buffer: self.placeholders.len(), offset: range.start };
                continue;
            }
            let bytes = views.bytes(kept[i])?;
            let mut current = match run {
                Some(run) if run.buffer == buffer && range.start <= run.end => run,
                _ => self.begin_run(buffer, range.start),
            };
            if range.end > current.end {
                self.blob.extend_from_slice(&bytes[current.end - range.start..]);
                current.end = range.end;
            }
            let offset = current.at + (range.start - current.start);
            self.located[i] = Located { buffer: 0, offset };
            run = Some(current);
        }
        Ok(())
    }

    fn begin_run(&mut self, buffer: usize, start: usize) -> Run {
        while self.blob.len() % 4 != start % 4 {
            self.blob.push(0);
        }
        Run { buffer, start, end: start, at: self.blob.len() }
    }

    /// Adds the bytes that compressed views stand for.
    fn add_compressed(&mut self, kept: &[usize], views: &Views<'_>) -> Result<(), FormatError> {
        for (i, &view) in kept.iter().enumerate().filter(|(_, view)| views.is_compressed(**view)) {
            let bytes = views.bytes(view)?;
            self.blob.resize(self.blob.len().next_multiple_of(4), 0);
            self.located[i] = Located { buffer: 0, offset: self.blob.len() };
            self.blob.extend_from_slice(bytes);
        }
        Ok(())
    }
}

/// Writes the new places into the document's views, which are not compressed any more.
fn relocate_views(root: &mut Object, located: &[Located]) {
    let entries = root.get_mut("bufferViews").and_then(Value::as_array_mut);
    for (view, to) in entries.into_iter().flatten().zip(located) {
        let Some(view) = view.as_object_mut() else { continue };
        view.insert("buffer".to_owned(), to.buffer.into());
        if to.offset > 0 || view.contains_key("byteOffset") {
            view.insert("byteOffset".to_owned(), to.offset.into());
        }
        MESHOPT.iter().for_each(|name| json::remove_extension(view, name));
    }
}

/// Replaces the document's buffers by the blob and the placeholders.
fn replace_buffers(root: &mut Object, placeholders: &[usize], blob: &mut Vec<u8>) {
    if blob.is_empty() && !placeholders.is_empty() {
        // Buffers cannot be empty, and the first one is the blob.
        blob.resize(4, 0);
    }
    let old = json::list(root, "buffers");
    let mut buffers: Vec<Value> = placeholders.iter().map(|&b| old[b].clone()).collect();
    for buffer in buffers.iter_mut().filter_map(Value::as_object_mut) {
        MESHOPT.iter().for_each(|name| json::remove_extension(buffer, name));
    }
    if blob.is_empty() {
        root.shift_remove("buffers");
    } else {
        buffers.insert(0, serde_json::json!({ "byteLength": blob.len() }));
        root.insert("buffers".to_owned(), Value::Array(buffers));
    }
}

/// Images in base 64 become bytes of the blob: a third smaller, and what a GLB should have. One
/// that cannot be decoded stays as it is.
fn embed_data_images(root: &mut Object, blob: &mut Vec<u8>) {
    let first = Pool::BufferViews.len(root);
    let mut added = Vec::new();
    for image in root.get_mut("images").and_then(Value::as_array_mut).into_iter().flatten() {
        let Some(image) = image.as_object_mut() else { continue };
        let decoded = image.get("uri").and_then(Value::as_str).and_then(uri::decoded_data);
        let Some((media_type, bytes)) = decoded.filter(|(_, bytes)| !bytes.is_empty()) else {
            continue;
        };
        if !image.contains_key("mimeType") {
            if !matches!(&*media_type, "image/png" | "image/jpeg") {
                continue;
            }
            image.insert("mimeType".to_owned(), media_type.into());
        }
        image.shift_remove("uri");
        image.insert("bufferView".to_owned(), (first + added.len()).into());
        blob.resize(blob.len().next_multiple_of(4), 0);
        added.push(
            serde_json::json!({ "buffer": 0, "byteOffset": blob.len(), "byteLength": bytes.len() }),
        );
        blob.extend(bytes);
    }
    if !added.is_empty()
        && let Value::Array(views) =
            root.entry("bufferViews").or_insert_with(|| Value::Array(Vec::new()))
    {
        views.extend(added);
    }
}
