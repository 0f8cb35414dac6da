//! glTF 2.0 and GLB.
//!
//! The document stays a tree of JSON values, so that everything that is not a triangle comes out as
//! it went in; what is read from it is checked against a table (`schema`) first, and accessors,
//! buffer views and buffers are read as types of the package `gltf` (`typed`). Limits of what
//! external bytes can do: JSON nesting and size (`json`), paths (`uri`, [`Assets`](crate::Assets)),
//! ranges (`views`, `accessor`), memory in all (`budget`).

mod accessor;
mod animations;
mod appearance;
mod budget;
mod document;
mod extensions;
mod floats;
mod glb;
mod graph;
mod images;
mod json;
mod materials;
mod meshopt;
mod missing;
mod part_names;
mod quantize;
pub(crate) mod read;
mod schema;
mod semantic;
mod typed;
mod uri;
mod views;
pub(crate) mod write;

pub use animations::{animation, animation_names};
pub(crate) use appearance::appearance;
pub use graph::scene_graph;
pub(crate) use images::{add_embedded, read_textures};
pub(crate) use materials::library;
pub(crate) use missing::{bare_gltf, gltf_without_missing};
pub use part_names::PartNames;
pub use write::{ChainObject, ChainShape, LevelsObject, export_chain, export_levels};
