//! The levels that a report shows: counts, distances, and pictures from four sides.

use crate::colours::heat;
use crate::commands::asset::Asset;
use crate::exit::Outcome;
use lodc::SceneLevels;
use lodc::level_mesh;
use lodc_formats::images::png;
use lodc_measure::{ImageError, Looks, Picture, Portrait, SceneSurface, TriangleTree, Viewing};
use lodc_mesh::Mesh;
use lodc_scene::{Appearance, Arrangement, Image};
use lodc_select::{Selection, Target};
use rayon::prelude::*;

/// Shares of the input's triangles.
const SHARES: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.05, 0.01];
/// Pictures of a level, and twice the pixels across each: they are smoothed by halving.
const VIEWING: Viewing = Viewing { views: 4, size: 480 };

/// A level of the whole scene.
pub(super) struct Level {
    pub(super) triangles: u64,
    /// Share of the input's triangles.
    pub(super) share: f64,
    pub(super) error: f64,
    pub(super) rms: Option<f64>,
    /// Difference of the pictures from those of the input.
    pub(super) image: ImageError,
    /// One PNG for each side.
    pub(super) pictures: Vec<Vec<u8>>,
    /// The same with colours by the distance from the input; none for the input.
    pub(super) heat: Vec<Vec<u8>>,
    /// The distance of the reddest colour, in world units.
    pub(super) hottest: f64,
}

/// The input and its levels, the finest first, each once.
///
/// # Errors
/// If a level is no mesh, which is a bug.
pub(super) fn shown(
    asset: &Asset,
    scene: &SceneLevels<'_>,
    arrangement: &Arrangement,
    appearance: &Appearance,
) -> Outcome<Vec<Level>> {
    let objects = &asset.objects;
    let whole: Vec<&Mesh> = objects.iter().map(|o| o.simplified.mesh()).collect();
    let all: usize = whole.iter().map(|m| m.triangles().len()).sum();
    let input = SceneSurface::new(&whole, arrangement, appearance);
    let looks = Looks { checkerboard: false, ..input.common_looks(&input) };
    let portrait = Portrait::new(&input.surface, VIEWING, looks);
    let tree = input.surface.tree();
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
        let drawn = portrait.pictures_of(&surface);
        let far: Vec<Vec<f64>> = drawn.par_iter().map(|p| distances(p, &tree)).collect();
        let hottest = far.iter().flatten().copied().fold(0.0, f64::max);
        let warm = levels.is_empty().then(Vec::new);
        levels.push(Level {
            triangles,
            share: triangles as f64 / all.max(1) as f64,
            error,
            rms,
            image: portrait.compare_pictures(&drawn),
            pictures: drawn.iter().map(plain).collect(),
            heat: warm.unwrap_or_else(|| {
                drawn.iter().zip(&far).map(|(p, far)| heated(p, far, hottest)).collect()
            }),
            hottest,
        });
    }
    Ok(levels)
}

/// Distance of each pixel's place from the input; 0 where nothing is.
fn distances(picture: &Picture, tree: &TriangleTree) -> Vec<f64> {
    let of = |(colour, &place): (&[f32; 3], &_)| match colour[0] < 0.0 {
        true => 0.0,
        false => tree.distance_squared(place).sqrt(),
    };
    picture.colours.iter().zip(&picture.points).map(of).collect()
}

fn plain(picture: &Picture) -> Vec<u8> {
    encoded(picture, |_, colour| colour.map(|v| v as u8))
}

/// Colours by distance, as dark as the surface is there.
fn heated(picture: &Picture, far: &[f64], hottest: f64) -> Vec<u8> {
    encoded(picture, |pixel, _| heat(if hottest > 0.0 { far[pixel] / hottest } else { 0.0 }))
}

/// A PNG of half the size, transparent where nothing is.
fn encoded(picture: &Picture, colour: impl Fn(usize, [f32; 3]) -> [u8; 3]) -> Vec<u8> {
    let pixel = |(i, &c): (usize, &[f32; 3])| match c[0] < 0.0 {
        true => [0; 4],
        false => {
            let [r, g, b] = colour(i, c);
            [r, g, b, 255]
        }
    };
    let bytes = picture.colours.iter().enumerate().flat_map(pixel).collect();
    png(&Image { width: picture.size, height: picture.size, bytes }.halved())
}
