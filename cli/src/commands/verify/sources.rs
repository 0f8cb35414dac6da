//! `verify --source`: finds the mesh file that a `.lodc` was built from, by name or, in a folder,
//! by its content hash.

use crate::batch::{self, MESH_EXTENSIONS};
use crate::exit::{Failure, Outcome, Status};
use lodc_formats::import::{ImportOptions, import};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The meshes that files are compared with.
#[derive(Debug)]
pub(super) enum Sources {
    /// No file is compared.
    None,
    /// Each file is compared with this one.
    One(PathBuf),
    /// Each file is compared with the one of its content hash; of several the one of its name.
    Folder(PathBuf, BTreeMap<u128, Vec<PathBuf>>),
}

impl Sources {
    /// Reads the content of every mesh below a folder; one that cannot be read is left out.
    ///
    /// # Errors
    /// If there is no mesh in the folder.
    pub(super) fn new(source: Option<&Path>, options: &ImportOptions) -> Outcome<Self> {
        let Some(source) = source else { return Ok(Self::None) };
        if !source.is_dir() {
            return Ok(Self::One(source.to_owned()));
        }
        let meshes = batch::expand_folders(&[source.to_owned()], &MESH_EXTENSIONS, &[], &[])?;
        let mut by_hash: BTreeMap<u128, Vec<PathBuf>> = BTreeMap::new();
        for path in meshes {
            if let Ok(scene) = import(&path, options) {
                by_hash.entry(scene.source.content_hash).or_default().push(path);
            }
        }
        Ok(Self::Folder(source.to_owned(), by_hash))
    }

    /// Returns the mesh that a file was made from, by its hash.
    ///
    /// # Errors
    /// If the folder has none with its content.
    pub(super) fn of(&self, hash: u128, input: &Path) -> Outcome<Option<&Path>> {
        match self {
            Self::None => Ok(None),
            Self::One(path) => Ok(Some(path)),
            Self::Folder(folder, meshes) => match meshes.get(&hash) {
                Some(paths) => {
                    // `max_by_key` returns the last of equals: in reverse order the first by name.
                    let closest = paths.iter().rev().max_by_key(|path| likeness(path, input));
                    Ok(closest.map(PathBuf::as_path))
                }
                None => Err(Failure::new(
                    Status::Difference,
                    format!(
                        "{}: no mesh in {} has the content that it was made from",
                        input.display(),
                        folder.display()
                    ),
                )),
            },
        }
    }
}

/// How much the path of a mesh is like that of the file made of it: the bytes of its name that the
/// other begins with, then the number of folders, from the last one up, of the same names.
fn likeness(mesh: &Path, lodc: &Path) -> (usize, usize) {
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let stem = mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let common_start = |start: &str| if name(lodc).starts_with(start) { start.len() } else { 0 };
    let folders = |path: &Path| -> Vec<_> {
        path.parent().into_iter().flat_map(|p| p.iter().rev().map(ToOwned::to_owned)).collect()
    };
    let same = folders(mesh).iter().zip(&folders(lodc)).take_while(|(a, b)| a == b).count();
    (common_start(&name(mesh)).max(common_start(&stem)), same)
}
