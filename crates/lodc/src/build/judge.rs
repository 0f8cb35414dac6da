//! Pictures of a scene's levels, to tell which of two simplifications looks better.

use super::{SceneContext, SimplifiedObjects};
use crate::level_mesh;
use crate::{Error, LodObject, scene_levels};
use lodc_formats::{ObjectInfo, SceneObject, scene_graph};
use lodc_measure::{Portrait, SceneSurface, ShadingOptions, Viewing};
use lodc_mesh::Mesh;
use lodc_scene::{Appearance, Arrangement};
use lodc_select::Target;
use std::sync::Arc;

/// Levels that are looked at, as shares of the scene's triangles.
const LEVELS: [f64; 6] = [0.5, 0.25, 0.1, 0.05, 0.02, 0.01];
/// The image error at each of them.
pub(super) type Errors = [f64; LEVELS.len()];
/// An image error up to this many times another's is no worse.
const NO_WORSE: f64 = 1.01;
/// The pictures: fewer and smaller than those of `compare`, and from other sides.
const VIEWING: Viewing = Viewing { views: 17, size: 256 };
/// Scenes with more triangles than this, instances counted, are not looked at.
const MAX_TRIANGLES: usize = 1 << 23;

/// The levels at which a metric decides, so that nothing looks worse than by the quadric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    Everywhere,
    Nowhere,
    /// Between these shares of the triangles.
    Between([f32; 2]),
}

/// Compares the image errors of a metric with those of the quadric at [`LEVELS`]: the metric
/// decides around the levels that follow each other, look no worse, and gain most together.
pub(super) fn verdict(quadric: &Errors, other: &Errors) -> Verdict {
    let is_good = |i: usize| other[i] <= NO_WORSE * quadric[i];
    if (0..LEVELS.len()).all(is_good) {
        return Verdict::Everywhere;
    }
    let mut best: Option<(f64, [usize; 2])> = None;
    for first in (0..LEVELS.len()).filter(|&i| is_good(i)) {
        let mut product = 1.0;
        for last in (first..LEVELS.len()).take_while(|&i| is_good(i)) {
            product *= if quadric[last] > 0.0 { other[last] / quadric[last] } else { 1.0 };
            if best.is_none_or(|b| product < b.0) {
                best = Some((product, [first, last]));
            }
        }
    }
    let Some((_, [first, last])) = best.filter(|b| b.0 < 1.0) else { return Verdict::Nowhere };
    let between = |i: usize| (LEVELS[i] * LEVELS[i + 1]).sqrt() as f32;
    let most = if first == 0 { 1.0 } else { between(first - 1) };
    let least = if last + 1 == LEVELS.len() { 0.0 } else { between(last) };
    Verdict::Between([least, most])
}

/// A scene, and what it looks like.
pub(super) struct Judge<'a> {
    known: SceneContext<'a>,
    scene: Arrangement,
    portrait: Portrait,
}

impl<'a> Judge<'a> {
    /// Takes pictures of a scene; none if it is too large or shows nothing.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub(super) fn new(
        objects: &[SceneObject],
        known: SceneContext<'a>,
    ) -> Result<Option<Self>, Error> {
        let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
        let graph = scene_graph(known.document, &infos, &known.limits)?;
        let scene = Arrangement::new(&graph, &graph.rest_pose(), objects.len());
        let count = |object: usize| objects[object].mesh.triangles().len();
        let counts = scene.placements().iter().map(|p| count(p.object));
        let triangles = counts.fold(0, usize::saturating_add);
        if triangles == 0 || triangles > MAX_TRIANGLES {
            return Ok(None);
        }
        let meshes: Vec<&Mesh> = objects.iter().map(|o| &o.mesh).collect();
        let shown = surface(&meshes, &scene, known);
        // Shapes alone where the metric sees no more.
        let looks = known.paints.map_or(ShadingOptions::default(), |_| shown.common_looks(&shown));
        let portrait = Portrait::new(&shown.surface, VIEWING, looks);
        Ok(Some(Self { known, scene, portrait }))
    }

    /// The image errors at [`LEVELS`].
    ///
    /// # Errors
    /// If a level is no mesh: a bug.
    pub(super) fn errors(&self, objects: &SimplifiedObjects) -> Result<Errors, Error> {
        let object = |(info, simplified): &(ObjectInfo, _)| LodObject {
            info: info.clone(),
            simplified: Arc::clone(simplified),
            models: Vec::new(),
        };
        let objects: Vec<LodObject> = objects.iter().map(object).collect();
        let levels = scene_levels(&objects, self.known.document, &self.known.limits)?;
        let mut errors = Errors::default();
        for (share, error) in LEVELS.into_iter().zip(&mut errors) {
            let lods = levels.select(Target::Ratio(share), false)?.lods;
            let meshes = level_mesh::plain(&objects, &lods)?;
            let shown = surface(&meshes.iter().collect::<Vec<_>>(), &self.scene, self.known);
            *error = self.portrait.compare(&shown.surface).rmse;
        }
        Ok(errors)
    }
}

/// A scene as it is shown.
fn surface(meshes: &[&Mesh], scene: &Arrangement, known: SceneContext<'_>) -> SceneSurface {
    match known.paints {
        None => SceneSurface::new(meshes, scene, &Appearance::default()),
        Some(paints) => {
            SceneSurface::with_images(meshes, scene, paints.looks(), || paints.images())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Errors, Verdict, verdict};

    #[test]
    fn the_metric_decides_where_it_looks_no_worse() {
        let against = |ratios: Errors| verdict(&[2.0; 6], &ratios.map(|r| 2.0 * r));
        assert_eq!(against([1.0, 0.9, 0.8, 1.01, 0.9, 1.0]), Verdict::Everywhere);
        assert_eq!(against([1.2, 1.1, 1.3, 1.04, 1.1, 1.2]), Verdict::Nowhere);
        assert_eq!(against([1.2, 1.01, 1.3, 1.04, 1.1, 1.2]), Verdict::Nowhere);
        let Verdict::Between([least, most]) = against([1.1, 1.2, 0.9, 0.8, 0.9, 0.95]) else {
            panic!("it is better at coarse levels")
        };
        assert!(least == 0.0 && most > 0.1 && most < 0.25, "{least} {most}");
        let Verdict::Between([least, most]) = against([0.9, 0.7, 1.4, 0.8, 0.9, 1.0]) else {
            panic!("it is better at fine levels")
        };
        assert!(most == 1.0 && least > 0.1 && least < 0.25, "{least} {most}");
        let Verdict::Between([least, most]) = against([0.9, 0.7, 0.8, 0.8, 0.9, 1.2]) else {
            panic!("it is worse at the coarsest level alone")
        };
        assert!(most == 1.0 && least > 0.01 && least < 0.02, "{least} {most}");
        assert_eq!(verdict(&[0.0; 6], &[0.0; 6]), Verdict::Everywhere);
    }
}
