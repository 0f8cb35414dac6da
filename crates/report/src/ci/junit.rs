//! JUnit files, which most CI systems show.

use super::{Case, Suite, Verdict};
use std::fmt::Write;

/// The checks as XML.
#[must_use]
pub fn junit(title: &str, suites: &[Suite]) -> String {
    let cases: Vec<&Case> = suites.iter().flat_map(|suite| &suite.cases).collect();
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    // Writing to a string cannot fail.
    let (title, counts) = (escaped(title), Counts::of(cases.iter().copied()));
    let _ = writeln!(xml, "<testsuites name=\"{title}\" {counts}>");
    for suite in suites {
        let (name, counts) = (escaped(&suite.name), Counts::of(&suite.cases));
        let _ = writeln!(xml, "  <testsuite name=\"{name}\" {counts}>");
        for case in &suite.cases {
            let title = escaped(&case.name);
            let verdict = element(&case.verdict);
            let _ = writeln!(
                xml,
                "    <testcase classname=\"{name}\" name=\"{title}\">{verdict}</testcase>"
            );
        }
        xml.push_str("  </testsuite>\n");
    }
    xml.push_str("</testsuites>\n");
    xml
}

fn element(verdict: &Verdict) -> String {
    let (tag, message) = match verdict {
        Verdict::Passed => return String::new(),
        Verdict::Skipped(why) => ("skipped", why),
        Verdict::Failed(what) => ("failure", what),
        Verdict::Error(what) => ("error", what),
    };
    format!("<{tag} message=\"{}\"/>", escaped(message))
}

/// Numbers of checks by their results.
#[derive(Default)]
struct Counts {
    tests: usize,
    failures: usize,
    errors: usize,
    skipped: usize,
}

impl Counts {
    fn of<'a>(cases: impl IntoIterator<Item = &'a Case>) -> Self {
        let mut counts = Self::default();
        for case in cases {
            counts.tests += 1;
            match case.verdict {
                Verdict::Passed => {}
                Verdict::Skipped(_) => counts.skipped += 1,
                Verdict::Failed(_) => counts.failures += 1,
                Verdict::Error(_) => counts.errors += 1,
            }
        }
        counts
    }
}

impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { tests, failures, errors, skipped } = self;
        write!(
            f,
            "tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" skipped=\"{skipped}\""
        )
    }
}

/// Text as an attribute value; what XML cannot hold becomes a question mark.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => safe.push('?'),
            c if c.is_control() => safe.push('?'),
            c => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_break_the_markup_and_every_verdict_has_its_element() {
        let case = |verdict| Case { name: "a<b>&\"c\u{1}".to_owned(), verdict };
        let cases = vec![
            case(Verdict::Passed),
            case(Verdict::Skipped("why".to_owned())),
            case(Verdict::Failed("<x>".to_owned())),
            case(Verdict::Error("gone".to_owned())),
        ];
        let text = junit("lodc verify", &[Suite { name: "f".to_owned(), cases }]);
        assert!(text.contains("classname=\"f\" name=\"a&lt;b&gt;&amp;&quot;c?\""), "{text}");
        for element in ["skipped message=\"why\"", "failure message=\"&lt;x&gt;\"", "error message"]
        {
            assert!(text.contains(element), "{element} in {text}");
        }
        let counts = "tests=\"4\" failures=\"1\" errors=\"1\" skipped=\"1\"";
        assert_eq!(text.matches(counts).count(), 2, "{text}");
    }
}
