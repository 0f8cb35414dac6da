//! docs/OPTIONS.md lists all options as `--help` does: this test compares them, and `UPDATE=1`
//! writes the page (`just options`).

use super::Cli;
use clap::{Arg, Command, CommandFactory};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// A row of the page: how an option is typed, what it does, its default.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Row {
    typed: String,
    meaning: String,
    default: String,
}

impl Row {
    fn of(option: &Arg) -> Self {
        let help = option.get_help().unwrap_or_default().to_string();
        let (meaning, default) = match help.split_once(" [default: ") {
            Some((meaning, default)) => (meaning, default.trim_end_matches(']').to_owned()),
            None => {
                let values = option.get_default_values().iter();
                let values: Vec<_> = values.map(|v| v.to_string_lossy()).collect();
                let takes = option.get_action().takes_values();
                (help.as_str(), if takes { values.join(" ") } else { String::new() })
            }
        };
        let required = if option.is_required_set() { "(required)" } else { &default };
        Self { typed: typed(option), meaning: with_code(meaning), default: with_code(required) }
    }

    fn text(&self) -> String {
        format!("| `{}` | {} | {} |", self.typed, self.meaning, self.default)
    }
}

/// `-o, --output OUT`, `--format glb|gltf`.
fn typed(option: &Arg) -> String {
    let short = option.get_short().map(|c| format!("-{c}, ")).unwrap_or_default();
    let long = option.get_long().expect("every option has a long name");
    let values = option.get_possible_values();
    let value = if !option.get_action().takes_values() {
        String::new()
    } else if values.is_empty() {
        let names = option.get_value_names().expect("options with values name them");
        format!(" {}", names[0])
    } else {
        let values: Vec<&str> = values.iter().map(|value| value.get_name()).collect();
        let values = values.join("|");
        if option.is_require_equals_set() { format!("[={values}]") } else { format!(" {values}") }
    };
    format!("{short}--{long}{value}").replace('|', "\\|")
}

/// Text with options as code.
fn with_code(text: &str) -> String {
    let word = |word: &str| {
        let end = word.rfind(|c: char| c.is_alphanumeric()).map_or(0, |at| at + 1);
        match word.starts_with("--") && end > 0 {
            true => format!("`{}`{}", &word[..end], &word[end..]),
            false => word.replace('|', "\\|").replace('*', "\\*"),
        }
    };
    text.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

/// The rows of the visible commands, by group in the order of the help.
struct Options {
    /// Command, group, row.
    all: Vec<(String, String, Row)>,
}

impl Options {
    fn new(program: &Command) -> Self {
        let visible = program.get_subcommands().filter(|c| !c.is_hide_set());
        let all = visible.flat_map(|command| {
            let options =
                command.get_arguments().filter(|a| !a.is_positional() && !a.is_hide_set());
            options.map(|option| {
                let group = option.get_help_heading().expect("every option is in a group");
                (command.get_name().to_owned(), group.to_owned(), Row::of(option))
            })
        });
        Self { all: all.filter(|(command, ..)| command != "help").collect() }
    }

    /// The commands that have an option.
    fn commands_of(&self, group: &str, row: &Row) -> Vec<&str> {
        let same = self.all.iter().filter(|(_, g, r)| g == group && r == row);
        same.map(|(command, ..)| command.as_str()).collect()
    }

    fn is_shared(&self, group: &str, row: &Row) -> bool {
        self.commands_of(group, row).len() > 1
    }

    /// The options of several commands, under their groups and the commands that have them.
    fn shared(&self) -> String {
        let mut groups: Vec<(String, Vec<&Row>)> = Vec::new();
        let mut all_commands: Vec<&str> = self.all.iter().map(|(c, ..)| c.as_str()).collect();
        all_commands.dedup();
        for (_, group, row) in self.all.iter().filter(|(_, group, row)| self.is_shared(group, row))
        {
            let commands = self.commands_of(group, row);
            let names = match commands == all_commands {
                true => "every command".to_owned(),
                false => commands.join(", "),
            };
            let title = format!("| **{group}**: {names} | | |");
            match groups.iter_mut().find(|(t, _)| *t == title) {
                Some((_, rows)) if rows.contains(&row) => {}
                Some((_, rows)) => rows.push(row),
                None => groups.push((title, vec![row])),
            }
        }
        let order = |title: &str| {
            let first =
                |(_, group, _): &(_, String, _)| title.starts_with(&format!("| **{group}*"));
            self.all.iter().position(first)
        };
        groups.sort_by_key(|(title, _)| order(title));
        let mut lines =
            vec!["| option | meaning | default |".to_owned(), "| --- | --- | --- |".into()];
        for (title, rows) in groups {
            lines.push(title);
            lines.extend(rows.into_iter().map(Row::text));
        }
        lines.join("\n")
    }

    /// The options of one command, and the groups that it shares with others.
    fn of_command(&self, command: &str) -> String {
        let rows_of_command = || self.all.iter().filter(|(name, ..)| name == command);
        let mut lines = Vec::new();
        let mut groups: BTreeMap<usize, (&str, Vec<String>)> = BTreeMap::new();
        let mut shared: Vec<&str> = Vec::new();
        for (_, group, row) in rows_of_command() {
            if self.is_shared(group, row) {
                if !shared.contains(&group.as_str()) && group != super::GENERAL {
                    shared.push(group);
                }
                continue;
            }
            let position = rows_of_command().position(|(_, g, _)| g == group).expect("it is there");
            groups.entry(position).or_insert((group, Vec::new())).1.push(row.text());
        }
        if !groups.is_empty() {
            lines.push("| option | meaning | default |\n| --- | --- | --- |".to_owned());
        }
        for (group, rows) in groups.into_values() {
            lines.push(format!("| **{group}** | | |"));
            lines.extend(rows);
        }
        if !shared.is_empty() {
            let and = if lines.is_empty() { "" } else { "\n" };
            let shared = shared.join(", ");
            lines.push(format!("{and}[Shared](#options-of-several-commands): {shared}."));
        }
        lines.join("\n")
    }
}

/// The commands that the program lists.
fn commands(program: &Command) -> String {
    let visible = program.get_subcommands().filter(|c| !c.is_hide_set() && c.get_name() != "help");
    let row = |command: &Command| {
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        format!("| `{}` | {about} |", command.get_name())
    };
    let rows: Vec<String> = visible.map(row).collect();
    format!("| command | does |\n| --- | --- |\n{}", rows.join("\n"))
}

/// The whole page.
fn page(program: &Command) -> String {
    let options = Options::new(program);
    let mut parts = vec![
        "# Commands and options".to_owned(),
        "Made from the program. [CLI.md](CLI.md) says what they promise.".to_owned(),
        commands(program),
        "## Options of several commands".to_owned(),
        options.shared(),
    ];
    let mut names: Vec<&str> = options.all.iter().map(|(command, ..)| command.as_str()).collect();
    names.dedup();
    for name in names {
        parts.extend([format!("## {name}"), options.of_command(name)]);
    }
    parts.join("\n\n") + "\n"
}

#[test]
fn the_page_of_options_is_that_of_the_program() {
    let mut program = Cli::command();
    program.build();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/OPTIONS.md");
    let made = page(&program);
    if std::env::var_os("UPDATE").is_some() {
        fs::write(&path, &made).expect("the page can be written");
        return;
    }
    let text = fs::read_to_string(&path).expect("the page");
    for (line, made) in text.lines().zip(made.lines()) {
        assert_eq!(line, made, "docs/OPTIONS.md shows something else: `just options` writes it");
    }
    assert_eq!(text.lines().count(), made.lines().count(), "docs/OPTIONS.md: run `just options`");
}
