//! `lodc completions`: a completion script for a shell.

use crate::console;
use crate::exit::Outcome;
use crate::help::MORE;
use clap::{Args, Command};
use clap_complete::Shell;

/// Options of `completions`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct CompletionsArgs {
    /// Shell to write the script for
    shell: Shell,
}

const EXAMPLES: &str = "\
Examples:
  lodc completions bash > ~/.local/share/bash-completion/completions/lodc
  lodc completions zsh";

/// Prints the script for `program`, the whole command line.
pub(crate) fn run(args: &CompletionsArgs, mut program: Command) -> Outcome<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "lodc", &mut script);
    console::result(String::from_utf8_lossy(&script).trim_end())
}
