//! Reading meshes: the format is told by content.

mod sniff;

use crate::lodc::{self, LodFile};
pub use crate::options::ImportOptions;
use crate::{Assets, Fault, FormatError, Scene, gltf, obj};
use std::path::Path;

/// A mesh file or a file of levels of detail.
#[derive(Debug)]
pub enum Either<M> {
    /// OBJ, glTF or GLB.
    Scene(Scene),
    /// `.lodc`.
    Levels(LodFile<M>),
}

/// Reads a mesh file, or a `.lodc` file by `levels`; `-` from standard input.
///
/// # Errors
/// See [`import`].
pub fn either<M>(
    path: &Path,
    options: &ImportOptions,
    levels: impl FnOnce(&[u8]) -> Result<LodFile<M>, FormatError>,
) -> Result<Either<M>, FormatError> {
    let mut assets = Assets::new(path, &options.allowed, options.limits);
    let bytes = assets.read_main()?;
    if lodc::is_lodc(&bytes) {
        return levels(&bytes).map(Either::Levels).map_err(|e| e.in_file(&assets.main_name()));
    }
    read(bytes, path, &mut assets, options).map(Either::Scene)
}

/// Reads an asset, `-` from standard input. The format is recognised by content; the file's
/// extension only helps messages.
///
/// # Errors
/// If the asset cannot be read, is malformed, unsupported, or larger than the limits. The error
/// names the file.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Scene, FormatError> {
    let mut assets = Assets::new(path, &options.allowed, options.limits);
    let bytes = assets.read_main()?;
    read(bytes, path, &mut assets, options)
}

fn read(
    bytes: Vec<u8>,
    path: &Path,
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<Scene, FormatError> {
    let name = assets.main_name();
    let scene = match sniff::format(&bytes, path) {
        sniff::Sniffed::Glb | sniff::Sniffed::Gltf => gltf::read::import(bytes, assets, options),
        sniff::Sniffed::Obj => obj::read::import(bytes, assets, options),
        sniff::Sniffed::Other(what) => {
            let what = format!("{what} cannot be read: convert it to OBJ or glTF first");
            Err(FormatError::new(Fault::Unsupported, "", what))
        }
    };
    scene.map_err(|e| e.in_file(&name))
}
