//! The nearest configuration above an input.

use std::path::{Path, PathBuf};

/// Returns the nearest file of this name beside or above an input, but not above `folder`; without
/// one, not above the current folder. None if there is none, or if the input is standard input.
pub(super) fn nearest(name: &str, input: &Path, folder: Option<&Path>) -> Option<PathBuf> {
    if crate::jobs::target::is_standard_stream(input) {
        return None;
    }
    let folder_of_input = match input.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let bottom = folder_of_input.canonicalize().ok()?;
    let top = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
    let is_below_top = bottom.starts_with(&top);
    // For an input outside of `top` only its own folder is searched.
    let ancestors =
        bottom.ancestors().take_while(|a| is_below_top && a.starts_with(&top) || *a == bottom);
    let found = ancestors.map(|a| a.join(name)).find(|file| file.is_file())?;
    Some(shortened(found))
}

/// The path relative to the current folder if it is below that, for shorter messages.
fn shortened(path: PathBuf) -> PathBuf {
    let current = std::env::current_dir().and_then(|folder| folder.canonicalize());
    match current.as_deref().map(|folder| path.strip_prefix(folder)) {
        Ok(Ok(short)) => short.to_owned(),
        _ => path,
    }
}
