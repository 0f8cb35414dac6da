//! Files that list assets (`--manifest`): a JSON document in each line.

use crate::jobs::error::JobError;
use crate::jobs::options::OptionValues;
use crate::jobs::target::is_standard_stream;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// One line of a list.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Line {
    pub(crate) input: PathBuf,
    /// The file that `compare` compares `input` with.
    #[serde(rename = "a")]
    pub(crate) compared_with: Option<PathBuf>,
    pub(crate) output: Option<PathBuf>,
    #[serde(default)]
    options: serde_json::Map<String, serde_json::Value>,
}

impl Line {
    /// Its options by long name.
    ///
    /// # Errors
    /// If a value is neither text, number, true, false nor a list of texts and numbers.
    pub(crate) fn options(&self) -> Result<OptionValues, String> {
        OptionValues::from_json(&self.options)
    }
}

/// The error that says what is wrong with a line of a list.
pub(crate) fn line_error(list: &Path, number: usize, what: &str) -> JobError {
    JobError::Input(format!("{}: line {number}: {what}", list.display()))
}

/// Reads a list, `-` from standard input; blank lines are skipped. Returns the lines with
/// their numbers, from 1.
///
/// # Errors
/// If the list cannot be read, or a line is no valid document.
pub(crate) fn read(path: &Path) -> Result<Vec<(usize, Line)>, JobError> {
    let failure = |what: String| JobError::Input(format!("{}: {what}", path.display()));
    let text = if is_standard_stream(path) {
        std::io::read_to_string(std::io::stdin())
    } else {
        std::fs::read_to_string(path)
    };
    let text = text.map_err(|e| failure(e.to_string()))?;
    let mut lines = Vec::new();
    for (number, line) in (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty()) {
        lines.push((number, json_object(line, number).map_err(failure)?));
    }
    Ok(lines)
}

/// Reads the JSON object in a line.
///
/// # Errors
/// In words, with the line's number, if it is none or has wrong values.
pub(crate) fn json_object<T: DeserializeOwned>(line: &str, number: usize) -> Result<T, String> {
    if !line.trim_start().starts_with('{') {
        return Err(format!("line {number}: not a JSON object"));
    }
    serde_json::from_str(line).map_err(|e| {
        // The parser's own line number counts within this line: it is always 1.
        let what = e.to_string();
        let what = what.split(" at line ").next().unwrap_or_default();
        format!("line {number}, column {}: {what}", e.column())
    })
}
