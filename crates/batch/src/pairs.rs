//! Pairs of files to be compared: two files, the files of two folders by their names, or those of a
//! list.

use crate::assets::{Asset, Choice, found};
use crate::error::AssetError;
use crate::folder::{Filter, LEVELS, files, slashed};
use crate::manifest;
use crate::target::Target;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A file to be judged, and the one that it is compared with.
#[derive(Debug)]
pub struct Pair {
    /// The file to be judged. It has no result of its own: its target is standard output.
    pub asset: Asset,
    /// The other file, or the reason why there is none.
    pub other: Result<PathBuf, AssetError>,
}

/// Returns the pairs of two files, of two folders or of a list, those of the part that is wanted.
///
/// # Errors
/// If one is a folder and the other is none, a folder has no file to compare, or a list is none.
pub fn pairs(named: Option<[&Path; 2]>, choice: &Choice) -> Result<Vec<Pair>, AssetError> {
    let mut pairs = match (named, &choice.list) {
        (Some([a, b]), _) => of_paths(a, b, choice)?,
        (None, Some(list)) => of_list(list)?,
        (None, None) => Vec::new(),
    };
    if let Some(shard) = choice.shard {
        pairs.retain(|pair| shard.has(&pair.asset.name));
    }
    Ok(pairs)
}

/// A file to be judged, without options of its own.
fn judged(path: PathBuf, name: String, folder: Option<PathBuf>) -> Asset {
    found(path, name, folder, Ok(Target::Stdout))
}

/// Of `b`, files that the globs choose are taken; each is compared with the file of `a` of the same
/// path, else of the path without its extension (`club.obj` for `club.obj.lodc`), else with the
/// only one that differs in its extension.
fn of_paths(a: &Path, b: &Path, choice: &Choice) -> Result<Vec<Pair>, AssetError> {
    let filter = Filter::new(&choice.include, &choice.exclude)?;
    match (a.is_dir(), b.is_dir()) {
        (false, false) => {
            let asset = judged(b.to_owned(), slashed(b), None);
            Ok(vec![Pair { asset, other: Ok(a.to_owned()) }])
        }
        (true, true) => {
            let all = files(a, &LEVELS, &Filter::new(&[], &[])?)?;
            let all: BTreeMap<String, PathBuf> = all.into_iter().map(|(p, n)| (n, p)).collect();
            let pair = |(path, name): (PathBuf, String)| Pair {
                other: counterpart(&all, &name).cloned().ok_or_else(|| {
                    let what = format!("{} has no file of this name", a.display());
                    AssetError::Input(format!("{}: {what}", path.display()))
                }),
                asset: judged(path, name, Some(b.to_owned())),
            };
            Ok(files(b, &LEVELS, &filter)?.into_iter().map(pair).collect())
        }
        _ => {
            let what = "a folder is compared with a folder, a file with a file";
            Err(AssetError::Usage(what.to_owned()))
        }
    }
}

/// The pairs of a list: in each line `a`, what the file is compared with.
fn of_list(list: &Path) -> Result<Vec<Pair>, AssetError> {
    let pair = |(number, line): (usize, manifest::Line)| {
        let wrong = |what: &str| manifest::wrong(list, number, what);
        if line.output.is_some() {
            return Err(wrong("output: compare writes none"));
        }
        let options = line.options().map_err(|what| wrong(&what))?;
        let Some(a) = line.a else { return Err(wrong("a, what to compare with, is missing")) };
        let asset = judged(line.input.clone(), slashed(&line.input), None);
        let line = Some((list.to_owned(), number));
        Ok(Pair { asset: Asset { options, line, ..asset }, other: Ok(a) })
    };
    manifest::read(list)?.into_iter().map(pair).collect()
}

fn counterpart<'a>(all: &'a BTreeMap<String, PathBuf>, name: &str) -> Option<&'a PathBuf> {
    let same = all.get(name).or_else(|| all.get(stem(name)));
    same.or_else(|| {
        let mut near = all.iter().filter(|(other, _)| stem(other) == stem(name));
        near.next().filter(|_| near.next().is_none()).map(|(_, path)| path)
    })
}

/// A path without the extension of its file.
fn stem(name: &str) -> &str {
    match name.rsplit_once('.') {
        Some((stem, extension)) if !extension.contains('/') => stem,
        _ => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_meets_the_one_that_it_was_made_from() {
        let names = ["a.obj", "p/b.obj", "p/b.glb", "c.d/e.obj", "f.gltf"];
        let all = names.iter().map(|n| ((*n).to_owned(), PathBuf::from(n))).collect();
        let other = |name: &str| counterpart(&all, name).map(|p| p.display().to_string());
        let met = |name: &str| Some(name.to_owned());
        assert_eq!(other("a.obj"), met("a.obj"));
        assert_eq!(other("p/b.glb.lodc"), met("p/b.glb"));
        assert_eq!(other("p/b.lodc"), None, "two differ in their extension");
        assert_eq!(other("f.glb"), met("f.gltf"));
        assert_eq!(other("c.d/x.obj"), None);
        assert_eq!(other("b.obj"), None);
    }
}
