//! Samples of animations and matrices of skins, taken out of the bytes of the document so that they
//! can be compressed: likes in one buffer view, equal ones once.

use crate::gltf::json::{Object, entries, integer, list};
use crate::gltf::schema::{Pool, references};
use lodc_mesh::Component;
use serde_json::Value;
use std::collections::BTreeMap;
use std::ops::Range;

const FLOAT: u64 = 5126;

/// Accessors of one meaning and layout.
#[derive(Debug)]
pub(super) struct Samples {
    /// Name of what moves; times and matrices have names of their own.
    name: String,
    pub(super) stride: usize,
    pub(super) bytes: Vec<u8>,
    /// Accessors, with their places in `bytes`.
    accessors: Vec<(usize, usize)>,
    /// The place of each content.
    places: BTreeMap<Vec<u8>, usize>,
}

/// Finds all accessors of floats that nothing but animations and skins refers to.
pub(super) fn of(root: &mut Object, blob: &[u8]) -> Vec<Samples> {
    let mut uses = vec![0; Pool::Accessors.len(root)];
    references(root, Pool::Accessors, &mut |value, _| {
        if let Some(count) = integer(value).and_then(|a| uses.get_mut(a as usize)) {
            *count += 1;
        }
    });
    let mut names: BTreeMap<usize, (String, usize)> = BTreeMap::new();
    for (accessor, name) in named(root) {
        names.entry(accessor).or_insert((name, 0)).1 += 1;
    }
    let mut all: Vec<Samples> = Vec::new();
    for (accessor, (name, count)) in names {
        let Some((stride, bytes)) = floats(root, blob, accessor) else { continue };
        if uses.get(accessor) != Some(&count) {
            continue;
        }
        let same = |s: &Samples| s.name == name && s.stride == stride;
        let i = all.iter().position(same).unwrap_or_else(|| {
            let (bytes, accessors, places) = (vec![], vec![], BTreeMap::new());
            all.push(Samples { name, stride, bytes, accessors, places });
            all.len() - 1
        });
        let samples = &mut all[i];
        let place = *samples.places.entry(bytes).or_insert_with_key(|bytes| {
            samples.bytes.extend_from_slice(bytes);
            samples.bytes.len() - bytes.len()
        });
        samples.accessors.push((accessor, place));
    }
    all
}

/// The accessors of animations and skins, once for each reference, and what they say.
fn named(root: &Object) -> Vec<(usize, String)> {
    let index = |value: Option<&Value>| value.and_then(integer).map(|i| i as usize);
    let mut found = Vec::new();
    for animation in entries(root, "animations") {
        let channels = list(animation, "channels");
        for (s, sampler) in list(animation, "samplers").iter().enumerate() {
            let of_sampler = |c: &&Value| c.get("sampler").and_then(integer) == Some(s as u64);
            let channel = channels.iter().find(of_sampler);
            let path = channel.and_then(|c| c["target"]["path"].as_str()).unwrap_or("other");
            found.extend(index(sampler.get("input")).map(|a| (a, "times".to_owned())));
            found.extend(index(sampler.get("output")).map(|a| (a, path.to_owned())));
        }
    }
    for skin in entries(root, "skins") {
        let matrices = index(skin.get("inverseBindMatrices"));
        found.extend(matrices.map(|a| (a, "matrices".to_owned())));
    }
    found
}

/// The size of an element of an accessor, and its elements without gaps.
fn floats(root: &Object, blob: &[u8], accessor: usize) -> Option<(usize, Vec<u8>)> {
    let accessor = entries(root, "accessors").nth(accessor)?;
    let number = |object: &Object, key: &str| match object.get(key) {
        None => Some(0),
        Some(value) => integer(value).and_then(|n| usize::try_from(n).ok()),
    };
    let is_float = accessor.get("componentType").and_then(integer) == Some(FLOAT);
    if !is_float || accessor.contains_key("sparse") {
        return None;
    }
    let view = accessor.get("bufferView").and_then(integer)?;
    let view = entries(root, "bufferViews").nth(usize::try_from(view).ok()?)?;
    let bytes = blob.get(range(view)?)?;
    let components = match accessor.get("type").and_then(Value::as_str)? {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        "MAT4" => 16,
        _ => return None,
    };
    let size = components * Component::F32.size();
    let stride = Some(number(view, "byteStride")?).filter(|&s| s > 0).unwrap_or(size);
    let (first, count) = (number(accessor, "byteOffset")?, number(accessor, "count")?);
    let element = |i: usize| {
        let start = i.checked_mul(stride)?.checked_add(first)?;
        bytes.get(start..start.checked_add(size)?)
    };
    element(count.checked_sub(1)?)?;
    let elements: Option<Vec<&[u8]>> = (0..count).map(element).collect();
    Some((size, elements?.concat()))
}

/// The bytes of a view of the first buffer; none if they are elsewhere.
fn range(view: &Object) -> Option<Range<usize>> {
    let number = |key: &str| match view.get(key) {
        None => Some(0),
        Some(value) => integer(value).and_then(|n| usize::try_from(n).ok()),
    };
    if number("buffer")? != 0 || view.contains_key("extensions") {
        return None;
    }
    let (start, length) = (number("byteOffset")?, number("byteLength")?);
    Some(start..start.checked_add(length)?)
}

impl Samples {
    /// Makes their accessors refer to the view that these samples are in.
    pub(super) fn refer(&self, root: &mut Object, view: usize) {
        let Some(Value::Array(accessors)) = root.get_mut("accessors") else { return };
        for &(accessor, place) in &self.accessors {
            let Some(accessor) = accessors[accessor].as_object_mut() else { continue };
            accessor.insert("bufferView".to_owned(), view.into());
            accessor.shift_remove("byteOffset");
            if place > 0 {
                accessor.insert("byteOffset".to_owned(), place.into());
            }
        }
    }
}

/// Returns which of the first `count` views something refers to.
pub(super) fn used(root: &mut Object, count: usize) -> Vec<bool> {
    let mut used = vec![false; count];
    references(root, Pool::BufferViews, &mut |value, _| {
        if let Some(used) = integer(value).and_then(|v| used.get_mut(v as usize)) {
            *used = true;
        }
    });
    used
}

/// Drops the bytes that only unused views had. Does nothing if a view is not of the first buffer.
pub(super) fn drop_unused(root: &mut Object, blob: &mut Vec<u8>, used: &[bool]) {
    let ranges: Option<Vec<Range<usize>>> = entries(root, "bufferViews").map(range).collect();
    let Some(ranges) = ranges else { return };
    let mut kept: Vec<Range<usize>> =
        ranges.iter().zip(used).filter(|(_, used)| **used).map(|(r, _)| r.clone()).collect();
    kept.sort_unstable_by_key(|r| (r.start, r.end));
    let mut bytes = Vec::with_capacity(blob.len());
    // Where views that overlap or touch begin, there and here.
    let mut runs: Vec<(Range<usize>, usize)> = Vec::new();
    for range in kept {
        match runs.last_mut() {
            Some((run, _)) if range.start <= run.end => run.end = run.end.max(range.end),
            _ => runs.push((range, 0)),
        }
    }
    for (run, to) in &mut runs {
        let Some(content) = blob.get(run.clone()) else { return };
        bytes.resize(bytes.len().next_multiple_of(4) + run.start % 4, 0);
        *to = bytes.len();
        bytes.extend_from_slice(content);
    }
    let Some(Value::Array(views)) = root.get_mut("bufferViews") else { return };
    for ((view, range), _) in views.iter_mut().zip(&ranges).zip(used).filter(|(_, used)| **used) {
        let run = runs.partition_point(|(run, _)| run.start <= range.start) - 1;
        view["byteOffset"] = (runs[run].1 + range.start - runs[run].0.start).into();
    }
    *blob = bytes;
}
