//! Options of single assets, from `lodc.toml` and lists: `clap` parses them as if they had been
//! typed.

use crate::jobs::{CommandOptions, LIMIT_OPTION, OptionValues, ValueCheck, Vocabulary};
use crate::parts;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::parser::ValueSource;
use clap::{ArgMatches, Command, FromArgMatches, Id};
use std::cell::OnceCell;
use std::ffi::OsString;
use std::rc::Rc;

/// Options that hold for a whole run: no asset can have them of its own.
const RUN_OPTIONS: &[&str] = &[
    "annotate",
    "baseline",
    "config",
    "depfile",
    "exclude",
    "format",
    "heatmap",
    "help",
    "if-changed",
    "include",
    "jobs",
    "json",
    "junit",
    "manifest",
    "output",
    "profile",
    "prune",
    "quiet",
    "record",
    "report",
    "shard",
    "verbose",
];

/// The definition of the command line, and the options in it that assets can have of their own;
/// these are found on demand, as most runs have none.
pub(crate) struct Program {
    root: fn() -> Command,
    vocabulary: OnceCell<Vocabulary>,
}

impl Program {
    pub(crate) fn new(root: fn() -> Command) -> Self {
        Self { root, vocabulary: OnceCell::new() }
    }

    /// The names of commands and of their options.
    pub(crate) fn vocabulary(&self) -> &Vocabulary {
        self.vocabulary.get_or_init(|| {
            let mut root = (self.root)();
            // Only this makes the groups that arguments name without defining them.
            root.build();
            Vocabulary {
                commands: root.get_subcommands().map(options_of).collect(),
                run_options: RUN_OPTIONS,
                check_part: |text| parts::part(text).map(drop),
                check_value: value_check(self.root),
            }
        })
    }

    /// Returns the long names of the options of a command that are on the command line itself, or
    /// are excluded by those.
    pub(crate) fn given(&self, name: &str) -> Vec<String> {
        let root = (self.root)();
        let matches = root.clone().get_matches_from(std::env::args_os());
        let matches = matches.subcommand_matches(name).expect("the command that runs");
        let is_typed =
            |id: &Id| matches.value_source(id.as_str()) == Some(ValueSource::CommandLine);
        let typed = command(&root, name).get_arguments().filter(|a| is_typed(a.get_id()));
        let typed: Vec<String> = typed.filter_map(|a| a.get_long().map(str::to_owned)).collect();
        let excluded = self.vocabulary().command(name).excluded(&typed).map(str::to_owned);
        let excluded: Vec<String> = excluded.collect();
        [typed, excluded].concat()
    }

    /// Reads the arguments of a command anew, with an asset's own options where the command line
    /// has none of that name. Returns the command's arguments, and all options with their values as
    /// one text: equal texts mean equal options.
    ///
    /// # Errors
    /// In one line, if an option is unknown, holds for a whole run, or has a malformed value.
    pub(crate) fn arguments<A: FromArgMatches>(
        &self,
        name: &str,
        asset_options: &OptionValues,
    ) -> Result<(A, String), String> {
        let mut raw: Vec<OsString> = std::env::args_os().collect();
        let has_options = !asset_options.0.is_empty();
        let given = if has_options { self.given(name) } else { Vec::new() };
        let mut inserted = Vec::new();
        for (option, values) in &asset_options.0 {
            if RUN_OPTIONS.contains(&option.as_str()) {
                return Err(format!("option {option} is for a whole run, not for one asset"));
            }
            // Limits are inserted before those of the command line: for each key the last counts.
            if given.contains(option) && option != LIMIT_OPTION {
                continue;
            }
            match values.as_slice() {
                [] => inserted.push(format!("--{option}").into()),
                values => inserted.extend(values.iter().map(|v| format!("--{option}={v}").into())),
            }
        }
        let command_index = raw.iter().position(|arg| arg == name);
        let after_command = command_index.expect("the command's name is there") + 1;
        raw.splice(after_command..after_command, inserted);
        let root = (self.root)();
        let matches = root.clone().try_get_matches_from(raw).map_err(|e| first_line(&e))?;
        let matches = matches.subcommand_matches(name).expect("the same command");
        let read = A::from_arg_matches(matches).map_err(|e| first_line(&e))?;
        Ok((read, options_text(matches, command(&root, name))))
    }
}

/// Parses a value of an option as if it had been typed.
fn value_check(root: fn() -> Command) -> ValueCheck {
    ValueCheck(Rc::new(move |command, option, value| {
        let typed = ["lodc", command, &format!("--{option}={value}")];
        let Err(error) = root().try_get_matches_from(typed) else { return Ok(()) };
        let source = std::error::Error::source(&error).map(ToString::to_string);
        match (error.kind(), error.get(ContextKind::ValidValue), source) {
            (ErrorKind::InvalidValue, Some(ContextValue::Strings(known)), _) => {
                Err(format!("must be one of {}, not {value:?}", known.join(", ")))
            }
            (ErrorKind::ValueValidation, _, Some(why)) => Err(format!("{value:?}: {why}")),
            // The command lacks other arguments, which is no matter here.
            _ => Ok(()),
        }
    }))
}

fn command<'a>(root: &'a Command, name: &str) -> &'a Command {
    root.find_subcommand(name).expect("a command of this program")
}

/// The options of a command that assets can have.
fn options_of(command: &Command) -> CommandOptions {
    let visible = command.get_arguments().filter(|a| !a.is_hide_set());
    let names = visible.filter_map(|a| a.get_long());
    let options = names.filter(|n| !RUN_OPTIONS.contains(n)).map(str::to_owned).collect();
    let switches = command.get_arguments().filter(|a| !a.get_action().takes_values());
    let switches = switches.filter_map(|a| a.get_long()).map(str::to_owned).collect();
    let long = |id: &Id| {
        let mut all = command.get_arguments();
        all.find(|a| a.get_id() == id).and_then(|a| a.get_long()).map(str::to_owned)
    };
    // `is_multiple` needs a mutable group.
    let exclusive_groups = command.get_groups().cloned().filter_map(|mut group| {
        let names = group.get_args().filter_map(long).collect();
        (!group.is_multiple()).then_some(names)
    });
    CommandOptions {
        name: command.get_name().to_owned(),
        options,
        switches,
        exclusive_groups: exclusive_groups.collect(),
    }
}

/// The message about an option, without the usage around it.
fn first_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let mut lines = text.lines().map(str::trim);
    let what = lines.next().unwrap_or_default().trim_start_matches("error: ").to_owned();
    match lines.find(|line| line.starts_with("tip: ") || line.starts_with("[possible values: ")) {
        Some(tip) => format!("{what} ({})", tip.trim_matches(['[', ']'])),
        None => what,
    }
}

/// Every option of a command that can change an asset's result, with its values.
fn options_text(matches: &ArgMatches, command: &Command) -> String {
    let mut text = String::new();
    for argument in command.get_arguments() {
        let id = argument.get_id().as_str();
        let name = argument.get_long().unwrap_or_default();
        if name.is_empty() || RUN_OPTIONS.contains(&name) || name == LIMIT_OPTION {
            continue;
        }
        let values = matches.get_raw(id).into_iter().flatten();
        let values: Vec<_> = values.map(|v| v.to_string_lossy()).collect();
        text.push_str(&format!("{name}={};", values.join(",")));
    }
    text
}
