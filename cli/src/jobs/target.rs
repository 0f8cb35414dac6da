//! Where results go: a file, a file in a folder, or standard output.

use crate::jobs::error::JobError;
use crate::jobs::folder::{LEVEL_EXTENSIONS, has_extension};
use lodc_formats::export::ExportFormat;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Where one result is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// Standard output, `-` on the command line.
    Stdout,
    /// A file.
    File(PathBuf),
}

impl Target {
    /// The file, unless it is standard output.
    pub(crate) fn file(&self) -> Option<&Path> {
        match self {
            Self::Stdout => None,
            Self::File(path) => Some(path),
        }
    }

    /// As the user would write it.
    #[must_use]
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Stdout => "-".to_owned(),
            Self::File(path) => path.display().to_string(),
        }
    }
}

/// Returns whether a path stands for standard input or output.
#[must_use]
pub(crate) fn is_standard_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Returns the target of the only result of a run: inside OUT if that is a folder, else OUT, else
/// beside the input.
///
/// # Errors
/// If a result would be written beside standard input, or would replace the input.
pub(crate) fn single_target(
    input: &Path,
    out: Option<&Path>,
    extension: &str,
) -> Result<Target, JobError> {
    let folder = out.filter(|out| is_folder(out));
    let mut target = named_target(input, folder, out, extension);
    refuse_clashes([(input, &mut target)]);
    target
}

/// Extensions that say what is in a file, besides [`ExportFormat::EXTENSIONS`].
const OTHER_KINDS: [&str; 9] = ["mtl", "bin", "lodc", "lods", "html", "png", "jpg", "jpeg", "webp"];

/// Refuses a name that says that something else is in a file than what `extension` stands for.
///
/// # Errors
/// If it does.
pub(crate) fn of_kind(file: &Path, extension: &str) -> Result<(), JobError> {
    let is = |kind: &str| has_extension(file, &[kind]);
    // Avatars are GLB files.
    let is_avatar = extension == "glb" && is("vrm") || extension == "vrm" && is("glb");
    let says_kind = has_extension(file, &OTHER_KINDS)
        || ExportFormat::EXTENSIONS.iter().any(|(kind, _)| is(kind));
    // Strips are text, whose files have any name.
    if is(extension) || is_avatar || extension == "strips" || !says_kind {
        return Ok(());
    }
    let what = format!("{}: what is written there is a .{extension} file", file.display());
    Err(JobError::Usage(what))
}

/// Returns the target of the result of a file that the command line names: in `folder` under its
/// own name, else OUT, else beside the input.
///
/// # Errors
/// If a result would be written beside standard input, or OUT is the name of another kind of file.
pub(crate) fn named_target(
    input: &Path,
    folder: Option<&Path>,
    out: Option<&Path>,
    extension: &str,
) -> Result<Target, JobError> {
    let file = result_file(input, extension);
    match (folder, out) {
        // `./x.lodc` says no more than `x.lodc`.
        (Some(folder), _) if folder == Path::new(".") => Ok(Target::File(file)),
        (Some(folder), _) => Ok(Target::File(folder.join(file))),
        (None, Some(out)) if is_standard_stream(out) => Ok(Target::Stdout),
        (None, Some(out)) => of_kind(out, extension).map(|()| Target::File(out.to_owned())),
        (None, None) if is_standard_stream(input) => {
            let what = "standard input has no place beside it: name the output with -o";
            Err(JobError::Usage(what.to_owned()))
        }
        (None, None) => Ok(Target::File(input.with_file_name(file))),
    }
}

/// Turns every target that another result also has, or that is an input, into an error.
pub(crate) fn refuse_clashes<'a>(
    results: impl IntoIterator<Item = (&'a Path, &'a mut Result<Target, JobError>)>,
) {
    let mut results: Vec<_> = results.into_iter().collect();
    let files = results.iter().filter(|(input, _)| !is_standard_stream(input));
    let inputs: BTreeSet<PathBuf> = files.map(|(input, _)| path_identity(input)).collect();
    // The numbers of the results that each target has.
    let mut owners: BTreeMap<PathBuf, Vec<usize>> = BTreeMap::new();
    for (number, (_, target)) in results.iter().enumerate() {
        if let Ok(Target::File(path)) = target {
            owners.entry(path_identity(path)).or_default().push(number);
        }
    }
    for (identity, numbers) in owners {
        let names: Vec<_> = numbers.iter().map(|&n| results[n].0.display().to_string()).collect();
        let identities = numbers.iter().map(|&n| path_identity(results[n].0));
        let is_one_input = identities.collect::<BTreeSet<PathBuf>>().len() == 1;
        let what = match names.as_slice() {
            [_] if inputs.contains(&identity) => "the output would replace an input".to_owned(),
            [_] => continue,
            [a, _] if is_one_input => format!("{a} is named twice"),
            [a, b] => format!("{a} and {b} would both be written there"),
            [a, b, more @ ..] => {
                format!("{a}, {b} and {} more would all be written there", more.len())
            }
            [] => unreachable!("every target has an owner"),
        };
        for number in numbers {
            let target = &mut *results[number].1;
            if let Ok(Target::File(path)) = target {
                *target = Err(JobError::Usage(format!("{}: {what}", path.display())));
            }
        }
    }
}

/// Returns whether results are written inside: an existing folder, or a path that ends in a slash.
#[must_use]
pub(crate) fn is_folder(out: &Path) -> bool {
    out.is_dir() || out.as_os_str().to_string_lossy().ends_with(['/', std::path::MAIN_SEPARATOR])
}

/// Extensions of files that lodc only writes.
const WRITTEN_EXTENSIONS: [&str; 2] = ["lods", "html"];

/// Refuses a folder for several results that has a file's name and is not there: `-o levels.lodc`
/// is meant to be a file.
///
/// # Errors
/// If it is so.
pub(crate) fn refuse_file_name(folder: &Path) -> Result<(), JobError> {
    let is_file_name =
        has_extension(folder, &LEVEL_EXTENSIONS) || has_extension(folder, &WRITTEN_EXTENSIONS);
    if !is_file_name || is_folder(folder) {
        return Ok(());
    }
    let folder = folder.display();
    Err(JobError::Usage(format!(
        "{folder}: a file's name, and there are several results: name a folder, or {folder}/"
    )))
}

/// The name of an input's result: the input's with the extension added, so that no two inputs of a
/// folder share one. Files and streams of lodc itself exchange theirs.
pub(crate) fn result_name(input: &str, extension: &str) -> String {
    let exchanged = match extension {
        "lods" => input.strip_suffix(".lodc"),
        "lodc" => input.strip_suffix(".lods"),
        _ => None,
    };
    format!("{}.{extension}", exchanged.unwrap_or(input))
}

/// The file name of the result of a named input.
fn result_file(input: &Path, extension: &str) -> PathBuf {
    if is_standard_stream(input) {
        return format!("stdin.{extension}").into();
    }
    match input.file_name().map(|name| (name, name.to_str())) {
        Some((_, Some(name))) => result_name(name, extension).into(),
        name => {
            let mut name = name.map(|(name, _)| name).unwrap_or_default().to_owned();
            name.push(format!(".{extension}"));
            name.into()
        }
    }
}

/// Equal for paths of one file. Of a file that does not exist: the canonical path of its folder,
/// and its name; names that differ only in case on a system that ignores case are not recognized.
pub(crate) fn path_identity(path: &Path) -> PathBuf {
    if let Ok(whole) = path.canonicalize() {
        return whole;
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    folder.join(path.file_name().unwrap_or_default())
}

/// Checks before any work that results can be written; `make_folders` says whether their missing
/// folders are made.
///
/// # Errors
/// If a folder cannot be made or does not exist, or a result has the name of a folder.
pub(crate) fn prepare_targets<'a>(
    targets: impl IntoIterator<Item = &'a Target>,
    make_folders: bool,
) -> Result<(), JobError> {
    for target in targets {
        let Target::File(path) = target else { continue };
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => continue,
        };
        let above = folder.ancestors().find(|above| above.exists());
        if let Some(file) = above.filter(|above| !above.is_dir()) {
            return Err(not_written(path, &format!("{} is a file, not a folder", file.display())));
        }
        if make_folders && !folder.exists() {
            std::fs::create_dir_all(folder).map_err(|e| not_written(folder, &e.to_string()))?;
        }
        if !folder.is_dir() {
            return Err(not_written(path, "its folder does not exist"));
        }
        if path.is_dir() {
            return Err(not_written(path, "a folder has this name"));
        }
    }
    Ok(())
}

fn not_written(path: &Path, why: &str) -> JobError {
    JobError::Output(format!("{}: not written: {why}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_has_its_inputs_whole_name() {
        let file = |input: &str, extension: &str| result_file(Path::new(input), extension);
        assert_eq!(file("a/part.v2.obj", "lodc"), Path::new("part.v2.obj.lodc"));
        assert_eq!(file("-", "lodc"), Path::new("stdin.lodc"));
        assert_eq!(file("a/club.obj.lodc", "lods"), Path::new("club.obj.lods"));
        assert_eq!(file("club.obj.lods", "lodc"), Path::new("club.obj.lodc"));
        assert_eq!(file("club.lodc", "glb"), Path::new("club.lodc.glb"));
    }

    #[test]
    fn a_folder_has_no_name_of_a_file() {
        for (name, refused) in
            [("x.lodc", true), ("a/x.GLB", true), ("x.lodc/", false), ("v1.2", false)]
        {
            assert_eq!(refuse_file_name(Path::new(name)).is_err(), refused, "{name}");
        }
    }

    #[test]
    fn a_single_result_goes_where_out_says() {
        let name = |input: &str, out: Option<&str>| {
            single_target(Path::new(input), out.map(Path::new), "lodc").map(|target| target.name())
        };
        assert_eq!(name("a/x.obj", None), Ok("a/x.obj.lodc".to_owned()));
        assert_eq!(name("a/x.obj", Some("out/")), Ok("out/x.obj.lodc".to_owned()));
        assert_eq!(name("a/x.obj", Some(".")), Ok("x.obj.lodc".to_owned()));
        assert_eq!(name("-", Some("-")), Ok("-".to_owned()));
        assert!(name("-", None).is_err());
        assert!(name("x.obj", Some("x.obj")).is_err(), "it would replace the input");
    }
}
