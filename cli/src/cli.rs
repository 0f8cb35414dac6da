//! The command line as `clap` sees it: every command, and the options that all of them have.

use crate::commands::{
    bench, building, chain, compare, completions, config, extract, info, man, pack, render, report,
    select, shaders, strips, unpack, verify, view,
};
use crate::help::{GENERAL, MORE};
use crate::numbers::whole;
use clap::{ArgAction, Args, Parser, Subcommand};
use std::num::NonZeroUsize;

/// Continuous level of detail: every level between a full mesh and a single point, in one verified
/// file.
#[derive(Debug, Parser)]
#[command(
    name = "lodc",
    version,
    propagate_version = true,
    arg_required_else_help = true,
    disable_help_flag = true,
    disable_version_flag = true,
    after_help = EXAMPLES
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) common: CommonArgs,
}

const EXAMPLES: &str = "\
Examples:
  lodc extract chair.glb --ratio 25% -o chair.quarter.glb
  lodc build chair.glb -o chair.lodc
  lodc verify chair.lodc --source chair.glb

`lodc COMMAND -h` shows the options needed most, `lodc COMMAND --help` all of them.
Exit status: 0 done, 1 a check found a difference, 2 wrong usage, 3 bad input, 4 output not \
written, 5 a limit was reached, 6 no usable GPU, 70 a bug.";

/// Options of every command.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = GENERAL)]
pub(crate) struct CommonArgs {
    /// Print errors only
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// Print seconds and peak memory of every stage
    #[arg(short, long, global = true, conflicts_with = "quiet", hide_short_help = true)]
    pub(crate) verbose: bool,
    /// Threads; no result depends on it [default: all cores]
    #[arg(long, value_name = "N", value_parser = whole::<NonZeroUsize>(1..), global = true,
          hide_short_help = true)]
    pub(crate) jobs: Option<NonZeroUsize>,
    /// Show help (-h: common options; --help: all options and examples)
    #[arg(id = "help", short, long, global = true, action = ArgAction::Help)]
    _help: Option<bool>,
    /// Print the version
    #[arg(id = "version", short = 'V', long, global = true, action = ArgAction::Version,
          hide_short_help = true)]
    _version: Option<bool>,
}

/// The command and its options.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Turn glTF, GLB, OBJ, PLY or STL files into .lodc files, which hold every level
    Build(building::BuildArgs),
    /// Take one level of detail out of meshes or .lodc files
    Extract(extract::ExtractArgs),
    /// Write a few levels for engines: one file, or a file for each
    Chain(chain::ChainArgs),
    /// Make an offline page that shows every level in a browser
    #[command(after_help = MORE, after_long_help = view::EXAMPLES)]
    View(view::ViewArgs),
    /// Show what is inside .lodc files and .lods streams
    Info(info::InfoArgs),
    /// Replay every model of .lodc files against the reference
    Verify(verify::VerifyArgs),
    /// Say how far apart two meshes are, in space and in pictures
    Compare(compare::CompareArgs),
    /// Make a picture of a mesh, or of levels
    Render(render::RenderArgs),
    /// Make an offline page for approving an asset: pictures, errors, checks
    #[command(after_help = MORE, after_long_help = report::EXAMPLES)]
    Report(view::PageArgs),
    /// Choose levels for a distance, or for all instances under a budget
    Select(select::SelectArgs),
    /// Write the WGSL that an engine needs to show models, and a guide to it
    Shaders(shaders::ShadersArgs),
    /// Turn a .lodc file into a progressive stream
    Pack(pack::PackArgs),
    /// Turn a stream, or as much as there is of it, into a mesh file
    Unpack(unpack::UnpackArgs),
    /// Show what lodc.toml says of an asset
    Config(config::ShowArgs),
    /// Measure storage, extraction time, bus traffic and primitives
    Bench(bench::BenchArgs),
    /// Write the triangle strips of a mesh as text
    Strips(strips::StripsArgs),
    /// Print a completion script for a shell
    #[command(hide = true)]
    Completions(completions::CompletionsArgs),
    /// Print a manual page
    #[command(hide = true)]
    Man(man::ManArgs),
}

impl Command {
    /// Returns whether a graphics device may be opened.
    pub(crate) fn uses_gpu(&self) -> bool {
        match self {
            Self::Verify(args) => args.gpu.gpu.is_some(),
            Self::Bench(args) => args.gpu.gpu.is_some(),
            _ => false,
        }
    }

    /// Returns whether it simplifies meshes that may be large, or replays whole sequences.
    pub(crate) fn needs_much_memory(&self) -> bool {
        match self {
            Self::Build(args) => !args.is_small(),
            Self::Chain(args) => !args.is_small(),
            Self::Extract(args) => !args.is_small(),
            Self::Bench(_) => true,
            Self::Pack(_) | Self::Unpack(_) | Self::Verify(_) => true,
            _ => false,
        }
    }
}

#[cfg(test)]
#[path = "page_tests.rs"]
mod page_tests;
#[cfg(test)]
#[path = "cli_tests.rs"]
mod tests;
