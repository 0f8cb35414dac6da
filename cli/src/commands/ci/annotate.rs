//! Failures as annotations: lines that a CI system shows beside the files.

use super::{Suite, Verdict};
use crate::console;
use clap::ValueEnum;

/// CI systems with annotations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Annotate {
    /// Workflow commands of GitHub Actions
    Github,
}

/// Prints an annotation for every check that failed or could not be made.
pub(crate) fn annotate(system: Annotate, title: &str, suites: &[Suite]) {
    let Annotate::Github = system;
    for suite in suites {
        for case in &suite.cases {
            if let Verdict::Failed(what) | Verdict::Error(what) = &case.verdict {
                console::annotation(&github(title, &suite.name, &format!("{}: {what}", case.name)));
            }
        }
    }
}

/// A workflow command: `::error file=…,title=…::…`.
fn github(title: &str, file: &str, what: &str) -> String {
    let property = |text: &str| escaped(text).replace(':', "%3A").replace(',', "%2C");
    format!("::error file={},title={}::{}", property(file), property(title), escaped(what))
}

/// Text that stays in its line.
fn escaped(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_ends_an_annotation_early() {
        let line = github("lodc verify", "a,b:c.lodc", "5 %\nmore: ::x");
        assert_eq!(line, "::error file=a%2Cb%3Ac.lodc,title=lodc verify::5 %25%0Amore: ::x");
    }
}
