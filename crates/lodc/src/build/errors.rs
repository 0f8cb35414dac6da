//! The stage that measures how far every level is from the input.

use super::watch::staged;
use super::{SimplifiedObjects, Watch};
use lodc_formats::{Document, FormatError, Limits, ObjectInfo, scene_graph};
use lodc_mesh::Simplified;
use lodc_scene::{Arrangement, shape_in_scene};
use rayon::prelude::*;
use std::sync::Arc;

/// Puts measured distances in the place of what the simplifier was guided by, several objects at
/// once. Distances are those of the shape that the document's default scene gives an object.
///
/// # Errors
/// If the stored document is damaged.
pub fn measure_all(
    objects: SimplifiedObjects,
    document: &Document,
    limits: &Limits,
    watch: &dyn Watch,
) -> Result<SimplifiedObjects, FormatError> {
    let triangles = |s: &Simplified| s.mesh().triangles().len() as u64;
    let counted = objects.len() > 1;
    let units = counted.then(|| objects.iter().map(|(_, s)| triangles(s)).sum());
    let infos: Vec<&ObjectInfo> = objects.iter().map(|(info, _)| info).collect();
    let graph = scene_graph(document, &infos, limits)?;
    let scene = Arrangement::new(&graph, &graph.rest_pose(), objects.len());
    let one = |(number, (info, simplified)): (usize, (ObjectInfo, Arc<Simplified>))| {
        let shape = shape_in_scene(simplified.mesh(), number, &scene);
        let distances = lodc_errors::measure(&simplified, &shape);
        drop(shape);
        let measured = Arc::unwrap_or_clone(simplified)
            .with_distances(distances.error, distances.rms)
            .expect("the pass has a distance for each step, none below the one before");
        watch.add(triangles(&measured));
        (info, Arc::new(measured))
    };
    Ok(staged(watch, "errors", units, || objects.into_par_iter().enumerate().map(one).collect()))
}
