//! Configuration files: options of assets by their place, in `lodc.toml`.

mod file;
mod find;

pub use file::Layer;

use crate::assets::Asset;
use crate::error::AssetError;
use crate::options::{OptionValues, Vocabulary};
use file::{File, Options};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Name of a configuration file that is found by itself.
const NAME: &str = "lodc.toml";

/// Options that shape the order of collapses, which a `.lodc` file has already.
const OF_THE_ORDER: [&str; 6] =
    ["lock", "lock-border", "metric", "no-attributes", "preserve-topology", "weight"];

/// The options of a part as JSON.
pub(super) fn text(part: &Options) -> String {
    serde_json::to_string(part).expect("options are values of JSON")
}

/// The configurations of a run, each read once.
#[derive(Debug)]
pub struct Configs<'a> {
    path: Option<&'a Path>,
    profile: Option<&'a str>,
    words: &'a Vocabulary,
    command: &'a str,
    read: BTreeMap<PathBuf, Rc<File>>,
}

impl<'a> Configs<'a> {
    /// The configurations that assets of a command may meet: the one at `path`, or else for each
    /// the nearest `lodc.toml`; with the options of a profile, if one is named.
    #[must_use]
    pub fn new(
        path: Option<&'a Path>,
        profile: Option<&'a str>,
        words: &'a Vocabulary,
        command: &'a str,
    ) -> Self {
        Self { path, profile, words, command, read: BTreeMap::new() }
    }

    /// Returns what a configuration says of an asset: layers, the strongest last.
    ///
    /// # Errors
    /// If the configuration cannot be read, has an unknown key, or lacks the profile.
    pub fn layers(
        &mut self,
        input: &Path,
        folder: Option<&Path>,
    ) -> Result<Vec<Layer>, AssetError> {
        let found = match self.path {
            Some(path) => Some(path.to_owned()),
            None => find::nearest(NAME, input, folder),
        };
        let Some(path) = found else { return self.no_profile() };
        if !self.read.contains_key(&path) {
            self.read.insert(path.clone(), Rc::new(File::read(&path, self.words)?));
        }
        let file = Rc::clone(&self.read[&path]);
        file.layers((self.words, self.command), self.profile, input)
    }

    /// Puts what configurations say under the options that assets have already. To an asset that
    /// has its order of collapses they say nothing of that. `given` returns the long names of the
    /// options that the command line has or excludes; it is called only if there are parts.
    ///
    /// # Errors
    /// As for [`Self::layers`].
    pub fn apply(
        &mut self,
        assets: &mut [Asset],
        given: impl Fn() -> Vec<String>,
    ) -> Result<(), AssetError> {
        let (command, mut there) = (self.words.of(self.command), None);
        for asset in assets {
            let layers = self.layers(&asset.input, asset.folder.as_deref())?;
            let has_order = asset.input.extension().is_some_and(|e| e.eq_ignore_ascii_case("lodc"));
            let applies = |option: &str| !has_order || !OF_THE_ORDER.contains(&option);
            let (mut under, mut parts) = (OptionValues::default(), Vec::new());
            for layer in layers {
                under = under.under(layer.values, command);
                parts.extend(layer.part);
            }
            under.0.retain(|option, _| applies(option));
            for part in &mut parts {
                let given = there.get_or_insert_with(&given);
                // The command line and the list's line win.
                part.retain(|option, _| {
                    let stronger = given.contains(option) || asset.options.0.contains_key(option);
                    applies(option) && !stronger
                });
            }
            if !parts.is_empty() {
                let if_there = |mut part: Options| {
                    part.insert("if-there".to_owned(), true.into());
                    text(&part)
                };
                let texts = parts.into_iter().map(if_there);
                under.0.insert("part".to_owned(), texts.collect());
            }
            let own = std::mem::take(&mut asset.options);
            asset.options = under.under(own, command);
        }
        Ok(())
    }

    /// The overrides of all configurations whose globs matched no input, a sentence each.
    #[must_use]
    pub fn unmatched(&self) -> Vec<String> {
        self.read.values().flat_map(|file| file.unmatched()).collect()
    }

    fn no_profile(&self) -> Result<Vec<Layer>, AssetError> {
        match self.profile {
            Some(name) => Err(AssetError::Usage(format!(
                "profile {name}: there is no {NAME} that could have it (--config names one)"
            ))),
            None => Ok(vec![]),
        }
    }
}
