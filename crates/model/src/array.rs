//! The arrays that a model stores in files besides the mesh and the collapse sequence, and the
//! errors of building a model from them.

/// Width of the numbers in stored arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Layout {
    /// The fewest bytes that hold the largest number.
    #[default]
    Packed,
    /// A `u32` each where a graphics device uses them, so that nothing has to be unpacked.
    Gpu,
}

impl Layout {
    /// All layouts.
    pub const ALL: [Self; 2] = [Self::Packed, Self::Gpu];

    /// The name in options and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Packed => "packed",
            Self::Gpu => "gpu",
        }
    }

    /// One line of help.
    #[must_use]
    pub const fn help(self) -> &'static str {
        match self {
            Self::Packed => "Numbers of as few bytes as hold them",
            Self::Gpu => "Indices, targets and strips as u32, aligned: uploaded as they are",
        }
    }

    /// Bytes of each number below `count`: 1 to 4.
    #[must_use]
    pub fn width(self, count: usize) -> usize {
        match self {
            Self::Packed => crate::bytes::width(count),
            Self::Gpu => 4,
        }
    }
}

/// A named run of bytes that a model needs besides the mesh and the sequence. Numbers in it are
/// little-endian.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Array {
    /// Its name, unique within the model.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
    /// True if each number in it is a `u32`.
    pub wide: bool,
}

/// Why a model cannot be made of a sequence, or of what was stored.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// A triangle comes after one that disappears before it.
    #[error("triangle {triangle} of submesh {submesh} comes after one that disappears before it")]
    TriangleOrder {
        /// The submesh of both.
        submesh: usize,
        /// The triangle, as an index into the mesh.
        triangle: usize,
    },
    /// A stored array does not fit the mesh, the sequence or itself.
    #[error("the array \"{array}\" {what}")]
    Malformed {
        /// Name of the array.
        array: &'static str,
        /// The fault.
        what: String,
    },
    /// The stored arrays are not the ones that the model has.
    #[error("the model does not have the arrays [{}]", given.join(", "))]
    Arrays {
        /// Names of the arrays given.
        given: Vec<String>,
    },
}
