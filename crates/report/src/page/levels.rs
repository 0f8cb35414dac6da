//! The levels that the report page shows: counts, distances, and pictures from four sides.

use crate::missing_parts::{MissingPart, PartInventory};
use lodc::{Error, LodObject, SceneLevels, level_mesh};
use lodc_formats::images::png;
use lodc_measure::{
    ImageError, Picture, ReferencePictures, SceneSurface, ShadingOptions, TriangleTree, Viewing,
    heat,
};
use lodc_mesh::Mesh;
use lodc_scene::{Appearance, Arrangement, centre};
use lodc_select::{Selection, Target};
use rayon::prelude::*;

/// The levels on the page, by their shares of the input's triangles. Chosen by hand.
const SHARES: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.05, 0.01];
/// The pictures of a level, twice as large as they are shown: they are smoothed by halving.
const VIEWING: Viewing = Viewing { views: 4, size: 480 };

/// Distances up to this share of the diagonal are rounding errors of coordinates. Chosen by hand.
const ROUNDING: f64 = 1e-6;

/// A level of the whole scene, as the page shows it.
#[derive(Debug)]
pub struct PageLevel {
    /// Triangles of all objects.
    pub triangles: u64,
    /// Share of the input's triangles.
    pub share: f64,
    /// The error, in world units.
    pub error: f64,
    /// Root mean square of the distances, in world units; none if they are not measured.
    pub rms: Option<f64>,
    /// Difference of the pictures from those of the input.
    pub image: ImageError,
    /// One PNG for each side.
    pub pictures: Vec<Vec<u8>>,
    /// The same with colours by the distance from the input; none for the input.
    pub distance_pictures: Vec<Vec<u8>>,
    /// Pictures of the input with colours by the distance from the level, which show what the level
    /// has lost; none for the input.
    pub loss_pictures: Vec<Vec<u8>>,
    /// The parts that it no longer shows.
    pub gone: Vec<MissingPart>,
}

/// Makes the input and its levels with their pictures, the finest first, each once.
///
/// # Errors
/// If a level is no mesh, which is a bug.
pub fn page_levels(
    objects: &[LodObject],
    scene: &SceneLevels<'_>,
    inventory: &PartInventory<'_>,
    arrangement: &Arrangement,
    appearance: &Appearance,
) -> Result<Vec<PageLevel>, Error> {
    let input: Vec<&Mesh> = objects.iter().map(|o| o.simplified.mesh()).collect();
    let arrangement = &arrangement.moved(centre(arrangement, |o| input[o]).map(|c| -c));
    let input_triangles: usize = input.iter().map(|m| m.triangles().len()).sum();
    let input = SceneSurface::new(&input, arrangement, appearance);
    let shading = ShadingOptions { checkerboard: false, ..input.common_shading(&input) };
    let reference = ReferencePictures::new(&input.surface, VIEWING, shading);
    let tree = input.surface.tree();
    let rounding = ROUNDING * input.surface.diagonal();
    let input_pictures = reference.pictures_of(&input.surface);
    let mut levels: Vec<PageLevel> = Vec::new();
    for share in SHARES {
        let Selection { lods, error, rms, .. } = scene.select(Target::Ratio(share))?;
        let meshes = level_mesh::reference_meshes(objects, &lods)?;
        let triangles = meshes.iter().map(|m| m.triangles().len() as u64).sum();
        if levels.last().is_some_and(|l| l.triangles == triangles) {
            continue;
        }
        let refs: Vec<&Mesh> = meshes.iter().collect();
        let surface = SceneSurface::new(&refs, arrangement, appearance).surface;
        let level_pictures = reference.pictures_of(&surface);
        let by_distance = |pictures: &[Picture], from: &TriangleTree| -> Vec<Vec<u8>> {
            let png = |p: &Picture| distance_png(p, &p.distances(from), error, rounding);
            pictures.par_iter().map(png).collect()
        };
        let (distance_pictures, loss_pictures) = match levels.is_empty() {
            true => Default::default(),
            false => {
                (by_distance(&level_pictures, &tree), by_distance(&input_pictures, &surface.tree()))
            }
        };
        levels.push(PageLevel {
            triangles,
            share: triangles as f64 / input_triangles.max(1) as f64,
            error,
            rms,
            image: reference.compare_pictures(&level_pictures),
            pictures: level_pictures.iter().map(plain_png).collect(),
            distance_pictures,
            loss_pictures,
            gone: inventory.gone(&lods),
        });
    }
    Ok(levels)
}

fn plain_png(picture: &Picture) -> Vec<u8> {
    png(&picture.image([0; 4], |_, colour| colour.map(|v| v as u8)).halved())
}

/// The picture with colours by the distances of its pixels, that of `hottest` the reddest; those up
/// to `rounding` count as 0.
fn distance_png(picture: &Picture, distances: &[f64], hottest: f64, rounding: f64) -> Vec<u8> {
    let share = |pixel: usize| match distances[pixel] {
        distance if distance > rounding => distance / hottest,
        _ => 0.0,
    };
    png(&picture.image([0; 4], |pixel, _| heat(share(pixel))).halved())
}
