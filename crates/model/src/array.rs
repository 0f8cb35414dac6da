//! Arrays that models give to files: named runs of bytes, and their errors.

use std::fmt;

/// A named run of bytes that a model needs besides the mesh and the sequence. Numbers in it are
/// little-endian.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Array {
    /// Its name, unique within the model.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Why a model cannot be made of a sequence, or of what was stored.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// A triangle stands behind one that disappears before it.
    TriangleOrder {
        /// The submesh of both.
        submesh: usize,
        /// The triangle, as an index into the mesh.
        triangle: usize,
    },
    /// A stored array does not fit the mesh, the sequence or itself.
    Malformed {
        /// Name of the array.
        array: &'static str,
        /// The fault.
        what: String,
    },
    /// The stored arrays are not the ones that the model has.
    Arrays {
        /// Names of the arrays given.
        given: Vec<String>,
    },
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TriangleOrder { submesh, triangle } => {
                write!(f, "triangle {triangle} of submesh {submesh} stands behind one ")?;
                f.write_str("that disappears before it")
            }
            Self::Malformed { array, what } => write!(f, "the array \"{array}\" {what}"),
            Self::Arrays { given } => {
                write!(f, "the model does not have the arrays [{}]", given.join(", "))
            }
        }
    }
}

impl std::error::Error for BuildError {}
