//! Messages about sections that a reader skips because this version does not know them. Their
//! number is limited, because a crafted file may have any number.

/// Lines beyond this are only counted: a crafted file could ask for any number of them.
const MOST: usize = 20;
/// Characters of a name that a line shows.
const NAME: usize = 60;

/// Collects one line for each thing left out.
#[derive(Default)]
pub(super) struct LeftOut {
    lines: Vec<String>,
    more: usize,
}

impl LeftOut {
    /// `line` is made only if it is kept.
    pub(super) fn tell(&mut self, line: impl FnOnce() -> String) {
        if self.lines.len() < MOST {
            self.lines.push(line());
        } else {
            self.more += 1;
        }
    }

    pub(super) fn into_lines(mut self) -> Vec<String> {
        if self.more > 0 {
            self.lines.push(format!("{} things more were left out", self.more));
        }
        self.lines
    }
}

/// A name from a file, fit for a line.
pub(super) fn shortened(name: &str) -> String {
    let mut short: String = name.chars().take(NAME).collect();
    if short.len() < name.len() {
        short.push('…');
    }
    if cfg!(feature = "terse") { short } else { short.escape_debug().to_string() }
}
