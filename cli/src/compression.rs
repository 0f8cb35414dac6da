//! Options of geometry compression (meshopt) and quantisation.

use crate::bits;
use crate::exit::{Failure, Outcome};
use crate::help::BECOMES;
use crate::mesh_output::FormatName;
use clap::{Args, ValueEnum};
use lodc::level_mesh::Order;
use lodc_formats::OutputFile;
use lodc_formats::export::{ExportOptions, Precision};
use lodc_formats::images::PlacedTextures;
use lodc_report::text::size;

/// Options of compression.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = BECOMES)]
pub(crate) struct CompressArgs {
    /// Compression of .glb and .gltf [default: as in the input]
    ///
    /// Of geometry, samples of animations and matrices of skins. A .lodc file is not compressed.
    /// Files that compression and --quantize together would make larger have neither, with a
    /// warning.
    #[arg(long, value_enum)]
    compress: Option<Compression>,
    /// Bits per number in .glb and .gltf: pos=14,normal=10,uv=12 [default: all]
    ///
    /// From 2 to 16 for pos, normal (tangents, too), uv, color and weight (of skins), by
    /// KHR_mesh_quantization; kinds left out stay as they are. The step of positions is the same
    /// for all objects as the scene shows them.
    #[arg(long, value_name = "KIND=BITS,…", value_parser = precision)]
    quantize: Option<Precision>,
}

/// Compressions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Compression {
    /// EXT_meshopt_compression, without loss
    Meshopt,
    /// None
    None,
}

/// Compression and precision of one output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EncodeOptions {
    compress: bool,
    pub(crate) precision: Precision,
}

impl EncodeOptions {
    /// What to write instead if files become larger by this: neither compressed nor quantised. None
    /// unless both are on: only then are files meant to be small.
    pub(crate) fn alternative(self) -> Option<Self> {
        let precision = Precision::default();
        (self.compress && self.precision != precision)
            .then_some(Self { compress: false, precision })
    }

    /// A line for people where the alternative is smaller; `packed` and `plain` are the files.
    pub(crate) fn prefers_plain(packed: &[OutputFile], plain: &[OutputFile]) -> Option<String> {
        let bytes = |files: &[OutputFile]| files.iter().map(|f| f.bytes.len() as u64).sum::<u64>();
        let [packed, plain] = [packed, plain].map(bytes);
        (plain < packed).then(|| {
            format!(
                "written without quantisation and compression, which would take {} instead of {}",
                size(packed),
                size(plain)
            )
        })
    }

    /// How an export is encoded.
    pub(crate) fn of(options: &ExportOptions) -> Self {
        Self { compress: options.compress, precision: options.precision }
    }

    /// The contents of an export besides its objects and their provenance.
    pub(crate) fn options(self, textures: PlacedTextures) -> ExportOptions {
        let Self { compress, precision } = self;
        ExportOptions { textures, compress, precision, provenance: None }
    }

    /// The order of triangles where none is asked for.
    pub(crate) fn order(self) -> Order {
        if self.compress { Order::Size } else { Order::Cache }
    }
}

impl CompressArgs {
    /// Returns whether a result is compressed, and the bits that its numbers keep.
    ///
    /// # Errors
    /// If either was asked for and the format has neither.
    pub(crate) fn wanted(
        &self,
        format: FormatName,
        input_is_compressed: bool,
    ) -> Outcome<EncodeOptions> {
        let supports_both = format.is_gltf();
        if self.compress == Some(Compression::Meshopt) && !supports_both {
            return Err(Failure::usage("only .glb and .gltf can be compressed"));
        }
        if self.quantize.is_some() && !supports_both {
            return Err(Failure::usage("only .glb and .gltf can be quantised"));
        }
        let compress = supports_both
            && self.compress.map_or(input_is_compressed, |c| c == Compression::Meshopt);
        Ok(EncodeOptions { compress, precision: self.quantize.unwrap_or_default() })
    }
}

/// Reads `pos=14,normal=10`.
fn precision(text: &str) -> Result<Precision, String> {
    let kinds = ["pos", "normal", "uv", "color", "weight"];
    let [position, normal, uv, color, weight] = bits::bits_by_kind(text, kinds, &(2..=16))?;
    Ok(Precision { position, normal, uv, color, weight })
}
