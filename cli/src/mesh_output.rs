//! Mesh files as results: their formats, where they go, how they are written.

use crate::console;
use crate::exit::{Failure, Outcome};
use crate::output::{self, Target};
use clap::ValueEnum;
use lodc_formats::export::{Additions, ExportFormat, ExportObject, export_with};
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
    /// Returns the format that a path's extension names.
    ///
    /// # Errors
    /// If it names none.
    pub(crate) fn by_extension(path: &Path) -> Outcome<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        Self::from_str(&extension, true).map_err(|_| {
            Failure::usage(format!(
                "{}: the extension names no known format: use .glb, .gltf, .obj or .ply, or say \
                 --format",
                path.display()
            ))
        })
    }
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
    pub(crate) inputs: &'a [PathBuf],
    pub(crate) output: &'a Path,
    pub(crate) format: Option<FormatName>,
    /// True if standard output is taken by JSON.
    pub(crate) json: bool,
    pub(crate) depfile: Option<&'a Path>,
}

impl Wanted<'_> {
    /// Returns the target of the only result, and its format.
    ///
    /// # Errors
    /// As [`Self::targets`].
    pub(crate) fn target(&self) -> Outcome<(Target, FormatName)> {
        let (mut targets, format) = self.targets()?;
        Ok((targets.pop().expect("one input has one target")?, format))
    }

    /// Returns the target of the result of every input, and their format.
    ///
    /// # Errors
    /// If OUT does not suit the inputs, or nothing can be written there.
    pub(crate) fn targets(&self) -> Outcome<(Vec<Outcome<Target>>, FormatName)> {
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
            return Ok((output::targets(self.inputs, Some(self.output), "")?, format));
        }
        let folder = self.inputs.len() > 1 || output::is_folder(self.output);
        let format = if folder { self.format.unwrap_or(FormatName::Glb) } else { self.by_name()? };
        let targets = output::targets(self.inputs, Some(self.output), format.extension())?;
        output::prepare(targets.iter().flatten(), folder)?;
        if let Some(depfile) = self.depfile {
            let is_input = self.inputs.iter().any(|input| input == depfile);
            if output::is_stream(depfile) || depfile == self.output || is_input {
                return Err(Failure::usage("the dependency file needs a name of its own"));
            }
            output::prepare(&[Target::File(depfile.to_owned())], false)?;
        }
        Ok((targets, format))
    }

    /// The format by option or by the extension of OUT.
    fn by_name(&self) -> Outcome<FormatName> {
        self.format.map_or_else(|| FormatName::by_extension(self.output), Ok)
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
    additions: &Additions,
) -> Outcome<Vec<OutputFile>> {
    let path = match target {
        Target::File(path) => path.clone(),
        Target::Stdout => PathBuf::from("stdout").with_extension(format.extension()),
    };
    Ok(export_with(&path, format.format(), document, objects, additions)?)
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
