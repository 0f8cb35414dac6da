//! Images as files: PNG and JPEG in, PNG out, and the places of those that a document names.

mod decode;
mod encode;
mod pictures;
mod place;
#[cfg(test)]
mod tests;

pub use decode::decode;
pub use encode::png;
pub(crate) use pictures::Pictures;
pub(crate) use place::{Place, embedded_name};
pub use place::{PlacedTextures, TextureMode, Textures};
