//! The rest of a document when its triangles are gone: everything else, its buffer views
//! compacted into one blob.

use super::extensions::{self, DRACO, MESHOPT};
use super::json::{self, Object, integer};
use super::primitive;
use super::schema::{Pool, references, retain};
use super::uri;
use super::views::Views;
use crate::{FormatError, GltfDocument};
use serde_json::Value;

/// Takes the given primitives' geometry (mesh, primitive) out of a document and compacts the rest.
/// Nothing is renumbered while an unknown extension might point to it; then old geometry stays
/// behind.
pub(super) fn remainder(
    mut root: Object,
    stripped: &[(usize, usize)],
    views: &Views<'_>,
    warnings: &mut Vec<String>,
) -> Result<GltfDocument, FormatError> {
    let before = Used::of(&mut root);
    let mut outlines = 0;
    for &(mesh, p) in stripped {
        let primitive = primitive_mut(&mut root, mesh, p).expect("it has been read");
        outlines += usize::from(primitive::strip(primitive));
    }
    if outlines > 0 {
        warnings.push(format!(
            "outlines or n-gons of {outlines} primitives dropped: they name the old triangles"
        ));
    }
    drop_draco(&mut root);
    let mut kept: Vec<usize> = (0..before.views.len()).collect();
    if let Some(name) = extensions::opaque(&root) {
        warnings.push(format!(
            "the extension {name} is unknown and may refer to old data, which stays in the file"
        ));
    } else {
        let after = Used::of(&mut root);
        // What nothing pointed to from the start may be meant for someone else.
        let keep = |before: &[bool], after: &[bool]| -> Vec<bool> {
            before.iter().zip(after).map(|(b, a)| *a || !*b).collect()
        };
        let keep_views = keep(&before.views, &after.views);
        retain(&mut root, Pool::Accessors, &keep(&before.accessors, &after.accessors));
        retain(&mut root, Pool::BufferViews, &keep_views);
        kept.retain(|&v| keep_views[v]);
    }
    let blob = compact(&mut root, &kept, views)?;
    for name in MESHOPT {
        extensions::forget(&mut root, name);
    }
    Ok(GltfDocument { json: Value::Object(root).to_string(), blob })
}

fn primitive_mut(root: &mut Object, mesh: usize, primitive: usize) -> Option<&mut Object> {
    let mesh = root.get_mut("meshes")?.as_array_mut()?.get_mut(mesh)?;
    mesh.get_mut("primitives")?.as_array_mut()?.get_mut(primitive)?.as_object_mut()
}

/// Compressed primitives have been refused, so wherever the extension is left the uncompressed data
/// is there too.
fn drop_draco(root: &mut Object) {
    for mesh in root.get_mut("meshes").and_then(Value::as_array_mut).into_iter().flatten() {
        for primitive in
            mesh.get_mut("primitives").and_then(Value::as_array_mut).into_iter().flatten()
        {
            if let Some(primitive) = primitive.as_object_mut() {
                json::remove_extension(primitive, DRACO);
            }
        }
    }
    extensions::forget(root, DRACO);
}

/// Accessors and buffer views that something refers to; what an unused accessor refers to does not
/// count.
struct Used {
    accessors: Vec<bool>,
    views: Vec<bool>,
}

impl Used {
    fn of(root: &mut Object) -> Self {
        let mut accessors = vec![false; Pool::Accessors.len(root)];
        let mut views = vec![false; Pool::BufferViews.len(root)];
        let index = |v: &Value| integer(v).map_or(usize::MAX, |i| i as usize);
        references(root, Pool::Accessors, &mut |v, _| accessors[index(v)] = true);
        references(root, Pool::BufferViews, &mut |v, place| {
            let accessor = place
                .strip_prefix("accessors[")
                .and_then(|p| p.split_once(']')?.0.parse::<usize>().ok());
            if accessor.is_none_or(|a| accessors[a]) {
                views[index(v)] = true;
            }
        });
        Self { accessors, views }
    }
}

/// Lays the kept views out in one buffer, the document's first; after it come buffers that have no
/// bytes, if a view still needs them. Overlapping views stay overlapping, so the blob is never
/// larger than what it is made from; offsets keep their remainder by 4.
fn compact(root: &mut Object, kept: &[usize], views: &Views<'_>) -> Result<Vec<u8>, FormatError> {
    let mut blob: Vec<u8> = Vec::new();
    let mut located = vec![(0, 0); kept.len()];
    let mut plain: Vec<usize> =
        (0..kept.len()).filter(|&i| !views.is_compressed(kept[i])).collect();
    plain.sort_by_key(|&i| {
        let (buffer, range) = views.range(kept[i]);
        (buffer, range.start, range.end)
    });
    let mut placeholders: Vec<usize> = Vec::new();
    // The run of overlapping views being laid out: buffer, first byte, end, and where it begins in
    // the blob.
    let mut run: Option<(usize, usize, usize, usize)> = None;
    for i in plain {
        let (buffer, range) = views.range(kept[i]);
        if views.is_placeholder(kept[i]) {
            if placeholders.last() != Some(&buffer) {
                placeholders.push(buffer);
            }
            located[i] = (placeholders.len(), range.start);
            continue;
        }
        let bytes = views.bytes(kept[i])?;
        let (start, end, at) = match run {
            Some((b, start, end, at)) if b == buffer && range.start <= end => (start, end, at),
            _ => {
                while blob.len() % 4 != range.start % 4 {
                    blob.push(0);
                }
                (range.start, range.start, blob.len())
            }
        };
        if range.end > end {
            blob.extend_from_slice(&bytes[end - range.start..]);
        }
        run = Some((buffer, start, end.max(range.end), at));
        located[i] = (0, at + (range.start - start));
    }
    for (i, &view) in kept.iter().enumerate().filter(|(_, view)| views.is_compressed(**view)) {
        let bytes = views.bytes(view)?;
        blob.resize(blob.len().next_multiple_of(4), 0);
        located[i] = (0, blob.len());
        blob.extend_from_slice(bytes);
    }
    let entries = root.get_mut("bufferViews").and_then(Value::as_array_mut);
    for (view, &(buffer, offset)) in entries.into_iter().flatten().zip(&located) {
        let Some(view) = view.as_object_mut() else { continue };
        view.insert("buffer".to_owned(), buffer.into());
        if offset > 0 || view.contains_key("byteOffset") {
            view.insert("byteOffset".to_owned(), offset.into());
        }
        MESHOPT.iter().for_each(|name| json::remove_extension(view, name));
    }
    embed_data_images(root, &mut blob);
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
    Ok(blob)
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
