//! Mesh files as results: their formats, where they go, how they are written.

use crate::console;
use crate::exit::{Failure, Outcome};
use crate::output::{self, Target};
use clap::ValueEnum;
use lodc_formats::export::{ExportFormat, ExportObject, export};
use lodc_formats::{Document, OutputFile};
use std::path::{Path, PathBuf};

/// Formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormatName {
    Glb,
    Gltf,
    Obj,
    Ply,
}

impl FormatName {
    fn extension(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Gltf => "gltf",
            Self::Obj => "obj",
            Self::Ply => "ply",
        }
    }
    fn format(self) -> ExportFormat {
        match self {
            Self::Glb => ExportFormat::Glb,
            Self::Gltf => ExportFormat::Gltf,
            Self::Obj => ExportFormat::Obj,
            Self::Ply => ExportFormat::Ply,
        }
    }
}

/// The output as it was asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted<'a> {
    pub(crate) input: &'a Path,
    pub(crate) output: &'a Path,
    pub(crate) format: Option<FormatName>,
    /// True if standard output is taken by JSON.
    pub(crate) json: bool,
    pub(crate) depfile: Option<&'a Path>,
}

impl Wanted<'_> {
    /// Returns the target of the result and its format.
    pub(crate) fn target(&self) -> Outcome<(Target, FormatName)> {
        if output::is_stream(self.output) {
            let format = self.format.unwrap_or(FormatName::Glb);
            if self.json {
                return Err(Failure::usage("the mesh and the JSON do not fit one standard output"));
            }
            if format == FormatName::Gltf {
                return Err(Failure::usage(
                    "a .gltf has a .bin beside it: write .glb to standard output instead",
                ));
            }
            if self.depfile.is_some() {
                return Err(Failure::usage(
                    "a dependency file needs an output file, not standard output",
                ));
            }
            return Ok((Target::Stdout, format));
        }
        let folder = output::is_folder(self.output);
        let format = if folder { self.format.unwrap_or(FormatName::Glb) } else { self.by_name()? };
        let inputs = &[self.input.to_owned()];
        let targets = output::targets(inputs, Some(self.output), format.extension())?;
        output::prepare(&targets, folder)?;
        if let Some(depfile) = self.depfile {
            if output::is_stream(depfile) || depfile == self.output || depfile == self.input {
                return Err(Failure::usage("the dependency file needs a name of its own"));
            }
            output::prepare(&[Target::File(depfile.to_owned())], false)?;
        }
        let target = targets.into_iter().next().expect("one input has one target");
        Ok((target, format))
    }

    /// The format by option or by the extension of OUT.
    fn by_name(&self) -> Outcome<FormatName> {
        if let Some(format) = self.format {
            return Ok(format);
        }
        let extension =
            self.output.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        FormatName::from_str(&extension, true).map_err(|_| {
            Failure::usage(format!(
                "{}: the extension names no known format: use .glb, .gltf, .obj or .ply, or say --format",
                self.output.display()
            ))
        })
    }
}

/// The files that a mesh becomes, the one that refers to the others first.
///
/// # Errors
/// If the format cannot hold it.
pub(crate) fn files(
    target: &Target,
    format: FormatName,
    document: &Document,
    objects: &[ExportObject<'_>],
) -> Outcome<Vec<OutputFile>> {
    let path = match target {
        Target::File(path) => path.clone(),
        Target::Stdout => PathBuf::from("stdout").with_extension(format.extension()),
    };
    Ok(export(&path, format.format(), document, objects)?)
}

/// Writes what [`files`] gave.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(target: &Target, files: Vec<OutputFile>) -> Outcome<()> {
    match target {
        Target::File(_) => output::commit(&files),
        // Standard output takes the mesh; what stands beside it (an MTL) has no place there.
        Target::Stdout => {
            files.into_iter().next().map_or(Ok(()), |first| console::bytes(&first.bytes))
        }
    }
}
