//! Failures as annotations: lines that a CI system shows beside the files.

use super::{Suite, Verdict};

/// A workflow command of GitHub Actions, `::error file=…,title=…::…`, for every check that failed
/// or could not be made.
pub fn github(title: &str, suites: &[Suite]) -> impl Iterator<Item = String> {
    let commands = move |suite: &Suite| {
        let lines = suite.cases.iter().filter_map(|case| match &case.verdict {
            Verdict::Failed(what) | Verdict::Error(what) => {
                Some(command(title, &suite.name, &format!("{}: {what}", case.name)))
            }
            Verdict::Passed | Verdict::Skipped(_) => None,
        });
        lines.collect::<Vec<_>>()
    };
    suites.iter().flat_map(commands)
}

fn command(title: &str, file: &str, what: &str) -> String {
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
        let line = command("lodc verify", "a,b:c.lodc", "5 %\nmore: ::x");
        assert_eq!(line, "::error file=a%2Cb%3Ac.lodc,title=lodc verify::5 %25%0Amore: ::x");
    }
}
