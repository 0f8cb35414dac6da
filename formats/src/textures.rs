//! Reads every image file that a document names, from the folder of its source.

use crate::images::Textures;
use crate::obj::mtl;
use crate::{Assets, Document, FormatError, gltf};

impl Textures {
    /// The paths of the image files that a document names, as it has them, each once.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub fn names(document: &Document) -> Result<Vec<String>, FormatError> {
        let mut names = match document {
            Document::Obj(document) => {
                let lines = document.materials.iter().flat_map(|m| &m.lines);
                lines.filter_map(|line| mtl::file(line)).map(|n| n.replace('\\', "/")).collect()
            }
            Document::Gltf(document) => gltf::image_names(document)?,
        };
        let mut seen = std::collections::BTreeSet::new();
        names.retain(|name| seen.insert(name.clone()));
        Ok(names)
    }

    /// Reads the image files that a document names from where `assets` has its main file. What
    /// cannot be read is a warning.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub fn read(document: &Document, assets: &mut Assets) -> Result<Self, FormatError> {
        let mut textures = Self::default();
        match document {
            Document::Obj(document) => {
                let lines = document.materials.iter().flat_map(|m| &m.lines);
                for name in lines.filter_map(|line| mtl::file(line)) {
                    let path = name.replace('\\', "/");
                    textures.add(&path, |assets| assets.read_name(&path), assets);
                }
            }
            Document::Gltf(document) => gltf::read_textures(document, &mut textures, assets)?,
        }
        Ok(textures)
    }

    /// Adds the images that a glTF document holds itself, for formats that cannot.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub fn add_embedded(&mut self, document: &Document) -> Result<(), FormatError> {
        match document {
            Document::Obj(_) => Ok(()),
            Document::Gltf(document) => gltf::add_embedded(document, self),
        }
    }
}

#[cfg(test)]
#[path = "textures_tests.rs"]
mod tests;
