//! Image files: PNG and JPEG decoded, PNG encoded, and the files that a document names copied
//! beside or into an export.

#[cfg(feature = "import")]
mod decode;
#[cfg(feature = "import")]
mod encode;
#[cfg(feature = "import")]
mod pictures;
#[cfg(feature = "export")]
mod place;
#[cfg(all(test, feature = "import"))]
mod tests;

#[cfg(feature = "import")]
pub use decode::decode;
#[cfg(feature = "import")]
use decode::decode_if;
#[cfg(feature = "import")]
pub use encode::png;
#[cfg(feature = "import")]
pub(crate) use pictures::Pictures;
#[cfg(all(feature = "import", feature = "export"))]
pub(crate) use place::kind;
#[cfg(feature = "export")]
pub(crate) use place::{ImagePlace, embedded_name};
#[cfg(feature = "export")]
pub use place::{PlacedTextures, TextureMode, Textures};
