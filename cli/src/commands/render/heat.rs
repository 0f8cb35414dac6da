//! Colours by the distance of a level of detail from the input, all over its surface.

use super::scene::DrawableScene;
use super::tiles::{Tile, all_triangles};
use lodc_formats::ObjectInfo;
use lodc_measure::render::Corner;
use lodc_measure::{DistanceField, TriangleTree, heat};
use lodc_mesh::{Mesh, OrientedTriangle};
use lodc_scene::to_linear;
use rayon::prelude::*;

/// Spacing of the points of an edge whose distance is measured, as a share of the object's
/// diagonal. Chosen by hand: finer shows no more in a picture, and takes longer.
const SAMPLE_SPACING: f64 = 1.0 / 160.0;

/// The distances of the surfaces that one sheet shows.
pub(super) struct Heat {
    /// By tile and object.
    fields: Vec<Vec<DistanceField>>,
    /// World units per mesh unit of each object.
    scales: Vec<f64>,
    /// The distance of the last colour, in world units: the largest stated error; if none is
    /// stated, the largest distance.
    pub(super) largest: f64,
    /// The diagonal of the input's largest object as the scene shows it, in world units.
    pub(super) diagonal: f64,
}

/// Measures the distances of every tile from the input.
pub(super) fn measure(drawable: &DrawableScene, tiles: &[Tile]) -> Heat {
    let objects = drawable.objects.len();
    let scale = |o: usize| world_scale(drawable.objects.info(o));
    let scales: Vec<f64> = (0..objects).map(scale).collect();
    let tree = |o: usize| {
        let mesh = drawable.objects.mesh(o);
        TriangleTree::new(&corners(mesh, &all_triangles(mesh)))
    };
    let trees: Vec<TriangleTree> = (0..objects).into_par_iter().map(tree).collect();
    let field = |tile: &Tile, o: usize| {
        let corners = corners(tile.mesh(drawable, o), &tile.triangles[o]);
        DistanceField::new(
            &corners,
            &trees[o],
            drawable.objects.mesh(o).diagonal() * SAMPLE_SPACING,
        )
    };
    let fields: Vec<Vec<DistanceField>> = tiles
        .iter()
        .map(|tile| (0..objects).into_par_iter().map(|o| field(tile, o)).collect())
        .collect();
    let in_scene = |(f, scale): (&DistanceField, &f64)| f64::from(f.largest()) * scale;
    let largest = fields.iter().flat_map(|tile| tile.iter().zip(&scales)).map(in_scene);
    let stated = tiles.iter().filter_map(|tile| tile.error).filter(|e| e.is_finite());
    let largest = stated.reduce(f64::max).unwrap_or_else(|| largest.fold(0.0, f64::max));
    let diagonals = (0..objects).map(|o| drawable.objects.mesh(o).diagonal() * scales[o]);
    let diagonal = diagonals.fold(0.0, f64::max);
    Heat { fields, scales, largest, diagonal }
}

fn world_scale(info: &ObjectInfo) -> f64 {
    if info.world_scale.is_finite() { info.world_scale.abs() } else { 1.0 }
}

fn corners<P: From<[f64; 3]>>(mesh: &Mesh, triangles: &[OrientedTriangle]) -> Vec<[P; 3]> {
    let position = |v: u32| mesh.positions()[v as usize].map(f64::from).into();
    triangles.iter().map(|t| t.corners.map(position)).collect()
}

impl Heat {
    /// Divides triangle `t` of a tile's object; each corner has the colour of its distance.
    pub(super) fn divide(
        &self,
        tile: usize,
        object: usize,
        t: usize,
        corners: &[Corner; 3],
    ) -> Vec<Corner> {
        self.fields[tile][object].parts(t, |shares, distance| {
            let distance = f64::from(distance) * self.scales[object];
            let share = if self.largest > 0.0 { distance / self.largest } else { 0.0 };
            let [r, g, b] = heat(share).map(|v| to_linear(f32::from(v) / 255.0));
            let mix = |of: &dyn Fn(&Corner) -> f32| -> f32 {
                (0..3).map(|c| shares[c] as f32 * of(&corners[c])).sum()
            };
            Corner {
                position: std::array::from_fn(|i| mix(&|c| c.position[i])),
                normal: std::array::from_fn(|i| mix(&|c| c.normal[i])),
                uv: [0.0; 2],
                colour: [r, g, b, 1.0],
            }
        })
    }
}
