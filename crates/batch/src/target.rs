//! Where results go: a file, a folder or standard output; and rules of dependency files.

use crate::error::AssetError;
use lodc_formats::RequestedFiles;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// Target of one result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// `-`.
    Stdout,
    /// A file.
    File(PathBuf),
}

impl Target {
    /// As the user would write it.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Stdout => "-".to_owned(),
            Self::File(path) => path.display().to_string(),
        }
    }
}

/// Returns whether a path stands for standard input or output.
#[must_use]
pub fn is_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Returns the target of the only result: inside OUT if that is a folder, else OUT, else beside the
/// input.
///
/// # Errors
/// If standard input would need a place beside it, or the result would replace the input.
pub fn target(input: &Path, out: Option<&Path>, extension: &str) -> Result<Target, AssetError> {
    let folder = out.filter(|out| is_folder(out));
    let mut target = named_target(input, folder, out, extension);
    refuse_clashes([(input, &mut target)]);
    target
}

/// Returns the target of the result of a file that the command line names: in `folder` under its
/// own stem, else OUT, else beside the input.
///
/// # Errors
/// If standard input would need a place beside it.
pub(crate) fn named_target(
    input: &Path,
    folder: Option<&Path>,
    out: Option<&Path>,
    extension: &str,
) -> Result<Target, AssetError> {
    let stem = named(input, extension);
    match (folder, out) {
        // `.` would only make names longer.
        (Some(folder), _) if folder == Path::new(".") => Ok(Target::File(stem)),
        (Some(folder), _) => Ok(Target::File(folder.join(stem))),
        (None, Some(out)) if is_stream(out) => Ok(Target::Stdout),
        (None, Some(out)) => Ok(Target::File(out.to_owned())),
        (None, None) if is_stream(input) => {
            let what = "standard input has no place beside it: name the output with -o";
            Err(AssetError::Usage(what.to_owned()))
        }
        (None, None) => Ok(Target::File(input.with_file_name(stem))),
    }
}

/// Makes a failure of every target that another result has as well, or that is an input.
pub(crate) fn refuse_clashes<'a>(
    results: impl IntoIterator<Item = (&'a Path, &'a mut Result<Target, AssetError>)>,
) {
    let mut results: Vec<_> = results.into_iter().collect();
    let named = results.iter().filter(|(input, _)| !is_stream(input));
    let inputs: BTreeSet<PathBuf> = named.map(|(input, _)| place(input)).collect();
    let mut owners: BTreeMap<PathBuf, Vec<usize>> = BTreeMap::new();
    for (number, (_, target)) in results.iter().enumerate() {
        if let Ok(Target::File(path)) = target {
            owners.entry(place(path)).or_default().push(number);
        }
    }
    for (place, numbers) in owners {
        let names: Vec<_> = numbers.iter().map(|&n| results[n].0.display().to_string()).collect();
        let what = match names.as_slice() {
            [_] if inputs.contains(&place) => "the output would replace an input".to_owned(),
            [_] => continue,
            [a, b] => format!("{a} and {b} would both be written there"),
            [a, b, more @ ..] => {
                format!("{a}, {b} and {} more would all be written there", more.len())
            }
            [] => unreachable!("every place has an owner"),
        };
        for number in numbers {
            let target = &mut *results[number].1;
            if let Ok(Target::File(path)) = target {
                *target = Err(AssetError::Usage(format!("{}: {what}", path.display())));
            }
        }
    }
}

/// Returns whether results belong inside.
#[must_use]
pub fn is_folder(out: &Path) -> bool {
    out.is_dir() || out.as_os_str().to_string_lossy().ends_with(['/', std::path::MAIN_SEPARATOR])
}

/// The name of a result for an input.
fn named(input: &Path, extension: &str) -> PathBuf {
    let stem = if is_stream(input) {
        "stdin".into()
    } else {
        input.file_stem().unwrap_or_default().to_owned()
    };
    // Not `with_extension`: a stem such as `part.v2` keeps its dot.
    let mut name = stem;
    name.push(".");
    name.push(extension);
    name.into()
}

/// The identity of a path: its folder as the system knows it, and its name. Good enough for files
/// that do not exist.
fn place(path: &Path) -> PathBuf {
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

/// Makes sure that a result could be written, before the work that makes it.
///
/// # Errors
/// If the folder cannot be made or is none.
pub fn prepare<'a>(
    targets: impl IntoIterator<Item = &'a Target>,
    make_folder: bool,
) -> Result<(), AssetError> {
    for target in targets {
        let Target::File(path) = target else { continue };
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => continue,
        };
        if make_folder && !folder.exists() {
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

fn not_written(path: &Path, why: &str) -> AssetError {
    AssetError::Output(format!("{}: not written: {why}", path.display()))
}

/// One rule of a dependency file: a result, the files it was made from, and those that were not
/// there.
#[derive(Clone, Debug)]
pub struct Rule {
    /// The result.
    pub output: PathBuf,
    /// The files.
    pub inputs: Vec<PathBuf>,
    /// Files that would have been read, had they been there.
    pub absent: Vec<PathBuf>,
}

impl Rule {
    /// A rule of files that were looked for.
    #[must_use]
    pub fn new(output: &Path, files: &RequestedFiles) -> Self {
        let absent = files.absent().into_iter().filter(|path| has_rule(path)).collect();
        Self { output: output.to_owned(), inputs: files.read(), absent }
    }

    /// Checks that Make can read its names.
    ///
    /// # Errors
    /// If one has a line break or is not UTF-8: there is no way to write it.
    pub fn check(&self) -> Result<(), AssetError> {
        let names = [&self.output].into_iter().chain(&self.inputs).chain(&self.absent);
        let wrong = |path: &&PathBuf| path.to_str().is_none_or(|name| name.contains(['\n', '\r']));
        match names.into_iter().find(wrong) {
            None => Ok(()),
            Some(path) => Err(AssetError::Output(format!(
                "{path:?}: a name with a line break, or not in UTF-8, has no place in a \
                 dependency file"
            ))),
        }
    }

    /// The rule as Make reads it; what was read twice is listed once. A rule without inputs for
    /// each file that is not there keeps Make from asking how to make it.
    #[must_use]
    pub fn text(&self) -> String {
        let (mut text, mut named) = (escaped(&self.output), BTreeSet::new());
        text.push(':');
        for input in self.inputs.iter().chain(&self.absent) {
            if !is_stream(input) && named.insert(input) {
                text.push_str(" \\\n  ");
                text.push_str(&escaped(input));
            }
        }
        text.push('\n');
        let absent = self.absent.iter().collect::<BTreeSet<_>>();
        text.extend(absent.into_iter().map(|path| format!("{}:\n", escaped(path))));
        text
    }
}

/// Returns whether a file that is not there can have a rule of its own, without which Make would
/// stop: some characters mean something else in one, however they are written.
fn has_rule(path: &Path) -> bool {
    let plain =
        |c: Component<'_>| !c.as_os_str().to_string_lossy().contains(['\\', '%', ':', '=', ';']);
    path.components().all(|c| !matches!(c, Component::Normal(_)) || plain(c))
}

/// A path as Make reads it.
fn escaped(path: &Path) -> String {
    let mut text = String::new();
    for c in path.to_string_lossy().chars() {
        match c {
            ' ' | '#' | '\t' => text.extend(['\\', c]),
            '$' => text.push_str("$$"),
            _ => text.push(c),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stem_keeps_its_dots() {
        assert_eq!(named(Path::new("a/part.v2.obj"), "lodc"), Path::new("part.v2.lodc"));
        assert_eq!(named(Path::new("-"), "lodc"), Path::new("stdin.lodc"));
    }

    #[test]
    fn one_result_has_the_place_that_out_names() {
        let place = |input: &str, out: Option<&str>| {
            target(Path::new(input), out.map(Path::new), "lodc").map(|target| target.name())
        };
        assert_eq!(place("a/x.obj", None), Ok("a/x.lodc".to_owned()));
        assert_eq!(place("a/x.obj", Some("out/")), Ok("out/x.lodc".to_owned()));
        assert_eq!(place("a/x.obj", Some(".")), Ok("x.lodc".to_owned()));
        assert_eq!(place("-", Some("-")), Ok("-".to_owned()));
        assert!(place("-", None).is_err());
        assert!(place("x.lodc", None).is_err(), "it would replace the input");
    }

    #[test]
    fn a_rule_names_each_input_once() {
        let inputs = ["m.gltf", "a.png", "b.png", "a.png"].map(PathBuf::from).to_vec();
        let absent = vec!["c.png".into()];
        let text = Rule { output: "m.glb".into(), inputs, absent }.text();
        let named = "m.glb: \\\n  m.gltf \\\n  a.png \\\n  b.png \\\n  c.png\nc.png:\n";
        assert_eq!(text, named);
    }

    #[test]
    fn names_that_make_takes_for_something_else_are_no_rules() {
        for (name, plain) in [("a/b c.png", true), ("a/%2e/b.mtl", false), ("a/..\\b.png", false)] {
            assert_eq!(has_rule(Path::new(name)), plain, "{name}");
        }
    }

    #[test]
    fn names_that_make_cannot_read_are_refused() {
        let rule =
            |name: &str| Rule { output: "x".into(), inputs: vec![name.into()], absent: vec![] };
        assert!(rule("a b.obj").check().is_ok());
        for name in ["a\nb.obj", "a\rb.obj"] {
            let error = rule(name).check().expect_err(name).to_string();
            assert!(error.contains("line break") && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn make_reads_back_what_was_escaped() {
        assert_eq!(escaped(Path::new("a b/c$d#e")), "a\\ b/c$$d\\#e");
    }
}
