//! The stage that measures how far every level is from the input.

use crate::exit::Outcome;
use crate::progress::Progress;
use lodc_formats::{Document, Limits, ObjectInfo, scene_graph};
use lodc_mesh::Simplified;
use lodc_scene::{Arrangement, shape_in_scene};
use rayon::prelude::*;
use std::sync::Arc;

/// Objects on their way from the simplifier to a file.
pub(crate) type SimplifiedObjects = Vec<(ObjectInfo, Arc<Simplified>)>;

/// Puts measured distances in the place of what the simplifier was guided by, several objects at
/// once. Distances are those of the shape that the document's default scene gives an object.
///
/// # Errors
/// If the stored document is damaged.
pub(crate) fn measure_all(
    objects: SimplifiedObjects,
    document: &Document,
    limits: &Limits,
    progress: &Progress,
) -> Outcome<SimplifiedObjects> {
    let triangles = |s: &Simplified| s.mesh().triangles().len() as u64;
    if objects.len() > 1 {
        progress.stage_of("errors", objects.iter().map(|(_, s)| triangles(s)).sum());
    } else {
        progress.stage("errors");
    }
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
        progress.add(triangles(&measured));
        (info, Arc::new(measured))
    };
    Ok(objects.into_par_iter().enumerate().map(one).collect())
}
