//! The compression of EXT_meshopt_compression and KHR_meshopt_compression, decoded. Source: the
//! published specification of the extension (bitstream and filters); nothing here trusts a byte.

mod filter;
mod index;
pub(crate) mod recent;
mod vertex;

pub(crate) use filter::apply as unfiltered;

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

/// A compressed buffer view, its bytes apart.
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
    /// Returns whether mode, filter, stride and count go together.
    pub(crate) fn check(&self) -> Result<(), &'static str> {
        let stride = match (self.mode, self.filter) {
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
            _ if !stride => Err("the stride does not fit mode and filter"),
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

#[cfg(test)]
mod tests;
