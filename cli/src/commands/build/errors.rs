//! The stage that measures how far every level is from the input.

use crate::progress::Progress;
use lodc_formats::ObjectInfo;
use lodc_mesh::Simplified;
use rayon::prelude::*;
use std::sync::Arc;

/// Objects on their way from the simplifier to a file.
pub(crate) type SimplifiedObjects = Vec<(ObjectInfo, Arc<Simplified>)>;

/// Puts measured distances in the place of what the simplifier was guided by, several objects at
/// once.
pub(crate) fn measure_all(objects: SimplifiedObjects, progress: &Progress) -> SimplifiedObjects {
    let triangles = |s: &Simplified| s.mesh().triangles().len() as u64;
    if objects.len() > 1 {
        progress.stage_of("errors", objects.iter().map(|(_, s)| triangles(s)).sum());
    } else {
        progress.stage("errors");
    }
    let one = |(info, simplified): (ObjectInfo, Arc<Simplified>)| {
        let distances = lodc_errors::measure(&simplified, simplified.mesh().positions());
        let measured = Arc::unwrap_or_clone(simplified)
            .with_distances(distances.error, distances.rms)
            .expect("the pass has a distance for each step, none below the one before");
        progress.add(triangles(&measured));
        (info, Arc::new(measured))
    };
    objects.into_par_iter().map(one).collect()
}
