//! Statements of a text format: lines that may be continued, with comments, in any convention for
//! line ends.

use crate::words::counted;
use crate::{Fault, FormatError};

/// Walks over the statements of a text without copying it.
#[derive(Debug)]
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    /// Offset of the next byte to read.
    offset: usize,
    /// The line of that byte, from 1.
    line: u32,
    /// Offset of the current statement.
    start: usize,
    /// The line on which it starts.
    statement_line: u32,
    /// Largest number of bytes of a statement.
    limit: usize,
}

impl<'a> Lines<'a> {
    /// The statements of `bytes`, none longer than `limit`.
    pub(super) fn new(bytes: &'a [u8], limit: u64) -> Self {
        Self {
            bytes,
            offset: 0,
            line: 1,
            start: 0,
            statement_line: 1,
            limit: usize::try_from(limit).unwrap_or(usize::MAX),
        }
    }

    /// The location of the current statement, for messages.
    pub(super) fn location(&self) -> String {
        format!("line {}", self.statement_line)
    }

    /// The line on which the current statement starts, counted from 1.
    pub(super) fn number(&self) -> u32 {
        self.statement_line
    }

    /// Returns the number of line ends passed.
    pub(super) fn passed(&self) -> u32 {
        self.line - 1
    }

    /// Goes to the next statement and returns its first word; none at the end.
    pub(super) fn next_statement(&mut self) -> Result<Option<&'a [u8]>, FormatError> {
        loop {
            while self.token().is_some() {}
            self.skip_comment();
            self.check_length()?;
            if self.offset >= self.bytes.len() {
                return Ok(None);
            }
            self.end_line();
            (self.start, self.statement_line) = (self.offset, self.line);
            if let Some(word) = self.token() {
                return Ok(Some(word));
            }
        }
    }

    /// The first word of the first statement.
    pub(super) fn first_statement(&mut self) -> Result<Option<&'a [u8]>, FormatError> {
        match self.token() {
            Some(word) => Ok(Some(word)),
            None => self.next_statement(),
        }
    }

    /// The next word of the current statement.
    pub(super) fn token(&mut self) -> Option<&'a [u8]> {
        self.skip_spaces();
        let first = self.offset;
        if self.bytes.get(first) == Some(&b'#') || first - self.start > self.limit {
            return None;
        }
        // The first comparison decides nearly all bytes.
        let in_word = |b: u8| b > b' ' && b != b'\\' || !b.is_ascii_whitespace();
        while self.bytes.get(self.offset).is_some_and(|&b| in_word(b)) && !self.continued() {
            self.offset += 1;
        }
        (self.offset > first).then(|| &self.bytes[first..self.offset])
    }

    /// The rest of the current statement as text. A `#` is part of it unless it is alone
    /// between spaces: names like `Object #2` are common.
    pub(super) fn rest(&mut self) -> String {
        let mut text_bytes: Vec<u8> = Vec::new();
        self.skip_spaces();
        while let Some(&b) = self.bytes.get(self.offset) {
            if b == b'\n' || b == b'\r' || self.offset - self.start > self.limit {
                break;
            }
            let begins_comment = b == b'#'
                && self.bytes[self.offset - 1].is_ascii_whitespace()
                && self.bytes.get(self.offset + 1).is_none_or(u8::is_ascii_whitespace);
            if begins_comment {
                self.skip_comment();
                break;
            }
            if self.continued() {
                self.skip_spaces();
                text_bytes.push(b' ');
                continue;
            }
            text_bytes.push(b);
            self.offset += 1;
        }
        text(text_bytes.trim_ascii())
    }

    /// Skips the rest of the current statement.
    pub(super) fn skip(&mut self) {
        let rest = &self.bytes[self.offset..];
        let end = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
        // A line that may be continued is left to `next_statement`.
        if !rest[..end].ends_with(b"\\") {
            self.offset += end;
        }
    }

    fn check_length(&self) -> Result<(), FormatError> {
        if self.offset - self.start > self.limit {
            return Err(FormatError::new(
                Fault::Limit,
                self.location(),
                format!("longer than {}", counted(self.limit, "byte", "bytes")),
            ));
        }
        Ok(())
    }

    /// Returns whether a backslash here joins the next line to this one.
    fn continued(&self) -> bool {
        self.bytes[self.offset] == b'\\'
            && matches!(self.bytes.get(self.offset + 1), Some(b'\n' | b'\r'))
    }

    fn skip_spaces(&mut self) {
        while let Some(&b) = self.bytes.get(self.offset) {
            match b {
                b' ' | b'\t' | b'\x0c' => self.offset += 1,
                b'\\' if self.continued() => {
                    self.offset += 1;
                    self.end_line();
                }
                _ => break,
            }
        }
    }

    fn skip_comment(&mut self) {
        let rest = &self.bytes[self.offset..];
        self.offset += rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
    }

    fn end_line(&mut self) {
        let is_crlf = self.bytes[self.offset..].starts_with(b"\r\n");
        self.offset += if is_crlf { 2 } else { 1 };
        self.line = self.line.saturating_add(1);
    }
}

/// Bytes as text: UTF-8, or else Latin-1, so that different names stay different.
pub(super) fn text(bytes: &[u8]) -> String {
    std::str::from_utf8(bytes)
        .map_or_else(|_| bytes.iter().map(|&b| char::from(b)).collect(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statements(bytes: &[u8]) -> Vec<String> {
        let mut lines = Lines::new(bytes, 1000);
        let mut out = Vec::new();
        let mut word = lines.first_statement().expect("short");
        while let Some(w) = word {
            let mut all = format!("{}:{}", lines.number(), text(w));
            while let Some(t) = lines.token() {
                all = format!("{all} {}", text(t));
            }
            out.push(all);
            word = lines.next_statement().expect("short");
        }
        out
    }

    #[test]
    fn line_ends_comments_and_continuations_are_understood() {
        let expected = ["1:a b", "3:c d e", "5:f"];
        for end in ["\n", "\r\n", "\r"] {
            let source = "a\tb # x\n   # only a comment\n c d \\\n e\nf#".replace('\n', end);
            let mut expected = expected.map(str::to_owned).to_vec();
            expected[2] = "5:f#".to_owned();
            assert_eq!(statements(source.as_bytes()), expected, "{end:?}");
        }
        assert_eq!(statements(b"v\\\n\\\r\n1 \\"), ["1:v 1 \\"]);
        assert!(statements(b"").is_empty() && statements(b"\n\n#").is_empty());
    }

    #[test]
    fn the_rest_of_a_line_keeps_spaces_and_number_signs() {
        let rest = |source: &str| {
            let mut lines = Lines::new(source.as_bytes(), 1000);
            lines.first_statement().expect("short");
            lines.rest()
        };
        assert_eq!(rest("usemtl a  b, c  \r\n"), "a  b, c");
        assert_eq!(rest("g Object #2\n"), "Object #2");
        assert_eq!(rest("g red # not blue\n"), "red");
        assert_eq!(rest("g two \\\n lines"), "two  lines");
        assert_eq!(rest("g"), "");
        assert_eq!(text(b"caf\xe9"), "café");
    }

    #[test]
    fn a_line_that_is_too_long_is_a_limit() {
        let source = [b"f".as_slice(), &b" 1".repeat(600)].concat();
        let mut lines = Lines::new(&source, 1000);
        lines.first_statement().expect("one word");
        while lines.token().is_some() {}
        assert_eq!(lines.next_statement().expect_err("1,201 bytes").fault, Fault::Limit);
    }
}
