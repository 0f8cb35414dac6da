//! The place of every image file in or beside an export.

use super::{Textures, extension_of, mime_of};
use crate::OutputFile;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};
use xxhash_rust::xxh3::xxh3_64;

/// Places for the image files that a document names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureMode {
    /// They go into the glTF itself.
    Embed,
    /// They are copied beside the output.
    Copy,
}

/// Image files with a place in or beside an export. The default leaves every name as it is.
#[derive(Clone, Debug, Default)]
pub struct PlacedTextures {
    places: BTreeMap<String, Place>,
    /// Files to write beside the output.
    pub copies: Vec<OutputFile>,
    /// One line for each that has another name than in the document, or no place.
    pub warnings: Vec<String>,
}

/// The place of one image file.
#[derive(Clone, Debug)]
pub(crate) enum Place {
    /// In the glTF.
    Inside { mime: &'static str, bytes: Vec<u8> },
    /// Beside the output, by its path from there with `/` between folders.
    Beside(String),
}

impl Textures {
    /// Gives every file its place in or beside `output`. A copy whose name another file has already
    /// takes a name with a hash of its bytes; a file with the same bytes is left as it is.
    #[must_use]
    pub fn placed(self, mode: TextureMode, output: &Path) -> PlacedTextures {
        let mut placed = PlacedTextures::default();
        // Names that the export itself takes.
        let own = ["bin", "mtl"].map(|extension| output.with_extension(extension));
        let mut taken: BTreeMap<PathBuf, u64> =
            own.into_iter().chain([output.to_owned()]).map(|path| (path, 0)).collect();
        for (name, bytes) in self.files {
            let place = match (mode, mime_of(&bytes)) {
                (TextureMode::Embed, Some(mime)) => Place::Inside { mime, bytes },
                (TextureMode::Embed, None) => {
                    let what = format!("{name}: no image that glTF can hold: not embedded");
                    placed.warnings.push(what);
                    continue;
                }
                (TextureMode::Copy, _) => placed.beside(&name, bytes, output, &mut taken),
            };
            placed.places.insert(name, place);
        }
        placed
    }
}

impl PlacedTextures {
    /// The place of the file that the document calls `name`; none if it stays as it is.
    pub(crate) fn of(&self, name: &str) -> Option<&Place> {
        self.places.get(name)
    }

    /// A file beside `output`; `taken` has the hashes of those that this run puts there.
    fn beside(
        &mut self,
        name: &str,
        bytes: Vec<u8>,
        output: &Path,
        taken: &mut BTreeMap<PathBuf, u64>,
    ) -> Place {
        let folder = output.parent().unwrap_or(Path::new(""));
        let hash = xxh3_64(&bytes);
        let mut relative = relative(name, &bytes, output);
        let differs = |path: &PathBuf| match taken.get(path) {
            Some(&other) => other != hash,
            None => path.symlink_metadata().is_ok() && fs::read(path).ok().as_ref() != Some(&bytes),
        };
        if differs(&folder.join(&relative)) {
            let other = hashed(&relative, hash);
            self.warnings.push(format!(
                "{relative}: another file has this name: the texture was written as {other}"
            ));
            relative = other;
        }
        let path = folder.join(&relative);
        if !path.exists() && !taken.contains_key(&path) {
            self.copies.push(OutputFile { path: path.clone(), bytes });
        }
        taken.insert(path, hash);
        Place::Beside(relative)
    }
}

/// The path from the output's folder: that of the document where it leads downwards, else the
/// file's name alone.
fn relative(name: &str, bytes: &[u8], output: &Path) -> String {
    if let Some(number) = name.strip_prefix("data:") {
        let stem = output.file_stem().unwrap_or_default().to_string_lossy();
        return format!("{stem}_image{number}.{}", extension_of(bytes));
    }
    let parts: Vec<Component<'_>> =
        Path::new(name).components().filter(|c| *c != Component::CurDir).collect();
    let text = |c: &Component<'_>| c.as_os_str().to_string_lossy().into_owned();
    if parts.iter().all(|c| matches!(c, Component::Normal(_))) {
        parts.iter().map(text).collect::<Vec<_>>().join("/")
    } else {
        parts.last().map(text).unwrap_or_default()
    }
}

/// `wood.png` becomes `wood-0123456789abcdef.png`.
fn hashed(relative: &str, hash: u64) -> String {
    let path = Path::new(relative);
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().map(|e| format!(".{}", e.to_string_lossy()));
    let name = format!("{stem}-{hash:016x}{}", extension.unwrap_or_default());
    match relative.rsplit_once('/') {
        Some((folder, _)) => format!("{folder}/{name}"),
        None => name,
    }
}
