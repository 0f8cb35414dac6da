//! The assets of a run: named files, files below folders, lines of a list.

use super::folder::{Filter, files, slashed};
use super::{BatchArgs, OptionValues, manifest};
use crate::exit::{Failure, Outcome};
use crate::output::{self, Target};
use std::path::{Path, PathBuf};

/// One asset of a run.
#[derive(Clone, Debug)]
pub(crate) struct Asset {
    pub(crate) input: PathBuf,
    /// Its path as named, or below the folder that was given; with slashes.
    pub(crate) name: String,
    /// The folder that was given and that it was found in.
    pub(crate) folder: Option<PathBuf>,
    /// The target of its result, or the reason why there is none.
    pub(crate) target: Outcome<Target>,
    /// Options of its own.
    pub(crate) options: OptionValues,
    /// The list and the line that names it, for messages.
    pub(crate) line: Option<(PathBuf, usize)>,
    /// Missing folders of its result are made.
    pub(crate) makes_folders: bool,
}

impl Asset {
    /// Returns whether it came from a folder or a list: one of many.
    pub(crate) fn is_listed(&self) -> bool {
        self.folder.is_some() || self.line.is_some()
    }

    /// A message about its options, with the line that they stand in.
    pub(crate) fn with_line(&self, what: &str) -> String {
        match &self.line {
            Some((list, line)) => format!("{}: line {line}: {what}", list.display()),
            None => format!("{}: {what}", self.input.display()),
        }
    }
}

/// Inputs and outputs of a command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sources<'a> {
    /// Named files and folders.
    pub(crate) inputs: &'a [PathBuf],
    /// `-o`.
    pub(crate) output: Option<&'a Path>,
    /// Extensions of the files that are taken from folders.
    pub(crate) reads: &'a [&'a str],
    /// Extension of results.
    pub(crate) writes: &'a str,
}

/// Returns the assets of a run in order: named ones and folders as they were given, then the
/// list's. Two that would share a result each carry that as their failure.
///
/// # Errors
/// If a folder or the list cannot be read, or holds nothing; if there is nothing to do with what
/// was given.
pub(crate) fn assets(sources: Sources<'_>, batch: &BatchArgs) -> Outcome<Vec<Asset>> {
    let filter = Filter::new(&batch.include, &batch.exclude)?;
    let several = batch.takes_many(sources.inputs);
    let folder_out = sources.output.filter(|out| several || output::is_folder(out));
    if let Some(out) = folder_out {
        check_folder(out)?;
    }
    let mut all = Vec::new();
    for input in sources.inputs {
        if input.is_dir() {
            for (path, name) in files(input, sources.reads, &filter)? {
                let file = format!("{name}.{}", sources.writes);
                let target = Target::File(folder_out.unwrap_or(input).join(file));
                all.push(found(path, name, Some(input.clone()), Ok(target)));
            }
        } else {
            let target = output::named_target(input, folder_out, sources.output, sources.writes);
            let name = input.to_string_lossy().replace('\\', "/");
            all.push(found(input.clone(), name, None, target));
        }
    }
    if let Some(list) = &batch.manifest {
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
    if let Some(shard) = batch.shard {
        all.retain(|asset| shard.has(&asset.name));
    }
    all.iter_mut().for_each(|asset| asset.makes_folders |= folder_out.is_some());
    output::refuse_clashes(all.iter_mut().map(|a| (a.input.as_path(), &mut a.target)));
    Ok(all)
}

/// An asset without options of its own.
pub(super) fn found(
    input: PathBuf,
    name: String,
    folder: Option<PathBuf>,
    target: Outcome<Target>,
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

fn check_folder(out: &Path) -> Outcome<()> {
    if output::is_stream(out) {
        let what = "several results do not fit one standard output: name a folder";
        return Err(Failure::usage(what));
    }
    if out.exists() && !out.is_dir() {
        let what = "several inputs need a folder, this is a file";
        return Err(Failure::usage(format!("{}: {what}", out.display())));
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
        let sources = Sources { inputs: &inputs, output, reads: &["obj"], writes: "lodc" };
        assets(sources, &BatchArgs::default()).expect("assets")
    }

    #[test]
    fn results_of_one_name_are_failures_of_their_own() {
        let all = of_names(&["a/x.obj", "b/x.glb", "b/y.obj"], Some("out"));
        let failed: Vec<bool> = all.iter().map(|asset| asset.target.is_err()).collect();
        assert_eq!(failed, [true, true, false]);
        let what = all[0].target.clone().expect_err("a clash").message;
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
