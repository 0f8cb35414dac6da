//! `lodc completions`: a script that teaches a shell the options.

use crate::cli::Cli;
use crate::console;
use crate::exit::Outcome;
use clap::{Args, CommandFactory};
use clap_complete::Shell;

/// Options of `completions`.
#[derive(Args, Debug)]
pub(crate) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

pub(crate) fn run(args: &CompletionsArgs) -> Outcome<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "lodc", &mut script);
    console::result(String::from_utf8_lossy(&script).trim_end())
}
