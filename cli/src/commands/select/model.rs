//! Joins the objects of a file into one model for selection: one list of levels with one error
//! each.

use crate::commands::read::read_lodc;
use crate::exit::{Failure, Outcome, Status};
use crate::limits::LimitArgs;
use lodc::{LodFile, scene_levels};
use lodc_formats::{Limits, ObjectInfo, scene_graph};
use lodc_report::ErrorsOver;
use lodc_scene::{Arrangement, posed_positions};
use lodc_select::LevelCurve;
use std::path::Path;

/// The levels of a file and its size.
#[derive(Debug)]
pub(super) struct Model {
    /// World error and triangles of each level, the finest first.
    levels: Vec<(f64, u32)>,
    /// The LOD of each level, if there is a single object.
    lods: Option<Vec<u32>>,
    /// The poses that its errors are the largest over.
    pub(super) errors_over: ErrorsOver,
    /// Radius of a sphere around the origin that holds everything that the scene shows.
    pub(super) radius: f32,
}

impl Model {
    /// Reads a file.
    ///
    /// # Errors
    /// If the file cannot be read or has no triangles.
    pub(super) fn read(path: &Path, limits: &LimitArgs) -> Outcome<Self> {
        let (limits, clock) = (limits.limits(), limits.clock(path));
        let (file, _) = read_lodc(path, limits)?;
        clock.check();
        let levels = scene_levels(&file.objects, &file.document, &limits)?.by_error();
        if levels.first().is_none_or(|&(_, triangles)| triangles == 0) {
            let what = format!("{}: has no triangles to choose a level of", path.display());
            return Err(Failure::new(Status::Input, what));
        }
        let lods = match &file.objects[..] {
            [object] => {
                let collapses = object.simplified.collapses();
                let steps = (0..collapses.steps()).map(|i| collapses.step(i).lod.0);
                Some(std::iter::once(0).chain(steps).collect())
            }
            _ => None,
        };
        let errors_over = ErrorsOver::of(file.objects.iter().map(|o| &o.info));
        Ok(Self { levels, lods, errors_over, radius: radius(&file, limits)? })
    }

    pub(super) fn curve(&self, radius: f32) -> LevelCurve {
        LevelCurve::new(&self.levels, radius)
    }

    pub(super) fn lod(&self, index: u32) -> Option<u32> {
        self.lods.as_ref().map(|lods| lods[index as usize])
    }
}

fn radius(file: &LodFile, limits: Limits) -> Outcome<f32> {
    let infos: Vec<&ObjectInfo> = file.objects.iter().map(|o| &o.info).collect();
    let graph = scene_graph(&file.document, &infos, &limits)?;
    let scene = Arrangement::new(&graph, &graph.rest_pose(), infos.len());
    let farthest = scene.placements().iter().flat_map(|placement| {
        let mesh = file.objects[placement.object].simplified.mesh();
        posed_positions(mesh, placement).into_iter().map(|p| p.length())
    });
    Ok(farthest.fold(0.0, f64::max) as f32)
}
