//! The image files that a document names: read beside the asset, and given a place in or beside an
//! export, so that a model that moves to another folder keeps its textures.

mod kind;
pub(crate) mod map_line;
mod place;
mod read;
#[cfg(test)]
mod tests;

pub(crate) use kind::{extension_of, mime_of};
pub(crate) use place::Place;
pub use place::{PlacedTextures, TextureMode};
pub use read::Textures;
pub(crate) use read::embedded_name;
