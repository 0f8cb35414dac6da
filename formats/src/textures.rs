//! Reading every image file that a document names.

use super::map_line;
use crate::import::gltf::stored::Stored;
use crate::import::gltf::{json, uri};
use crate::nodes::as_index;
use crate::{Assets, Document, FormatError, GltfDocument, ObjDocument};
use serde_json::Value;
use std::collections::BTreeMap;

/// The image files of a document.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    /// Bytes by the path that the document has for them: decoded, with `/` between folders.
    pub(super) files: BTreeMap<String, Vec<u8>>,
    /// One line for each that could not be read.
    pub warnings: Vec<String>,
}

impl Textures {
    /// Reads the image files that a document names from where `assets` has its main file. What
    /// cannot be read is a warning.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub fn read(document: &Document, assets: &mut Assets) -> Result<Self, FormatError> {
        let mut textures = Self::default();
        match document {
            Document::Obj(obj) => textures.read_obj(obj, assets),
            Document::Gltf(gltf) => textures.read_gltf(gltf, assets)?,
        }
        Ok(textures)
    }

    /// Adds the images that a glTF document holds itself, for formats that cannot.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub fn add_embedded(&mut self, document: &Document) -> Result<(), FormatError> {
        let Document::Gltf(gltf) = document else { return Ok(()) };
        Stored::read(gltf, &crate::Limits::DEFAULT, |stored, root| {
            for (i, image) in json::entries(root, "images").enumerate() {
                let data = image.get("uri").and_then(Value::as_str).and_then(uri::decoded_data);
                let bytes = match (data, image.get("bufferView").and_then(as_index)) {
                    (Some((_, bytes)), _) => bytes,
                    (None, Some(view)) => stored.view(view)?,
                    (None, None) => continue,
                };
                self.files.insert(embedded_name(i), bytes);
            }
            Ok(())
        })
    }

    fn read_obj(&mut self, obj: &ObjDocument, assets: &mut Assets) {
        for line in obj.materials.iter().flat_map(|m| &m.lines) {
            let Some(name) = map_line::file(line) else { continue };
            let path = name.replace('\\', "/");
            self.add(&path, |assets| assets.read_reference(&path), assets);
        }
    }

    fn read_gltf(&mut self, gltf: &GltfDocument, assets: &mut Assets) -> Result<(), FormatError> {
        let root = json::parse(gltf.json.as_bytes(), assets.limits())?;
        for (i, image) in json::entries(&root, "images").enumerate() {
            let Some(text) = image.get("uri").and_then(Value::as_str) else { continue };
            let Some(path) = uri::path(text) else { continue };
            let place = format!("images[{i}]");
            self.add(&path, |assets| uri::read(text, &place, assets), assets);
        }
        Ok(())
    }

    fn add(
        &mut self,
        path: &str,
        read: impl FnOnce(&mut Assets) -> Result<Vec<u8>, FormatError>,
        assets: &mut Assets,
    ) {
        if self.files.contains_key(path) {
            return;
        }
        match read(assets) {
            Ok(bytes) => drop(self.files.insert(path.to_owned(), bytes)),
            Err(e) => {
                let warning = format!("a texture is missing: {}", e.in_file(path));
                if !self.warnings.contains(&warning) {
                    self.warnings.push(warning);
                }
            }
        }
    }
}

/// The name of an image that a glTF document holds itself. No file can have it.
pub(crate) fn embedded_name(image: usize) -> String {
    format!("data:{image}")
}
