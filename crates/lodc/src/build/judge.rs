//! Pictures of a scene's levels, to tell which of two simplifications looks better.

use super::{SceneContext, SimplifiedObjects};
use crate::level_mesh;
use crate::{Error, LodObject, scene_levels};
use lodc_formats::{ObjectInfo, SceneObject, scene_graph};
use lodc_measure::{Portrait, SceneSurface, ShadingOptions, Viewing};
use lodc_mesh::Mesh;
use lodc_scene::{Appearance, Arrangement};
use lodc_select::Target;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Levels that are looked at, as shares of the scene's triangles.
const LEVELS: [f64; 6] = [0.5, 0.25, 0.1, 0.05, 0.02, 0.01];
/// The image error at each of them.
pub(super) type Errors = [f64; LEVELS.len()];
/// An image error up to this many times another's is no worse.
const NO_WORSE: f64 = 1.01;
/// Levels of fewer triangles are no picture of anything, and are not compared.
const FEWEST: f64 = 16.0;
/// The pictures: fewer and smaller than those of `compare`, and from other sides.
const VIEWING: Viewing = Viewing { views: 17, size: 256 };
/// Scenes with more triangles than this, instances counted, are not looked at.
const MAX_TRIANGLES: usize = 1 << 23;

/// The levels at which a metric decides, so that nothing looks worse than by the quadric.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    Everywhere,
    Nowhere,
    /// At these of [`LEVELS`], which follow each other.
    At(RangeInclusive<usize>),
}

/// Picks the levels at which a metric may replace the quadric, by the image errors of both at
/// [`LEVELS`]: the run of levels, none of which looks worse, with the smallest product of error
/// ratios. The run lies within `decided`, the levels at which the metric was used when `other` was
/// measured; if it would be all of them one is left out, so that tries come to an end.
pub(super) fn verdict(
    quadric: &Errors,
    other: &Errors,
    decided: &RangeInclusive<usize>,
) -> Verdict {
    let is_good = |i: usize| other[i] <= NO_WORSE * quadric[i];
    let Some(bad) = (0..LEVELS.len()).find(|&i| !is_good(i)) else { return Verdict::Everywhere };
    let mut best: Option<(f64, RangeInclusive<usize>)> = None;
    for first in decided.clone().filter(|&i| is_good(i)) {
        let mut product = 1.0;
        for last in (first..=*decided.end()).take_while(|&i| is_good(i)) {
            product *= if quadric[last] > 0.0 { other[last] / quadric[last] } else { 1.0 };
            if best.as_ref().is_none_or(|b| product < b.0) {
                best = Some((product, first..=last));
            }
        }
    }
    let Some((_, levels)) = best.filter(|b| b.0 < 1.0) else { return Verdict::Nowhere };
    if levels != *decided {
        return Verdict::At(levels);
    }
    // Every level of the run is good, but one beside it, at which the quadric was used, is worse:
    // the quadric does not mend what the metric did before. The end of the run next to it goes.
    let (first, last) = levels.into_inner();
    match first < last {
        true if bad < first => Verdict::At(first + 1..=last),
        true => Verdict::At(first..=last - 1),
        false => Verdict::Nowhere,
    }
}

/// All levels that are looked at.
pub(super) const ALL: RangeInclusive<usize> = 0..=LEVELS.len() - 1;

/// The shares of the triangles around some of [`LEVELS`], the smaller first.
pub(super) fn shares(levels: &RangeInclusive<usize>) -> [f32; 2] {
    let (first, last) = (*levels.start(), *levels.end());
    let between = |i: usize| (LEVELS[i] * LEVELS[i + 1]).sqrt() as f32;
    let most = if first == 0 { 1.0 } else { between(first - 1) };
    let least = if last + 1 == LEVELS.len() { 0.0 } else { between(last) };
    [least, most]
}

/// A scene, and reference pictures of it.
pub(super) struct Judge<'a> {
    known: SceneContext<'a>,
    scene: Arrangement,
    portrait: Portrait,
    /// Those of the scene, instances counted.
    triangles: usize,
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
        Ok(Some(Self { known, scene, portrait, triangles }))
    }

    /// The image errors at [`LEVELS`]; 0 at those of fewer than [`FEWEST`] triangles.
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
            if (self.triangles as f64 * share) < FEWEST {
                continue;
            }
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
    use super::{ALL, Errors, Verdict, shares, verdict};

    #[test]
    fn the_metric_decides_where_it_looks_no_worse() {
        let against = |ratios: Errors| verdict(&[2.0; 6], &ratios.map(|r| 2.0 * r), &ALL);
        assert_eq!(against([1.0, 0.9, 0.8, 1.01, 0.9, 1.0]), Verdict::Everywhere);
        assert_eq!(against([1.2, 1.1, 1.3, 1.04, 1.1, 1.2]), Verdict::Nowhere);
        assert_eq!(against([1.2, 1.01, 1.3, 1.04, 1.1, 1.2]), Verdict::Nowhere);
        assert_eq!(against([1.1, 1.2, 0.9, 0.8, 0.9, 0.95]), Verdict::At(2..=5));
        assert_eq!(against([0.9, 0.7, 1.4, 0.8, 0.9, 1.0]), Verdict::At(0..=1));
        assert_eq!(against([0.9, 0.7, 0.8, 0.8, 0.9, 1.2]), Verdict::At(0..=4));
        assert_eq!(verdict(&[0.0; 6], &[0.0; 6], &ALL), Verdict::Everywhere);
    }

    #[test]
    fn it_gives_way_a_level_earlier_where_the_quadric_cannot_mend_what_came_before() {
        let against =
            |ratios: Errors, decided| verdict(&[2.0; 6], &ratios.map(|r| 2.0 * r), &decided);
        let worse_at_the_end = [0.9, 0.7, 0.8, 0.8, 0.9, 1.2];
        assert_eq!(against(worse_at_the_end, 0..=4), Verdict::At(0..=3));
        assert_eq!(against([1.02, 0.99, 0.8, 0.8, 0.9, 0.95], 1..=5), Verdict::At(2..=5));
        assert_eq!(against([0.9, 1.02, 1.0, 1.0, 1.0, 1.0], 0..=0), Verdict::Nowhere);
        // Levels at which the quadric decided are none to begin with.
        assert_eq!(against([0.9, 0.9, 0.9, 1.3, 0.5, 0.5], 0..=3), Verdict::At(0..=2));
    }

    #[test]
    fn shares_lie_between_the_levels() {
        assert_eq!(shares(&ALL), [0.0, 1.0]);
        let [least, most] = shares(&(2..=4));
        assert!(0.01 < least && least < 0.02 && 0.1 < most && most < 0.25, "{least} {most}");
    }
}
