//! Every external byte of lodc: meshes in and out, the `.lodc` container and the `.lods` stream.
//!
//! Nothing outside this package parses or writes files. It knows no model: a file has their arrays
//! under the names of their kinds ([`lodc::StoredModel`]). Each format has a room: `gltf`, `obj`,
//! `ply`, `stl`, `images`, [`lodc`] and `lods`; what they share is beside them, and `import`,
//! `export`, `appearance`, `materials` and `images::Textures` choose among them. No format uses
//! what chooses, and its reader and writer do not use each other.
//!
#![cfg_attr(all(feature = "import", feature = "export"), doc = "```")]
#![cfg_attr(not(all(feature = "import", feature = "export")), doc = "```ignore")]
//! use lodc_formats::export::{ExportFormat, ExportObject, export};
//! use lodc_formats::import::{ImportOptions, import};
//! use std::path::Path;
//!
//! let scene = import(Path::new("../fixtures/machine_part.glb"), &ImportOptions::default())?;
//! let object = &scene.objects[0];
//! assert_eq!(object.mesh.triangles().len(), 480);
//!
//! let objects = [ExportObject { info: &object.info, mesh: &object.mesh }];
//! let files = export(Path::new("part.ply"), ExportFormat::Ply, &scene.document, &objects)?;
//! assert!(files[0].bytes.starts_with(b"ply\nformat binary_little_endian"));
//! # Ok::<(), lodc_formats::FormatError>(())
//! ```
//!
//! Features: `import` (OBJ, glTF, PLY and STL in), `export` (the same out), `stream`
//! (`.lods`); all of them by default, and without any the container alone.

#![cfg_attr(
    feature = "minimal-messages",
    allow(unused_variables, reason = "values of messages are not formatted")
)]

/// A message without its values: what formats them would be half of a browser's decoder.
#[cfg(feature = "minimal-messages")]
macro_rules! format {
    ($text:literal $(, $value:expr)* $(,)?) => {{
        $(let _ = &$value;)*
        String::from($text)
    }};
}

#[cfg(feature = "import")]
mod appearance;
mod assets;
#[cfg(any(feature = "import", feature = "export"))]
mod colours;
mod error;
#[cfg(feature = "export")]
pub mod export;
#[cfg(feature = "import")]
mod exported;
#[cfg(feature = "import")]
mod faces;
#[cfg(any(feature = "import", feature = "export"))]
mod far;
mod fields;
mod file_header;
#[cfg(feature = "export")]
mod flatten;
#[cfg(feature = "json")]
#[cfg_attr(
    not(all(feature = "import", feature = "export", feature = "stream")),
    allow(
        dead_code,
        unused_imports,
        unused_macros,
        reason = "each part has a user among all features"
    )
)]
pub mod gltf;
#[cfg(any(feature = "import", feature = "export"))]
pub mod images;
#[cfg(feature = "import")]
pub mod import;
#[cfg(feature = "gltf")]
mod known;
mod limits;
#[cfg_attr(not(feature = "stream"), allow(dead_code, reason = "streams describe attributes alike"))]
pub mod lodc;
#[cfg(feature = "stream")]
pub mod lods;
#[cfg(any(feature = "import", feature = "export"))]
mod loose;
#[cfg(feature = "gltf")]
mod material;
#[cfg(feature = "gltf")]
mod materials;
#[cfg(feature = "gltf")]
#[cfg_attr(
    not(all(feature = "import", feature = "export", feature = "stream")),
    allow(
        dead_code,
        unused_imports,
        unused_macros,
        reason = "each part has a user among all features"
    )
)]
mod obj;
#[cfg(any(feature = "import", feature = "export"))]
mod options;
#[cfg(feature = "gltf")]
mod percent;
#[cfg(any(feature = "import", feature = "export"))]
mod ply;
#[cfg(any(feature = "import", feature = "export"))]
mod provenance;
mod requested_files;
mod scene;
#[cfg(any(feature = "import", feature = "export"))]
mod stl;
#[cfg(test)]
mod testing;
#[cfg(feature = "export")]
mod textures;
mod words;
mod write;

#[cfg(feature = "import")]
pub use appearance::{appearance, coordinates};
pub use assets::Assets;
pub use error::{Fault, FormatError};
#[cfg(feature = "import")]
pub use exported::{ExportedLevels, Geomorph, GeomorphPart};
#[cfg(feature = "gltf")]
pub use gltf::{PartNames, animation, animation_names, scene_graph, scene_motion};
pub use limits::Limits;
#[cfg(feature = "gltf")]
pub use material::{Material, MaterialTexture, Materials};
#[cfg(feature = "gltf")]
pub use materials::materials;
pub use requested_files::RequestedFiles;
pub use scene::{
    Document, GltfDocument, ObjDocument, ObjMaterial, ObjectInfo, Scene, SceneObject, Source,
    SourceFormat, SubmeshInfo,
};
pub use write::{OutputFile, write_all, write_each};

/// The name of the morph target that moves a level to the next one.
#[cfg_attr(not(all(feature = "import", feature = "export")), allow(dead_code, reason = "of glTF"))]
pub(crate) const GEOMORPH_TARGET: &str = "lodc:next";

/// The name and version of this program.
pub(crate) const GENERATOR: &str = concat!("lodc ", env!("CARGO_PKG_VERSION"));
