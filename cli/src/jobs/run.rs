//! The assets of a run: named files, files below folders, lines of a list.

use crate::jobs::error::JobError;
use crate::jobs::folder::{PathFilter, files_below, with_slashes};
use crate::jobs::list;
use crate::jobs::options::OptionValues;
use crate::jobs::shard::Shard;
use crate::jobs::target::{
    Target, is_folder, is_standard_stream, named_target, of_kind, refuse_clashes, refuse_file_name,
    result_name,
};
use std::path::{Path, PathBuf};

/// One asset of a run.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    /// The file that it is read from; `-` for standard input.
    pub(crate) input: PathBuf,
    /// Its path as it was named, or below `folder`; with slashes on every system.
    pub(crate) name: String,
    /// The folder of the command line that it was found in, at any depth.
    pub(crate) folder: Option<PathBuf>,
    /// Where its result is written, or why it cannot be.
    pub(crate) target: Result<Target, JobError>,
    /// Options that the list gives to it alone; configurations come under them.
    pub(crate) options: OptionValues,
    /// The list that names it and the number of its line, from 1, for messages.
    pub(crate) list_line: Option<(PathBuf, usize)>,
    /// The configuration that gives it options.
    pub(crate) configuration: Option<PathBuf>,
    /// Whether missing folders of its result are made.
    pub(crate) makes_folders: bool,
}

impl Job {
    pub(crate) fn without_options(
        input: PathBuf,
        name: String,
        folder: Option<PathBuf>,
        target: Result<Target, JobError>,
    ) -> Self {
        let (options, list_line, configuration) = (OptionValues::default(), None, None);
        let makes_folders = folder.is_some();
        Self { input, name, folder, target, options, list_line, configuration, makes_folders }
    }

    /// Returns whether it came from a folder or a list: one of many.
    #[must_use]
    pub(crate) fn is_listed(&self) -> bool {
        self.folder.is_some() || self.list_line.is_some()
    }

    /// The file that its result is written to, if it is.
    pub(crate) fn file(&self) -> Option<&Path> {
        self.target.as_ref().ok()?.file()
    }

    /// The files that give it options: its configuration and the list that names it.
    pub(crate) fn option_files(&self) -> impl Iterator<Item = &PathBuf> {
        self.configuration.iter().chain(self.list_line.iter().map(|(list, _)| list))
    }

    /// A message about its options, with the list's line or the file that it is about.
    #[must_use]
    pub(crate) fn with_line(&self, what: &str) -> String {
        match &self.list_line {
            Some((list, line)) => format!("{}: line {line}: {what}", list.display()),
            None => format!("{}: {what}", self.input.display()),
        }
    }
}

/// Which assets a run has besides those that are named, and which of them it leaves out.
#[derive(Clone, Debug, Default)]
pub(crate) struct JobChoice {
    /// A file that lists assets, a JSON document in each line; `-` for standard input.
    pub(crate) list: Option<PathBuf>,
    /// Globs of paths below a folder that is given: only these are taken.
    pub(crate) include: Vec<String>,
    /// Globs of paths below a folder that is given: these are left out.
    pub(crate) exclude: Vec<String>,
    /// The only part of the assets that this run is for.
    pub(crate) shard: Option<Shard>,
}

impl JobChoice {
    /// Returns whether a run with these inputs has several results, or may have them.
    #[must_use]
    pub(crate) fn takes_many(&self, inputs: &[PathBuf]) -> bool {
        inputs.len() > 1 || self.list.is_some() || inputs.iter().any(|input| input.is_dir())
    }
}

/// The paths that a command was given, and what it does with them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CommandPaths<'a> {
    /// Named files and folders.
    pub(crate) inputs: &'a [PathBuf],
    /// The file or folder of `-o`.
    pub(crate) output: Option<&'a Path>,
    /// Extensions of the files that are taken from folders.
    pub(crate) input_extensions: &'a [&'a str],
    /// Extension of results.
    pub(crate) output_extension: &'a str,
    /// Folders outside of `inputs` that links in folders may lead to.
    pub(crate) allowed_folders: &'a [PathBuf],
}

/// Returns the assets of a run in order: named ones and folders as they were given, then the
/// list's. Assets whose results would have one path have an error in place of their target.
///
/// # Errors
/// If a folder or the list cannot be read, or a folder has no such file; if a glob is malformed, or
/// several results have no folder to go to.
pub(crate) fn jobs(paths: CommandPaths<'_>, choice: &JobChoice) -> Result<Vec<Job>, JobError> {
    let filter = PathFilter::new(&choice.include, &choice.exclude)?;
    let several = choice.takes_many(paths.inputs);
    let output_folder = paths.output.filter(|output| several || is_folder(output));
    if let Some(folder) = output_folder {
        check_output_folder(folder)?;
    }
    let mut all = Vec::new();
    for input in paths.inputs {
        if input.is_dir() {
            for (path, name) in files_below(input, paths.input_extensions, &filter)? {
                let file = result_name(&name, paths.output_extension);
                let target = Target::File(output_folder.unwrap_or(input).join(file));
                let target = check_link(&path, input, paths.allowed_folders).map(|()| target);
                all.push(Job::without_options(path, name, Some(input.clone()), target));
            }
        } else {
            let target = named_target(input, output_folder, paths.output, paths.output_extension);
            let name = input.to_string_lossy().replace('\\', "/");
            all.push(Job::without_options(input.clone(), name, None, target));
        }
    }
    if let Some(list) = &choice.list {
        for (number, line) in list::read(list)? {
            let options = match line.compared_with {
                Some(_) => Err("a is for compare alone".to_owned()),
                None => line.options(),
            };
            let options = options.map_err(|what| list::line_error(list, number, &what))?;
            let name = with_slashes(&line.input);
            let target = listed_target(&line, output_folder, paths.output_extension);
            let target = of_kind(&target, paths.output_extension).map(|()| Target::File(target));
            let job = Job::without_options(line.input, name, None, target);
            all.push(Job {
                options,
                list_line: Some((list.clone(), number)),
                makes_folders: true,
                ..job
            });
        }
    }
    if let Some(shard) = choice.shard {
        all.retain(|job| shard.contains(&job.name));
    }
    all.iter_mut().for_each(|job| job.makes_folders |= output_folder.is_some());
    refuse_clashes(all.iter_mut().map(|job| (job.input.as_path(), &mut job.target)));
    Ok(all)
}

/// Refuses a link that leads out of the folder that it was found in, as importers refuse such
/// paths in files.
fn check_link(path: &Path, folder: &Path, allowed: &[PathBuf]) -> Result<(), JobError> {
    if !path.is_symlink() {
        return Ok(());
    }
    let destination =
        path.canonicalize().map_err(|e| JobError::Input(format!("{}: {e}", path.display())))?;
    let roots = [folder].into_iter().chain(allowed.iter().map(PathBuf::as_path));
    let mut roots = roots.filter_map(|root| root.canonicalize().ok());
    if roots.any(|root| destination.starts_with(root)) {
        return Ok(());
    }
    let what = "a link that leads out of the folder: it is read with --allow-path DIR";
    Err(JobError::Input(format!("{}: {what}", path.display())))
}

/// Checks that the results of several inputs can be written inside OUT.
fn check_output_folder(out: &Path) -> Result<(), JobError> {
    if is_standard_stream(out) {
        let what = "several results cannot go to standard output: name a folder";
        return Err(JobError::Usage(what.to_owned()));
    }
    if out.exists() && !out.is_dir() {
        let what = "several inputs need a folder, this is a file";
        return Err(JobError::Usage(format!("{}: {what}", out.display())));
    }
    refuse_file_name(out)
}

/// Where a line's result is written: its `output`, else the input's name with the extension of
/// results added to its own.
fn listed_target(line: &list::Line, output_folder: Option<&Path>, extension: &str) -> PathBuf {
    match (&line.output, output_folder) {
        (Some(output), Some(folder)) if output.is_relative() => folder.join(output),
        (Some(output), _) => output.clone(),
        (None, Some(folder)) => folder.join(result_name(&with_slashes(&line.input), extension)),
        (None, None) => {
            let name = line.input.file_name().unwrap_or_default().to_string_lossy();
            line.input.with_file_name(result_name(&name, extension))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assets_named(names: &[&str], output: Option<&str>) -> Vec<Job> {
        let inputs: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
        let output = output.map(Path::new);
        let paths = CommandPaths {
            inputs: &inputs,
            output,
            input_extensions: &["obj"],
            output_extension: "lodc",
            allowed_folders: &[],
        };
        jobs(paths, &JobChoice::default()).expect("assets")
    }

    #[test]
    fn results_of_one_name_are_failures_of_their_own() {
        let all = assets_named(&["a/x.obj", "b/x.obj", "b/y.obj"], Some("out"));
        let failed: Vec<bool> = all.iter().map(|job| job.target.is_err()).collect();
        assert_eq!(failed, [true, true, false]);
        let what = all[0].target.clone().expect_err("a clash").to_string();
        assert_eq!(what, "out/x.obj.lodc: a/x.obj and b/x.obj would both be written there");
        assert!(assets_named(&["a/x.obj", "a/x.glb"], None).iter().all(|a| a.target.is_ok()));
        let three = assets_named(&["a/x.obj", "a/y.obj", "a/x.obj"], None);
        let failed: Vec<bool> = three.iter().map(|job| job.target.is_err()).collect();
        assert_eq!(failed, [true, false, true], "the others are done");
        assert!(assets_named(&["x.obj", "x.obj"], None).iter().all(|a| a.target.is_err()));
    }

    #[test]
    fn a_result_never_replaces_an_input() {
        let all = assets_named(&["x.obj", "x.obj.lodc"], None);
        assert_eq!(all.iter().filter(|job| job.target.is_err()).count(), 1);
    }
}
