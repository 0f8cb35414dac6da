//! Messages about sections that a reader skips because this version does not know them. Their
//! number is limited, because a crafted file may have any number.

/// Lines beyond this are only counted: a crafted file could ask for any number of them.
/// Chosen by hand.
const MAX_LINES: usize = 20;
/// Characters of a name that a line shows. Chosen by hand.
const NAME_CHARACTERS: usize = 60;

/// Collects one line for each part of a file that is skipped.
#[derive(Default)]
pub(super) struct SkippedParts {
    lines: Vec<String>,
    /// Number of skipped parts that have no line.
    unlisted: usize,
}

impl SkippedParts {
    /// Adds a line, which is composed only if there is room for it.
    pub(super) fn add(&mut self, line: impl FnOnce() -> String) {
        if self.lines.len() < MAX_LINES {
            self.lines.push(line());
        } else {
            self.unlisted += 1;
        }
    }

    pub(super) fn into_lines(mut self) -> Vec<String> {
        if self.unlisted > 0 {
            self.lines.push(format!("{} more unknown parts were left out", self.unlisted));
        }
        self.lines
    }
}

/// A name from a file, fit for a line.
pub(super) fn shortened(name: &str) -> String {
    let mut short: String = name.chars().take(NAME_CHARACTERS).collect();
    if short.len() < name.len() {
        short.push('…');
    }
    if cfg!(feature = "minimal-messages") { short } else { short.escape_debug().to_string() }
}
