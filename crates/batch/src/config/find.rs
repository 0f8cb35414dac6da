//! The nearest configuration above an input.

use std::path::{Path, PathBuf};

/// Returns the nearest file of this name beside or above an input, but not above `folder`; without
/// one, not above the current folder. None if there is none, or if the input is a stream.
pub(super) fn nearest(name: &str, input: &Path, folder: Option<&Path>) -> Option<PathBuf> {
    if crate::target::is_stream(input) {
        return None;
    }
    let parent = match input.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let parent = parent.canonicalize().ok()?;
    let top = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
    let inside = parent.starts_with(&top);
    // An input outside of the current folder: what is beside it, and nothing above.
    let ancestors =
        parent.ancestors().take_while(|a| inside && a.starts_with(&top) || *a == parent);
    let found = ancestors.map(|a| a.join(name)).find(|file| file.is_file())?;
    Some(shortened(found))
}

/// The path below the current folder, if it is there: for messages.
fn shortened(path: PathBuf) -> PathBuf {
    let here = std::env::current_dir().and_then(|here| here.canonicalize());
    match here.as_deref().map(|here| path.strip_prefix(here)) {
        Ok(Ok(short)) => short.to_owned(),
        _ => path,
    }
}
