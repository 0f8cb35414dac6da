//! `lodc shaders`: the WGSL that an engine needs, and the guide to it.

use crate::console::note;
use crate::exit::{Failure, Outcome};
use crate::help::{MORE, OUTPUT};
use crate::output::{self, Target};
use clap::Args;
use lodc_formats::OutputFile;
use lodc_lod::ModelKind;
use lodc_report::text::count;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The guide beside the shaders.
const GUIDE: &str = include_str!("../../ENGINE.md");

/// Options of `shaders`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct ShadersArgs {
    /// Folder to write to; created if missing
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    output: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  lodc shaders -o shaders
  lodc shaders -o engine/src/wgsl -q";

pub(crate) fn run(args: &ShadersArgs) -> Outcome<()> {
    if output::is_standard_stream(&args.output) {
        return Err(Failure::usage("several files cannot go to standard output: name a folder"));
    }
    // Models share kernels: each is written once.
    let shaders = ModelKind::ALL.into_iter().flat_map(|kind| kind.shaders());
    let texts: BTreeMap<String, String> =
        shaders.map(|s| (format!("{}.wgsl", s.name), s.text())).collect();
    let guide = std::iter::once(("ENGINE.md".to_owned(), GUIDE.to_owned()));
    let files: Vec<OutputFile> = (texts.into_iter().chain(guide))
        .map(|(name, text)| OutputFile { path: args.output.join(name), bytes: text.into_bytes() })
        .collect();
    let targets: Vec<Target> = files.iter().map(|file| Target::File(file.path.clone())).collect();
    output::prepare_targets(&targets, true)?;
    output::commit(&files)?;
    note(&format!("{}: {}", args.output.display(), count(files.len() as u64, "file")));
    Ok(())
}
