//! `--source`: the mesh that a file was made from, by name or, in a folder, by content.

use crate::batch::{self, MESHES};
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
    /// Each file is compared with the one of its content hash.
    Folder(PathBuf, BTreeMap<u128, PathBuf>),
}

impl Sources {
    /// Reads the content of every mesh below a folder; a mesh that cannot be read has no hash.
    ///
    /// # Errors
    /// If there is no mesh in the folder.
    pub(super) fn new(source: Option<&Path>, options: &ImportOptions) -> Outcome<Self> {
        let Some(source) = source else { return Ok(Self::None) };
        if !source.is_dir() {
            return Ok(Self::One(source.to_owned()));
        }
        let meshes = batch::expand(&[source.to_owned()], &MESHES, &[], &[])?;
        let hashed = |path: PathBuf| {
            let scene = import(&path, options).ok()?;
            Some((scene.source.content_hash, path))
        };
        Ok(Self::Folder(source.to_owned(), meshes.into_iter().filter_map(hashed).collect()))
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
                Some(path) => Ok(Some(path)),
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
