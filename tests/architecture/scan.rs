//! A small scanner of Rust and WGSL: enough to find functions, paths and words without a parser.

/// The code with comments and the contents of literals replaced by spaces. Lines stay where they
/// are.
pub(crate) fn blanked(text: &str) -> String {
    let bytes: Vec<char> = text.chars().collect();
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    while at < bytes.len() {
        let end = skipped(&bytes, at);
        if end == at {
            out.push(bytes[at]);
            at += 1;
        } else {
            out.extend(bytes[at..end].iter().map(|&c| if c == '\n' { '\n' } else { ' ' }));
            at = end;
        }
    }
    out
}

/// The end of the comment or literal that begins at `at`, or `at` if there is none.
fn skipped(text: &[char], at: usize) -> usize {
    let next = |i: usize| text.get(i).copied().unwrap_or('\n');
    let inside_a_word = at > 0 && is_word(text[at - 1]);
    match text[at] {
        '/' if next(at + 1) == '/' => line_end(text, at),
        '/' if next(at + 1) == '*' => comment_end(text, at),
        '"' => string_end(text, at + 1),
        'r' if !inside_a_word && (next(at + 1) == '"' || next(at + 1) == '#') => {
            raw_string_end(text, at)
        }
        // A character, not a lifetime.
        '\'' if next(at + 1) == '\\' => {
            let close = (at + 3..text.len()).find(|&i| text[i] == '\'');
            close.map_or(text.len(), |i| i + 1)
        }
        '\'' if next(at + 2) == '\'' => at + 3,
        _ => at,
    }
}

fn line_end(text: &[char], at: usize) -> usize {
    (at..text.len()).find(|&i| text[i] == '\n').unwrap_or(text.len())
}

fn comment_end(text: &[char], at: usize) -> usize {
    let mut depth = 0;
    let mut i = at;
    while i + 1 < text.len() {
        match (text[i], text[i + 1]) {
            ('/', '*') => depth += 1,
            ('*', '/') => depth -= 1,
            _ => {
                i += 1;
                continue;
            }
        }
        i += 2;
        if depth == 0 {
            return i;
        }
    }
    text.len()
}

fn string_end(text: &[char], mut at: usize) -> usize {
    while at < text.len() {
        match text[at] {
            '\\' => at += 2,
            '"' => return at + 1,
            _ => at += 1,
        }
    }
    text.len()
}

/// The end of `r"…"` or `r#"…"#`; `at` itself for a raw identifier.
fn raw_string_end(text: &[char], at: usize) -> usize {
    let hashes = text[at + 1..].iter().take_while(|&&c| c == '#').count();
    let open = at + 1 + hashes;
    if text.get(open) != Some(&'"') {
        return at;
    }
    let close = |i: &usize| {
        text[*i] == '"'
            && text[i + 1..].iter().take(hashes).filter(|&&c| c == '#').count() == hashes
    };
    (open + 1..text.len()).find(close).map_or(text.len(), |i| i + 1 + hashes)
}

pub(crate) fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// A function: name, first line (from 1) and number of lines, signature and braces included.
pub(crate) struct Function {
    pub(crate) name: String,
    pub(crate) line: usize,
    pub(crate) lines: usize,
}

/// All functions with a body, in blanked code.
pub(crate) fn functions(blanked: &str) -> Vec<Function> {
    let mut found = Vec::new();
    for (at, _) in blanked.match_indices("fn ") {
        if blanked[..at].chars().next_back().is_some_and(is_word) {
            continue;
        }
        let name: String = blanked[at + 3..].chars().take_while(|&c| is_word(c)).collect();
        let rest = &blanked[at..];
        if name.is_empty() {
            continue;
        }
        if let Some(end) = body_end(rest) {
            let line = blanked[..at].matches('\n').count() + 1;
            found.push(Function { name, line, lines: rest[..end].matches('\n').count() + 1 });
        }
    }
    found
}

/// The end of the braces that follow a signature; none for a declaration without a body.
fn body_end(text: &str) -> Option<usize> {
    let (mut braces, mut brackets) = (0usize, 0usize);
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' => brackets += 1,
            ')' | ']' => brackets = brackets.saturating_sub(1),
            ';' if braces == 0 && brackets == 0 => return None,
            '{' => braces += 1,
            '}' => {
                braces = braces.saturating_sub(1);
                if braces == 0 {
                    return Some(at + 1);
                }
            }
            _ => {}
        }
    }
    None
}

/// The words of a text in lower case: `removedAt`, `removed_at` and `RemovedAt` all are two.
pub(crate) fn words(text: &str) -> impl Iterator<Item = String> + '_ {
    text.split(|c: char| !is_word(c)).filter(|i| !i.is_empty()).flat_map(parts)
}

fn parts(identifier: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut was_lower = false;
    for c in identifier.chars() {
        if c == '_' || (c.is_uppercase() && was_lower) {
            parts.push(String::new());
        }
        if c != '_' {
            parts.last_mut().expect("never empty").extend(c.to_lowercase());
        }
        was_lower = c.is_lowercase() || c.is_numeric();
    }
    parts.retain(|p| !p.is_empty());
    parts
}

#[test]
fn scanner_knows_comments_literals_and_functions() {
    let code = "fn a<'b>() { let c = '{'; /* } */ \"}\\\"\"; r#\"}\"#; }\nfn d();\nfn e()\n{\n}\n";
    let clean = blanked(code);
    assert_eq!(clean.len(), code.len());
    assert_eq!(clean.matches(['{', '}']).count(), 4);
    let found = functions(&clean);
    let found: Vec<_> = found.iter().map(|f| (f.name.as_str(), f.line, f.lines)).collect();
    assert_eq!(found, [("a", 1, 1), ("e", 3, 3)]);
    let split: Vec<String> = words("removedAt Removed_AT x2y").collect();
    assert_eq!(split, ["removed", "at", "removed", "at", "x2y"]);
}
