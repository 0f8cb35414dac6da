//! One configuration file: defaults, profiles, and overrides by glob.

use crate::jobs::error::JobError;
use crate::jobs::folder::globs;
use crate::jobs::options::{CommandOptions, OptionValues, Vocabulary, suggestion};
use indexmap::IndexMap;
use serde::Deserialize;
use serde_json::Value;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeArray, DeTable};

/// Options by long name; a table under a command's name has options of that command alone.
pub(super) type OptionTable = IndexMap<String, Value>;

/// A configuration file as it is in TOML.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(default)]
    defaults: OptionTable,
    #[serde(default)]
    profile: BTreeMap<String, OptionTable>,
    #[serde(default, rename = "override")]
    overrides: Vec<Override>,
}

/// The keys of an override that are lists of globs.
const GLOB_KEYS: [&str; 3] = ["files", "objects", "materials"];

/// Options for the files that match, or for parts of them.
#[derive(Debug, Deserialize)]
struct Override {
    /// Globs of paths below the configuration's folder; all files if there are none.
    #[serde(default)]
    files: Vec<String>,
    /// Globs of names of objects.
    #[serde(default)]
    objects: Vec<String>,
    /// Globs of names of materials.
    #[serde(default)]
    materials: Vec<String>,
    #[serde(flatten)]
    options: OptionTable,
}

/// The options that one table of a configuration has for an asset.
#[derive(Clone, Debug)]
pub(crate) struct ConfigLayer {
    /// File and table, for people.
    pub(crate) source: String,
    /// The options of a whole asset; empty if there is a `part`.
    pub(crate) values: OptionValues,
    /// The options of a part of an asset, with the globs that name it.
    pub(crate) part: Option<OptionTable>,
}

impl ConfigLayer {
    /// The options of the part as JSON.
    #[must_use]
    pub(crate) fn part_json(&self) -> Option<String> {
        self.part.as_ref().map(super::json)
    }
}

/// A table of a configuration.
struct Place {
    /// For people, such as `[profile.fast]`.
    name: String,
    /// The keys that lead to it; numbers, from 0, in an array.
    keys: Vec<String>,
    /// Whether its options are for parts of assets.
    is_part: bool,
}

impl Place {
    /// The keys that lead to a key of it.
    fn keys_of(&self, key: &str) -> Vec<String> {
        self.keys.iter().cloned().chain([key.to_owned()]).collect()
    }

    /// The table of a command in it.
    fn of_command(&self, command: &str) -> Self {
        let name = match self.name.strip_suffix(']') {
            Some(open) => format!("{open}.{command}]"),
            None => format!("{}, [override.{command}]", self.name),
        };
        Self { name, keys: self.keys_of(command), is_part: self.is_part }
    }

    /// Returns whether it is a whole override, which has globs beside its options.
    fn has_globs(&self) -> bool {
        matches!(&self.keys[..], [first, _] if first == "override")
    }
}

/// A configuration file that was read and checked.
#[derive(Debug)]
pub(super) struct ConfigFile {
    path: PathBuf,
    /// Canonical; the globs of overrides match paths below it.
    folder: PathBuf,
    text: String,
    document: Document,
    /// By override: whether it has matched an input so far.
    has_matched: RefCell<Vec<bool>>,
}

impl ConfigFile {
    /// Reads a file and checks every key in it.
    ///
    /// # Errors
    /// If it cannot be read, is no TOML, or has an unknown key.
    pub(super) fn read(path: &Path, vocabulary: &Vocabulary) -> Result<Self, JobError> {
        let message = |what: String| format!("{}: {what}", path.display());
        let unreadable = |e: std::io::Error| JobError::Input(message(e.to_string()));
        let text = std::fs::read_to_string(path).map_err(unreadable)?;
        let document: Document = toml::from_str(&text).map_err(|e| {
            let (line, what) = malformed_override(&text).unwrap_or_else(|| {
                let line = e.span().map_or(1, |span| text[..span.start].matches('\n').count() + 1);
                (line, e.message().to_owned())
            });
            JobError::Usage(message(format!("line {line}: {what}")))
        })?;
        let folder = match path.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        let folder = folder.canonicalize().map_err(unreadable)?;
        let has_matched = RefCell::new(vec![false; document.overrides.len()]);
        let file = Self { path: path.to_owned(), folder, text, document, has_matched };
        file.check(vocabulary)?;
        Ok(file)
    }

    /// Every table with its place, the strongest last: defaults, profiles, overrides.
    fn tables(&self) -> impl Iterator<Item = (Place, &OptionTable)> {
        let document = &self.document;
        let place = |name: String, keys: &[&str]| Place {
            name,
            keys: keys.iter().map(|key| (*key).to_owned()).collect(),
            is_part: false,
        };
        let defaults =
            std::iter::once((place("[defaults]".to_owned(), &["defaults"]), &document.defaults));
        let profiles = document.profile.iter().map(move |(name, options)| {
            (place(format!("[profile.{name}]"), &["profile", name]), options)
        });
        let overrides = document.overrides.iter().enumerate().map(move |(i, one)| {
            let name = format!("[[override]] {}", i + 1);
            let is_part = !one.objects.is_empty() || !one.materials.is_empty();
            let whole = place(name, &["override", &i.to_string()]);
            (Place { is_part, ..whole }, &one.options)
        });
        defaults.chain(profiles).chain(overrides)
    }

    /// A message about what keys lead to, with its line.
    fn message(&self, keys: &[String], what: &str) -> JobError {
        let line = line_of(&self.text, keys);
        JobError::Usage(format!("{}: line {line}: {what}", self.path.display()))
    }

    /// Refuses unknown options and malformed overrides.
    fn check(&self, vocabulary: &Vocabulary) -> Result<(), JobError> {
        let all_commands: Vec<&CommandOptions> = vocabulary.commands.iter().collect();
        for (table, options) in self.tables() {
            for (key, value) in options {
                match value {
                    Value::Object(inner) if vocabulary.is_command(key) => {
                        let (table, command) = (table.of_command(key), [vocabulary.command(key)]);
                        for option in inner {
                            self.check_option(&table, option, vocabulary, &command)?;
                        }
                        self.check_exclusive(&table, inner, &command)?;
                    }
                    _ => self.check_option(&table, (key, value), vocabulary, &all_commands)?,
                }
            }
            self.check_exclusive(&table, options, &all_commands)?;
        }
        for (number, one) in self.document.overrides.iter().enumerate() {
            one.check(vocabulary).map_err(|(keys, what)| {
                let place = ["override".to_owned(), number.to_string()];
                let key = keys.last().map(|key| format!("{key}: ")).unwrap_or_default();
                let keys = [&place[..], &keys].concat();
                self.message(&keys, &format!("[[override]] {}: {key}{what}", number + 1))
            })?;
        }
        Ok(())
    }

    /// Refuses two options of a table that exclude each other.
    fn check_exclusive<'a>(
        &self,
        table: &Place,
        options: impl IntoIterator<Item = (&'a String, &'a Value)>,
        commands: &[&CommandOptions],
    ) -> Result<(), JobError> {
        let on = options.into_iter().filter(|(_, value)| **value != Value::Bool(false));
        let names: Vec<&String> = on.map(|(name, _)| name).collect();
        for group in commands.iter().flat_map(|command| &command.exclusive_groups) {
            let mut of_group = names.iter().filter(|name| group.contains(name));
            if let (Some(first), Some(second)) = (of_group.next(), of_group.next()) {
                let what = format!("{}: {second} cannot be given with {first}", table.name);
                return Err(self.message(&table.keys_of(second), &what));
            }
        }
        Ok(())
    }

    /// Refuses an option that none of `commands` has for assets, a switch that is neither on nor
    /// off, and a value that an option does not take.
    fn check_option(
        &self,
        table: &Place,
        (option, value): (&String, &Value),
        vocabulary: &Vocabulary,
        commands: &[&CommandOptions],
    ) -> Result<(), JobError> {
        let is_switch = |command: &&CommandOptions| command.switches.contains(option);
        let what = if option == "allow-path" {
            "only the command line permits further folders".to_owned()
        } else if commands.iter().any(|command| command.has(option)) {
            if commands.iter().any(is_switch) {
                if value.is_boolean() {
                    return Ok(());
                }
                format!("must be true or false, not {value}")
            } else {
                // A value is for the commands that take it; those of parts are checked as a whole.
                let commands = commands.iter().filter(|command| command.has(option));
                let checks: Vec<_> =
                    commands.map(|c| check_value(vocabulary, c, option, value)).collect();
                if table.is_part || checks.iter().any(Result::is_ok) {
                    return Ok(());
                }
                checks.into_iter().find_map(Result::err).unwrap_or_default()
            }
        } else if vocabulary.run_options.contains(&option.as_str()) {
            "is for a whole run, not for assets: say it on the command line".to_owned()
        } else {
            let (kind, names): (_, Vec<&str>) = if value.is_object() {
                ("command", vocabulary.commands.iter().map(|c| c.name.as_str()).collect())
            } else {
                let globs: &[&str] = if table.has_globs() { &GLOB_KEYS } else { &[] };
                let options = commands.iter().flat_map(|c| &c.options).map(String::as_str);
                ("option", options.chain(globs.iter().copied()).collect())
            };
            match suggestion(option, names) {
                Some(name) => format!("unknown {kind}; did you mean `{name}`?"),
                None => format!("unknown {kind}"),
            }
        };
        let keys = table.keys_of(option);
        Err(self.message(&keys, &format!("{}: {option}: {what}", table.name)))
    }

    /// A message for each override whose globs have matched no input so far.
    pub(super) fn unmatched(&self) -> Vec<String> {
        let has_matched = self.has_matched.borrow();
        let overrides = (1..).zip(&self.document.overrides).zip(has_matched.iter());
        let unmatched = overrides.filter(|((_, one), matched)| !**matched && !one.files.is_empty());
        unmatched
            .map(|((number, one), _)| {
                let globs = one.files.join(", ");
                format!("{}: [[override]] {number}: no input matches {globs}", self.path.display())
            })
            .collect()
    }

    /// The layers that apply to an input: defaults, then the profile, then each override that
    /// matches.
    ///
    /// # Errors
    /// If it lacks the profile, or a value has a wrong type.
    pub(super) fn layers(
        &self,
        vocabulary: &Vocabulary,
        command: &str,
        profile: Option<&str>,
        input: &Path,
    ) -> Result<Vec<ConfigLayer>, JobError> {
        if let Some(name) = profile.filter(|name| !self.document.profile.contains_key(*name)) {
            let names: Vec<&str> = self.document.profile.keys().map(String::as_str).collect();
            return Err(JobError::Usage(format!(
                "{}: no profile {name}; there are: {}",
                self.path.display(),
                names.join(", ")
            )));
        }
        let path = input.canonicalize().unwrap_or_else(|_| input.to_owned());
        let name = path.strip_prefix(&self.folder).unwrap_or(&path);
        let mut layers = Vec::new();
        // The defaults come first, then the profiles: see `tables`.
        let first_override = 1 + self.document.profile.len();
        for (number, (table, options)) in self.tables().enumerate() {
            let override_number = number.checked_sub(first_override);
            let one = override_number.map(|i| &self.document.overrides[i]);
            let applies = match one {
                Some(one) => one.files.is_empty() || globs(&one.files)?.is_match(name),
                None => {
                    number == 0 || profile.is_some_and(|p| table.name == format!("[profile.{p}]"))
                }
            };
            if applies {
                if let Some(number) = override_number {
                    self.has_matched.borrow_mut()[number] = true;
                }
                let (mut plain, own) = options_of_command(options, vocabulary, command);
                let all = plain.iter().chain(&own).map(|(key, value)| (key.clone(), value.clone()));
                if let Some(part) = one.and_then(|one| one.part(all.collect())) {
                    let layer = self.layer(&table, &OptionTable::new())?;
                    layers.push(ConfigLayer { part: Some(part), ..layer });
                } else {
                    // `false` in the command's own table turns a switch off.
                    plain.retain(|option, _| !own.contains_key(option));
                    layers.push(self.layer(&table, &plain)?);
                    layers.push(self.layer(&table.of_command(command), &own)?);
                }
            }
        }
        Ok(layers)
    }

    /// The layer of a table that is for whole assets.
    fn layer(&self, table: &Place, options: &OptionTable) -> Result<ConfigLayer, JobError> {
        let values = OptionValues::from_json(options);
        let values =
            values.map_err(|what| self.message(&table.keys, &format!("{}: {what}", table.name)))?;
        let source = format!("{} {}", self.path.display(), table.name);
        Ok(ConfigLayer { source, values, part: None })
    }
}

impl Override {
    /// Checks its globs and, if it is for parts, each of its options. An error has the keys that
    /// lead to what is wrong.
    fn check(&self, vocabulary: &Vocabulary) -> Result<(), (Vec<String>, String)> {
        globs(&self.files).map_err(|e| (vec!["files".to_owned()], e.to_string()))?;
        if self.files.is_empty() && self.objects.is_empty() && self.materials.is_empty() {
            return Err((vec![], "names neither files nor objects nor materials".to_owned()));
        }
        let check = |options: OptionTable, keys: &[&String]| {
            let Some(part) = self.part(options) else { return Ok(()) };
            (vocabulary.check_part)(&super::json(&part))
                .map_err(|what| (keys.iter().map(|key| (*key).clone()).collect(), what))
        };
        check(OptionTable::new(), &[])?;
        for (key, value) in &self.options {
            let Value::Object(own) = value else {
                check([(key.clone(), value.clone())].into(), &[key])?;
                continue;
            };
            for (option, value) in own {
                check([(option.clone(), value.clone())].into(), &[key, option])?;
            }
        }
        Ok(())
    }

    /// The options with the globs of the part that they are for; none if they are for whole files.
    fn part(&self, options: OptionTable) -> Option<OptionTable> {
        if self.objects.is_empty() && self.materials.is_empty() {
            return None;
        }
        let names = [("objects", &self.objects), ("materials", &self.materials)];
        let names = names.into_iter().filter(|(_, names)| !names.is_empty());
        let names = names.map(|(key, names)| (key.to_owned(), names.clone().into()));
        Some(options.into_iter().chain(names).collect())
    }
}

/// Refuses a value that an option of a command does not take.
fn check_value(
    vocabulary: &Vocabulary,
    command: &CommandOptions,
    option: &str,
    value: &Value,
) -> Result<(), String> {
    let check = &vocabulary.check_value.0;
    match value {
        Value::Bool(false) => Ok(()),
        Value::Bool(true) => Err("needs a value".to_owned()),
        Value::Array(list) => {
            list.iter().try_for_each(|value| check_value(vocabulary, command, option, value))
        }
        Value::String(text) => check(&command.name, option, text),
        Value::Number(number) => check(&command.name, option, &number.to_string()),
        Value::Null | Value::Object(_) => Ok(()),
    }
}

/// The line, from 1, of what keys lead to, or of the last of them that is there.
fn line_of(text: &str, keys: &[String]) -> usize {
    let mut at = 0;
    if let Ok(document) = DeTable::parse(text) {
        let (mut table, mut list) = (Some(document.get_ref()), None);
        for key in keys {
            let value = match (table, list) {
                (Some(table), _) => {
                    table.iter().find(|(name, _)| name.get_ref() == key).map(|(name, value)| {
                        at = name.span().start;
                        value
                    })
                }
                (_, Some(list)) => {
                    let list: &DeArray<'_> = list;
                    key.parse().ok().and_then(|number: usize| list.get(number)).inspect(|value| {
                        at = value.span().start;
                    })
                }
                _ => None,
            };
            let Some(value) = value.map(Spanned::get_ref) else { break };
            (table, list) = (value.as_table(), value.as_array());
        }
    }
    text[..at].matches('\n').count() + 1
}

/// The options in a table that a command has, and those in the command's own table.
fn options_of_command(
    options: &OptionTable,
    vocabulary: &Vocabulary,
    command: &str,
) -> (OptionTable, OptionTable) {
    let has =
        |option: &str| vocabulary.is_command(command) && vocabulary.command(command).has(option);
    let plain = options
        .iter()
        .filter(|(key, value)| !(value.is_object() && vocabulary.is_command(key)) && has(key))
        .map(|(key, value)| (key.clone(), value.clone()))
        .collect();
    let own = match options.get(command) {
        Some(Value::Object(own)) => own.clone().into_iter().collect(),
        _ => OptionTable::new(),
    };
    (plain, own)
}

/// The line and what is wrong with the first override that is no list, or has a glob where a list
/// of them belongs; none if the text is no TOML or has no such override.
fn malformed_override(text: &str) -> Option<(usize, String)> {
    let document: toml::Table = text.parse().ok()?;
    let overrides = document.get("override")?;
    let Some(overrides) = overrides.as_array() else {
        let what = "write [[override]] with two brackets".to_owned();
        return Some((line_of(text, &["override".to_owned()]), what));
    };
    overrides.iter().enumerate().find_map(|(number, one)| {
        let glob = |key: &'static str| Some((key, one.get(key)?.as_str()?));
        let (key, glob) = GLOB_KEYS.into_iter().find_map(glob)?;
        let keys = ["override".to_owned(), number.to_string(), key.to_owned()];
        let what = format!("[[override]] {}: {key} must be a list: [{glob:?}]", number + 1);
        Some((line_of(text, &keys), what))
    })
}
