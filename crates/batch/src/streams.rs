//! Standard streams of a run, and its dependency file: each holds one thing.

use crate::assets::Asset;
use crate::error::AssetError;
use crate::target::{Target, is_stream, prepare};
use std::path::Path;

/// Checks that standard input is read once, that standard output has one thing to hold, and that
/// the dependency file has a place of its own. `document` says that a report takes standard output.
///
/// # Errors
/// If not, or the dependency file could not be written.
pub fn check_streams(
    assets: &[Asset],
    document: bool,
    depfile: Option<&Path>,
) -> Result<(), AssetError> {
    if assets.iter().filter(|asset| is_stream(&asset.input)).count() > 1 {
        return Err(AssetError::Usage("standard input can be read once only".to_owned()));
    }
    let targets = || assets.iter().filter_map(|asset| asset.target.as_ref().ok());
    let to_stdout = targets().any(|target| *target == Target::Stdout);
    if to_stdout && document {
        return Err(AssetError::Usage(
            "the report and the output do not fit one standard output".to_owned(),
        ));
    }
    let Some(depfile) = depfile else { return Ok(()) };
    if to_stdout || is_stream(depfile) {
        return Err(AssetError::Usage(
            "a dependency file needs files, not standard output".to_owned(),
        ));
    }
    let inputs = assets.iter().map(|asset| asset.input.display().to_string());
    if targets().map(Target::name).chain(inputs).any(|o| o == depfile.display().to_string()) {
        return Err(AssetError::Usage(format!(
            "{}: named both as dependency file and as mesh",
            depfile.display()
        )));
    }
    prepare(&[Target::File(depfile.to_owned())], false)
}
