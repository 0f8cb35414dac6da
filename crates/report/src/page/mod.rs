//! The page for people who approve assets: every level with pictures, charts, storage and checks.

mod levels;
mod text;

pub use levels::{PageLevel, page_levels};
pub use text::page;

use crate::CheckReport;
use lodc::{LodObject, SceneLevels};
use lodc_select::{SelectError, Target};

/// Largest number of points of a curve. Chosen by hand: enough for any mesh down to three
/// triangles.
const MAX_POINTS: usize = 200;

/// The content of a page.
#[derive(Debug)]
pub struct PageContent<'a> {
    /// Name of the asset.
    pub title: String,
    /// The objects of the asset.
    pub objects: &'a [LodObject],
    /// The input and its levels, the finest first.
    pub levels: Vec<PageLevel>,
    /// Triangles and error of many levels, fine to coarse: [`error_curve`].
    pub curve: Vec<[f64; 2]>,
    /// The diagonal of the largest object as the scene shows it.
    pub diagonal: f64,
    /// The checks of all objects.
    pub checks: Vec<CheckReport>,
    /// Warnings, one line each.
    pub warnings: Vec<String>,
    /// Bytes of the input file.
    pub bytes: Option<u64>,
}

/// Returns triangles and error, in the units of [`Selection::error`](lodc_select::Selection), of
/// levels that each have nine tenths of the triangles of the one before.
///
/// # Errors
/// If a level cannot be chosen, which is a bug.
pub fn error_curve(scene: &SceneLevels<'_>, triangles: u64) -> Result<Vec<[f64; 2]>, SelectError> {
    let mut points = Vec::new();
    let mut wanted = triangles;
    while wanted > 3 && points.len() < MAX_POINTS {
        let chosen = scene.select(Target::Triangles(wanted))?;
        let candidates = scene.candidates();
        let remaining: u32 = candidates
            .iter()
            .zip(&chosen.lods)
            .map(|(c, &lod)| c.collapses.triangles_at(lod))
            .sum();
        points.push([f64::from(remaining), chosen.error]);
        wanted = wanted * 9 / 10;
    }
    Ok(points)
}
