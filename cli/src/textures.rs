//! Options for the image files of a scene: embedded, copied or left where they are.

use crate::exit::{Failure, Outcome};
use crate::help::BECOMES;
use crate::limits::ImportArgs;
use crate::mesh_output::FormatName;
use crate::output::Target;
use clap::{Args, ValueEnum};
use lodc_formats::images::{PlacedTextures, TextureMode, Textures};
use lodc_formats::{Document, RequestedFiles};
use std::path::{Path, PathBuf};

/// Options of image files.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = BECOMES)]
pub(crate) struct TextureArgs {
    /// Places of image files [default: embed for .glb, copy for .gltf, .obj and .ply]
    #[arg(long, value_enum, hide_short_help = true)]
    textures: Option<TextureChoice>,
    /// Folder to look for image files in [default: that of the input]
    #[arg(long, value_name = "DIR", hide_short_help = true)]
    textures_from: Option<PathBuf>,
}

/// Places of image files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TextureChoice {
    /// Into the file
    Embed,
    /// Beside the file
    Copy,
    /// Left where they are: the file names them as the input does
    Keep,
}

impl TextureArgs {
    /// Refuses what a format cannot hold.
    ///
    /// # Errors
    /// If an OBJ or PLY should hold images, or copies have no folder.
    pub(crate) fn check(&self, format: FormatName, to_stdout: bool) -> Outcome<()> {
        let holds_images = format.is_gltf();
        match self.textures {
            Some(TextureChoice::Embed) if !holds_images => {
                Err(Failure::usage("only .glb and .gltf hold images: use --textures copy or keep"))
            }
            Some(TextureChoice::Copy) if to_stdout => {
                Err(Failure::usage("image files cannot be written beside standard output"))
            }
            _ => Ok(()),
        }
    }

    /// Reads the image files of a document and says where each goes. Also returns the files that
    /// were looked for.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub(crate) fn placed(
        &self,
        document: &Document,
        input: &Path,
        import: &ImportArgs,
        target: &Target,
        format: FormatName,
    ) -> Outcome<(PlacedTextures, RequestedFiles)> {
        let Some(mode) = self.mode(target, format) else { return Ok(Default::default()) };
        let mut assets = import.assets(input, self.textures_from.as_ref());
        let mut textures = Textures::read(document, &mut assets)?;
        if !format.is_gltf() {
            textures.add_embedded(document)?;
        }
        let output = match target {
            Target::File(path) => path.clone(),
            Target::Stdout => PathBuf::from("-"),
        };
        let missing = std::mem::take(&mut textures.warnings);
        let mut placed = textures.placed(mode, &output);
        placed.warnings.splice(0..0, missing);
        Ok((placed, assets.files().clone()))
    }

    /// Where image files go; none if they are not touched.
    fn mode(&self, target: &Target, format: FormatName) -> Option<TextureMode> {
        match (self.textures, format) {
            (_, FormatName::Stl) | (Some(TextureChoice::Keep), _) => None,
            (Some(TextureChoice::Embed), _) | (None, FormatName::Glb | FormatName::Vrm) => {
                Some(TextureMode::Embed)
            }
            (None, _) if *target == Target::Stdout => None,
            (Some(TextureChoice::Copy) | None, _) => Some(TextureMode::Copy),
        }
    }
}
