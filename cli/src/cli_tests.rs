use super::*;
use clap::{Arg, CommandFactory};

/// The program and every command, hidden ones included, as they are when they print help.
fn commands() -> Vec<clap::Command> {
    commands_in(100)
}

/// The same in a terminal of `columns` columns.
fn commands_in(columns: usize) -> Vec<clap::Command> {
    let mut program = Cli::command().term_width(columns);
    program.build();
    let each = program.get_subcommands().filter(|c| c.get_name() != "help");
    let each: Vec<clap::Command> = each.map(|c| c.clone().term_width(columns)).collect();
    [vec![program], each].concat()
}

fn options(command: &clap::Command) -> impl Iterator<Item = &Arg> {
    command.get_arguments().filter(|arg| !arg.is_positional())
}

#[test]
fn the_definition_is_sound() {
    Cli::command().debug_assert();
}

#[test]
fn short_help_fits_a_screen_and_leads_to_the_rest() {
    for columns in [80, 100] {
        for mut command in commands_in(columns) {
            let help = command.render_help().to_string();
            let lines = help.lines().count();
            assert!(lines <= 40, "{}: {lines} lines\n{help}", command.get_name());
            assert!(help.lines().all(|line| line.chars().count() <= columns), "{help}");
            let last = help.lines().last().expect("a last line");
            assert!(last.contains("--help") || command.get_name() == "lodc", "{help}");
        }
    }
}

#[test]
fn every_option_is_in_a_group_of_the_long_help_with_a_short_first_line() {
    for mut command in commands() {
        let long = command.render_long_help().to_string();
        let name = command.get_name();
        for option in options(&command) {
            let option_name = option.get_long().expect("every option has a long name");
            let help = option.get_help().unwrap_or_default().to_string();
            assert!(!help.is_empty(), "{name} --{option_name} has no help");
            let words = help.split(" [default").next().unwrap_or_default();
            let length = words.chars().count();
            assert!(length <= 76, "{name} --{option_name}: {length} characters: {words}");
            assert!(option.get_help_heading().is_some(), "{name} --{option_name} has no heading");
            let shown = long.contains(&format!("--{option_name}"));
            assert!(shown && !option.is_hide_set(), "{name}: {long}");
        }
        for argument in command.get_positionals() {
            assert!(argument.get_help().is_some(), "{name} {}", argument.get_id());
        }
    }
}

/// The words of a line of a shell, up to what the shell does with the output.
fn words(line: &str) -> Vec<String> {
    let line = line.split(" | ").next().unwrap_or_default().split(" > ").next().unwrap_or_default();
    let quoted = line.split('\'').enumerate();
    let parts = quoted.flat_map(|(number, part)| match number % 2 {
        0 => part.split_whitespace().map(str::to_owned).collect(),
        _ => vec![part.to_owned()],
    });
    parts.collect()
}

#[test]
fn examples_are_commands_that_the_parser_takes() {
    for command in commands() {
        let (short, long) = (command.get_after_help(), command.get_after_long_help());
        let text = long.or(short).map(ToString::to_string).unwrap_or_default();
        let lines: Vec<&str> = text.lines().filter(|line| line.starts_with("  lodc ")).collect();
        let name = command.get_name();
        assert!((2..=3).contains(&lines.len()), "{name}: {text}");
        for line in lines {
            let matches = Cli::command().try_get_matches_from(words(line));
            let matches = matches.unwrap_or_else(|e| panic!("{line}: {e}"));
            let parsed = matches.subcommand_name().unwrap_or_default();
            assert!(parsed == name || name == "lodc", "{line} is in the help of {name}");
        }
    }
}
