//! Reading meshes: one file or folder per format.

pub mod gltf;
pub mod obj;
mod sniff;

use crate::{Assets, Fault, FormatError, Limits, Scene};
use std::path::{Path, PathBuf};

/// What an import may do.
#[derive(Clone, Debug, Default)]
pub struct ImportOptions {
    /// How large inputs may be.
    pub limits: Limits,
    /// Folders besides the asset's own that may be read.
    pub allowed: Vec<PathBuf>,
    /// Weld positions closer than this share of the bounding box's diagonal; 0 joins identical positions only.
    pub weld: f64,
}

/// Reads an asset, `-` from standard input. The format is told by content; the file's extension only helps messages.
///
/// # Errors
/// If the asset cannot be read, is malformed, unsupported, or larger than the limits. The error names the file.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Scene, FormatError> {
    let mut assets = Assets::new(path, &options.allowed, options.limits);
    let name = assets.main_name();
    let bytes = assets.read_main()?;
    let scene = match sniff::format(&bytes, path) {
        sniff::Sniffed::Glb | sniff::Sniffed::Gltf => gltf::import(bytes, &mut assets, options),
        sniff::Sniffed::Obj => obj::import(bytes, &mut assets, options),
        sniff::Sniffed::Other(what) => {
            let what = format!("{what} cannot be read: convert it to OBJ or glTF first");
            Err(FormatError::new(Fault::Unsupported, "", what))
        }
    };
    scene.map_err(|e| e.in_file(&name))
}
