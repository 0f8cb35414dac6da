//! Every external byte of lodc: meshes in and out, the `.lodc` container and the `.lods` stream.
//!
//! Nothing outside this package parses or writes files. It knows no model by name: models list
//! their arrays (`lodc_lod::any`), this package lays them out.

mod animations;
pub mod appearance;
mod assets;
mod error;
pub mod export;
mod file_header;
mod graph;
pub mod import;
mod limits;
pub mod lodc;
pub mod lods;
mod nodes;
mod part_names;
pub mod picture;
mod scene;
#[cfg(test)]
mod testing;
pub mod textures;
mod write;

pub use animations::{animation, animation_names};
pub use assets::Assets;
pub use error::{Fault, FormatError};
pub use graph::scene_graph;
pub use limits::Limits;
pub use part_names::PartNames;
pub use scene::{
    Document, GltfDocument, ObjDocument, ObjMaterial, ObjectInfo, Scene, SceneObject, Source,
    SourceFormat, SubmeshInfo,
};
pub use write::{OutputFile, write_all};
