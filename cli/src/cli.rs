//! The command line as `clap` sees it: every command, and the options all of them have.

use crate::commands::{
    bench, build, chain, compare, completions, config, extract, info, man, pack, render, select,
    shaders, strips, unpack, verify, view,
};
use clap::{Args, Parser, Subcommand};

/// Continuous level of detail: every level between a full mesh and a single point, in one verified
/// file.
#[derive(Debug, Parser)]
#[command(name = "lodc", version, propagate_version = true, arg_required_else_help = true)]
#[command(after_help = "Exit status: 0 done, 1 a check found a difference, 2 wrong usage, \
                  3 bad input, 4 output not written, 5 a limit was reached, 6 no usable GPU, \
                  70 a bug.")]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) common: CommonArgs,
}

/// Options of every command.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct CommonArgs {
    /// Print errors only
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// Print seconds and peak memory of every stage
    #[arg(short, long, global = true, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
}

/// The command and its options.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Turn OBJ, glTF or GLB files into .lodc files
    Build(build::BuildArgs),
    /// Take one level of detail out of meshes or .lodc files
    Extract(extract::ExtractArgs),
    /// Write a few levels for engines: one file over one vertex buffer, or a file each
    Chain(chain::ChainArgs),
    /// Show what is inside a .lodc file
    Info(info::InfoArgs),
    /// Replay every model of .lodc files against the reference
    Verify(verify::VerifyArgs),
    /// Say how far apart two meshes are, in space and in pictures
    Compare(compare::CompareArgs),
    /// Make a picture of a mesh, or of levels of detail, with a graphics device
    Render(render::RenderArgs),
    /// Make an offline page that shows every level in a browser
    View(view::PageArgs),
    /// Make an offline page for approving an asset: pictures, errors, storage, checks
    Report(view::PageArgs),
    /// Turn a .lodc file into a progressive stream
    Pack(pack::PackArgs),
    /// Turn a progressive stream, or as much as there is of it, into a mesh file
    Unpack(unpack::UnpackArgs),
    /// Write the triangle strips of a mesh as text
    Strips(strips::StripsArgs),
    /// Write the WGSL that an engine needs to show models, and a guide to it
    Shaders(shaders::ShadersArgs),
    /// Choose levels for a distance, or for all instances of a scene under a budget
    Select(select::SelectArgs),
    /// Measure storage, extraction time, bus traffic and primitives
    Bench(bench::BenchArgs),
    /// Show what lodc.toml says of an asset
    Config(config::ShowArgs),
    /// Print a completion script for a shell
    Completions(completions::CompletionsArgs),
    /// Print a manual page
    Man(man::ManArgs),
}

impl Command {
    /// Returns whether a graphics device may be opened.
    pub(crate) fn takes_gpu(&self) -> bool {
        match self {
            Self::Render(_) => true,
            Self::Verify(args) => args.gpu.gpu.is_some(),
            Self::Bench(args) => args.gpu.gpu.is_some() || args.draws(),
            _ => false,
        }
    }

    /// Returns whether meshes that may be large are simplified, or whole sequences replayed.
    pub(crate) fn takes_memory(&self) -> bool {
        match self {
            Self::Build(args) => !args.is_small(),
            Self::Bench(_) | Self::Chain(_) | Self::Extract(_) => true,
            Self::Pack(_) | Self::Unpack(_) | Self::Verify(_) => true,
            _ => false,
        }
    }
}
