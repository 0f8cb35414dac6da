//! Options that an asset has of its own, from a list or a configuration: the command line's, by
//! their long names.

use clap::parser::ValueSource;
use clap::{ArgMatches, Command, FromArgMatches, Id};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::sync::OnceLock;

/// Options that were added, and the value that changes nothing: a result with it is the one of
/// before.
const ADDED: [(&str, &str); 1] = [("layout", "packed")];

/// Options that belong to a run, not to an asset.
const OF_THE_RUN: [&str; 21] = [
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
    "quiet",
    "record",
    "report",
    "shard",
    "verbose",
];

/// The option whose values have keys: each key counts by itself, the last one given.
const LIMIT: &str = "limit";

/// The command line as the program defines it: set once, so that nothing here depends on the
/// commands.
static ROOT: OnceLock<fn() -> Command> = OnceLock::new();

/// Makes the command line known.
pub(crate) fn know(root: fn() -> Command) {
    let _ = ROOT.set(root);
}

fn root() -> Command {
    ROOT.get().expect("the command line is known from the start")()
}

/// Values of options by long name, without dashes. A switch has none.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct OptionValues(pub(crate) BTreeMap<String, Vec<String>>);

impl OptionValues {
    /// Reads them from a JSON object. `false` says that a switch is off, like leaving it out.
    ///
    /// # Errors
    /// If a value is neither text, number, true, false nor a list of texts and numbers.
    pub(crate) fn from_json(
        object: &serde_json::Map<String, serde_json::Value>,
    ) -> Result<Self, String> {
        use serde_json::Value;
        let one = |name: &str, value: &Value| match value {
            Value::String(text) => Ok(text.clone()),
            Value::Number(number) => Ok(number.to_string()),
            _ => Err(format!("option {name}: a text, a number, true, false or a list is needed")),
        };
        let mut values = BTreeMap::new();
        for (name, value) in object {
            let list = match value {
                Value::Bool(false) => continue,
                Value::Bool(true) => vec![],
                Value::Array(list) => {
                    list.iter().map(|v| one(name, v)).collect::<Result<_, _>>()?
                }
                value => vec![one(name, value)?],
            };
            values.insert(name.clone(), list);
        }
        Ok(Self(values))
    }

    /// Those of `stronger`, and these where it has none, nor one that excludes them. Limits are
    /// known by their keys: of both, those of `stronger` stand last and count.
    pub(crate) fn under(mut self, mut stronger: Self, command: &str) -> Self {
        let names: Vec<&str> = stronger.0.keys().map(String::as_str).collect();
        for name in excluded(&names, command) {
            self.0.remove(name);
        }
        if let Some(last) = stronger.0.get_mut(LIMIT)
            && let Some(mut limits) = self.0.remove(LIMIT)
        {
            limits.append(last);
            *last = limits;
        }
        self.0.extend(stronger.0);
        self
    }
}

/// Returns the long names of the options that stand on the command line itself.
fn given(matches: &ArgMatches, command: &Command) -> Vec<String> {
    let arguments = command.get_arguments();
    let there = arguments
        .filter(|a| matches.value_source(a.get_id().as_str()) == Some(ValueSource::CommandLine));
    there.filter_map(|a| a.get_long().map(str::to_owned)).collect()
}

/// Returns the long names of the options of a command that stand on the command line itself, or are
/// excluded by those.
pub(crate) fn given_options(name: &str) -> Vec<String> {
    let root = root();
    let command = root.find_subcommand(name).expect("a command of this program");
    let typed = root.clone().get_matches_from(std::env::args_os());
    let typed = typed.subcommand_matches(name).expect("the command that runs");
    with_excluded(given(typed, command), name)
}

fn with_excluded(mut given: Vec<String>, command: &str) -> Vec<String> {
    let names: Vec<&str> = given.iter().map(String::as_str).collect();
    given.extend(excluded(&names, command).into_iter().map(str::to_owned));
    given
}

/// Returns the long names of options that cannot stand beside those of these names.
fn excluded<'a>(names: &[&str], command: &str) -> Vec<&'a str> {
    let command = commands().iter().find(|c| c.name == command).expect("a command");
    let groups = command.exclusive.iter();
    let met = groups.filter(|group| group.iter().any(|name| names.contains(&name.as_str())));
    met.flatten().map(String::as_str).collect()
}

/// Reads the arguments of a command anew, with an asset's own options where the command line has
/// none of that name. Returns what the command sees, and every option with its values as text, for
/// keys: equal texts mean equal options.
///
/// # Errors
/// In one line, if an option is unknown, belongs to a run, or has a value that is none.
pub(crate) fn arguments<A: FromArgMatches>(
    name: &str,
    own: &OptionValues,
) -> Result<(A, String), String> {
    let mut raw: Vec<OsString> = std::env::args_os().collect();
    let root = root();
    let command = root.find_subcommand(name).expect("a command of this program");
    let typed = root.clone().get_matches_from(&raw);
    let typed = typed.subcommand_matches(name).expect("the command that runs");
    let given = with_excluded(given(typed, command), name);
    let mut more = Vec::new();
    for (option, values) in &own.0 {
        if OF_THE_RUN.contains(&option.as_str()) {
            return Err(format!("option {option} is for a whole run, not for one asset"));
        }
        // These stand before those of the command line, so that its limits count.
        if given.contains(option) && option != LIMIT {
            continue;
        }
        match values.as_slice() {
            [] => more.push(format!("--{option}").into()),
            values => more.extend(values.iter().map(|v| format!("--{option}={v}").into())),
        }
    }
    let place = raw.iter().position(|arg| arg == name).expect("the command's name is there") + 1;
    raw.splice(place..place, more);
    let matches = root.clone().try_get_matches_from(raw).map_err(|e| first_line(&e))?;
    let matches = matches.subcommand_matches(name).expect("the same command");
    let read = A::from_arg_matches(matches).map_err(|e| first_line(&e))?;
    Ok((read, resolved(matches, command)))
}

/// The message about an option, without the usage around it.
fn first_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let mut lines = text.lines().map(str::trim);
    let what = lines.next().unwrap_or_default().trim_start_matches("error: ").to_owned();
    match lines.find(|line| line.starts_with("tip: ")) {
        Some(tip) => format!("{what} ({tip})"),
        None => what,
    }
}

/// Every option of an asset that can change its result, with its values.
fn resolved(matches: &ArgMatches, command: &Command) -> String {
    let mut text = String::new();
    for argument in command.get_arguments() {
        let id = argument.get_id().as_str();
        let name = argument.get_long().unwrap_or_default();
        if name.is_empty() || OF_THE_RUN.contains(&name) || name.starts_with(LIMIT) {
            continue;
        }
        let values = matches.get_raw(id).into_iter().flatten();
        let values: Vec<_> = values.map(|v| v.to_string_lossy()).collect();
        let default = |added: &(&str, &str)| added.0 == name && (values == [added.1]);
        if ADDED.iter().any(default) {
            continue;
        }
        text.push_str(&format!("{name}={};", values.join(",")));
    }
    text
}

/// The options of a command.
struct CommandOptions {
    name: String,
    /// Long names of those for assets.
    for_assets: Vec<String>,
    /// Long names of those of which only one can be given, group by group.
    exclusive: Vec<Vec<String>>,
}

impl CommandOptions {
    fn of(command: &Command) -> Self {
        let shown = command.get_arguments().filter(|a| !a.is_hide_set());
        let names = shown.filter_map(|a| a.get_long());
        let for_assets = names.filter(|n| !OF_THE_RUN.contains(n)).map(str::to_owned).collect();
        let long = |id: &Id| {
            let mut all = command.get_arguments();
            all.find(|a| a.get_id() == id).and_then(|a| a.get_long()).map(str::to_owned)
        };
        // Whether a group allows several can only be asked of a mutable one.
        let exclusive = command.get_groups().cloned().filter_map(|mut group| {
            let names = group.get_args().filter_map(long).collect();
            (!group.is_multiple()).then_some(names)
        });
        let exclusive = exclusive.collect();
        Self { name: command.get_name().to_owned(), for_assets, exclusive }
    }
}

/// The options of every command.
fn commands() -> &'static [CommandOptions] {
    static COMMANDS: OnceLock<Vec<CommandOptions>> = OnceLock::new();
    COMMANDS.get_or_init(|| {
        let mut root = root();
        // Groups that only arguments name are known then.
        root.build();
        root.get_subcommands().map(CommandOptions::of).collect()
    })
}

/// Returns whether a command, or any, has an option of this long name for assets.
pub(crate) fn has_option(command: Option<&str>, option: &str) -> bool {
    let mut of = commands().iter().filter(|c| command.is_none_or(|name| name == c.name));
    of.any(|c| c.for_assets.iter().any(|o| o == option))
}

/// Returns whether an option of this long name belongs to a run, not to an asset.
pub(crate) fn is_of_the_run(option: &str) -> bool {
    OF_THE_RUN.contains(&option)
}

/// Returns whether a command has this name.
pub(crate) fn is_command(name: &str) -> bool {
    commands().iter().any(|c| c.name == name)
}

/// The option of a command, or of any, whose name is most like a wrong one; none if none is.
pub(crate) fn suggestion(wrong: &str, command: Option<&str>) -> Option<&'static str> {
    let of = commands().iter().filter(|c| command.is_none_or(|name| name == c.name));
    let names = of.flat_map(|c| c.for_assets.iter().map(String::as_str));
    let near = names.map(|name| (strsim::jaro(wrong, name), name)).filter(|(s, _)| *s > 0.7);
    near.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, name)| name)
}
