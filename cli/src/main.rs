//! The `lodc` program: commands to functions, results to exit statuses. The other modules read
//! options and files and print; levels are made in the libraries.

mod batch;
mod bits;
mod cli;
mod clock;
mod commands;
mod compression;
mod config;
mod console;
mod environment;
mod exit;
mod gpu;
mod help;
mod huge_pages;
mod importance;
mod interrupt;
mod jobs;
mod kinds;
mod limits;
mod memory;
mod mesh_output;
mod numbers;
mod output;
mod parts;
mod pose;
mod program;
mod progress;
mod results;
mod rounding;
mod selector;
mod stages;
mod textures;
mod threads;
mod version;
mod views;
mod warnings;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use cli::{Cli, Command};
use commands::{
    bench, building, chain, compare, completions, config as config_command, extract, info, man,
    pack, render, select, shaders, strips, unpack, verify, view,
};
use console::Loudness;
use exit::{Outcome, Status};
use mimalloc::MiMalloc;
use program::Program;
use std::panic;
use std::process::ExitCode;
use std::time::Instant;

/// Returns freed memory to the system. A region of the simplifier allocates a dozen lists for one
/// round; the allocators of systems keep much of that, glibc's a third of the peak.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    huge_pages::forbid();
    panic::set_hook(Box::new(report_panic));
    let status =
        panic::catch_unwind(run).unwrap_or_else(|payload| {
            match clock::time_limit_failure(&*payload) {
                Some(failure) => {
                    console::error(&failure);
                    failure.status
                }
                None => Status::Bug,
            }
        });
    ExitCode::from(status.code())
}

fn run() -> Status {
    if version::is_asked_for_as_json() {
        return version::print().map_or_else(|failure| failure.status, |()| Status::Done);
    }
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if error.kind() == ErrorKind::ValueValidation => {
            // The first line has the reason; the others point to help that has no more of it.
            let text = error.to_string();
            let line = text.lines().next().unwrap_or_default();
            console::error(&line.trim_start_matches("error: "));
            return Status::Usage;
        }
        Err(error) => {
            // Help and versions come as errors too. A closed pipe does not matter here.
            let _ = error.print();
            return if error.use_stderr() { Status::Usage } else { Status::Done };
        }
    };
    let program = Program::new(Cli::command);
    let mut variables = Vec::new();
    if cfg!(feature = "gpu") && cli.command.uses_gpu() {
        variables.push(environment::RUNTIME_FOLDER);
    }
    if cli.command.needs_much_memory() {
        variables.push(environment::RETURN_MEMORY);
    }
    environment::restart_with(&variables);
    console::set_loudness(match (cli.common.quiet, cli.common.verbose) {
        (true, _) => Loudness::Quiet,
        (_, true) => Loudness::Verbose,
        _ => Loudness::Normal,
    });
    let start = Instant::now();
    let without_status = |outcome: Outcome<()>| outcome.map(|()| Status::Done);
    let outcome = interrupt::install().and_then(|()| threads::start(cli.common.jobs)).and_then(
        |()| match &cli.command {
            Command::Build(args) => building::run(args, &program),
            Command::Extract(args) => extract::run(args, &program),
            Command::Chain(args) => chain::run(args, &program),
            Command::Info(args) => info::run(args),
            Command::Verify(args) => verify::run(args, &program),
            Command::Compare(args) => compare::run(args, &program),
            Command::Render(args) => without_status(render::run(args)),
            Command::Report(args) => commands::report::run(args),
            Command::View(args) => without_status(view::run(args)),
            Command::Pack(args) => pack::run(args, &program),
            Command::Unpack(args) => unpack::run(args),
            Command::Strips(args) => without_status(strips::run(args)),
            Command::Shaders(args) => without_status(shaders::run(args)),
            Command::Select(args) => without_status(select::run(args)),
            Command::Bench(args) => bench::run(args),
            Command::Config(args) => without_status(config_command::run(args, &program)),
            Command::Completions(args) => without_status(completions::run(args, Cli::command())),
            Command::Man(args) => without_status(man::run(args, Cli::command())),
        },
    );
    stages::print("all", start.elapsed().as_secs_f64());
    outcome.unwrap_or_else(|failure| {
        console::error(&failure);
        failure.status
    })
}

/// Prints one line instead of a back-trace. `main` or the work on one input catches the panic and
/// ends with status 70.
fn report_panic(info: &panic::PanicHookInfo<'_>) {
    let site =
        info.location().map(|l| format!(" at {}:{}", l.file(), l.line())).unwrap_or_default();
    let payload = info.payload();
    let text = payload
        .downcast_ref::<&str>()
        .copied()
        .or(payload.downcast_ref::<String>().map(String::as_str));
    let what = exit::one_line(text.unwrap_or("no reason given"));
    console::error(&format_args!("internal error{site}: {what}; {}", exit::REPORT_IT));
}
