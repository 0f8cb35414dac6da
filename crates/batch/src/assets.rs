//! The assets of a run: named files, files below folders, lines of a list.

use crate::error::AssetError;
use crate::folder::{Filter, files, slashed};
use crate::manifest;
use crate::options::OptionValues;
use crate::shard::Shard;
use crate::target::{Target, is_folder, is_stream, named_target, refuse_clashes};
use std::path::{Path, PathBuf};

/// One asset of a run.
#[derive(Clone, Debug)]
pub struct Asset {
    /// Its file; `-` for standard input.
    pub input: PathBuf,
    /// Its path as named, or below the folder that was given; with slashes.
    pub name: String,
    /// The folder that was given and that it was found in.
    pub folder: Option<PathBuf>,
    /// The target of its result, or the reason why there is none.
    pub target: Result<Target, AssetError>,
    /// Options of its own.
    pub options: OptionValues,
    /// The list and the line that names it, for messages.
    pub line: Option<(PathBuf, usize)>,
    /// Missing folders of its result are made.
    pub makes_folders: bool,
}

impl Asset {
    /// Returns whether it came from a folder or a list: one of many.
    #[must_use]
    pub fn is_listed(&self) -> bool {
        self.folder.is_some() || self.line.is_some()
    }

    /// A message about its options, with the line that they are in.
    #[must_use]
    pub fn with_line(&self, what: &str) -> String {
        match &self.line {
            Some((list, line)) => format!("{}: line {line}: {what}", list.display()),
            None => format!("{}: {what}", self.input.display()),
        }
    }
}

/// The choice of assets besides those that are named.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    /// A list: a JSON document in each line. `-` for standard input.
    pub list: Option<PathBuf>,
    /// Globs of paths below a folder that is given: only these are taken.
    pub include: Vec<String>,
    /// Globs of paths that are not.
    pub exclude: Vec<String>,
    /// Only one of several parts of all assets.
    pub shard: Option<Shard>,
}

impl Choice {
    /// Returns whether a run with these inputs has several results, or may have them.
    #[must_use]
    pub fn takes_many(&self, inputs: &[PathBuf]) -> bool {
        inputs.len() > 1 || self.list.is_some() || inputs.iter().any(|input| input.is_dir())
    }
}

/// Inputs and outputs of a command.
#[derive(Clone, Copy, Debug)]
pub struct Sources<'a> {
    /// Named files and folders.
    pub inputs: &'a [PathBuf],
    /// `-o`.
    pub output: Option<&'a Path>,
    /// Extensions of the files that are taken from folders.
    pub reads: &'a [&'a str],
    /// Extension of results.
    pub writes: &'a str,
    /// Folders besides those that are given that links in them may lead to.
    pub allowed: &'a [PathBuf],
}

/// Returns the assets of a run in order: named ones and folders as they were given, then the
/// list's. Two that would share a result each carry that as their failure.
///
/// # Errors
/// If a folder or the list cannot be read, or holds nothing; if there is nothing to do with what
/// was given.
pub fn assets(sources: Sources<'_>, choice: &Choice) -> Result<Vec<Asset>, AssetError> {
    let filter = Filter::new(&choice.include, &choice.exclude)?;
    let several = choice.takes_many(sources.inputs);
    let folder_out = sources.output.filter(|out| several || is_folder(out));
    if let Some(out) = folder_out {
        check_folder(out)?;
    }
    let mut all = Vec::new();
    for input in sources.inputs {
        if input.is_dir() {
            for (path, name) in files(input, sources.reads, &filter)? {
                let file = format!("{name}.{}", sources.writes);
                let target = Target::File(folder_out.unwrap_or(input).join(file));
                let target = check_link(&path, input, sources.allowed).map(|()| target);
                all.push(found(path, name, Some(input.clone()), target));
            }
        } else {
            let target = named_target(input, folder_out, sources.output, sources.writes);
            let name = input.to_string_lossy().replace('\\', "/");
            all.push(found(input.clone(), name, None, target));
        }
    }
    if let Some(list) = &choice.list {
        for (number, line) in manifest::read(list)? {
            let options = match line.a {
                Some(_) => Err("a is for compare alone".to_owned()),
                None => line.options(),
            };
            let options = options.map_err(|what| manifest::wrong(list, number, &what))?;
            let name = slashed(&line.input);
            let target = Target::File(listed_target(&line, folder_out, sources.writes));
            let asset = found(line.input, name, None, Ok(target));
            all.push(Asset {
                options,
                line: Some((list.clone(), number)),
                makes_folders: true,
                ..asset
            });
        }
    }
    if let Some(shard) = choice.shard {
        all.retain(|asset| shard.has(&asset.name));
    }
    all.iter_mut().for_each(|asset| asset.makes_folders |= folder_out.is_some());
    refuse_clashes(all.iter_mut().map(|a| (a.input.as_path(), &mut a.target)));
    Ok(all)
}

/// Refuses a link that leads out of the folder that it was found in, as a path in a file that does.
fn check_link(path: &Path, folder: &Path, allowed: &[PathBuf]) -> Result<(), AssetError> {
    if !path.is_symlink() {
        return Ok(());
    }
    let real =
        path.canonicalize().map_err(|e| AssetError::Input(format!("{}: {e}", path.display())))?;
    let roots = [folder].into_iter().chain(allowed.iter().map(PathBuf::as_path));
    let mut roots = roots.filter_map(|root| root.canonicalize().ok());
    if roots.any(|root| real.starts_with(root)) {
        return Ok(());
    }
    let what = "a link that leads out of the folder: it is read with --allow-path DIR";
    Err(AssetError::Input(format!("{}: {what}", path.display())))
}

/// An asset without options of its own.
pub(crate) fn found(
    input: PathBuf,
    name: String,
    folder: Option<PathBuf>,
    target: Result<Target, AssetError>,
) -> Asset {
    let makes_folders = folder.is_some();
    Asset {
        input,
        name,
        folder,
        target,
        options: OptionValues::default(),
        line: None,
        makes_folders,
    }
}

fn check_folder(out: &Path) -> Result<(), AssetError> {
    if is_stream(out) {
        let what = "several results do not fit one standard output: name a folder";
        return Err(AssetError::Usage(what.to_owned()));
    }
    if out.exists() && !out.is_dir() {
        let what = "several inputs need a folder, this is a file";
        return Err(AssetError::Usage(format!("{}: {what}", out.display())));
    }
    Ok(())
}

/// Target of a line of a list: what it says, else the input's whole name.
fn listed_target(line: &manifest::Line, folder_out: Option<&Path>, extension: &str) -> PathBuf {
    match (&line.output, folder_out) {
        (Some(output), Some(out)) if output.is_relative() => out.join(output),
        (Some(output), _) => output.clone(),
        (None, Some(out)) => out.join(format!("{}.{extension}", slashed(&line.input))),
        (None, None) => {
            let mut name = line.input.file_name().unwrap_or_default().to_owned();
            name.push(format!(".{extension}"));
            line.input.with_file_name(name)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_names(names: &[&str], output: Option<&str>) -> Vec<Asset> {
        let inputs: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
        let output = output.map(Path::new);
        let sources =
            Sources { inputs: &inputs, output, reads: &["obj"], writes: "lodc", allowed: &[] };
        assets(sources, &Choice::default()).expect("assets")
    }

    #[test]
    fn results_of_one_name_are_failures_of_their_own() {
        let all = of_names(&["a/x.obj", "b/x.glb", "b/y.obj"], Some("out"));
        let failed: Vec<bool> = all.iter().map(|asset| asset.target.is_err()).collect();
        assert_eq!(failed, [true, true, false]);
        let what = all[0].target.clone().expect_err("a clash").to_string();
        assert_eq!(what, "out/x.lodc: a/x.obj and b/x.glb would both be written there");
        assert!(of_names(&["a/x.obj", "b/x.glb"], None).iter().all(|a| a.target.is_ok()));
        let three = of_names(&["a/x.obj", "a/y.obj", "a/x.glb"], None);
        let failed: Vec<bool> = three.iter().map(|asset| asset.target.is_err()).collect();
        assert_eq!(failed, [true, false, true], "the others are done");
        assert!(of_names(&["x.obj", "x.obj"], None).iter().all(|a| a.target.is_err()));
    }

    #[test]
    fn a_result_never_replaces_an_input() {
        let all = of_names(&["x.obj", "x.lodc"], None);
        assert_eq!(all.iter().filter(|asset| asset.target.is_err()).count(), 2);
    }
}
