//! One configuration file: defaults, profiles, and overrides by glob.

use crate::error::AssetError;
use crate::folder::globs;
use crate::options::{CommandOptions, OptionValues, Vocabulary};
use indexmap::IndexMap;
use serde::Deserialize;
use serde_json::Value;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Options by long name; a table under a command's name holds options of that command alone.
pub(super) type Options = IndexMap<String, Value>;

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

/// Options and their lines.
#[derive(Clone, Debug)]
pub struct Layer {
    /// File and table, for people.
    pub source: String,
    /// The options.
    pub values: OptionValues,
    /// Options of a part, in place of `values`.
    pub part: Option<Options>,
}

impl Layer {
    /// The options of a part as JSON, if they are those of a part.
    #[must_use]
    pub fn part_text(&self) -> Option<String> {
        self.part.as_ref().map(super::text)
    }
}

/// A configuration that was read.
#[derive(Debug)]
pub(super) struct File {
    path: PathBuf,
    folder: PathBuf,
    document: Document,
    /// Whether each override has matched an input.
    matched: RefCell<Vec<bool>>,
}

impl File {
    /// Reads a file and checks every key in it.
    ///
    /// # Errors
    /// If it cannot be read, is no TOML, or has a key that nothing knows.
    pub(super) fn read(path: &Path, words: &Vocabulary) -> Result<Self, AssetError> {
        let named = |what: String| format!("{}: {what}", path.display());
        let unreadable = |e: std::io::Error| AssetError::Input(named(e.to_string()));
        let text = std::fs::read_to_string(path).map_err(unreadable)?;
        let document: Document = toml::from_str(&text).map_err(|e| {
            let line = e.span().map_or(1, |span| text[..span.start].matches('\n').count() + 1);
            AssetError::Usage(named(format!("line {line}: {}", e.message())))
        })?;
        let folder = match path.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        let folder = folder.canonicalize().map_err(unreadable)?;
        let matched = RefCell::new(vec![false; document.overrides.len()]);
        let file = Self { path: path.to_owned(), folder, document, matched };
        file.check(words)?;
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

    fn check(&self, words: &Vocabulary) -> Result<(), AssetError> {
        let any: Vec<&CommandOptions> = words.commands.iter().collect();
        for (table, options) in self.tables() {
            for (key, value) in options {
                match value {
                    Value::Object(inner) if words.is_command(key) => {
                        let command = [words.of(key)];
                        for option in inner.keys() {
                            let table = format!("{table}, {key}");
                            self.check_option(&table, option, words, &command)?;
                        }
                    }
                    _ => self.check_option(&table, key, words, &any)?,
                }
            }
        }
        for (number, one) in (1..).zip(&self.document.overrides) {
            one.check(words).map_err(|what| {
                let table = format!("[[override]] {number}");
                AssetError::Usage(format!("{}: {table}: {what}", self.path.display()))
            })?;
        }
        Ok(())
    }

    /// Refuses an option that none of some commands has for assets.
    fn check_option(
        &self,
        table: &str,
        option: &str,
        words: &Vocabulary,
        commands: &[&CommandOptions],
    ) -> Result<(), AssetError> {
        let what = if option == "allow-path" {
            "only the command line permits further folders".to_owned()
        } else if commands.iter().any(|command| command.has(option)) {
            return Ok(());
        } else if words.of_the_run.contains(&option) {
            "is for a whole run, not for assets: say it on the command line".to_owned()
        } else {
            match Vocabulary::suggestion(option, commands) {
                Some(near) => format!("no such option; is {near} meant?"),
                None => "no such option".to_owned(),
            }
        };
        Err(AssetError::Usage(format!("{}: {table}: {option}: {what}", self.path.display())))
    }

    /// The overrides whose globs matched no input so far, a sentence each.
    pub(super) fn unmatched(&self) -> Vec<String> {
        let matched = self.matched.borrow();
        let overrides = (1..).zip(&self.document.overrides).zip(matched.iter());
        let idle = overrides.filter(|((_, one), matched)| !**matched && !one.files.is_empty());
        idle.map(|((number, one), _)| {
            let globs = one.files.join(", ");
            format!("{}: [[override]] {number}: no input matches {globs}", self.path.display())
        })
        .collect()
    }

    /// Layers that hold for an input: defaults, then a profile, then each override that matches.
    ///
    /// # Errors
    /// If it lacks the profile, or a value is none.
    pub(super) fn layers(
        &self,
        (words, command): (&Vocabulary, &str),
        profile: Option<&str>,
        input: &Path,
    ) -> Result<Vec<Layer>, AssetError> {
        if let Some(name) = profile.filter(|name| !self.document.profile.contains_key(*name)) {
            let there: Vec<&str> = self.document.profile.keys().map(String::as_str).collect();
            return Err(AssetError::Usage(format!(
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
                if let Some(number) = number.checked_sub(first_override) {
                    self.matched.borrow_mut()[number] = true;
                }
                let source = format!("{} {table}", self.path.display());
                let own = own(options, words, command);
                let part = one.and_then(|one| one.part(&own));
                let values = if part.is_some() {
                    Ok(OptionValues::default())
                } else {
                    OptionValues::from_json(&own)
                };
                let values = values.map_err(|what| {
                    AssetError::Usage(format!("{}: {table}: {what}", self.path.display()))
                })?;
                layers.push(Layer { source, values, part });
            }
        }
        Ok(layers)
    }
}

impl Override {
    /// Checks its globs and, of parts, its options.
    fn check(&self, words: &Vocabulary) -> Result<(), String> {
        globs(&self.files).map_err(|e| e.to_string())?;
        if self.files.is_empty() && self.objects.is_empty() && self.materials.is_empty() {
            return Err("names neither files nor objects nor materials".to_owned());
        }
        let tables = self.options.iter().filter(|(_, value)| value.is_object());
        let tables = tables.map(|(name, _)| own(&self.options, words, name));
        let plain = self.options.iter().filter(|(_, value)| !value.is_object());
        let plain: Options = plain.map(|(name, value)| (name.clone(), value.clone())).collect();
        for own in tables.chain([plain]) {
            if let Some(part) = self.part(&own) {
                (words.check_part)(&super::text(&part))?;
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
fn own(options: &Options, words: &Vocabulary, command: &str) -> Options {
    let has = |option: &str| words.is_command(command) && words.of(command).has(option);
    let mut own: Options = options
        .iter()
        .filter(|(key, value)| !(value.is_object() && words.is_command(key)) && has(key))
        .map(|(key, value)| (key.clone(), value.clone()))
        .collect();
    if let Some(Value::Object(inner)) = options.get(command) {
        own.extend(inner.clone());
    }
    own
}
