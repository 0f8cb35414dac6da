//! Output options of the commands that write mesh files: format, path, and how they are written.

use crate::console;
use crate::exit::{Failure, Outcome};
use crate::output::{self, Target};
use clap::ValueEnum;
use lodc::level_mesh::Order;
use lodc_formats::OutputFile;
use lodc_formats::export::ExportFormat;
use std::path::{Path, PathBuf};

/// Formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormatName {
    Glb,
    Gltf,
    Obj,
    Ply,
    Stl,
    /// A glTF binary under the name of avatars
    Vrm,
}

/// Orders of triangles and vertices that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum OrderName {
    /// For vertex caches; vertices by first use, identical ones once
    Cache,
    /// For compression; vertices by first use, identical ones once
    Size,
    /// As in the input
    File,
}

impl From<OrderName> for Order {
    fn from(name: OrderName) -> Self {
        match name {
            OrderName::Cache => Self::Cache,
            OrderName::Size => Self::Size,
            OrderName::File => Self::File,
        }
    }
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
                "{}: the extension names no known format: use .glb, .gltf, .obj, .ply, .stl or \
                 .vrm, or say --format",
                path.display()
            ))
        })
    }
    /// The extension of its files.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Gltf => "gltf",
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Stl => "stl",
            Self::Vrm => "vrm",
        }
    }
    pub(crate) const fn export_format(self) -> ExportFormat {
        match self {
            Self::Glb | Self::Vrm => ExportFormat::Glb,
            Self::Gltf => ExportFormat::Gltf,
            Self::Obj => ExportFormat::Obj,
            Self::Ply => ExportFormat::Ply,
            Self::Stl => ExportFormat::Stl,
        }
    }
    /// Returns whether its files are glTF, in JSON or binary.
    pub(crate) fn is_gltf(self) -> bool {
        matches!(self, Self::Glb | Self::Gltf | Self::Vrm)
    }
}

/// Returns the format of results at OUT: by option, by the extension of OUT or, for standard output
/// and folders, GLB. `is_folder` says whether OUT is one.
///
/// # Errors
/// If the extension names none, or a .gltf should go to standard output.
pub(crate) fn format(
    output: &Path,
    option: Option<FormatName>,
    is_folder: bool,
) -> Outcome<FormatName> {
    let to_stdout = output::is_standard_stream(output);
    let format = match option {
        Some(format) => format,
        None if to_stdout || is_folder => FormatName::Glb,
        None => FormatName::by_extension(output)?,
    };
    if to_stdout && format == FormatName::Gltf {
        return Err(Failure::usage(
            "a .gltf has a .bin beside it: write .glb to standard output instead",
        ));
    }
    Ok(format)
}

/// The path that the files of a result are named after.
pub(crate) fn path(target: &Target, format: FormatName) -> PathBuf {
    match target {
        Target::File(path) => path.clone(),
        Target::Stdout => PathBuf::from("stdout").with_extension(format.extension()),
    }
}

/// Writes a mesh's files, of which the first refers to the others.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(target: &Target, files: Vec<OutputFile>) -> Outcome<()> {
    match target {
        Target::File(_) => output::commit(&files),
        // Standard output takes the mesh only: a file that belongs to it (an MTL) is left out.
        Target::Stdout => {
            files.into_iter().next().map_or(Ok(()), |first| console::bytes(&first.bytes))
        }
    }
}
