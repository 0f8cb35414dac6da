//! How far a level of detail is from the input, all over its surface.

use super::cells::{Cell, whole};
use super::scene::Shown;
use lodc_formats::ObjectInfo;
use lodc_gpu::picture::Corner;
use lodc_measure::Bvh;
use lodc_mesh::{Mesh, OrientedTriangle};
use rayon::prelude::*;

/// An edge is measured at steps of this share of the object's diagonal.
const STEP: f64 = 1.0 / 160.0;
/// Most steps along an edge.
const MOST: usize = 48;
/// Places measured on one object, more or less.
const PLACES: usize = 4 << 20;

/// Distances all over the pictures of one sheet.
pub(super) struct Heat {
    /// For each cell and object.
    fields: Vec<Vec<Field>>,
    /// The largest distance: in mesh units for one object, in world units for several.
    pub(super) largest: f64,
    /// Of the input: of the largest object as the scene shows it.
    pub(super) diagonal: f64,
}

/// Distances on the triangles of one object.
struct Field {
    /// For each triangle, how many parts its edges have.
    parts: Vec<usize>,
    /// For each triangle, the distances of its places, row by row.
    distances: Vec<Vec<f32>>,
}

/// Measures every cell. Vertices of a level are vertices of the input, so that what lies between
/// them is what counts.
pub(super) fn measure(shown: &Shown, cells: &[Cell]) -> Heat {
    let objects = shown.objects.len();
    let scale = |o: usize| if objects > 1 { world_scale(shown.objects.info(o)) } else { 1.0 };
    let trees: Vec<Bvh> =
        (0..objects).into_par_iter().map(|o| tree(shown.objects.mesh(o))).collect();
    let field =
        |cell: &Cell, o: usize| field(shown.objects.mesh(o), &cell.objects[o], &trees[o], scale(o));
    let fields: Vec<Vec<Field>> = cells
        .iter()
        .map(|cell| (0..objects).into_par_iter().map(|o| field(cell, o)).collect())
        .collect();
    let all = fields.iter().flatten().flat_map(|f| f.distances.iter().flatten());
    let largest = f64::from(all.fold(0.0f32, |l, d| l.max(*d)));
    let diagonal =
        (0..objects).map(|o| shown.objects.mesh(o).diagonal() * scale(o)).fold(0.0, f64::max);
    Heat { fields, largest, diagonal }
}

fn world_scale(info: &ObjectInfo) -> f64 {
    if info.world_scale.is_finite() { info.world_scale.abs() } else { 1.0 }
}

fn tree(mesh: &Mesh) -> Bvh {
    let corners = |t: &OrientedTriangle| corners(mesh, t).map(Into::into);
    Bvh::of(&whole(mesh).iter().map(corners).collect::<Vec<_>>())
}

fn corners(mesh: &Mesh, t: &OrientedTriangle) -> [[f64; 3]; 3] {
    t.corners.map(|v| mesh.positions()[v as usize].map(f64::from))
}

fn field(mesh: &Mesh, triangles: &[OrientedTriangle], tree: &Bvh, scale: f64) -> Field {
    let step = mesh.diagonal() * STEP;
    let wanted = |t: &OrientedTriangle| {
        let [a, b, c] = corners(mesh, t);
        let longest = [(a, b), (b, c), (c, a)]
            .map(|(p, q)| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>());
        let longest = longest.into_iter().fold(0.0, f64::max).sqrt();
        if step > 0.0 { ((longest / step).ceil() as usize).clamp(1, MOST) } else { 1 }
    };
    let mut parts: Vec<usize> = triangles.iter().map(wanted).collect();
    let places: usize = parts.iter().map(|k| k * k / 2).sum();
    if places > PLACES {
        let less = (PLACES as f64 / places as f64).sqrt();
        parts.iter_mut().for_each(|k| *k = ((*k as f64 * less) as usize).max(1));
    }
    let distances = |(t, &k): (&OrientedTriangle, &usize)| -> Vec<f32> {
        let corners = corners(mesh, t);
        let at = |shares: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|i| (0..3).map(|c| shares[c] * corners[c][i]).sum())
        };
        // An input without triangles has no levels with any.
        grid(k)
            .map(|shares| (tree.distance_squared(at(shares).into()).sqrt() * scale) as f32)
            .collect()
    };
    let distances = triangles.par_iter().zip(&parts).map(distances).collect();
    Field { parts, distances }
}

/// The places of a triangle whose edges have `k` parts, row by row, as shares of its corners.
fn grid(k: usize) -> impl Iterator<Item = [f64; 3]> {
    let part = 1.0 / k as f64;
    (0..=k).flat_map(move |row| {
        (0..=k - row).map(move |i| {
            let (b, c) = (i as f64 * part, row as f64 * part);
            [1.0 - b - c, b, c]
        })
    })
}

impl Heat {
    /// A triangle of a cell in parts, each corner with the colour of its distance.
    pub(super) fn parts(
        &self,
        cell: usize,
        object: usize,
        t: usize,
        corners: &[Corner; 3],
    ) -> Vec<Corner> {
        let field = &self.fields[cell][object];
        let k = field.parts[t];
        let places: Vec<Corner> = grid(k)
            .zip(&field.distances[t])
            .map(|(shares, &distance)| {
                let [r, g, b] = super::colours::heat(if self.largest > 0.0 {
                    f64::from(distance) / self.largest
                } else {
                    0.0
                });
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
            .collect();
        let mut out = Vec::with_capacity(3 * k * k);
        let mut start = 0;
        for row in 0..k {
            let (length, next) = (k - row, start + k - row + 1);
            for i in 0..length {
                out.extend([start + i, start + i + 1, next + i].map(|p| places[p]));
                if i + 1 < length {
                    out.extend([start + i + 1, next + i + 1, next + i].map(|p| places[p]));
                }
            }
            start = next;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_triangle_cover_it_once() {
        let at = |x: f32, y: f32| Corner {
            position: [x, y, 0.0],
            normal: [0.0, 0.0, 1.0],
            ..Corner::default()
        };
        let corners = [at(0.0, 0.0), at(6.0, 0.0), at(0.0, 6.0)];
        for k in [1, 2, 5] {
            let distances = grid(k).map(|shares| shares[0] as f32).collect();
            let field = Field { parts: vec![k], distances: vec![distances] };
            let heat = Heat { fields: vec![vec![field]], largest: 1.0, diagonal: 1.0 };
            let parts = heat.parts(0, 0, 0, &corners);
            assert_eq!(parts.len(), 3 * k * k);
            let area = |t: &[Corner; 3]| {
                let [a, b, c] = t.map(|c| c.position);
                (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
            };
            let areas: Vec<f32> = parts.as_chunks::<3>().0.iter().map(area).collect();
            assert!(areas.iter().all(|a| (a - 36.0 / (k * k) as f32).abs() < 1e-4), "{areas:?}");
            assert_eq!(parts[0].colour[..3], super::super::colours::heat(1.0));
        }
    }

    #[test]
    fn a_level_is_measured_between_its_vertices() {
        let mesh = lodc_fixtures::named("cube").expect("a shape");
        let tree = tree(&mesh);
        let triangles = whole(&mesh);
        let own = field(&mesh, &triangles, &tree, 1.0);
        assert!(own.distances.iter().flatten().all(|&d| d < 1e-6));
        // A triangle through the middle of the cube, between corners that are far apart.
        let corner = |sign: [f32; 3]| {
            let at = |p: &[f32; 3]| (0..3).map(|i| p[i] * sign[i]).sum::<f32>();
            let all = 0..mesh.vertex_count() as u32;
            let score = |v: &u32| at(&mesh.positions()[*v as usize]);
            all.max_by(|a, b| score(a).total_cmp(&score(b))).expect("corners")
        };
        let inner = OrientedTriangle::new(
            0,
            [corner([1., 1., 1.]), corner([-1., -1., 1.]), corner([-1., 1., -1.])],
        );
        let inside = field(&mesh, &[inner], &tree, 2.0);
        let largest = inside.distances[0].iter().fold(0.0f32, |l, d| l.max(*d));
        let side = mesh.diagonal() as f32 / 3.0f32.sqrt();
        assert!(largest > 0.3 * side && largest <= side, "{largest} of {side}");
    }
}
