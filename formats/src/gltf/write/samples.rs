//! Takes animation samples and inverse bind matrices out of a document's buffer, so that they can
//! be compressed: accessors of one kind share a buffer view, and equal ones are stored once.

use crate::gltf::floats::{Floats, range};
use crate::gltf::json::{Json, Object};
use crate::gltf::schema::{Pool, references};
use std::collections::BTreeMap;
use std::ops::Range;

/// Accessors of one meaning and layout.
#[derive(Debug)]
pub(super) struct Samples {
    /// Name of what moves; times and matrices have names of their own.
    name: String,
    pub(super) stride: usize,
    pub(super) bytes: Vec<u8>,
    /// Accessors, with their offsets in `bytes`.
    accessors: Vec<(usize, usize)>,
    /// The offset in `bytes` of each accessor's content, so that equal ones are stored once.
    offsets: BTreeMap<Vec<u8>, usize>,
}

/// Finds all accessors of floats that nothing but animations and skins refers to.
pub(super) fn of(root: &mut Object, blob: &[u8]) -> Vec<Samples> {
    let mut uses = vec![0; Pool::Accessors.len(root)];
    references(root, Pool::Accessors, &mut |value, _| {
        if let Some(count) = value.as_index().and_then(|a| uses.get_mut(a)) {
            *count += 1;
        }
    });
    let mut names: BTreeMap<usize, (String, usize)> = BTreeMap::new();
    for (accessor, name) in named(root) {
        names.entry(accessor).or_insert((name, 0)).1 += 1;
    }
    let mut all: Vec<Samples> = Vec::new();
    for (accessor, (name, count)) in names {
        if uses.get(accessor) != Some(&count) {
            continue;
        }
        let Some(floats) = Floats::of(root, accessor) else { continue };
        let elements: Option<Vec<&[u8]>> =
            floats.byte_ranges().map(|range| blob.get(range)).collect();
        let (stride, Some(bytes)) = (floats.size, elements.map(|e| e.concat())) else { continue };
        let same_kind = |s: &Samples| s.name == name && s.stride == stride;
        let i = all.iter().position(same_kind).unwrap_or_else(|| {
            let (bytes, accessors, offsets) = (vec![], vec![], BTreeMap::new());
            all.push(Samples { name, stride, bytes, accessors, offsets });
            all.len() - 1
        });
        let samples = &mut all[i];
        let offset = *samples.offsets.entry(bytes).or_insert_with_key(|bytes| {
            samples.bytes.extend_from_slice(bytes);
            samples.bytes.len() - bytes.len()
        });
        samples.accessors.push((accessor, offset));
    }
    all
}

/// The accessors of animations and skins, once for each reference, with the names of their kinds.
fn named(root: &Object) -> Vec<(usize, String)> {
    let mut named_accessors = Vec::new();
    for animation in root.entries("animations") {
        let channels = animation.list("channels");
        // A sampler is named by the first channel that uses it.
        let mut paths: BTreeMap<usize, &Json> = BTreeMap::new();
        for channel in channels {
            if let Some(sampler) = channel["sampler"].as_index() {
                paths.entry(sampler).or_insert(&channel["target"]["path"]);
            }
        }
        for (s, sampler) in animation.list("samplers").iter().enumerate() {
            let path = paths.get(&s).and_then(|path| path.as_str()).unwrap_or("other");
            named_accessors.extend(sampler["input"].as_index().map(|a| (a, "times".to_owned())));
            named_accessors.extend(sampler["output"].as_index().map(|a| (a, path.to_owned())));
        }
    }
    for skin in root.entries("skins") {
        let matrices = skin["inverseBindMatrices"].as_index();
        named_accessors.extend(matrices.map(|a| (a, "matrices".to_owned())));
    }
    named_accessors
}

impl Samples {
    /// Makes their accessors refer to the view that these samples are in.
    pub(super) fn refer_to(&self, root: &mut Object, view: usize) {
        let Some(Json::Array(accessors)) = root.get_mut("accessors") else { return };
        for &(accessor, offset) in &self.accessors {
            let Some(accessor) = accessors[accessor].as_object_mut() else { continue };
            accessor["bufferView"] = view.into();
            accessor.shift_remove("byteOffset");
            if offset > 0 {
                accessor["byteOffset"] = offset.into();
            }
        }
    }
}

/// Drops the bytes that only unused views had. Does nothing if a view is not of the first buffer.
pub(super) fn drop_unused(root: &mut Object, blob: &mut Vec<u8>, used: &[bool]) {
    let ranges: Option<Vec<Range<usize>>> = root.entries("bufferViews").map(range).collect();
    let Some(ranges) = ranges else { return };
    let mut used_ranges: Vec<Range<usize>> =
        ranges.iter().zip(used).filter(|(_, used)| **used).map(|(r, _)| r.clone()).collect();
    used_ranges.sort_unstable_by_key(|r| (r.start, r.end));
    let mut bytes = Vec::with_capacity(blob.len());
    // Runs of views that overlap or touch, each with its offset in `bytes`.
    let mut runs: Vec<(Range<usize>, usize)> = Vec::new();
    for range in used_ranges {
        match runs.last_mut() {
            Some((run, _)) if range.start <= run.end => run.end = run.end.max(range.end),
            _ => runs.push((range, 0)),
        }
    }
    for (run, offset) in &mut runs {
        let Some(content) = blob.get(run.clone()) else { return };
        bytes.resize(bytes.len().next_multiple_of(4) + run.start % 4, 0);
        *offset = bytes.len();
        bytes.extend_from_slice(content);
    }
    let Some(Json::Array(views)) = root.get_mut("bufferViews") else { return };
    for ((view, range), _) in views.iter_mut().zip(&ranges).zip(used).filter(|(_, used)| **used) {
        let (run, offset) = &runs[runs.partition_point(|(run, _)| run.start <= range.start) - 1];
        view["byteOffset"] = (offset + range.start - run.start).into();
    }
    *blob = bytes;
}
