//! `--junit`: the checks as a JUnit file, which CI systems show.

use crate::report::VerifyReport;
use std::fmt::Write;

/// The report as XML.
pub(super) fn xml(report: &VerifyReport) -> String {
    let checks = || report.files.iter().flat_map(|f| &f.checks);
    let failures = checks().filter(|c| c.ok == Some(false)).count();
    let errors = report.files.iter().filter(|f| f.error.is_some()).count();
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    // Writing to a string cannot fail.
    let _ = writeln!(
        xml,
        "<testsuites name=\"lodc verify\" tests=\"{}\" \
         failures=\"{failures}\" errors=\"{errors}\">",
        checks().count() + errors
    );
    for file in &report.files {
        let name = escaped(&file.file);
        let failed = file.checks.iter().filter(|c| c.ok == Some(false)).count();
        let unread = usize::from(file.error.is_some());
        let tests = file.checks.len() + unread;
        let skipped = file.checks.iter().filter(|c| c.ok.is_none()).count();
        let _ = writeln!(
            xml,
            "  <testsuite name=\"{name}\" tests=\"{tests}\" failures=\"{failed}\" \
             errors=\"{unread}\" skipped=\"{skipped}\">"
        );
        if let Some(error) = &file.error {
            let _ = writeln!(
                xml,
                "    <testcase classname=\"{name}\" name=\"read\">\
                 <error message=\"{}\"/></testcase>",
                escaped(error)
            );
        }
        for check in &file.checks {
            let object = check.object.as_deref().unwrap_or("file");
            let title =
                escaped(&format!("{object}: {}, {}, {}", check.model, check.check, check.device));
            let verdict = match (&check.first_difference, &check.skipped) {
                (Some(what), _) => format!("<failure message=\"{}\"/>", escaped(what)),
                (None, Some(why)) => format!("<skipped message=\"{}\"/>", escaped(why)),
                (None, None) => String::new(),
            };
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
    use crate::report::{CheckReport, FileReport};

    #[test]
    fn names_cannot_break_the_markup_and_every_verdict_has_its_element() {
        let check = |ok, skipped: Option<&str>, first_difference: Option<&str>| CheckReport {
            object: Some("a<b>&\"c\u{1}".to_owned()),
            model: "interactive",
            check: "random jumps",
            device: "cpu",
            adapter: None,
            lods: 1,
            full: 1,
            ok,
            skipped: skipped.map(str::to_owned),
            first_difference: first_difference.map(str::to_owned),
        };
        let checks = vec![
            check(Some(true), None, None),
            check(None, Some("why"), None),
            check(Some(false), None, Some("<x>")),
        ];
        let file = FileReport { file: "f".to_owned(), ok: false, checks, error: None };
        let text = xml(&VerifyReport { schema_version: 1, ok: false, files: vec![file] });
        assert!(text.contains("a&lt;b&gt;&amp;&quot;c?: interactive, random jumps, cpu"), "{text}");
        assert!(text.contains("<failure message=\"&lt;x&gt;\"/>"), "{text}");
        assert!(text.contains("<skipped message=\"why\"/>"), "{text}");
        assert!(text.contains("tests=\"3\" failures=\"1\" errors=\"0\" skipped=\"1\""), "{text}");
    }
}
