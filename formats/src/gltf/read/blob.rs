//! Copies all buffer views that a document keeps into one buffer (`blob`), so that it can be stored
//! in one section, and changes their offsets.

use crate::FormatError;
use crate::gltf::extensions::MESHOPT;
use crate::gltf::json::{Object, object};
use crate::gltf::schema::Pool;
use crate::gltf::uri;
use crate::gltf::views::{Views, put};

/// Lays the kept views out in one buffer, the document's first; after it come buffers that have no
/// bytes, if a view still needs them. Overlapping views stay overlapping, so the blob is never
/// larger than what it is made from; offsets modulo 4 stay as they were. Those that are `emptied`
/// keep nothing but their numbers.
pub(super) fn compact(
    root: &mut Object,
    kept_views: &[usize],
    emptied: &[bool],
    views: &Views<'_>,
) -> Result<Vec<u8>, FormatError> {
    let mut layout = BlobLayout::new(kept_views.len());
    let full: Vec<usize> = (0..kept_views.len()).filter(|&i| !emptied[i]).collect();
    layout.add_plain(kept_views, &full, views)?;
    layout.add_compressed(kept_views, &full, views)?;
    let BlobLayout { mut blob, placeholders, locations } = layout;
    relocate_views(root, &locations);
    empty_views(root, emptied, &mut blob);
    embed_data_images(root, &mut blob);
    replace_buffers(root, &placeholders, &mut blob);
    Ok(blob)
}

/// The new buffer and offset of a kept view.
#[derive(Clone, Copy, Default)]
struct NewLocation {
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
    blob_offset: usize,
}

/// The new buffers as far as they are laid out.
struct BlobLayout {
    blob: Vec<u8>,
    /// Old buffers without bytes that a view still needs.
    placeholders: Vec<usize>,
    /// One for each kept view.
    locations: Vec<NewLocation>,
}

impl BlobLayout {
    fn new(views: usize) -> Self {
        Self {
            blob: Vec::new(),
            placeholders: Vec::new(),
            locations: vec![NewLocation::default(); views],
        }
    }

    /// Adds the views that are not compressed, in the order of their bytes in the old buffers.
    fn add_plain(
        &mut self,
        kept_views: &[usize],
        full: &[usize],
        views: &Views<'_>,
    ) -> Result<(), FormatError> {
        let is_plain = |i: &usize| !views.is_compressed(kept_views[*i]);
        let mut plain: Vec<usize> = full.iter().copied().filter(is_plain).collect();
        plain.sort_by_key(|&i| {
            let (buffer, range) = views.range(kept_views[i]);
            (buffer, range.start, range.end)
        });
        let mut run: Option<Run> = None;
        for i in plain {
            let (buffer, range) = views.range(kept_views[i]);
            if views.is_placeholder(kept_views[i]) {
                if self.placeholders.last() != Some(&buffer) {
                    self.placeholders.push(buffer);
                }
                let buffer = self.placeholders.len();
                self.locations[i] = NewLocation { buffer, offset: range.start };
                continue;
            }
            let bytes = views.bytes(kept_views[i])?;
            let mut current = match run {
                Some(run) if run.buffer == buffer && range.start <= run.end => run,
                _ => self.begin_run(buffer, range.start),
            };
            // In order, so the view starts within the run, and only its end may be new.
            if range.end > current.end {
                self.blob.extend_from_slice(&bytes[current.end - range.start..]);
                current.end = range.end;
            }
            let offset = current.blob_offset + (range.start - current.start);
            self.locations[i] = NewLocation { buffer: 0, offset };
            run = Some(current);
        }
        Ok(())
    }

    fn begin_run(&mut self, buffer: usize, start: usize) -> Run {
        while self.blob.len() % 4 != start % 4 {
            self.blob.push(0);
        }
        Run { buffer, start, end: start, blob_offset: self.blob.len() }
    }

    /// Adds the decompressed bytes of compressed views.
    fn add_compressed(
        &mut self,
        kept_views: &[usize],
        full: &[usize],
        views: &Views<'_>,
    ) -> Result<(), FormatError> {
        let all = full.iter().map(|&i| (i, kept_views[i]));
        for (i, view) in all.filter(|(_, view)| views.is_compressed(*view)) {
            let bytes = views.bytes(view)?;
            self.blob.resize(self.blob.len().next_multiple_of(4), 0);
            self.locations[i] = NewLocation { buffer: 0, offset: self.blob.len() };
            self.blob.extend_from_slice(bytes);
        }
        Ok(())
    }
}

/// Writes the new locations into the document's views, which are not compressed any more.
fn relocate_views(root: &mut Object, locations: &[NewLocation]) {
    for (view, to) in root.objects_mut("bufferViews").zip(locations) {
        view["buffer"] = to.buffer.into();
        if to.offset > 0 || view.contains_key("byteOffset") {
            view["byteOffset"] = to.offset.into();
        }
        MESHOPT.iter().for_each(|name| view.remove_extension(name));
    }
}

/// Makes views without content refer to the first bytes of the blob: a view cannot be empty.
fn empty_views(root: &mut Object, emptied: &[bool], blob: &mut Vec<u8>) {
    let views = root.objects_mut("bufferViews").zip(emptied);
    for (view, _) in views.filter(|(_, is_emptied)| **is_emptied) {
        if blob.len() < EMPTY_BYTES {
            blob.resize(EMPTY_BYTES, 0);
        }
        ["byteStride", "target"].iter().for_each(|key| drop(view.shift_remove(*key)));
        view["byteLength"] = EMPTY_BYTES.into();
    }
}

/// Bytes of a view or blob without content: glTF has no empty ones.
const EMPTY_BYTES: usize = 4;

/// Replaces the document's buffers by the blob and the placeholders.
fn replace_buffers(root: &mut Object, placeholders: &[usize], blob: &mut Vec<u8>) {
    if blob.is_empty() && !placeholders.is_empty() {
        // Buffers cannot be empty, and the first one is the blob.
        blob.resize(EMPTY_BYTES, 0);
    }
    if blob.is_empty() {
        root.shift_remove("buffers");
        return;
    }
    let without_bytes = |&b: &usize| {
        let mut buffer = root["buffers"][b].clone();
        let members = buffer.as_object_mut().into_iter();
        members.for_each(|b| MESHOPT.iter().for_each(|name| b.remove_extension(name)));
        buffer
    };
    let mut buffers = vec![object! { "byteLength" => blob.len() }];
    buffers.extend(placeholders.iter().map(without_bytes));
    root["buffers"] = buffers.into();
}

/// Images in base 64 become bytes of the blob: a third smaller, and what a GLB should have. One
/// that cannot be decoded stays as it is.
fn embed_data_images(root: &mut Object, blob: &mut Vec<u8>) {
    let first = Pool::BufferViews.len(root);
    let mut added = Vec::new();
    for image in root.objects_mut("images") {
        let decoded = image["uri"].as_str().and_then(uri::decoded_data);
        let Some((media_type, bytes)) = decoded.filter(|(_, bytes)| !bytes.is_empty()) else {
            continue;
        };
        if !image.contains_key("mimeType") {
            if !matches!(&*media_type, "image/png" | "image/jpeg") {
                continue;
            }
            image["mimeType"] = media_type.into();
        }
        image.shift_remove("uri");
        image["bufferView"] = (first + added.len()).into();
        added.push(put(blob, &bytes));
    }
    root.append("bufferViews", added);
}
