//! Pairs of files that are compared: two files, the files of two folders paired by their names, or
//! those of a list.

use crate::jobs::error::JobError;
use crate::jobs::folder::{LEVEL_EXTENSIONS, PathFilter, files_below, with_slashes};
use crate::jobs::list;
use crate::jobs::run::{Job, JobChoice};
use crate::jobs::target::Target;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Two files that are compared.
#[derive(Debug)]
pub(crate) struct Pair {
    /// The file that is judged. No file is written for it: its target is standard output.
    pub(crate) job: Job,
    /// The file that it is compared with, or why there is none.
    pub(crate) compared_with: Result<PathBuf, JobError>,
}

/// Returns the pairs of two files, of two folders or of a list that belong to the chosen shard.
///
/// # Errors
/// If a folder would be compared with a file, a folder or the list cannot be read, or a line of the
/// list or a glob is malformed.
pub(crate) fn pairs(named: Option<[&Path; 2]>, choice: &JobChoice) -> Result<Vec<Pair>, JobError> {
    let mut pairs = match (named, &choice.list) {
        (Some([a, b]), _) => pairs_of_paths(a, b, choice)?,
        (None, Some(list)) => pairs_of_list(list)?,
        (None, None) => Vec::new(),
    };
    if let Some(shard) = choice.shard {
        pairs.retain(|pair| shard.contains(&pair.job.name));
    }
    Ok(pairs)
}

fn judged_asset(path: PathBuf, name: String, folder: Option<PathBuf>) -> Job {
    Job::without_options(path, name, folder, Ok(Target::Stdout))
}

/// Pairs two files, or each file of folder `b` that the globs accept with a file of folder `a`.
fn pairs_of_paths(a: &Path, b: &Path, choice: &JobChoice) -> Result<Vec<Pair>, JobError> {
    let filter = PathFilter::new(&choice.include, &choice.exclude)?;
    match (a.is_dir(), b.is_dir()) {
        (false, false) => {
            let job = judged_asset(b.to_owned(), with_slashes(b), None);
            Ok(vec![Pair { job, compared_with: Ok(a.to_owned()) }])
        }
        (true, true) => {
            let files = files_below(a, &LEVEL_EXTENSIONS, &PathFilter::new(&[], &[])?)?;
            let files = files.into_iter().map(|(path, name)| (name, path));
            let files_of_a: BTreeMap<String, PathBuf> = files.collect();
            let pair = |(path, name): (PathBuf, String)| Pair {
                compared_with: counterpart(&files_of_a, &name).cloned().ok_or_else(|| {
                    let what = format!("{} has no file of this name", a.display());
                    JobError::Input(format!("{}: {what}", path.display()))
                }),
                job: judged_asset(path, name, Some(b.to_owned())),
            };
            Ok(files_below(b, &LEVEL_EXTENSIONS, &filter)?.into_iter().map(pair).collect())
        }
        _ => {
            let what = "a folder is compared with a folder, a file with a file";
            Err(JobError::Usage(what.to_owned()))
        }
    }
}

/// The pairs of a list, one in each line.
fn pairs_of_list(list: &Path) -> Result<Vec<Pair>, JobError> {
    let pair = |(number, line): (usize, list::Line)| {
        let wrong = |what: &str| list::line_error(list, number, what);
        if line.output.is_some() {
            return Err(wrong("output: compare writes none"));
        }
        let options = line.options().map_err(|what| wrong(&what))?;
        let Some(a) = line.compared_with else {
            return Err(wrong("a, what to compare with, is missing"));
        };
        let job = judged_asset(line.input.clone(), with_slashes(&line.input), None);
        let list_line = Some((list.to_owned(), number));
        Ok(Pair { job: Job { options, list_line, ..job }, compared_with: Ok(a) })
    };
    list::read(list)?.into_iter().map(pair).collect()
}

/// The file to compare another of this name with: the one of the same name, else of the name
/// without its extension (`club.obj` for `club.obj.lodc`), else the only one that differs in its
/// extension.
fn counterpart<'a>(files: &'a BTreeMap<String, PathBuf>, name: &str) -> Option<&'a PathBuf> {
    let same = files.get(name).or_else(|| files.get(stem(name)));
    same.or_else(|| {
        let mut alike = files.iter().filter(|(other, _)| stem(other) == stem(name));
        alike.next().filter(|_| alike.next().is_none()).map(|(_, path)| path)
    })
}

/// A name without its last extension.
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
    fn a_file_is_compared_with_the_one_that_it_was_made_from() {
        let names = ["a.obj", "p/b.obj", "p/b.glb", "c.d/e.obj", "f.gltf"];
        let files = names.iter().map(|n| ((*n).to_owned(), PathBuf::from(n))).collect();
        let other = |name: &str| counterpart(&files, name).map(|p| p.display().to_string());
        let found = |name: &str| Some(name.to_owned());
        assert_eq!(other("a.obj"), found("a.obj"));
        assert_eq!(other("p/b.glb.lodc"), found("p/b.glb"));
        assert_eq!(other("p/b.lodc"), None, "two differ in their extension");
        assert_eq!(other("f.glb"), found("f.gltf"));
        assert_eq!(other("c.d/x.obj"), None);
        assert_eq!(other("b.obj"), None);
    }
}
