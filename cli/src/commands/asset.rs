//! An asset with its levels: read from a `.lodc` file, or simplified in memory from a mesh.

use crate::commands::build::{measure_all, simplify_all};
use crate::exit::{Failure, Outcome};
use crate::limits::ImportArgs;
use crate::progress::Progress;
use crate::stages::Stages;
use lodc_formats::import::{Either, either};
use lodc_formats::lodc::LodObject;
use lodc_formats::{Document, Scene};
use lodc_simplify::{MetricKind, Options};
use std::path::{Path, PathBuf};

/// An asset whose levels can be taken out.
pub(crate) struct Asset {
    pub(crate) objects: Vec<LodObject>,
    pub(crate) document: Document,
    /// Every file that was read, for dependency files.
    pub(crate) files_read: Vec<PathBuf>,
    /// Messages about what was repaired, dropped or left out while reading.
    pub(crate) warnings: Vec<String>,
}

/// Reads an input; a mesh is simplified by `metric`.
///
/// # Errors
/// If the input cannot be read, or simplifying it would take more memory than there is.
pub(crate) fn read(
    input: &Path,
    import: &ImportArgs,
    metric: MetricKind,
    stages: &mut Stages,
) -> Outcome<Asset> {
    match stages.run("read", || either(input, &import.options()))? {
        Either::Levels(file) => Ok(Asset {
            objects: file.objects,
            document: file.document,
            files_read: vec![input.to_owned()],
            warnings: file.left_out,
        }),
        Either::Scene(scene) => simplified(input, import, metric, scene, stages),
    }
}

/// Simplifies the objects of a scene and measures every level.
///
/// # Errors
/// If that would take more memory than there is.
pub(crate) fn simplified(
    input: &Path,
    import: &ImportArgs,
    metric: MetricKind,
    scene: Scene,
    stages: &mut Stages,
) -> Outcome<Asset> {
    let Scene { document, objects, warnings, files_read, .. } = scene;
    let triangles = objects.iter().map(|o| o.mesh.triangles().len() as u64).sum();
    let name = input.display().to_string();
    import
        .limits()
        .check_memory(triangles)
        .map_err(|f| Failure::new(f.status, format!("{name}: {f}")))?;
    let limits = import.options().limits;
    let progress = Progress::new(&name);
    let options = Options { metric, ..Options::DEFAULT };
    let simplified =
        stages.run("simplify", || simplify_all(objects, &options, None, triangles, &progress));
    let measured =
        stages.run("errors", || measure_all(simplified, &document, &limits, &progress))?;
    let object = |(info, simplified)| LodObject { info, simplified, models: Vec::new() };
    let objects = measured.into_iter().map(object).collect();
    Ok(Asset { objects, document, files_read, warnings })
}
