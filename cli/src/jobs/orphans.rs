//! Results whose inputs are gone.

use crate::jobs::folder::{has_extension, with_slashes};
use crate::jobs::run::{CommandPaths, Job};
use crate::jobs::target::path_identity;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use walkdir::WalkDir;

/// The folder beside results that says what they were made from: of `OUT/NAME` in
/// `OUT/.lodc/NAME.json`.
pub(crate) const RECORDS: &str = ".lodc";

/// Returns, by folder and name, the results in folders that are named after inputs which no input
/// folder has any more. Those of `jobs` are left out: named files and lists may have results there,
/// too. With `recorded` only results with a record count. What cannot be read is left out.
#[must_use]
pub(crate) fn orphans(paths: CommandPaths<'_>, jobs: &[Job], recorded: bool) -> Vec<PathBuf> {
    let own: BTreeSet<PathBuf> = jobs.iter().filter_map(Job::file).map(path_identity).collect();
    let folders: Vec<&PathBuf> = paths.inputs.iter().filter(|input| input.is_dir()).collect();
    let roots: BTreeSet<&Path> =
        folders.iter().map(|folder| paths.output.unwrap_or(folder)).collect();
    let mut found = Vec::new();
    for root in roots {
        let walk = WalkDir::new(root).sort_by_file_name().into_iter().filter_entry(|entry| {
            let name = entry.file_name().to_string_lossy();
            entry.depth() == 0 || !name.starts_with('.') || (recorded && name == RECORDS)
        });
        for entry in walk.filter_map(Result::ok).filter(|entry| entry.file_type().is_file()) {
            let target = match recorded {
                true => recorded_target(entry.path()),
                false => Some(entry.path().to_owned()),
            };
            let Some(target) = target else { continue };
            let name = with_slashes(target.strip_prefix(root).unwrap_or(&target));
            let Some(input) = input_name(&name, paths) else { continue };
            if !folders.iter().any(|folder| folder.join(&input).exists())
                && !own.contains(&path_identity(&target))
            {
                found.push(target);
            }
        }
    }
    found
}

/// The result that a file is the record of.
fn recorded_target(record: &Path) -> Option<PathBuf> {
    let folder = record.parent().filter(|folder| folder.file_name() == Some(RECORDS.as_ref()))?;
    let name = record.file_name()?.to_str()?.strip_suffix(".json")?;
    Some(folder.parent()?.join(name))
}

/// The name of the input that a result of this name has, if it can be one.
fn input_name(result: &str, paths: CommandPaths<'_>) -> Option<String> {
    let stem = result.strip_suffix(paths.output_extension)?.strip_suffix('.')?;
    let input = match paths.output_extension {
        "lods" => format!("{stem}.lodc"),
        _ => stem.to_owned(),
    };
    has_extension(Path::new(&input), paths.input_extensions).then_some(input)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_results_lead_to_their_inputs() {
        let of = |result: &str, extension: &'static str| {
            let paths = CommandPaths {
                inputs: &[],
                output: None,
                input_extensions: &["obj", "lodc"],
                output_extension: extension,
                allowed_folders: &[],
            };
            input_name(result, paths)
        };
        assert_eq!(of("a/x.obj.lodc", "lodc").as_deref(), Some("a/x.obj"));
        assert_eq!(of("a/x.obj.lods", "lods").as_deref(), Some("a/x.obj.lodc"));
        for (other, extension) in [("x.lodc", "lodc"), ("x.txt.lodc", "lodc"), ("x.obj", "glb")] {
            assert_eq!(of(other, extension), None, "{other}");
        }
        let record = Path::new("out/a/.lodc/x.obj.glb.json");
        assert_eq!(recorded_target(record).as_deref(), Some(Path::new("out/a/x.obj.glb")));
        assert_eq!(recorded_target(Path::new("out/a/x.obj.glb.json")), None);
    }
}
