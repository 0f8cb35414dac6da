//! The files below a folder, at any depth, by extension and glob.

use crate::jobs::error::JobError;
use globset::{GlobBuilder, GlobSet, GlobSetBuilder};
use std::path::{Component, Path, PathBuf};
use walkdir::WalkDir;

/// Extensions of the meshes that are taken from folders.
pub(crate) const MESH_EXTENSIONS: [&str; 6] = ["obj", "gltf", "glb", "vrm", "ply", "stl"];

/// Extensions of the files that are taken from folders where stored levels serve as well as meshes.
pub(crate) const LEVEL_EXTENSIONS: [&str; 7] = ["obj", "gltf", "glb", "vrm", "ply", "stl", "lodc"];

/// Accepts files by their paths below a folder.
#[derive(Debug)]
pub(crate) struct PathFilter {
    /// Without globs every path is included.
    include: Option<GlobSet>,
    exclude: GlobSet,
}

impl PathFilter {
    /// Compiles the globs of `--include` and `--exclude`.
    ///
    /// # Errors
    /// If a glob is malformed.
    pub(crate) fn new(include: &[String], exclude: &[String]) -> Result<Self, JobError> {
        let include = (!include.is_empty()).then(|| globs(include)).transpose()?;
        Ok(Self { include, exclude: globs(exclude)? })
    }

    fn accepts(&self, name: &str) -> bool {
        self.include.as_ref().is_none_or(|set| set.is_match(name)) && !self.exclude.is_match(name)
    }
}

/// Returns `inputs` with each folder replaced by its files that have one of the extensions and
/// whose paths below it match the globs: any of `include`, if there are some, and none of
/// `exclude`.
///
/// # Errors
/// If a folder cannot be read or has no such file, or a glob is malformed.
pub(crate) fn expand_folders(
    inputs: &[PathBuf],
    extensions: &[&str],
    include: &[String],
    exclude: &[String],
) -> Result<Vec<PathBuf>, JobError> {
    let filter = PathFilter::new(include, exclude)?;
    let mut all = Vec::new();
    for input in inputs {
        if input.is_dir() {
            all.extend(files_below(input, extensions, &filter)?.into_iter().map(|(path, _)| path));
        } else {
            all.push(input.clone());
        }
    }
    Ok(all)
}

/// Compiles globs, in which `*` and `?` do not match a slash.
pub(crate) fn globs(patterns: &[String]) -> Result<GlobSet, JobError> {
    let mut set = GlobSetBuilder::new();
    for pattern in patterns {
        let glob = GlobBuilder::new(pattern).literal_separator(true).build();
        set.add(glob.map_err(|e| JobError::Usage(format!("glob {pattern}: {}", e.kind())))?);
    }
    set.build().map_err(|e| JobError::Usage(format!("globs: {e}")))
}

/// Returns the files below `folder` with one of the extensions that the filter accepts, sorted by
/// name: their paths, and their names, which are the paths below `folder` with slashes. Hidden
/// files and folders (`.name`) are skipped; links to folders are not followed.
///
/// # Errors
/// If a folder cannot be read, or no file matches.
pub(crate) fn files_below(
    folder: &Path,
    extensions: &[&str],
    filter: &PathFilter,
) -> Result<Vec<(PathBuf, String)>, JobError> {
    let hidden = |name: &std::ffi::OsStr| name.to_string_lossy().starts_with('.');
    let walk = WalkDir::new(folder).sort_by_file_name().into_iter();
    let mut found = Vec::new();
    for entry in walk.filter_entry(|e| e.depth() == 0 || !hidden(e.file_name())) {
        let entry = entry.map_err(|e| {
            let path = e.path().unwrap_or(folder).display().to_string();
            let why = e
                .into_io_error()
                .map_or("is part of a circle of links".to_owned(), |e| e.to_string());
            JobError::Input(format!("{path}: {why}"))
        })?;
        let path = entry.path();
        let name = with_slashes(path.strip_prefix(folder).unwrap_or(path));
        if path.is_file() && has_extension(path, extensions) && filter.accepts(&name) {
            found.push((path.to_owned(), name));
        }
    }
    if found.is_empty() {
        let wanted = extensions.join(", ");
        let what = format!("{}: no file of this folder matches ({wanted})", folder.display());
        return Err(JobError::Input(what));
    }
    found.sort_by(|a, b| a.1.cmp(&b.1));
    Ok(found)
}

/// Returns whether a path ends in one of some extensions, in any case.
#[must_use]
pub(crate) fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension().is_some_and(|e| extensions.iter().any(|x| e.eq_ignore_ascii_case(x)))
}

/// The names in a path, joined by slashes on every system; roots, `.` and `..` are dropped.
pub(crate) fn with_slashes(path: &Path) -> String {
    let normal = path.components().filter_map(|part| match part {
        Component::Normal(name) => Some(name.to_string_lossy()),
        _ => None,
    });
    normal.collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_stay_within_one_folder_and_double_stars_do_not() {
        let one = globs(&["*.obj".to_owned()]).expect("a glob");
        assert!(one.is_match("a.obj") && !one.is_match("b/a.obj"));
        let all = globs(&["**/*.obj".to_owned()]).expect("a glob");
        assert!(all.is_match("a.obj") && all.is_match("b/c/a.obj"));
        assert!(globs(&["a[".to_owned()]).is_err());
    }

    #[test]
    fn names_below_a_folder_have_slashes_and_no_way_out() {
        assert_eq!(with_slashes(Path::new("a/./b/../c.obj")), "a/b/c.obj");
        assert_eq!(with_slashes(Path::new("/x/y.glb")), "x/y.glb");
    }
}
