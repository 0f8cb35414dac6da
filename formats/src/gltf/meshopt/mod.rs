//! The compression of EXT_meshopt_compression and KHR_meshopt_compression, both ways. Source: the
//! published specification of the extension (bitstreams and filters). Decoding trusts no byte, and
//! encoding loses none.

mod filter;
mod index;
mod vertex;

use super::json::{Json, Object, malformed, object};
use crate::FormatError;
pub(crate) use filter::{packed_direction, unpacked_direction};

/// Contents of a compressed buffer view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Any data of a fixed stride.
    Attributes,
    /// Triangle lists.
    Triangles,
    /// Any sequence of indices.
    Indices,
}

/// Modes by their names in documents.
const MODES: [(&str, Mode); 3] =
    [("ATTRIBUTES", Mode::Attributes), ("TRIANGLES", Mode::Triangles), ("INDICES", Mode::Indices)];

/// Filter to apply to decoded attributes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Filter {
    /// Nothing.
    None,
    /// Unit vectors as two coordinates of an octahedron.
    Octahedral,
    /// Unit quaternions without their largest component.
    Quaternion,
    /// Floats as mantissa and exponent.
    Exponential,
    /// Colours as luma, two chroma and alpha (KHR only).
    Color,
}

/// Filters by their names in documents.
const FILTERS: [(&str, Filter); 5] = [
    ("NONE", Filter::None),
    ("OCTAHEDRAL", Filter::Octahedral),
    ("QUATERNION", Filter::Quaternion),
    ("EXPONENTIAL", Filter::Exponential),
    ("COLOR", Filter::Color),
];

/// How a buffer view is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Its contents.
    pub(crate) mode: Mode,
    /// Its filter.
    pub(crate) filter: Filter,
    /// Elements.
    pub(crate) count: usize,
    /// Bytes of an element.
    pub(crate) stride: usize,
}

impl Layout {
    /// Reads and checks what a view's extension says.
    pub(crate) fn read(packed: &Object, location: &str) -> Result<Self, FormatError> {
        let mode = packed.get("mode").and_then(Json::as_str);
        let filter = packed.get("filter").map_or(Some("NONE"), Json::as_str);
        let mode = MODES.iter().find(|(name, _)| Some(*name) == mode);
        let filter = FILTERS.iter().find(|(name, _)| Some(*name) == filter);
        let unknown = "`mode` is not one of ATTRIBUTES, TRIANGLES, INDICES";
        let layout = Self {
            mode: mode.ok_or_else(|| malformed(location, unknown))?.1,
            filter: filter.ok_or_else(|| malformed(location, "`filter` is unknown"))?.1,
            count: packed.required("count", location)? as usize,
            stride: packed.required("byteStride", location)? as usize,
        };
        layout.check().map_err(|problem| malformed(location, problem))?;
        Ok(layout)
    }

    /// The members of a view's extension, but for those that locate its bytes.
    pub(crate) fn json(&self) -> Json {
        let mode = MODES.iter().find(|(_, mode)| *mode == self.mode).map(|(name, _)| *name);
        let mut json =
            object! { "byteStride" => self.stride, "count" => self.count, "mode" => mode };
        if let Some((name, _)) = FILTERS[1..].iter().find(|(_, filter)| *filter == self.filter) {
            json["filter"] = (*name).into();
        }
        json
    }

    /// Returns whether mode, filter, stride and count go together.
    fn check(&self) -> Result<(), &'static str> {
        let stride_fits = match (self.mode, self.filter) {
            (Mode::Attributes, Filter::None | Filter::Exponential) => {
                self.stride > 0 && self.stride <= 256 && self.stride.is_multiple_of(4)
            }
            (Mode::Attributes, Filter::Octahedral | Filter::Color) => {
                self.stride == 4 || self.stride == 8
            }
            (Mode::Attributes, Filter::Quaternion) => self.stride == 8,
            (_, Filter::None) => self.stride == 2 || self.stride == 4,
            _ => return Err("a filter on indices"),
        };
        match self.mode {
            _ if !stride_fits => Err("the stride does not fit mode and filter"),
            Mode::Triangles if !self.count.is_multiple_of(3) => {
                Err("the count is not a multiple of 3")
            }
            _ => Ok(()),
        }
    }
}

/// Decodes one buffer view into `count * stride` bytes. The layout has been checked.
///
/// # Errors
/// Says what is wrong with the bytes.
pub(crate) fn decode(layout: &Layout, bytes: &[u8]) -> Result<Vec<u8>, &'static str> {
    match layout.mode {
        Mode::Attributes => {
            let mut out = vertex::decode(layout.count, layout.stride, bytes)?;
            filter::apply(layout.filter, layout.stride, &mut out);
            Ok(out)
        }
        Mode::Triangles => {
            index::triangles(layout.count, bytes).and_then(|i| narrowed(&i, layout.stride))
        }
        Mode::Indices => {
            index::sequence(layout.count, bytes).and_then(|i| narrowed(&i, layout.stride))
        }
    }
}

fn narrowed(indices: &[u32], stride: usize) -> Result<Vec<u8>, &'static str> {
    if stride == 2 && indices.iter().any(|&i| i > u32::from(u16::MAX)) {
        return Err("an index does not fit 16 bits");
    }
    Ok(indices.iter().flat_map(|i| i.to_le_bytes().into_iter().take(stride)).collect())
}

/// A buffer view to compress.
pub(crate) enum Content<'a> {
    /// Elements of a stride: a multiple of 4 up to 256.
    Attributes { stride: usize, bytes: &'a [u8] },
    /// Elements of floats, which may be multiples of powers of two.
    Floats { stride: usize, bytes: &'a [u8] },
    /// Unit vectors that may have been rounded to `bits` bits on an octahedron.
    Directions { bits: u8, stride: usize, bytes: &'a [u8] },
    /// Triangle lists of 2 or 4 bytes per index.
    Triangles { size: usize, bytes: &'a [u8] },
}

impl Content<'_> {
    /// Returns whether there is a codec for it.
    pub(crate) fn fits(&self) -> bool {
        match self {
            Self::Attributes { stride, bytes }
            | Self::Floats { stride, bytes }
            | Self::Directions { stride, bytes, .. } => {
                stride.is_multiple_of(4) && *stride <= 256 && bytes.len().is_multiple_of(*stride)
            }
            Self::Triangles { size, bytes } => bytes.len().is_multiple_of(3 * size),
        }
    }

    /// Returns the compressed bytes, and how they are laid out.
    pub(crate) fn encoded(&self) -> (Vec<u8>, Layout) {
        let (stride, bytes, filter, packed) = match *self {
            Self::Triangles { size, bytes } => return triangles(size, bytes),
            Self::Attributes { stride, bytes } => (stride, bytes, Filter::None, None),
            Self::Floats { stride, bytes } => {
                (stride, bytes, Filter::Exponential, filter::packed_floats(stride, bytes))
            }
            Self::Directions { bits, stride, bytes } => {
                (stride, bytes, Filter::Octahedral, filter::packed_directions(bits, stride, bytes))
            }
        };
        let count = bytes.len() / stride;
        let layout = |filter| Layout { mode: Mode::Attributes, filter, count, stride };
        let plain = vertex::encode(stride, bytes);
        // A filter is used where it can be and takes fewer bytes.
        match packed.map(|packed| vertex::encode(stride, &packed)) {
            Some(packed) if packed.len() < plain.len() => (packed, layout(filter)),
            _ => (plain, layout(Filter::None)),
        }
    }
}

fn triangles(size: usize, bytes: &[u8]) -> (Vec<u8>, Layout) {
    let read_index = |b: &[u8]| b.iter().rev().fold(0, |v, &b| v << 8 | u32::from(b));
    let indices: Vec<u32> = bytes.chunks_exact(size).map(read_index).collect();
    let (mode, filter, count) = (Mode::Triangles, Filter::None, indices.len());
    (index::encode(indices.as_chunks().0), Layout { mode, filter, count, stride: size })
}

#[cfg(test)]
mod tests;
