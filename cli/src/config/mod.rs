//! Configuration files: options of assets by their place, in `lodc.toml`.

mod file;
mod find;

pub(crate) use file::Layer;

use crate::batch::{self, Asset, OptionValues};
use crate::exit::{Failure, Outcome};
use crate::help::CONFIGURATION;
use clap::Args;
use file::{File, Options};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Name of a configuration file that is found by itself.
const NAME: &str = "lodc.toml";

/// Options that shape the order of collapses, which a `.lodc` file has already.
const OF_THE_ORDER: [&str; 6] =
    ["lock", "lock-border", "metric", "no-attributes", "preserve-topology", "weight"];

/// Options that choose a configuration.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = CONFIGURATION)]
pub(crate) struct ConfigArgs {
    /// Read options from FILE [default: the nearest lodc.toml above the input]
    ///
    /// The default is looked for up to the folder that was given or, for a named file, up to the
    /// current one. Options of the command line win.
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub(crate) config: Option<PathBuf>,
    /// Also take the options of this profile of the configuration
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    pub(crate) profile: Option<String>,
}

/// The configurations of a run, each read once.
#[derive(Debug)]
pub(crate) struct Configs<'a> {
    args: &'a ConfigArgs,
    command: &'static str,
    read: BTreeMap<PathBuf, Rc<File>>,
}

impl<'a> Configs<'a> {
    /// The configurations that assets of a command may meet.
    pub(crate) fn new(args: &'a ConfigArgs, command: &'static str) -> Self {
        Self { args, command, read: BTreeMap::new() }
    }

    /// Returns what a configuration says of an asset: layers, the strongest last.
    ///
    /// # Errors
    /// If the configuration cannot be read, has an unknown key, or lacks the profile.
    pub(crate) fn layers(&mut self, input: &Path, folder: Option<&Path>) -> Outcome<Vec<Layer>> {
        let found = match &self.args.config {
            Some(path) => Some(path.clone()),
            None => find::nearest(NAME, input, folder),
        };
        let Some(path) = found else { return self.no_profile() };
        if !self.read.contains_key(&path) {
            self.read.insert(path.clone(), Rc::new(File::read(&path)?));
        }
        let file = Rc::clone(&self.read[&path]);
        file.layers(self.command, self.args.profile.as_deref(), input)
    }

    /// Puts what configurations say under the options that assets have already. To an asset that
    /// has its order of collapses they say nothing of that.
    ///
    /// # Errors
    /// As for [`Self::layers`].
    pub(crate) fn apply(&mut self, assets: &mut [Asset]) -> Outcome<()> {
        let mut given = None;
        for asset in assets {
            let layers = self.layers(&asset.input, asset.folder.as_deref())?;
            let has_order = asset.input.extension().is_some_and(|e| e.eq_ignore_ascii_case("lodc"));
            let applies = |option: &str| !has_order || !OF_THE_ORDER.contains(&option);
            let (mut under, mut parts) = (OptionValues::default(), Vec::new());
            for layer in layers {
                under = under.under(layer.values, self.command);
                parts.extend(layer.part);
            }
            under.0.retain(|option, _| applies(option));
            for part in &mut parts {
                let given = given.get_or_insert_with(|| batch::given_options(self.command));
                // The command line and the list's line win.
                part.retain(|option, _| {
                    let stronger = given.contains(option) || asset.options.0.contains_key(option);
                    applies(option) && !stronger
                });
            }
            if !parts.is_empty() {
                let if_there = |mut part: Options| {
                    part.insert("if-there".to_owned(), true.into());
                    Value::Object(part).to_string()
                };
                let texts = parts.into_iter().map(if_there);
                under.0.insert("part".to_owned(), texts.collect());
            }
            let own = std::mem::take(&mut asset.options);
            asset.options = under.under(own, self.command);
        }
        Ok(())
    }

    fn no_profile(&self) -> Outcome<Vec<Layer>> {
        match &self.args.profile {
            Some(name) => Err(Failure::usage(format!(
                "profile {name}: there is no {NAME} that could have it (--config names one)"
            ))),
            None => Ok(vec![]),
        }
    }
}
