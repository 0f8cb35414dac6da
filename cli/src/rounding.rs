//! Levels that are chosen by a distance and quantised: what quantising adds counts, too.

use crate::exit::Outcome;
use lodc::level_mesh::LevelMesh;
use lodc::{Asset, Rounding, SceneLevels};
use lodc_formats::export::{ExportFormat, Precision};
use lodc_mesh::Mesh;
use lodc_report::text::distance;
use lodc_select::{Target, rounded_error, rounded_rms};

/// A largest distance that was asked for, and by which option.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    pub(crate) option: &'static str,
    pub(crate) target: Target,
    /// Whether it is in the units of each object, not the world's.
    pub(crate) per_object: bool,
}

/// Error and root mean square distance of each object, in its mesh units.
type Distances = [(f64, Option<f64>)];

/// How far quantising moves the vertices of each object at most, in mesh units: levels that are
/// chosen by a distance leave room for that.
#[derive(Debug)]
pub(crate) struct Room<'a> {
    asset: &'a Asset,
    stored: ExportFormat,
    precision: Precision,
    by_object: Vec<f64>,
}

impl<'a> Room<'a> {
    /// The room that the finest levels need; none if nothing is chosen by a distance. Coarser ones
    /// need no more unless refitting makes them larger: grids are laid over their boxes.
    pub(crate) fn new(
        asset: &'a Asset,
        stored: ExportFormat,
        precision: Precision,
        asked: &[Asked],
    ) -> Outcome<Self> {
        let by_object = vec![0.0; asset.objects.len()];
        let mut room = Self { asset, stored, precision, by_object };
        let rounds = precision.position.is_some() || precision.weight.is_some();
        if rounds && !asked.is_empty() {
            room.by_object = room.needed(asset.objects.iter().map(|o| o.simplified.mesh()))?;
        }
        Ok(room)
    }

    fn needed<'m>(&self, meshes: impl Iterator<Item = &'m Mesh>) -> Outcome<Vec<f64>>
    where
        'a: 'm,
    {
        let Self { asset, stored, precision, .. } = *self;
        let rounding = Rounding::new(&asset.objects, &asset.document, meshes, stored, precision)?;
        Ok(rounding.quantising())
    }

    /// Lets levels be chosen with this room.
    pub(crate) fn leave(&self, scene: &mut SceneLevels<'_>) {
        scene.set_rounding(&self.by_object);
    }

    /// Makes more room where levels need more than was left, and are beyond what was asked. Returns
    /// whether it did: then they are to be chosen again.
    pub(crate) fn make_more(
        &mut self,
        scene: &SceneLevels<'_>,
        asked: &[Asked],
        levels: &[LevelMesh],
    ) -> Outcome<bool> {
        if self.by_object.iter().all(|&room| room == 0.0) {
            return Ok(false);
        }
        let needed = self.needed(levels.iter().map(|level| &level.mesh))?;
        let before = distances(levels);
        let rounded = |(&(error, rms), &moved): (&(f64, Option<f64>), &f64)| {
            (rounded_error(error, moved), rms.map(|rms| rounded_rms(rms, moved)))
        };
        let written: Vec<_> = before.iter().zip(&needed).map(rounded).collect();
        let mut has_grown = false;
        for object in asked.iter().flat_map(|asked| beyond(scene, asked, &before, &written)) {
            if needed[object] > self.by_object[object] {
                self.by_object[object] = needed[object];
                has_grown = true;
            }
        }
        Ok(has_grown)
    }

    /// A line for each distance that was asked and that quantising does not keep, given those
    /// `before` and those that are `written`.
    pub(crate) fn unmet(
        &self,
        scene: &SceneLevels<'_>,
        asked: &[Asked],
        before: &Distances,
        written: &Distances,
    ) -> Vec<String> {
        let line = |asked: &Asked| {
            let unit = |o: usize| if asked.per_object { 1.0 } else { scene.objects()[o].scale };
            let added = beyond(scene, asked, before, written).map(|o| unit(o) * self.by_object[o]);
            let most = added.reduce(f64::max)?;
            let option = asked.option;
            Some(format!("{option} is not kept: --quantize adds up to {}", distance(most)))
        };
        asked.iter().filter_map(line).collect()
    }
}

/// The distances of levels before rounding.
pub(crate) fn distances(levels: &[LevelMesh]) -> Vec<(f64, Option<f64>)> {
    levels.iter().map(|level| (level.error, level.rms)).collect()
}

/// The objects that are written farther away than was asked, but were not before: others have
/// levels of their own.
fn beyond(
    scene: &SceneLevels<'_>,
    &Asked { target, per_object, .. }: &Asked,
    before: &Distances,
    written: &Distances,
) -> impl Iterator<Item = usize> {
    let before = scene.beyond(target, per_object, before);
    let written = scene.beyond(target, per_object, written);
    written.into_iter().filter(move |object| !before.contains(object))
}
