//! The page for people who approve assets: every level with pictures, charts, storage and checks.

mod levels;
mod text;

pub use levels::{Level, levels};
pub use text::page;

use crate::CheckReport;
use lodc::{LodObject, SceneLevels};
use lodc_select::{SelectError, Target};

/// All that a page is made of.
#[derive(Debug)]
pub struct Facts<'a> {
    /// Name of the asset.
    pub title: String,
    /// The objects of the asset.
    pub objects: &'a [LodObject],
    /// The input and its levels, the finest first.
    pub levels: Vec<Level>,
    /// Triangles and error in world units of many levels, fine to coarse: [`curve`].
    pub curve: Vec<[f64; 2]>,
    /// Of the largest object as the scene shows it.
    pub diagonal: f64,
    /// What was checked, of all objects.
    pub checks: Vec<CheckReport>,
    /// A line each.
    pub warnings: Vec<String>,
    /// Bytes of the input file.
    pub bytes: Option<u64>,
}

/// Triangles and error of levels that each have nine tenths of the triangles of the one before.
///
/// # Errors
/// If a level is none, which is a bug.
pub fn curve(scene: &SceneLevels<'_>, triangles: u64) -> Result<Vec<[f64; 2]>, SelectError> {
    let mut points = Vec::new();
    let mut wanted = triangles;
    while wanted > 3 && points.len() < 200 {
        let chosen = scene.select(Target::Triangles(wanted), false)?;
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
