//! Options that choose a chain's levels (shares or counts of triangles, errors, pixels at
//! distances, halving) and the LODs that they lead to.

use crate::exit::{Failure, Outcome};
use crate::help::LEVEL;
use crate::jobs::Parts;
use crate::numbers::whole;
use crate::rounding::Asked;
use crate::selector::{ScreenArgs, bound, positive, size};
use clap::Args;
use lodc::level_mesh::{self, LevelMesh};
use lodc::pipeline::LevelDistance;
use lodc::{LodObject, SceneLevels, single};
use lodc_formats::export::{GeomorphFacts, ScreenFacts};
use lodc_mesh::Lod;
use lodc_report::documents::ChainLevel;
use lodc_report::{MissingPart, PartInventory};
use lodc_select::{Selection, Target};
use std::path::Path;

/// The levels, in one of four ways.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = LEVEL)]
pub(super) struct LevelArgs {
    /// Shares (25%) or counts (10k) of triangles, finest first [default: 100%,50%,25%,10%]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = size, group = "which")]
    levels: Vec<Target>,
    /// Errors, finest first, in world units or as E%
    ///
    /// A percentage is of the diagonal.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = bound, group = "which")]
    errors: Vec<Target>,
    /// At most P pixels of error from each of --distances
    #[arg(long, value_name = "P", value_parser = positive, group = "which", requires = "distances")]
    pixels: Option<f64>,
    /// Distances of the eye for --pixels, nearest first
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = positive,
          requires = "pixels")]
    distances: Vec<f64>,
    /// N levels, each with half as many triangles
    ///
    /// As the one before. From 1 to 32; ends early where --max-error allows no coarser one.
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=32),
          group = "which")]
    auto: Option<u32>,
    #[command(flatten)]
    screen: ScreenArgs,
}

/// One level of a chain.
#[derive(Clone)]
pub(super) struct ChosenLevel {
    /// One LOD per object.
    pub(super) lods: Vec<Lod>,
    pub(super) triangles: u64,
    /// Vertices that the level needs, once its files are made.
    pub(super) vertices: u64,
    /// The largest of all objects, in world units, as `rms`.
    pub(super) error: f64,
    pub(super) rms: Option<f64>,
    /// The distances of each object by itself, in its mesh units, before rounding.
    pub(super) distances: Vec<LevelDistance>,
    /// What is asked of them.
    pub(super) asked: Vec<Asked>,
    /// The meshes of the objects, until they are written; none of levels that are not refitted.
    pub(super) refitted: Option<Vec<LevelMesh>>,
    /// Distance from the eye that the level was chosen for, in world units; none without --pixels.
    pub(super) distance: Option<f64>,
    /// Where it moves to the next level, if it does.
    pub(super) geomorph: Option<GeomorphFacts>,
    /// Parts that it no longer shows.
    pub(super) gone: Vec<MissingPart>,
}

impl ChosenLevel {
    /// Returns the LOD; none if several objects each have their own.
    pub(super) fn lod(&self) -> Option<u32> {
        single(&self.lods).map(|lod| lod.0)
    }
    pub(super) fn report(&self, level: usize, output: &Path) -> ChainLevel {
        ChainLevel {
            level,
            lod: self.lod(),
            triangles: self.triangles,
            vertices: self.vertices,
            error: self.error.is_finite().then_some(self.error),
            rms: self.rms.filter(|rms| rms.is_finite()),
            distance: self.distance,
            morph_from: self.geomorph.and_then(|geomorph| geomorph.morph_from),
            geomorph_pose_error: self.geomorph.and_then(|geomorph| geomorph.pose_error),
            geomorph_staying: self.geomorph.map(|geomorph| geomorph.staying),
            gone: self.gone.clone(),
            output: output.display().to_string(),
        }
    }
}

impl LevelArgs {
    /// Chooses the levels, finest first, none beyond `cap`. Objects with levels of their own in
    /// `parts` have these.
    ///
    /// # Errors
    /// If a level has more triangles than the one before it, or a level cannot be chosen.
    pub(super) fn choose(
        &self,
        objects: &[LodObject],
        scene: &SceneLevels<'_>,
        parts: Parts<'_>,
        cap: Option<Target>,
    ) -> Outcome<Vec<Chosen>> {
        let mut levels: Vec<Chosen> = Vec::new();
        for (index, (target, distance)) in self.targets().into_iter().enumerate() {
            let own = |object: &str| parts.chain_level(object, index);
            let per_object = false;
            let chosen = scene.select_capped(target, own, cap, per_object)?;
            let Selection { lods, warnings, .. } = chosen;
            let triangles = triangles(objects, &lods);
            let asked = self.asked(target, cap);
            let level = Chosen { lods, triangles, distance, asked, warnings };
            let before = levels.last().map(|l| (l.triangles, &l.lods));
            if before.is_some_and(|(triangles, _)| triangles < level.triangles) {
                return Err(Failure::usage(format!(
                    "level {} has more triangles than the one before it: name the finest first",
                    levels.len()
                )));
            }
            if self.auto.is_some() && before.is_some_and(|(_, lods)| *lods == level.lods) {
                break;
            }
            levels.push(level);
        }
        Ok(levels)
    }

    /// The targets, finest first.
    pub(super) fn wanted(&self) -> Vec<Target> {
        self.targets().into_iter().map(|(target, _)| target).collect()
    }

    /// The largest distances from the input that are asked of all levels.
    pub(super) fn all_asked(&self, cap: Option<Target>) -> Vec<Asked> {
        self.wanted().into_iter().flat_map(|target| self.asked(target, cap)).collect()
    }

    /// The largest distances from the input that are asked of a level.
    fn asked(&self, target: Target, cap: Option<Target>) -> Vec<Asked> {
        let by_error = !self.errors.is_empty() || self.pixels.is_some();
        let option = if self.pixels.is_some() { "--pixels" } else { "--errors" };
        let asked = |option, target| Asked { option, target, per_object: false };
        let own = by_error.then(|| asked(option, target));
        own.into_iter().chain(cap.map(|cap| asked("--max-error", cap))).collect()
    }

    /// The distance of the eye from which a level with this error suits; none if it is infinite.
    pub(super) fn distance(&self, error: f64) -> Option<f64> {
        let distance = error / self.screen.slope(self.pixels.unwrap_or(1.0));
        distance.is_finite().then_some(distance)
    }

    /// The screen that distances are for.
    pub(super) fn screen(&self) -> ScreenFacts {
        let (height, fovy) = self.screen.size();
        ScreenFacts { pixels: self.pixels.unwrap_or(1.0), height, fovy }
    }

    /// The share of the screen's height, squared, that a length takes up at a distance.
    pub(super) fn coverage(&self, length: f64, distance: f64) -> f64 {
        let height = distance * self.screen.slope(1.0) * self.screen.size().0;
        if height > 0.0 { (length / height).powi(2).min(1.0) } else { 1.0 }
    }

    /// What each level is chosen by, finest first, and the eye's distance that it is for, if any.
    fn targets(&self) -> Vec<(Target, Option<f64>)> {
        let plain = |targets: &[Target]| targets.iter().map(|&t| (t, None)).collect();
        if let Some(pixels) = self.pixels {
            let for_distance = |&d: &f64| (self.screen.error(pixels, d), Some(d));
            return self.distances.iter().map(for_distance).collect();
        }
        if let Some(n) = self.auto {
            return (0..n).map(|k| (Target::Ratio(0.5f64.powi(k as i32)), None)).collect();
        }
        match (&self.levels[..], &self.errors[..]) {
            ([], []) => plain(&[1.0, 0.5, 0.25, 0.1].map(Target::Ratio)),
            ([], errors) => plain(errors),
            (levels, _) => plain(levels),
        }
    }
}

/// A level as it was chosen, not measured yet; [`described`] makes a [`ChosenLevel`] of it.
pub(super) struct Chosen {
    /// One LOD per object.
    pub(super) lods: Vec<Lod>,
    triangles: u64,
    /// Distance of the eye that it was chosen for.
    distance: Option<f64>,
    /// The largest distances that were asked for.
    pub(super) asked: Vec<Asked>,
    /// Targets that were not met.
    warnings: Vec<String>,
}

/// Keeps objects that no node shows at the finest level, since no engine reaches another one.
pub(super) fn keep_whole(levels: &mut [Chosen], objects: &[LodObject], is_shown: &[bool]) {
    let Some((finest, coarser)) = levels.split_first_mut() else { return };
    for level in coarser {
        for ((lod, &finest), &is_shown) in level.lods.iter_mut().zip(&finest.lods).zip(is_shown) {
            if !is_shown {
                *lod = finest;
            }
        }
        level.triangles = triangles(objects, &level.lods);
    }
}

/// How far each object of a level is from the input; with its meshes where levels are refitted.
pub(super) enum Measured {
    Plain(Vec<LevelDistance>),
    Refitted(Vec<LevelMesh>),
}

/// Adds to levels how far they are from the input and what they no longer show. Returns also the
/// warnings, level by level: targets that were not met, then parts that are gone.
pub(super) fn described(
    objects: &[LodObject],
    chosen: Vec<Chosen>,
    measured: Vec<Measured>,
    inventory: &PartInventory<'_>,
) -> (Vec<ChosenLevel>, Vec<String>) {
    let (mut levels, mut warnings): (Vec<ChosenLevel>, Vec<String>) = Default::default();
    for (number, (chosen, measured)) in chosen.into_iter().zip(measured).enumerate() {
        let Chosen { lods, triangles, distance, asked, warnings: unmet } = chosen;
        let (distances, refitted) = match measured {
            Measured::Plain(distances) => (distances, None),
            Measured::Refitted(meshes) => {
                let distance = |m: &LevelMesh| LevelDistance { error: m.error, rms: m.rms };
                (meshes.iter().map(distance).collect(), Some(meshes))
            }
        };
        let lost_parts = inventory.gone_at(&lods, distances.iter().map(|d| d.error));
        warnings.extend(unmet);
        warnings.dedup();
        warnings.extend(lost_parts.iter().map(|part| format!("level {number}: {part}")));
        let (error, rms) =
            level_mesh::largest_distance(objects, distances.iter().map(|d| (d.error, d.rms)));
        levels.push(ChosenLevel {
            lods,
            triangles,
            vertices: 0,
            error,
            rms,
            distances,
            asked,
            refitted,
            distance,
            geomorph: None,
            gone: lost_parts,
        });
    }
    (levels, warnings)
}

/// Returns the number of triangles of all objects, each at its LOD.
fn triangles(objects: &[LodObject], lods: &[Lod]) -> u64 {
    let mut sum = 0;
    for (object, &lod) in objects.iter().zip(lods) {
        sum += u64::from(object.simplified.collapses().triangles_at(lod));
    }
    sum
}
