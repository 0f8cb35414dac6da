//! What files are opened and built from: a path, bytes, a reader, or a mesh of arrays.

use lodc_formats::{Fault, FormatError};
use lodc_mesh::{Attribute, MeshParts};
use std::borrow::Cow;
use std::ffi::{OsStr, OsString};
use std::fmt;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Where a file comes from. Paths and bytes become one by themselves; a reader does by
/// [`Self::reader`].
///
/// ```
/// # std::env::set_current_dir("../../fixtures/golden/v1")?;
/// let by_path = lodc::open("two_parts.lodc")?;
/// let by_bytes = lodc::open(std::fs::read("two_parts.lodc")?)?;
/// let by_reader = lodc::open(lodc::Source::reader(std::fs::File::open("two_parts.lodc")?))?;
/// assert_eq!(by_path.triangles(), by_bytes.triangles());
/// assert_eq!(by_path.triangles(), by_reader.triangles());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[non_exhaustive]
pub enum Source<'a> {
    /// A file. Those that it names are looked for beside it.
    Path(Cow<'a, Path>),
    /// The bytes of a file. Files that it names are not there: nothing says where.
    Bytes(Cow<'a, [u8]>),
    /// The bytes that a reader gives, to its end.
    Reader(Box<dyn Read + 'a>),
    /// A mesh of arrays, which `lodc::build` takes.
    Mesh(Box<MeshParts>),
}

impl<'a> Source<'a> {
    /// Everything that a reader gives.
    #[must_use]
    pub fn reader(reader: impl Read + 'a) -> Self {
        Self::Reader(Box::new(reader))
    }

    /// A mesh: triangles are indices of `positions`, counter-clockwise from outside; attributes
    /// have a value for each position. Degenerate triangles and unused vertices are left out.
    #[must_use]
    pub fn arrays(
        positions: impl Into<Vec<[f32; 3]>>,
        triangles: impl Into<Vec<[u32; 3]>>,
        attributes: Vec<Attribute>,
    ) -> Self {
        MeshParts::of_arrays(positions.into(), triangles.into(), attributes).into()
    }

    /// The path of a file; `-` of everything else, which has none.
    pub(crate) fn path(&self) -> PathBuf {
        match self {
            Self::Path(path) => path.to_path_buf(),
            _ => PathBuf::from("-"),
        }
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// If they cannot be read, or it is a mesh. The error names the file, if it has a name.
    pub(crate) fn bytes(self) -> Result<Cow<'a, [u8]>, FormatError> {
        let unreadable = |e: io::Error| FormatError::new(Fault::Unreadable, "", e.to_string());
        match self {
            Self::Path(path) => {
                let bytes = std::fs::read(&path).map_err(unreadable);
                bytes.map(Cow::Owned).map_err(|e| e.in_file(&path.display().to_string()))
            }
            Self::Bytes(bytes) => Ok(bytes),
            Self::Reader(mut reader) => {
                let mut bytes = Vec::new();
                reader.read_to_end(&mut bytes).map_err(unreadable)?;
                Ok(Cow::Owned(bytes))
            }
            Self::Mesh(_) => {
                let problem = "a mesh, not a .lodc file: lodc::build makes one";
                Err(FormatError::new(Fault::Unsupported, "", problem))
            }
        }
    }
}

impl fmt::Debug for Source<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Path(path) => f.debug_tuple("Path").field(path).finish(),
            Self::Bytes(bytes) => write!(f, "Bytes({})", bytes.len()),
            Self::Reader(_) => f.write_str("Reader"),
            Self::Mesh(mesh) => write!(f, "Mesh({} triangles)", mesh.triangles.len()),
        }
    }
}

macro_rules! from_path {
    ($($borrowed:ty),*; $($owned:ty),*) => {
        $(impl<'a> From<&'a $borrowed> for Source<'a> {
            fn from(path: &'a $borrowed) -> Self {
                Self::Path(Cow::Borrowed(path.as_ref()))
            }
        })*
        $(impl From<$owned> for Source<'_> {
            fn from(path: $owned) -> Self {
                Self::Path(Cow::Owned(path.into()))
            }
        })*
    };
}
from_path!(str, String, Path, PathBuf, OsStr, OsString; String, PathBuf, OsString);

impl<'a> From<&'a [u8]> for Source<'a> {
    fn from(bytes: &'a [u8]) -> Self {
        Self::Bytes(Cow::Borrowed(bytes))
    }
}

impl<'a, const N: usize> From<&'a [u8; N]> for Source<'a> {
    fn from(bytes: &'a [u8; N]) -> Self {
        Self::Bytes(Cow::Borrowed(bytes))
    }
}

impl<'a> From<&'a Vec<u8>> for Source<'a> {
    fn from(bytes: &'a Vec<u8>) -> Self {
        Self::Bytes(Cow::Borrowed(bytes))
    }
}

impl From<Vec<u8>> for Source<'_> {
    fn from(bytes: Vec<u8>) -> Self {
        Self::Bytes(Cow::Owned(bytes))
    }
}

impl From<MeshParts> for Source<'_> {
    fn from(mesh: MeshParts) -> Self {
        Self::Mesh(Box::new(mesh))
    }
}

#[cfg(all(test, feature = "build"))]
#[path = "source_tests.rs"]
mod tests;
