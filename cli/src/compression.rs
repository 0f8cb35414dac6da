//! Options that say how geometry is compressed.

use crate::exit::{Failure, Outcome};
use crate::mesh_output::FormatName;
use clap::{Args, ValueEnum};

/// Options of compression.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct CompressArgs {
    /// Compression of geometry in .glb and .gltf [default: as in the input]
    #[arg(long, value_enum)]
    compress: Option<Compression>,
}

/// Compressions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Compression {
    /// EXT_meshopt_compression, without loss
    Meshopt,
    /// None
    None,
}

impl CompressArgs {
    /// Returns whether to compress what was compressed or was not.
    ///
    /// # Errors
    /// If the format knows no compression and it was asked for.
    pub(crate) fn wanted(&self, format: FormatName, input: bool) -> Outcome<bool> {
        let can = matches!(format, FormatName::Glb | FormatName::Gltf);
        if self.compress == Some(Compression::Meshopt) && !can {
            return Err(Failure::usage("only .glb and .gltf can be compressed"));
        }
        Ok(can && self.compress.map_or(input, |c| c == Compression::Meshopt))
    }
}
