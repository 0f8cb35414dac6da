//! The order in which a stream sends the bytes of a glTF's binary buffer: matrices of skins first,
//! then images in the order in which objects use them, animations last.

use super::extensions;
use super::json::{Json, Object, parse};
use super::schema::{self, Pool, references};
use crate::{GltfDocument, Limits, ObjectInfo};
use std::ops::Range;

/// Extensions that refer to images and textures elsewhere than in materials and `textures`.
const UNLISTED: [&str; 5] = [
    "EXT_lights_image_based",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "EXT_feature_metadata",
    "KHR_techniques_webgl",
];

/// What bytes of a buffer are for, in the order in which they are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Purpose {
    /// What places nodes: matrices of skins, instances, points and lines.
    Placement,
    /// Images of base colours.
    BaseColor,
    /// All other images, and what is not known.
    Texture,
    Animation,
}

/// Neighbouring bytes of a buffer that are wanted together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BufferRun {
    pub(crate) bytes: Range<u64>,
    pub(crate) purpose: Purpose,
}

/// Returns the buffer views of a document as runs in the order in which they are wanted: images in
/// the order in which the objects use them. Views that share bytes are one run. There is none if
/// the document refers to its buffer in a way that is not known.
pub(crate) fn buffer_runs<'a>(
    document: &GltfDocument,
    objects: impl Iterator<Item = &'a ObjectInfo>,
) -> Vec<BufferRun> {
    let Ok(mut root) = parse(document.json().as_bytes(), &Limits::DEFAULT) else {
        return Vec::new();
    };
    if schema::check(&mut root).is_err() || has_unknown_references(&root) {
        return Vec::new();
    }
    let priorities = priorities(&mut root, objects);
    let end = document.blob().len() as u64;
    let mut views: Vec<(Range<u64>, Priority)> = root
        .entries("bufferViews")
        .zip(priorities)
        .filter_map(|(view, priority)| Some((view_bytes(view)?, priority)))
        .filter(|(bytes, _)| !bytes.is_empty() && bytes.end <= end)
        .collect();
    views.sort_by_key(|(bytes, _)| bytes.start);
    let mut runs: Vec<(Range<u64>, Priority)> = Vec::new();
    for (bytes, priority) in views {
        match runs.last_mut() {
            Some((last, run_priority)) if bytes.start < last.end => {
                last.end = last.end.max(bytes.end);
                *run_priority = (*run_priority).min(priority);
            }
            _ => runs.push((bytes, priority)),
        }
    }
    // Padding goes with the run before it.
    for i in 0..runs.len() {
        let next = runs.get(i + 1).map_or(end, |(next, _)| next.start);
        let (bytes, _) = &mut runs[i];
        if next - bytes.end < ALIGN {
            bytes.end = next;
        }
    }
    runs.sort_by_key(|&(_, priority)| priority);
    runs.into_iter().map(|(bytes, (purpose, _))| BufferRun { bytes, purpose }).collect()
}

/// Returns whether a document may refer to its buffer in a way that is not known.
pub(super) fn has_unknown_references(root: &Object) -> bool {
    let mut used = root.list("extensionsUsed").iter().filter_map(Json::as_str);
    used.any(|e| UNLISTED.contains(&e)) || extensions::unknown(root).is_some()
}

/// The bytes of a view; none if they are more than can be.
pub(super) fn view_bytes(view: &Object) -> Option<Range<u64>> {
    let start = view["byteOffset"].as_u64().unwrap_or(0);
    Some(start..start.checked_add(view["byteLength"].as_u64()?)?)
}

/// A purpose, and a rank among equals.
type Priority = (Purpose, usize);

/// Returns what each view is wanted for first.
fn priorities<'a>(
    root: &mut Object,
    objects: impl Iterator<Item = &'a ObjectInfo>,
) -> Vec<Priority> {
    let mut used_by_animation = vec![false; Pool::Accessors.len(root)];
    let mut used_elsewhere = used_by_animation.clone();
    references(root, Pool::Accessors, &mut |accessor, location| {
        let used = if location.starts_with("animations") {
            &mut used_by_animation
        } else {
            &mut used_elsewhere
        };
        if let Some(mark) = accessor.as_index().and_then(|i| used.get_mut(i)) {
            *mark = true;
        }
    });
    let mut views: Vec<Option<Priority>> = vec![None; Pool::BufferViews.len(root)];
    let mut mark = |view: &Json, priority: Priority| {
        if let Some(first) = view.as_index().and_then(|i| views.get_mut(i)) {
            *first = Some(first.map_or(priority, |first| first.min(priority)));
        }
    };
    for (accessor, used) in
        root.entries("accessors").zip(used_elsewhere.into_iter().zip(used_by_animation))
    {
        let purpose = match used {
            (true, _) => Purpose::Placement,
            (false, true) => Purpose::Animation,
            (false, false) => continue,
        };
        let sparse = ["indices", "values"].map(|key| &accessor["sparse"][key]["bufferView"]);
        for view in [&accessor["bufferView"], sparse[0], sparse[1]] {
            mark(view, (purpose, 0));
        }
    }
    for (image, priority) in root.entries("images").zip(images(root, objects)) {
        mark(&image["bufferView"], priority);
    }
    views.into_iter().map(|first| first.unwrap_or((Purpose::Texture, usize::MAX))).collect()
}

/// Returns what each image is wanted for.
fn images<'a>(root: &Object, objects: impl Iterator<Item = &'a ObjectInfo>) -> Vec<Priority> {
    let meshes: Vec<&Object> = root.entries("meshes").collect();
    let mut order: Vec<usize> = Vec::new();
    for info in objects {
        let mesh = meshes.get(info.document_mesh as usize);
        let primitives = mesh.map_or(&[][..], |mesh| mesh.list("primitives"));
        order.extend(primitives.iter().filter_map(|p| p["material"].as_index()));
    }
    let materials: Vec<&Object> = root.entries("materials").collect();
    order.extend(0..materials.len());
    let textures: Vec<&Object> = root.entries("textures").collect();
    let mut images = vec![(Purpose::Texture, usize::MAX); Pool::Images.len(root)];
    let mut rank = 0;
    let mut seen = vec![false; materials.len()];
    for material in order {
        let Some(false) = seen.get(material) else { continue };
        seen[material] = true;
        let base = &materials[material]["pbrMetallicRoughness"]["baseColorTexture"]["index"];
        let mut used = Vec::new();
        texture_indices(materials[material].values(), &mut used);
        for texture in used {
            let is_base = base.as_index() == Some(texture);
            let purpose = if is_base { Purpose::BaseColor } else { Purpose::Texture };
            let Some(texture) = textures.get(texture) else { continue };
            let extensions = texture["extensions"].as_object();
            let sources = extensions.into_iter().flat_map(|e| e.values()).map(|e| &e["source"]);
            for source in sources.chain([&texture["source"]]).filter_map(Json::as_index) {
                if let Some(image_priority) = images.get_mut(source) {
                    *image_priority = (*image_priority).min((purpose, rank));
                }
                rank += 1;
            }
        }
    }
    images
}

/// Adds the textures that the members of a material name.
fn texture_indices<'a>(members: impl Iterator<Item = &'a Json>, used: &mut Vec<usize>) {
    for member in members {
        match member {
            Json::Object(members) => {
                used.extend(members.get("index").and_then(Json::as_index));
                texture_indices(members.values(), used);
            }
            Json::Array(values) => texture_indices(values.iter(), used),
            _ => {}
        }
    }
}

/// The bytes of a buffer that have arrived.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartialBuffer {
    bytes: Vec<u8>,
    /// Runs of the buffer in the order of their starts, each with its offset in `bytes`.
    runs: Vec<(Range<u64>, u64)>,
}

/// The offset of a run in `PartialBuffer::bytes` is the same as in the whole buffer modulo this
/// number of bytes: no component is longer, so all stay aligned.
const ALIGN: u64 = 8;

impl PartialBuffer {
    /// A buffer of the runs whose bytes have arrived, one run after the other; the last may have
    /// arrived in part.
    pub(crate) fn new(runs: impl Iterator<Item = Range<u64>>, mut arrived: &[u8]) -> Self {
        let mut partial = Self::default();
        for run in runs {
            let length = arrived.len().min((run.end - run.start) as usize);
            if length == 0 {
                continue;
            }
            let (piece, rest) = arrived.split_at(length);
            arrived = rest;
            while partial.bytes.len() as u64 % ALIGN != run.start % ALIGN {
                partial.bytes.push(0);
            }
            let offset = partial.bytes.len() as u64;
            partial.runs.push((run.start..run.start + length as u64, offset));
            partial.bytes.extend_from_slice(piece);
        }
        partial.runs.sort_unstable_by_key(|(run, _)| run.start);
        partial
    }

    /// Returns the offset of bytes of the buffer among those that have arrived; none if some are
    /// missing.
    pub(super) fn find(&self, bytes: &Range<u64>) -> Option<u64> {
        let index = self.runs.partition_point(|(run, _)| run.start <= bytes.start);
        let (run, offset) = self.runs.get(index.checked_sub(1)?)?;
        (bytes.end <= run.end).then(|| offset + bytes.start - run.start)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}
