//! `chain --geomorph`: which attributes get morph targets that move a level's vertices to the next
//! level, and the distances at which the movement begins and ends.

use super::levels::{ChosenLevel, LevelArgs};
use crate::exit::{Failure, Outcome};
use crate::help::BECOMES;
use crate::mesh_output::FormatName;
use clap::Args;
use lodc::Asset;
use lodc::geomorph::{bends, joints_error, pose_error};
use lodc::pipeline::GeomorphJudge;
use lodc_formats::Limits;
use lodc_formats::export::GeomorphFacts;
use lodc_formats::gltf::MovedStreams;
use lodc_mesh::{Lod, Mesh};
use lodc_scene::ObjectShapes;
use std::ops::Range;
use std::path::Path;

/// Part of the way to the next level's distance on which a level is shown as it is: the longer the
/// rest, the less changes from one picture to the next.
const AS_IT_IS: f64 = 0.125;

/// Whether levels move to the next one.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = BECOMES)]
pub(super) struct GeomorphArgs {
    /// Levels that move to the next one: a morph target each
    ///
    /// lodc:next takes level k to level k + 1, weight 1 being its shape exactly. It moves positions
    /// and normals; of tangent, uv and color those that are listed (--geomorph=uv,tangent), for
    /// engines that have targets of them. With joints a vertex follows the joints of the one that
    /// it becomes at the level where it moves, not its own. In .glb and .gltf.
    #[arg(long, value_name = "STREAMS", num_args = 0..=1, require_equals = true,
          default_missing_value = "", value_parser = moved_streams, conflicts_with = "index_ranges",
          display_order = 1)]
    geomorph: Option<MovedStreams>,
}

fn moved_streams(text: &str) -> Result<MovedStreams, String> {
    let mut moved_streams = MovedStreams::default();
    for word in text.split(',').filter(|word| !word.is_empty()) {
        match word {
            "tangent" => moved_streams.tangents = true,
            "uv" => moved_streams.texture_coordinates = true,
            "color" => moved_streams.colours = true,
            "joints" => moved_streams.joints = true,
            _ => return Err(format!("`{word}` is not one of tangent, uv, color, joints")),
        }
    }
    Ok(moved_streams)
}

impl GeomorphArgs {
    /// What moves besides positions and normals; none if levels do not morph.
    pub(super) fn moved_streams(self) -> Option<MovedStreams> {
        self.geomorph
    }

    /// Refuses formats without morph targets.
    pub(super) fn check(self, format: FormatName, output: &Path) -> Outcome<()> {
        if self.geomorph.is_some() && !format.is_gltf() {
            return Err(Failure::usage(format!(
                "{}: only .glb and .gltf hold morph targets: --geomorph needs one of them",
                output.display()
            )));
        }
        Ok(())
    }
}

/// Refuses levels that get finer: an object may have levels of its own.
pub(super) fn check(levels: &[ChosenLevel]) -> Outcome<()> {
    let finer = |pair: &[ChosenLevel]| pair[0].lods.iter().zip(&pair[1].lods).any(|(a, b)| a > b);
    match levels.windows(2).position(finer) {
        Some(k) => Err(Failure::usage(format!(
            "--geomorph: an object's level {} is finer than the one before it",
            k + 1
        ))),
        None => Ok(()),
    }
}

/// States the distances of levels whose errors are known. `pose_errors` are those of each level, of
/// meshes that bend; `staying` are the numbers of vertices that stay.
pub(super) fn set_distances(
    args: &LevelArgs,
    levels: &mut [ChosenLevel],
    pose_errors: &[Option<f64>],
    staying: &[u64],
) {
    for level in levels.iter_mut() {
        level.distance = level.distance.or_else(|| args.distance(level.error));
    }
    let distances: Vec<Option<f64>> = levels.iter().map(|level| level.distance).collect();
    for (k, level) in levels.iter_mut().enumerate() {
        let next = distances.get(k + 1).copied().flatten();
        let own_part = |(own, next): (f64, f64)| own + AS_IT_IS * (next - own);
        let morph_from = level.distance.zip(next).map(own_part);
        let distance = level.distance;
        let pose_error = pose_errors.get(k).copied().flatten();
        let staying = staying.get(k).copied().unwrap_or(0);
        level.geomorph = Some(GeomorphFacts { distance, morph_from, pose_error, staying });
    }
}

/// An object on its way from each level to the next: the mesh, where it goes, what moves.
pub(super) type MovingMesh<'a> = (&'a Mesh, &'a Mesh, Range<u32>);

/// How far each level is from the next once it has moved, over the poses that errors are over, the
/// largest of all objects; none of levels without skins and targets, and of the last. `ways` are by
/// level and object. With `joints` vertices follow the joints of those that they become, which
/// moves them before any target does: that is part of it.
///
/// # Errors
/// If the document is damaged.
pub(super) fn pose_errors(
    asset: &Asset,
    ways: &[Vec<MovingMesh<'_>>],
    joints: bool,
    limits: &Limits,
) -> Outcome<Vec<Option<f64>>> {
    let shapes = lodc::stated_shapes(&asset.objects, &asset.document, limits)?;
    let unit = |o: usize| asset.objects[o].info.world_scale;
    let largest = |ways: &[MovingMesh<'_>], of: &dyn Fn(usize, &MovingMesh<'_>) -> f64| -> f64 {
        ways.iter().enumerate().map(|(o, way)| unit(o) * of(o, way)).fold(0.0, f64::max)
    };
    let last = ways.len().saturating_sub(1);
    // How far level k is from itself with the joints of its own vertices.
    let borrowed_joints_error = |k: usize| {
        if !joints || k >= last {
            return 0.0;
        }
        largest(&ways[k], &|o, (now, next, moving)| {
            joints_error(shapes[o].all(), now, next, moving)
        })
    };
    let mut errors = Vec::new();
    for (k, ways) in ways.iter().enumerate() {
        let own = borrowed_joints_error(k);
        let is_stated = k < last && ways.iter().any(|(mesh, ..)| bends(mesh));
        errors.push(is_stated.then(|| {
            let moved = largest(ways, &|o, (now, next, moving)| {
                pose_error(shapes[o].all(), now, next, moving, joints)
            });
            // The next level has borrowed joints, too.
            moved + own + borrowed_joints_error(k + 1)
        }));
    }
    Ok(errors)
}

/// Shapes of all objects: those that errors are over, and those with each morph target.
pub(super) struct GeomorphShapes {
    stated: Vec<ObjectShapes>,
    targets: Vec<ObjectShapes>,
}

impl GeomorphShapes {
    pub(super) fn new(asset: &Asset, limits: &Limits) -> Outcome<Self> {
        let Asset { objects, document, .. } = asset;
        let stated = lodc::stated_shapes(objects, document, limits)?;
        Ok(Self { stated, targets: lodc::target_shapes(objects, document, limits)? })
    }

    /// Judges the levels of an object; none if nothing bends it.
    pub(super) fn judge(&self, asset: &Asset, object: usize) -> Option<GeomorphJudge<'_>> {
        let mesh = asset.objects[object].simplified.mesh();
        GeomorphJudge::new(mesh, &self.stated[object], &self.targets[object])
    }
}

/// The error of an object's level or of the next one, the larger.
pub(super) fn larger_error(levels: &[ChosenLevel], level: usize, object: usize) -> f64 {
    let error = |k: usize| levels.get(k).map_or(0.0, |level| level.distances[object].error);
    error(level).max(error(level + 1))
}

/// The vertices of an object that move from a level to the next. `vertex_counts` are those of its
/// levels, each of which has the first vertices of the one before.
pub(super) fn moving(vertex_counts: &[u32], level: usize) -> Option<Range<u32>> {
    let next = *vertex_counts.get(level + 1)?;
    Some(next..vertex_counts[level].max(next))
}

/// The LODs of an object.
pub(super) fn lods(levels: &[ChosenLevel], object: usize) -> Vec<Lod> {
    levels.iter().map(|level| level.lods[object]).collect()
}
