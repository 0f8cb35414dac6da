//! `lodc man`: manual pages in roff, for `man -l -`.

use crate::console;
use crate::exit::{Failure, Outcome, Status};
use crate::help::MORE;
use clap::{Args, Command};

/// Options of `man`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct ManArgs {
    /// Command to describe [default: lodc as a whole]
    command: Option<String>,
}

const EXAMPLES: &str = "\
Examples:
  lodc man
  lodc man extract | man -l -";

/// Prints the page of `program`, the whole command line, or of one of its commands.
pub(crate) fn run(args: &ManArgs, mut program: Command) -> Outcome<()> {
    program.build();
    let page = match &args.command {
        None => program,
        Some(name) => match program.find_subcommand(name) {
            Some(command) => command.clone(),
            None => return Err(Failure::usage(format!("{name}: unknown command"))),
        },
    };
    // The page leaves out the only text of an option that the short help hides.
    let page = page.mut_args(|option| option.hide_short_help(false));
    let mut text = Vec::new();
    clap_mangen::Man::new(page)
        .render(&mut text)
        .map_err(|e| Failure::new(Status::Bug, e.to_string()))?;
    console::result(String::from_utf8_lossy(&text).trim_end())
}
