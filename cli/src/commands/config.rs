//! `lodc config`: the options that configuration files give to an asset.

use crate::config::ConfigArgs;
use crate::console;
use crate::exit::Outcome;
use crate::help::{CONFIGURATION, MORE};
use crate::program::Program;
use clap::Args;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Commands whose options can be in a configuration.
const COMMANDS: [&str; 4] = ["build", "chain", "compare", "extract"];

/// Options of `config`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct ShowArgs {
    /// Show which options apply to FILE, and from where
    #[arg(long, value_name = "FILE", required = true, help_heading = CONFIGURATION)]
    show: PathBuf,
    #[command(flatten)]
    configuration: ConfigArgs,
}

const EXAMPLES: &str = "\
Examples:
  lodc config --show models/chair.glb
  lodc config --show models/chair.glb --profile mobile";

pub(crate) fn run(args: &ShowArgs, program: &Program) -> Outcome<()> {
    let mut lines = Vec::new();
    for command in COMMANDS {
        let layers = args.configuration.layers(program, command, &args.show)?;
        let mut options = BTreeMap::new();
        for layer in &layers {
            if let Some(part) = layer.part_json() {
                lines.push(format!("{command} --part '{part}' # {}", layer.source));
            }
            for (name, values) in &layer.values.0 {
                options.insert(name, (values, &layer.source));
            }
        }
        for (name, (values, source)) in options {
            let option = match values.as_slice() {
                [] => format!("--{name}"),
                values => format!("--{name} {}", values.join(",")),
            };
            lines.push(format!("{command} {option:<32} # {source}"));
        }
    }
    if lines.is_empty() {
        let what = format!("{}: no lodc.toml applies to it", args.show.display());
        console::note(&what);
        return Ok(());
    }
    console::result(&lines.join("\n"))
}
