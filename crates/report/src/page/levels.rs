//! The levels that the report page shows: counts, distances, and pictures from four sides.

use crate::gone::{MissingPart, PartInventory};
use lodc::{Error, LodObject, SceneLevels, level_mesh};
use lodc_formats::images::png;
use lodc_measure::{
    ImageError, Picture, ReferencePictures, SceneSurface, ShadingOptions, TriangleTree, Viewing,
    heat,
};
use lodc_mesh::Mesh;
use lodc_scene::{Appearance, Arrangement};
use lodc_select::{Selection, Target};
use rayon::prelude::*;

/// Shares of the input's triangles.
const SHARES: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.05, 0.01];
/// Pictures of a level, and twice the pixels across each: they are smoothed by halving.
const VIEWING: Viewing = Viewing { views: 4, size: 480 };

/// Distances up to this share of the diagonal come of rounded coordinates.
const ROUNDING: f64 = 1e-6;

/// A level of the whole scene.
#[derive(Debug)]
pub struct Level {
    /// Of all objects.
    pub triangles: u64,
    /// Share of the input's triangles.
    pub share: f64,
    /// In world units.
    pub error: f64,
    /// Root mean square of the distances; none if they are not measured.
    pub rms: Option<f64>,
    /// Difference of the pictures from those of the input.
    pub image: ImageError,
    /// One PNG for each side.
    pub pictures: Vec<Vec<u8>>,
    /// The same with colours by the distance from the input; none for the input.
    pub heat: Vec<Vec<u8>>,
    /// Pictures of the input with colours by the distance from the level: what it has lost; none
    /// for the input.
    pub lost: Vec<Vec<u8>>,
    /// The distance of the reddest colour: the error, in the units of the scene.
    pub hottest: f64,
    /// What it no longer shows.
    pub gone: Vec<MissingPart>,
}

/// The input and its levels, the finest first, each once.
///
/// # Errors
/// If a level is no mesh, which is a bug.
pub fn levels(
    objects: &[LodObject],
    scene: &SceneLevels<'_>,
    inventory: &PartInventory<'_>,
    arrangement: &Arrangement,
    appearance: &Appearance,
) -> Result<Vec<Level>, Error> {
    let whole: Vec<&Mesh> = objects.iter().map(|o| o.simplified.mesh()).collect();
    let all: usize = whole.iter().map(|m| m.triangles().len()).sum();
    let input = SceneSurface::new(&whole, arrangement, appearance);
    let looks = ShadingOptions { checkerboard: false, ..input.common_looks(&input) };
    let reference = ReferencePictures::new(&input.surface, VIEWING, looks);
    let tree = input.surface.tree();
    let rounding = ROUNDING * input.surface.diagonal();
    let whole = reference.pictures_of(&input.surface);
    // The error of a single object is in its own units.
    let unit = match objects {
        [one] if one.info.world_scale.is_finite() => one.info.world_scale.abs(),
        _ => 1.0,
    };
    let mut levels: Vec<Level> = Vec::new();
    for share in SHARES {
        let Selection { lods, error, rms, .. } = scene.select(Target::Ratio(share), false)?;
        let meshes = level_mesh::plain(objects, &lods)?;
        let triangles = meshes.iter().map(|m| m.triangles().len() as u64).sum();
        if levels.last().is_some_and(|l| l.triangles == triangles) {
            continue;
        }
        let refs: Vec<&Mesh> = meshes.iter().collect();
        let surface = SceneSurface::new(&refs, arrangement, appearance).surface;
        let drawn = reference.pictures_of(&surface);
        let hottest = unit * error;
        let heated = |pictures: &[Picture], from: &TriangleTree| -> Vec<Vec<u8>> {
            pictures.par_iter().map(|p| heated(p, &p.distances(from), hottest, rounding)).collect()
        };
        let (heat, lost) = match levels.is_empty() {
            true => Default::default(),
            false => (heated(&drawn, &tree), heated(&whole, &surface.tree())),
        };
        levels.push(Level {
            triangles,
            share: triangles as f64 / all.max(1) as f64,
            error,
            rms,
            image: reference.compare_pictures(&drawn),
            pictures: drawn.iter().map(plain).collect(),
            heat,
            lost,
            hottest,
            gone: inventory.gone(&lods),
        });
    }
    Ok(levels)
}

fn plain(picture: &Picture) -> Vec<u8> {
    png(&picture.image([0; 4], |_, colour| colour.map(|v| v as u8)).halved())
}

/// Colours by distance; places no farther than rounding makes them are not apart.
fn heated(picture: &Picture, far: &[f64], hottest: f64, rounding: f64) -> Vec<u8> {
    let share = |pixel: usize| if far[pixel] > rounding { far[pixel] / hottest } else { 0.0 };
    png(&picture.image([0; 4], |pixel, _| heat(share(pixel))).halved())
}
