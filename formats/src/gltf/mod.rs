//! Import and export of glTF 2.0 and GLB files.
//!
//! The document stays a tree of JSON values, so that everything that is not a triangle comes out as
//! it went in; what is read from it is checked against a table (`schema`) first, and accessors,
//! buffer views and buffers are read as types of the package `gltf` (`typed`). Limits of what
//! external bytes can do: JSON nesting and size (`json`), paths (`uri`, [`Assets`](crate::Assets)),
//! ranges (`views`, `accessor`), memory in all (`budget`).
//!
//! `read` makes objects and a document of a file, `write` puts levels back into it; `loose` reads
//! points and lines, `missing` and `buffer_runs` serve streams.

#[cfg(feature = "gltf")]
mod accessor;
#[cfg(feature = "gltf")]
mod animations;
#[cfg(feature = "import")]
mod appearance;
#[cfg(feature = "gltf")]
mod budget;
#[cfg(feature = "stream")]
mod buffer_runs;
#[cfg(feature = "gltf")]
mod coordinates;
#[cfg(feature = "import")]
mod difference;
#[cfg(feature = "gltf")]
mod document;
mod extension_table;
mod extensions;
#[cfg(feature = "export")]
mod floats;
#[cfg(any(feature = "import", feature = "export"))]
mod glb;
#[cfg(feature = "gltf")]
mod graph;
#[cfg(feature = "export")]
mod images;
mod json;
#[cfg(feature = "export")]
mod loose;
#[cfg(feature = "gltf")]
mod material_names;
#[cfg(feature = "export")]
mod materials;
#[cfg(feature = "gltf")]
mod meshopt;
#[cfg(feature = "stream")]
mod missing;
#[cfg(feature = "gltf")]
mod part_names;
mod pool;
mod prune;
#[cfg(feature = "export")]
mod quantize;
#[cfg(feature = "import")]
pub(crate) mod read;
mod schema;
#[cfg(any(feature = "import", feature = "export"))]
mod semantic;
#[cfg(feature = "gltf")]
mod texture_transform;
#[cfg(feature = "gltf")]
mod typed;
#[cfg(feature = "gltf")]
mod uri;
#[cfg(feature = "gltf")]
mod views;
#[cfg(feature = "export")]
pub(crate) mod write;

#[cfg(feature = "gltf")]
pub use animations::{animation, animation_names, scene_motion};
#[cfg(feature = "import")]
pub(crate) use appearance::appearance;
#[cfg(feature = "stream")]
pub(crate) use buffer_runs::{BufferRun, PartialBuffer, Purpose, buffer_runs};
#[cfg(feature = "gltf")]
pub(crate) use coordinates::coordinates;
#[cfg(feature = "import")]
pub(crate) use difference::difference;
#[cfg(feature = "gltf")]
pub use graph::scene_graph;
#[cfg(feature = "export")]
pub(crate) use images::{add_embedded, image_names, read_textures};
#[cfg(feature = "export")]
pub(crate) use loose::loose;
#[cfg(feature = "gltf")]
pub(crate) use material_names::materials;
#[cfg(feature = "export")]
pub(crate) use materials::library;
#[cfg(feature = "stream")]
pub(crate) use missing::{bare_gltf, gltf_without_missing};
#[cfg(feature = "gltf")]
pub use part_names::PartNames;
#[cfg(feature = "export")]
pub use write::{
    ChainObject, ChainShape, Geomorph, LevelsObject, MovedStreams, embed_images, export_chain,
    export_levels,
};
