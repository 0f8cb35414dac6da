//! Dependency files, as Make and Ninja read them: which files a result was made from.

use crate::jobs::error::JobError;
use crate::jobs::run::Job;
use crate::jobs::target::is_standard_stream;
use lodc_formats::RequestedFiles;
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

/// One rule of a dependency file: a result, the files that it was made from, and those that were
/// looked for and absent.
#[derive(Clone, Debug)]
pub(crate) struct DependencyRule {
    /// The result.
    pub(crate) output: PathBuf,
    /// The files that it was made from.
    pub(crate) inputs: Vec<PathBuf>,
    /// Files that would have been read, had they been there.
    pub(crate) absent: Vec<PathBuf>,
}

impl DependencyRule {
    /// The rule of a result: the files that were read for it, and the absent ones that Make can
    /// name.
    #[must_use]
    pub(crate) fn new(output: &Path, files: &RequestedFiles) -> Self {
        let absent = files.absent().into_iter().filter(|path| make_can_name(path)).collect();
        Self { output: output.to_owned(), inputs: files.read_files(), absent }
    }

    /// The rule with the files that gave the result its options.
    #[must_use]
    pub(crate) fn with_options_of(mut self, job: &Job) -> Self {
        self.inputs.extend(job.option_files().cloned());
        self
    }

    /// Checks that Make can read its names.
    ///
    /// # Errors
    /// If one has a line break or is not UTF-8: there is no way to write it.
    pub(crate) fn check(&self) -> Result<(), JobError> {
        let names = [&self.output].into_iter().chain(&self.inputs).chain(&self.absent);
        let unwritable =
            |path: &&PathBuf| path.to_str().is_none_or(|name| name.contains(['\n', '\r']));
        match names.into_iter().find(unwritable) {
            None => Ok(()),
            Some(path) => Err(JobError::Output(format!(
                "{path:?}: a name with a line break, or not in UTF-8, has no place in a \
                 dependency file"
            ))),
        }
    }

    /// The rule as Make reads it; a file that was read twice is listed once. Each absent file also
    /// gets a rule without inputs, else Make stops because it does not know how to make that file.
    #[must_use]
    pub(crate) fn text(&self) -> String {
        let (mut text, mut listed) = (escaped(&self.output), BTreeSet::new());
        text.push(':');
        for input in self.inputs.iter().chain(&self.absent) {
            if !is_standard_stream(input) && listed.insert(input) {
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

/// Returns whether an absent file can have a rule of its own: some characters have another meaning
/// in the target of a rule, and Make has no escape for them.
fn make_can_name(path: &Path) -> bool {
    const SPECIAL: [char; 5] = ['\\', '%', ':', '=', ';'];
    path.components().all(|component| match component {
        Component::Normal(name) => !name.to_string_lossy().contains(SPECIAL),
        _ => true,
    })
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
    fn a_rule_names_each_input_once() {
        let inputs = ["m.gltf", "a.png", "b.png", "a.png"].map(PathBuf::from).to_vec();
        let absent = vec!["c.png".into()];
        let text = DependencyRule { output: "m.glb".into(), inputs, absent }.text();
        let expected = "m.glb: \\\n  m.gltf \\\n  a.png \\\n  b.png \\\n  c.png\nc.png:\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn absent_names_that_make_reads_as_something_else_get_no_rule() {
        for (name, plain) in [("a/b c.png", true), ("a/%2e/b.mtl", false), ("a/..\\b.png", false)] {
            assert_eq!(make_can_name(Path::new(name)), plain, "{name}");
        }
    }

    #[test]
    fn names_that_make_cannot_read_are_refused() {
        let rule = |name: &str| DependencyRule {
            output: "x".into(),
            inputs: vec![name.into()],
            absent: vec![],
        };
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
