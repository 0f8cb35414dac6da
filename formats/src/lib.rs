//! Every external byte of lodc: meshes in and out, the `.lodc` container and the `.lods` stream.
//!
//! Nothing outside this package parses or writes files. It knows no model: a file has their arrays
//! under the names of their kinds ([`lodc::StoredModel`]). Each format has a room: [`gltf`], [`obj`],
//! `ply`, [`images`], [`lodc`] and [`lods`]; what they share stands beside them, and [`import`],
//! [`export`], [`appearance`](fn@appearance) and [`images::Textures`] choose among them. No format
//! uses what chooses, and its reader and writer do not use each other.

mod appearance;
mod assets;
mod error;
pub mod export;
mod file_header;
mod flatten;
pub mod gltf;
pub mod images;
pub mod import;
mod limits;
pub mod lodc;
pub mod lods;
mod obj;
mod options;
mod ply;
mod provenance;
mod scene;
#[cfg(test)]
mod testing;
mod textures;
mod write;

pub use appearance::appearance;
pub use assets::Assets;
pub use error::{Fault, FormatError};
pub use gltf::{PartNames, animation, animation_names, scene_graph};
pub use limits::Limits;
pub use scene::{
    Document, GltfDocument, ObjDocument, ObjMaterial, ObjectInfo, Scene, SceneObject, Source,
    SourceFormat, SubmeshInfo,
};
pub use write::{OutputFile, write_all};
