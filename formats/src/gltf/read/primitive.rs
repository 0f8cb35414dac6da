//! One primitive: which accessors it has, and its corners as triangles.

use crate::FormatError;
use crate::gltf::accessor::{Accessor, unsigned};
use crate::gltf::extension_table::DROPPED_FROM_PRIMITIVES;
use crate::gltf::extensions::DRACO;
use crate::gltf::json::{Json, Object, malformed};
use crate::gltf::semantic;
use crate::gltf::views::Views;
use lodc_mesh::{Component, Semantic};

/// A primitive that draws triangles.
#[derive(Debug)]
pub(super) struct Primitive {
    /// Its place in the document.
    pub(super) location: String,
    /// 4 list, 5 strip, 6 fan.
    mode: u64,
    indices: Option<usize>,
    /// The accessor of its positions.
    pub(super) position: usize,
    /// Everything but the positions at rest: meaning, morph target, accessor.
    pub(super) streams: Vec<Stream>,
}

/// Outcome of reading a primitive.
#[derive(Debug)]
pub(super) enum Read {
    /// It draws triangles.
    Triangles(Primitive),
    PointsOrLines,
    /// Triangles without positions: nothing is drawn.
    NoPosition,
}

/// Reads which accessors a primitive has, and checks that they can be what they are used for.
pub(super) fn read(
    object: &Object,
    location: String,
    accessors: &[Option<Accessor>],
) -> Result<Read, FormatError> {
    let mode = object.optional("mode", &location)?.unwrap_or(4);
    match mode {
        0..=3 => return Ok(Read::PointsOrLines),
        4..=6 => {}
        _ => {
            return Err(malformed(
                format!("{location}.mode"),
                format!("{mode} is not a mode from 0 to 6"),
            ));
        }
    }
    let attributes = object["attributes"].as_object();
    let attributes = attributes.ok_or_else(|| malformed(&*location, "has no `attributes`"))?;
    let Some(position) = attributes.get("POSITION").map(index) else { return Ok(Read::NoPosition) };
    let indices = object.get("indices").map(index);
    let mut streams = streams(object, attributes);
    check_streams(&streams, &location, accessors)?;
    // A mesh has its positions as floats anyway.
    streams.retain(|(s, target, a)| {
        *s != Semantic::Position || target.is_some() || !is_float(accessors, *a)
    });
    Ok(Read::Triangles(Primitive { location, mode, indices, position, streams }))
}

/// The index in a member; one that is out of any range if it is not an index.
fn index(value: &Json) -> usize {
    value.as_index().unwrap_or(usize::MAX)
}

/// A stream of values: its meaning, its morph target, its accessor.
type Stream = (Semantic, Option<u32>, usize);

/// The streams of a primitive's attributes and morph targets.
fn streams(primitive: &Object, attributes: &Object) -> Vec<Stream> {
    let stream =
        |(name, value): (&String, &Json), target| (semantic::from_name(name), target, index(value));
    let at_rest = attributes.iter().map(|entry| stream(entry, None));
    let targets = (0..).zip(primitive.list("targets"));
    let moved = targets.flat_map(|(t, target)| {
        let entries = target.as_object().into_iter().flat_map(|members| members.iter());
        entries.map(move |entry| stream(entry, Some(t)))
    });
    at_rest.chain(moved).collect()
}

/// Checks that accessors can be what they are used for, and that all have the same number of
/// elements.
fn check_streams(
    streams: &[Stream],
    location: &str,
    accessors: &[Option<Accessor>],
) -> Result<(), FormatError> {
    let mut count = None;
    for (semantic, target, accessor) in streams {
        let name = semantic::to_name(semantic);
        let location = || match target {
            None => format!("{location}.attributes.{name}"),
            Some(t) => format!("{location}.targets[{t}].{name}"),
        };
        let a = accessors.get(*accessor).and_then(Option::as_ref);
        let a = a.ok_or_else(|| malformed(location(), "the accessor has an unknown type"))?;
        if !semantic::accepts(semantic, target.is_some(), a) {
            return Err(malformed(location(), "the accessor's type does not fit"));
        }
        if *count.get_or_insert(a.count) != a.count {
            return Err(malformed(
                location(),
                format!("has {} elements where others have {}", a.count, count.unwrap_or(0)),
            ));
        }
    }
    Ok(())
}

/// Returns whether an accessor holds floats.
fn is_float(accessors: &[Option<Accessor>], accessor: usize) -> bool {
    accessors.get(accessor).and_then(Option::as_ref).is_some_and(|a| a.component == Component::F32)
}

impl Primitive {
    /// The vertices of its corners, one after another, each below `vertices`.
    pub(super) fn corners(
        &self,
        vertices: usize,
        accessors: &[Option<Accessor>],
        views: &Views<'_>,
    ) -> Result<Vec<u32>, FormatError> {
        let location = || format!("{}.indices", self.location);
        let end = u32::try_from(vertices).expect("accessors are smaller");
        let Some(index) = self.indices else {
            views.budget.charge(vertices as u64, 4, &self.location)?;
            return Ok((0..end).collect());
        };
        let accessor = accessors.get(index).and_then(Option::as_ref);
        let accessor = accessor.filter(|a| {
            a.shape.components() == 1
                && matches!(a.component, Component::U8 | Component::U16 | Component::U32)
                && !a.normalized
        });
        let accessor = accessor
            .ok_or_else(|| malformed(location(), "must be a SCALAR of unsigned integers"))?;
        let reader = accessor.reader(views)?;
        views.budget.charge(accessor.count as u64, 4, &self.location)?;
        let size = accessor.component.size();
        let restart = u32::MAX >> (32 - 8 * size);
        let mut corners = Vec::with_capacity(accessor.count);
        let mut bytes = Vec::with_capacity(4);
        for i in 0..accessor.count {
            bytes.clear();
            reader.append(i as u32, &mut bytes);
            let v = unsigned(&bytes);
            // In a list of triangles nothing could restart: there it can only be a vertex.
            if v == restart && !(self.mode == 4 && v < end) {
                return Err(malformed(
                    location(),
                    format!("element {i} is {v}, which glTF reserves for restarts"),
                ));
            }
            if v >= end {
                return Err(malformed(
                    location(),
                    format!("element {i} is {v}, but there are {end} vertices"),
                ));
            }
            corners.push(v);
        }
        Ok(corners)
    }

    /// Number of triangles that this many corners make.
    pub(super) const fn triangle_count(&self, corners: usize) -> usize {
        match self.mode {
            4 => corners / 3,
            _ => corners.saturating_sub(2),
        }
    }

    /// The triangles that corners make, wound as glTF 2.0, 3.7.2.1 has it.
    pub(super) fn triangles(&self, corners: &[u32], mut visit: impl FnMut([u32; 3])) {
        match self.mode {
            4 => corners.chunks_exact(3).for_each(|c| visit([c[0], c[1], c[2]])),
            5 => corners.windows(3).enumerate().for_each(|(i, c)| {
                // Every other triangle of a strip is turned over.
                let odd = i % 2;
                visit([c[0], c[1 + odd], c[2 - odd]]);
            }),
            _ => corners.windows(2).skip(1).for_each(|c| visit([c[0], c[1], corners[0]])),
        }
    }
}

/// Takes the geometry of a primitive out of the document; of morph targets empty objects stay.
/// Returns whether outlines or n-gons were dropped, which name the old triangles.
pub(super) fn strip(object: &mut Object) -> bool {
    object["attributes"] = Json::Object(Object::default());
    object.shift_remove("indices");
    object.shift_remove("mode");
    for target in object.get_mut("targets").and_then(Json::as_array_mut).into_iter().flatten() {
        *target = Json::Object(Object::default());
    }
    let mut had_outlines = false;
    for name in DROPPED_FROM_PRIMITIVES {
        had_outlines |= name != DRACO && object.extension(name).is_some();
        object.remove_extension(name);
    }
    had_outlines
}
