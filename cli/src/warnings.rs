//! Warnings about one file for people: one line for each kind, with the first example.

use std::collections::BTreeMap;

/// The lines for some warnings: as they are, or of several of one kind the first and their number.
pub(crate) fn merged(warnings: &[String]) -> Vec<String> {
    let mut kinds: BTreeMap<String, usize> = BTreeMap::new();
    // The first warning of each kind, and the number of all of it.
    let mut groups: Vec<(&str, usize)> = Vec::new();
    for warning in warnings {
        let next = groups.len();
        let group = *kinds.entry(kind(warning)).or_insert(next);
        if group == next {
            groups.push((warning, 0));
        }
        groups[group].1 += 1;
    }
    let line = |(first, count): &(&str, usize)| match count {
        1 => (*first).to_owned(),
        count => format!("{first} ({count} warnings of this kind, --verbose lists all)"),
    };
    groups.iter().map(line).collect()
}

/// What warnings of one kind have in common: the words before a colon, numbers and names left out.
fn kind(warning: &str) -> String {
    // A name is not in quotes in `the object NAME is gone`, and may be any text.
    for what in ["object", "material"] {
        let rest = warning.rsplit_once(": ").map_or(warning, |(_, rest)| rest);
        let of_part = rest.strip_prefix("the ").and_then(|rest| rest.strip_prefix(what));
        if of_part.is_some_and(|rest| rest.contains(" is gone")) {
            return format!("{what} gone");
        }
    }
    // What has no space before a colon is the name of a file.
    let mut parts = warning.split(": ").skip_while(|part| !part.contains(' '));
    let phrase = parts.next().unwrap_or(warning);
    let mut out = String::new();
    let mut in_quotes = false;
    for c in phrase.chars() {
        match c {
            '`' | '"' => in_quotes = !in_quotes,
            _ if in_quotes => {}
            '0'..='9' if out.ends_with('#') => {}
            '0'..='9' => out.push('#'),
            _ => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(warnings: &[&str]) -> Vec<String> {
        merged(&warnings.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn warnings_of_one_kind_are_one_line() {
        let shown = lines(&[
            "the object bolt is gone",
            "1 polygon was triangulated",
            "the object nut is gone (97 % of its visible surface)",
            "a texture is missing: a.png: no such file",
            "a texture is missing: b.png: no such file",
            "level 2: the object nut is gone",
        ]);
        assert_eq!(
            shown,
            [
                "the object bolt is gone (3 warnings of this kind, --verbose lists all)",
                "1 polygon was triangulated",
                "a texture is missing: a.png: no such file \
             (2 warnings of this kind, --verbose lists all)",
            ]
        );
    }

    #[test]
    fn warnings_of_different_kinds_stay() {
        let all = [
            "a.mtl: 2 materials are defined more than once: the first definition is used",
            "a.mtl: skipped 2 lines before the first material",
            "1 property of each face was ignored: `flags`",
            "1 property of each vertex was ignored: `quality`",
        ];
        assert_eq!(lines(&all), all);
    }
}
