//! Finds the bytes of float accessors in buffer 0 of a document that has been checked, so that
//! writers can change or compress them where they lie.

use super::accessor::{Shape, component_number};
use super::json::{Json, Object};
use lodc_mesh::Component;
use std::ops::Range;

/// The byte ranges of an accessor's elements in the document's bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Floats {
    /// Offset of the first element.
    first: usize,
    stride: usize,
    count: usize,
    /// Bytes of an element.
    pub(super) size: usize,
}

impl Floats {
    /// Finds the elements of an accessor; none if it has other components, is sparse, or its bytes
    /// are elsewhere or compressed.
    pub(super) fn of(root: &Object, accessor: usize) -> Option<Self> {
        let accessor = root["accessors"][accessor].as_object()?;
        let view = root["bufferViews"][accessor["bufferView"].as_index()?].as_object()?;
        let float = u64::from(component_number(Component::F32));
        if accessor["componentType"].as_u64() != Some(float) || accessor.contains_key("sparse") {
            return None;
        }
        let range = range(view)?;
        let size = Shape::named(accessor["type"].as_str()?)?.components() * Component::F32.size();
        let stride = Some(number(view, "byteStride", size)?).filter(|&s| s > 0).unwrap_or(size);
        let first = range.start.checked_add(number(accessor, "byteOffset", 0)?)?;
        let count = number(accessor, "count", 0)?;
        let last = count.checked_sub(1)?.checked_mul(stride)?.checked_add(first)?;
        let fits = last.checked_add(size)? <= range.end;
        fits.then_some(Self { first, stride, count, size })
    }

    /// The bytes of each element.
    pub(super) fn byte_ranges(self) -> impl Iterator<Item = Range<usize>> {
        let offset = move |i: usize| self.first + i * self.stride;
        (0..self.count).map(move |i| offset(i)..offset(i) + self.size)
    }
}

/// The bytes of a view of the first buffer; none if they are elsewhere.
pub(super) fn range(view: &Object) -> Option<Range<usize>> {
    if number(view, "buffer", 0)? != 0 || view.contains_key("extensions") {
        return None;
    }
    let (start, length) = (number(view, "byteOffset", 0)?, number(view, "byteLength", 0)?);
    Some(start..start.checked_add(length)?)
}

fn number(object: &Object, key: &str, default: usize) -> Option<usize> {
    object.get(key).map_or(Some(default), Json::as_index)
}
