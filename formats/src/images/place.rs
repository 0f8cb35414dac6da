//! The image files that a document names: read from the source's folder, then embedded into an
//! export or copied beside it, so that a model that moves to another folder keeps its textures.

use crate::assets::{is_of_another_machine, last_part};
use crate::{Assets, FormatError, OutputFile};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};
use xxhash_rust::xxh3::xxh3_64;

/// The image files of a document.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    /// Bytes by the path that the document has for them: decoded, with `/` between folders.
    pub(crate) files: BTreeMap<String, Vec<u8>>,
    /// One line for each that could not be read.
    pub warnings: Vec<String>,
    /// The paths of the files that could not be read.
    missing: BTreeSet<String>,
}

/// What becomes of the image files that a document names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureMode {
    /// They are put into the glTF itself.
    Embed,
    /// They are copied beside the output.
    Copy,
}

/// Image files with a place in or beside an export. The default leaves every name as it is.
#[derive(Clone, Debug, Default)]
pub struct PlacedTextures {
    places: BTreeMap<String, ImagePlace>,
    /// Files to write beside the output.
    pub copies: Vec<OutputFile>,
    /// One line for each that has another name than in the document, or no place.
    pub warnings: Vec<String>,
}

/// The place of one image file.
#[derive(Clone, Debug)]
pub(crate) enum ImagePlace {
    /// In the glTF.
    Inside { mime: &'static str, bytes: Vec<u8> },
    /// Beside the output, by its path from there with `/` between folders.
    Beside(String),
}

impl Textures {
    /// Adds the file that the document calls `path`, once.
    pub(crate) fn add(
        &mut self,
        path: &str,
        read: impl FnOnce(&mut Assets) -> Result<Vec<u8>, FormatError>,
        assets: &mut Assets,
    ) {
        if self.files.contains_key(path) || self.missing.contains(path) {
            return;
        }
        match read(assets) {
            Ok(bytes) => drop(self.files.insert(path.to_owned(), bytes)),
            Err(e) => {
                self.missing.insert(path.to_owned());
                self.warnings.push(format!("a texture is missing: {}", e.in_file(path)));
            }
        }
    }

    /// Puts every file into or beside `output`. A copy whose name another file has gets a name with
    /// a hash of its bytes; a file that is there with the same bytes is not written again.
    #[must_use]
    pub fn placed(self, mode: TextureMode, output: &Path) -> PlacedTextures {
        let mut placed = PlacedTextures::default();
        // Files that the export itself writes; 0 stands for bytes that no texture has.
        let export_names = ["bin", "mtl"].map(|extension| output.with_extension(extension));
        let mut hashes: BTreeMap<PathBuf, u64> =
            export_names.into_iter().chain([output.to_owned()]).map(|path| (path, 0)).collect();
        for (name, bytes) in self.files {
            let place = match (mode, kind(&bytes).map(|(mime, _)| mime)) {
                (TextureMode::Embed, Some(mime)) => ImagePlace::Inside { mime, bytes },
                (TextureMode::Embed, None) => {
                    let problem = format!("{name}: no image that glTF can hold: not embedded");
                    placed.warnings.push(problem);
                    continue;
                }
                (TextureMode::Copy, _) => placed.beside(&name, bytes, output, &mut hashes),
            };
            placed.places.insert(name, place);
        }
        placed
    }
}

impl PlacedTextures {
    /// The place of the file that the document calls `name`; none if it stays as it is.
    pub(crate) fn of(&self, name: &str) -> Option<&ImagePlace> {
        self.places.get(name)
    }

    /// Copies a file beside `output`; `hashes` has those of the files that this run writes.
    fn beside(
        &mut self,
        name: &str,
        bytes: Vec<u8>,
        output: &Path,
        hashes: &mut BTreeMap<PathBuf, u64>,
    ) -> ImagePlace {
        let folder = output.parent().unwrap_or(Path::new(""));
        let hash = xxh3_64(&bytes);
        let mut relative = relative(name, &bytes, output);
        let differs = |path: &PathBuf| match hashes.get(path) {
            Some(&other_hash) => other_hash != hash,
            None => path.symlink_metadata().is_ok() && fs::read(path).ok().as_ref() != Some(&bytes),
        };
        if differs(&folder.join(&relative)) {
            let other_name = hashed(&relative, hash);
            self.warnings.push(format!(
                "{relative}: another file has this name: the texture was written as {other_name}"
            ));
            relative = other_name;
        }
        let path = folder.join(&relative);
        if !path.exists() && !hashes.contains_key(&path) {
            self.copies.push(OutputFile { path: path.clone(), bytes });
        }
        hashes.insert(path, hash);
        ImagePlace::Beside(relative)
    }
}

/// The name of an image that a glTF document holds itself. No file can have it.
pub(crate) fn embedded_name(image: usize) -> String {
    format!("data:{image}")
}

/// The media type of an image that glTF can hold, by its first bytes, and its extension in file
/// names; none for other bytes.
pub(crate) fn kind(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    Some(match bytes {
        [0x89, b'P', b'N', b'G', ..] => ("image/png", "png"),
        [0xff, 0xd8, 0xff, ..] => ("image/jpeg", "jpg"),
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', ..] => ("image/ktx2", "ktx2"),
        [b'D', b'D', b'S', b' ', ..] => ("image/vnd-ms.dds", "dds"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => ("image/webp", "webp"),
        [_, _, _, _, b'f', b't', b'y', b'p', b'a', b'v', b'i', b'f', ..] => ("image/avif", "avif"),
        _ => return None,
    })
}

/// The path from the output's folder: that of the document where it leads downwards, else the
/// file's name alone.
fn relative(name: &str, bytes: &[u8], output: &Path) -> String {
    if let Some(number) = name.strip_prefix("data:") {
        let stem = output.file_stem().unwrap_or_default().to_string_lossy();
        let extension = kind(bytes).map_or("bin", |(_, extension)| extension);
        return format!("{stem}_image{number}.{extension}");
    }
    if is_of_another_machine(name) {
        return last_part(name).to_owned();
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
