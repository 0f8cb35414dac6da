//! Reads mesh files and exported levels of any format, which is recognised by content.

mod count;
mod sniff;

use crate::exported::NOT_EXPORTED;
use crate::lodc::{self, LodFile};
pub use crate::options::ImportOptions;
use crate::provenance::Provenance;
pub use crate::scene::Counted;
use crate::words::counted;
use crate::{
    Assets, Document, ExportedLevels, Fault, FormatError, Limits, Scene, faces, gltf, obj, ply, stl,
};
pub use count::count;
use lodc_mesh::MeshParts;
use std::path::Path;

/// A mesh file or a file of levels of detail.
#[derive(Debug)]
pub enum Either<M> {
    /// OBJ, glTF, GLB, PLY or STL.
    Scene(Scene),
    /// `.lodc`.
    Lodc(LodFile<M>),
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
        return levels(&bytes).map(Either::Lodc).map_err(|e| e.in_file(&assets.main_name()));
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

/// As [`import`], of bytes that have been read already. Files that they name are not there:
/// nothing says where they would be.
///
/// # Errors
/// As [`import`]; the error names no file.
pub fn import_bytes(bytes: Vec<u8>, options: &ImportOptions) -> Result<Scene, FormatError> {
    if bytes.len() as u64 > options.limits.file_bytes {
        let bytes = counted(options.limits.file_bytes, "byte", "bytes");
        let problem = format!("more than {bytes}");
        return Err(FormatError::new(Fault::Limit, "", problem));
    }
    let path = Path::new("-");
    let mut assets = Assets::new(path, &[], options.limits);
    let name = assets.main_name();
    read(bytes, path, &mut assets, options).map_err(|e| match e.file == name {
        true => FormatError { file: String::new(), ..e },
        false => e,
    })
}

/// Makes a scene of one object without a file: the same repairs as of files.
///
/// # Errors
/// If an index is out of range, a position is not finite, a stream has too few bytes, or the mesh
/// is larger than the limits.
pub fn import_parts(parts: MeshParts, options: &ImportOptions) -> Result<Scene, FormatError> {
    faces::scene_of_parts(parts, options)
}

/// Reads what `extract` or `chain` wrote: OBJ, PLY, glTF or GLB with the levels that it states.
///
/// # Errors
/// As [`import`], and if the file states no levels.
pub fn import_levels(path: &Path, options: &ImportOptions) -> Result<ExportedLevels, FormatError> {
    let mut assets = Assets::new(path, &options.allowed, options.limits);
    let bytes = assets.read_main()?;
    read_levels(bytes, path, &mut assets, options)
}

/// As [`import_levels`], of bytes that have been read already; files that they name are looked for
/// beside `path`.
///
/// # Errors
/// As [`import_levels`].
pub fn levels_in(
    bytes: Vec<u8>,
    path: &Path,
    options: &ImportOptions,
) -> Result<ExportedLevels, FormatError> {
    let mut assets = Assets::new(path, &options.allowed, options.limits);
    read_levels(bytes, path, &mut assets, options)
}

fn read_levels(
    bytes: Vec<u8>,
    path: &Path,
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<ExportedLevels, FormatError> {
    let name = assets.main_name();
    if is_gltf(&bytes, path) {
        return gltf::read::exported(&bytes, assets, options).map_err(|e| e.in_file(&name));
    }
    let stated = stated_in_text(&bytes);
    let levels = vec![read(bytes, path, assets, options)?];
    let states_none = || FormatError::new(Fault::Malformed, "line 1", NOT_EXPORTED).in_file(&name);
    Ok(ExportedLevels {
        stated: stated.ok_or_else(states_none)?,
        levels,
        difference: None,
        morphs: Vec::new(),
    })
}

/// Reads a glTF or GLB as one GLB that holds all it refers to, nothing in it compressed but images,
/// and a warning for each image that cannot be read.
///
/// # Errors
/// As [`import`], and for files of other formats.
#[cfg(feature = "export")]
pub fn as_plain_glb(
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<(Vec<u8>, Vec<String>), FormatError> {
    let bytes = assets.read_main()?;
    gltf::read::plain(&bytes, assets, options).map_err(|e| e.in_file(&assets.main_name()))
}

/// Returns whether a file can be read and states levels, as those do that `extract` and `chain`
/// write.
#[must_use]
pub fn states_levels(path: &Path, options: &ImportOptions) -> bool {
    let bytes = Assets::new(path, &options.allowed, options.limits).read_main();
    bytes.is_ok_and(|bytes| match is_gltf(&bytes, path) {
        true => gltf::read::states_levels(&bytes, options),
        false => stated_in_text(&bytes).is_some(),
    })
}

/// Compares what a level has besides its geometry with what its source has; returns the first
/// difference. Documents of different formats are not compared.
///
/// # Errors
/// If a stored document is damaged.
pub fn document_difference(
    source: &Document,
    level: &Document,
    limits: &Limits,
) -> Result<Option<String>, FormatError> {
    match (source, level) {
        (Document::Gltf(source), Document::Gltf(level)) => gltf::difference(source, level, limits),
        _ => Ok(None),
    }
}

fn is_gltf(bytes: &[u8], path: &Path) -> bool {
    matches!(sniff::format(bytes, path), sniff::Sniffed::Glb | sniff::Sniffed::Gltf)
}

fn stated_in_text(bytes: &[u8]) -> Option<Provenance> {
    // The first line of an OBJ, or the third of a PLY, after `ply` and the format.
    let mut lines = bytes.split(|&b| b == b'\n').take(3);
    lines.find_map(|line| {
        let line = std::str::from_utf8(line).ok()?;
        Provenance::of_line(line.strip_prefix("# ").or_else(|| line.strip_prefix("comment "))?)
    })
}

fn read(
    bytes: Vec<u8>,
    path: &Path,
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<Scene, FormatError> {
    let name = assets.main_name();
    if bytes.is_empty() {
        return Err(FormatError::new(Fault::Malformed, "", "the file is empty").in_file(&name));
    }
    let scene = match sniff::format(&bytes, path) {
        sniff::Sniffed::Glb | sniff::Sniffed::Gltf => gltf::read::import(bytes, assets, options),
        sniff::Sniffed::Obj => obj::read::import(bytes, assets, options),
        sniff::Sniffed::Ply => ply::read::import(&bytes, assets, options),
        sniff::Sniffed::Stl => stl::read::import(bytes, assets, options),
        sniff::Sniffed::Made => {
            let problem = "not a mesh but a file that lodc made: `lodc extract` takes meshes out \
                           of a .lodc, `lodc unpack` out of a .lods";
            Err(FormatError::new(Fault::Unsupported, "", problem))
        }
        sniff::Sniffed::Other(kind) => {
            let problem = format!("{kind} cannot be read: convert it to glTF first");
            Err(FormatError::new(Fault::Unsupported, "", problem))
        }
    };
    scene.map_err(|e| e.in_file(&name))
}
