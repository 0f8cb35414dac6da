//! One configuration file: defaults, profiles, and overrides by glob.

use crate::batch::{OptionValues, globs, has_option, is_command, is_of_the_run, suggestion};
use crate::exit::{Failure, Outcome, Status};
use crate::parts::Part;
use indexmap::IndexMap;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Options by long name; a table under a command's name holds options of that command alone.
pub(crate) type Options = IndexMap<String, Value>;

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

/// Options for files that match, or for parts of them.
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
    options: Options,
}

/// Options and where they stand.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    /// File and table, for people.
    pub(crate) source: String,
    pub(crate) values: OptionValues,
    /// Options of a part, in place of `values`.
    pub(crate) part: Option<Options>,
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
        for (number, one) in (1..).zip(&self.document.overrides) {
            one.check().map_err(|what| {
                let table = format!("[[override]] {number}");
                Failure::usage(format!("{}: {table}: {what}", self.path.display()))
            })?;
        }
        Ok(())
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
        if is_of_the_run(option) {
            return fail(
                "is for a whole run, not for assets: say it on the command line".to_owned(),
            );
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
            let one = number.checked_sub(first_override).map(|i| &self.document.overrides[i]);
            let takes = match one {
                Some(one) => one.files.is_empty() || globs(&one.files)?.is_match(below),
                None => number == 0 || profile.is_some_and(|p| table == format!("[profile.{p}]")),
            };
            if takes {
                let source = format!("{} {table}", self.path.display());
                let own = own(options, command);
                let part = one.and_then(|one| one.part(&own));
                let values = if part.is_some() {
                    Ok(OptionValues::default())
                } else {
                    OptionValues::from_json(&own)
                };
                let values = values.map_err(|what| {
                    Failure::usage(format!("{}: {table}: {what}", self.path.display()))
                })?;
                layers.push(Layer { source, values, part });
            }
        }
        Ok(layers)
    }
}

impl Override {
    /// Checks its globs and, of parts, its options.
    fn check(&self) -> Result<(), String> {
        globs(&self.files).map_err(|failure| failure.message)?;
        if self.files.is_empty() && self.objects.is_empty() && self.materials.is_empty() {
            return Err("names neither files nor objects nor materials".to_owned());
        }
        let tables = self.options.iter().filter(|(_, value)| value.is_object());
        let tables = tables.map(|(name, _)| own(&self.options, name));
        let plain = self.options.iter().filter(|(_, value)| !value.is_object());
        let plain: Options = plain.map(|(name, value)| (name.clone(), value.clone())).collect();
        for own in tables.chain([plain]) {
            if let Some(part) = self.part(&own) {
                Part::parse(&super::text(&part))?;
            }
        }
        Ok(())
    }

    /// Options with the part that they are for; none if they are for whole files.
    fn part(&self, own: &Options) -> Option<Options> {
        if self.objects.is_empty() && self.materials.is_empty() {
            return None;
        }
        let names = [("objects", &self.objects), ("materials", &self.materials)];
        let names = names.into_iter().filter(|(_, names)| !names.is_empty());
        let names = names.map(|(key, names)| (key.to_owned(), names.clone().into()));
        Some(own.clone().into_iter().chain(names).collect())
    }
}

/// The options of a table that a command has.
fn own(options: &Options, command: &str) -> Options {
    let has = |option: &str| has_option(Some(command), option);
    let mut own: Options = options
        .iter()
        .filter(|(key, value)| !(value.is_object() && is_command(key)) && has(key))
        .map(|(key, value)| (key.clone(), value.clone()))
        .collect();
    if let Some(Value::Object(inner)) = options.get(command) {
        own.extend(inner.clone());
    }
    own
}
