//! One configuration file: defaults, profiles, and overrides by glob.

use crate::batch::{OptionValues, globs, has_option, is_command, suggestion};
use crate::exit::{Failure, Outcome, Status};
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Options by long name; a table under a command's name holds options of that command alone.
type Options = Map<String, Value>;

/// A file as TOML has it.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(default)]
    defaults: Options,
    #[serde(default)]
    profile: BTreeMap<String, Options>,
    #[serde(default, rename = "override")]
    overrides: Vec<Override>,
}

/// Options for files that match.
#[derive(Debug, Deserialize)]
struct Override {
    /// Globs of paths below the configuration's folder.
    files: Vec<String>,
    #[serde(flatten)]
    options: Options,
}

/// Options and where they stand.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    /// File and table, for people.
    pub(crate) source: String,
    pub(crate) values: OptionValues,
}

/// A configuration that was read.
#[derive(Debug)]
pub(super) struct File {
    path: PathBuf,
    folder: PathBuf,
    document: Document,
}

impl File {
    /// Reads a file and checks every key in it.
    ///
    /// # Errors
    /// If it cannot be read, is no TOML, or has a key that nothing knows.
    pub(super) fn read(path: &Path) -> Outcome<Self> {
        let wrong = |status: Status, what: String| {
            Failure::new(status, format!("{}: {what}", path.display()))
        };
        let text =
            std::fs::read_to_string(path).map_err(|e| wrong(Status::Input, e.to_string()))?;
        let document: Document = toml::from_str(&text).map_err(|e| {
            let line = e.span().map_or(1, |span| text[..span.start].matches('\n').count() + 1);
            wrong(Status::Usage, format!("line {line}: {}", e.message()))
        })?;
        let folder = match path.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        let folder = folder.canonicalize().map_err(|e| wrong(Status::Input, e.to_string()))?;
        let file = Self { path: path.to_owned(), folder, document };
        file.check()?;
        Ok(file)
    }

    /// Every table with its name.
    fn tables(&self) -> impl Iterator<Item = (String, &Options)> {
        let document = &self.document;
        let defaults = std::iter::once(("[defaults]".to_owned(), &document.defaults));
        let profiles = document.profile.iter().map(|(name, o)| (format!("[profile.{name}]"), o));
        let overrides = (1..).zip(&document.overrides);
        let overrides = overrides.map(|(i, o)| (format!("[[override]] {i}"), &o.options));
        defaults.chain(profiles).chain(overrides)
    }

    fn check(&self) -> Outcome<()> {
        for (table, options) in self.tables() {
            for (key, value) in options {
                match value {
                    Value::Object(inner) if is_command(key) => {
                        for option in inner.keys() {
                            self.check_option(&format!("{table}, {key}"), option, Some(key))?;
                        }
                    }
                    _ => self.check_option(&table, key, None)?,
                }
            }
        }
        self.document
            .overrides
            .iter()
            .try_for_each(|o| globs(&o.files).map(drop))
            .map_err(|f| Failure::new(f.status, format!("{}: {f}", self.path.display())))
    }

    fn check_option(&self, table: &str, option: &str, command: Option<&str>) -> Outcome<()> {
        let fail = |what: String| {
            Err(Failure::usage(format!("{}: {table}: {option}: {what}", self.path.display())))
        };
        if option == "allow-path" {
            return fail("only the command line permits further folders".to_owned());
        }
        if has_option(command, option) {
            return Ok(());
        }
        match suggestion(option, command) {
            Some(near) => fail(format!("no such option; is {near} meant?")),
            None => fail("no such option".to_owned()),
        }
    }

    /// Layers that hold for an input: defaults, then a profile, then each override that matches.
    ///
    /// # Errors
    /// If it lacks the profile, or a value is none.
    pub(super) fn layers(
        &self,
        command: &str,
        profile: Option<&str>,
        input: &Path,
    ) -> Outcome<Vec<Layer>> {
        if let Some(name) = profile.filter(|name| !self.document.profile.contains_key(*name)) {
            let there: Vec<&str> = self.document.profile.keys().map(String::as_str).collect();
            return Err(Failure::usage(format!(
                "{}: no profile {name}; there are: {}",
                self.path.display(),
                there.join(", ")
            )));
        }
        let whole = input.canonicalize().unwrap_or_else(|_| input.to_owned());
        let below = whole.strip_prefix(&self.folder).unwrap_or(&whole);
        let mut layers = Vec::new();
        for (number, (table, options)) in self.tables().enumerate() {
            let first_override = 1 + self.document.profile.len();
            let takes = if number >= first_override {
                globs(&self.document.overrides[number - first_override].files)?.is_match(below)
            } else {
                number == 0 || profile.is_some_and(|name| table == format!("[profile.{name}]"))
            };
            if takes {
                let source = format!("{} {table}", self.path.display());
                let values = values(options, command).map_err(|what| {
                    Failure::usage(format!("{}: {table}: {what}", self.path.display()))
                })?;
                layers.push(Layer { source, values });
            }
        }
        Ok(layers)
    }
}

/// The options of a table that a command has.
fn values(options: &Options, command: &str) -> Result<OptionValues, String> {
    let has = |option: &str| has_option(Some(command), option);
    let mut own: Options = options
        .iter()
        .filter(|(key, value)| !(value.is_object() && is_command(key)) && has(key))
        .map(|(key, value)| (key.clone(), value.clone()))
        .collect();
    if let Some(Value::Object(inner)) = options.get(command) {
        own.extend(inner.clone());
    }
    OptionValues::from_json(&own)
}
