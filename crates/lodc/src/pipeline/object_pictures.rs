//! Pictures of one object from all sides, to compare its levels by: by the mesh alone, without its
//! textures.
//!
//! A source mesh has textures, a file of its levels may not, and both must give the same levels.
//! Noise takes their place, with as much detail of every size, as photographs have.

use lodc_measure::{Difference, Pyramid, ReferenceKinds, SceneSurface, ShadingOptions, Viewing};
use lodc_mesh::{Mesh, SplitMix64};
use lodc_scene::{
    Appearance, Arrangement, Coordinates, Graph, Image, Material, Pose, Texture, Wrap,
};
use std::cell::OnceCell;
use std::sync::Arc;

/// Cameras of each round: the second is asked only where the first leaves it open. Chosen by hand,
/// as are the next three.
const VIEWS: [u32; 2] = [5, 8];
/// Pixels across for the square root of the triangles: some two for each triangle that is seen.
const PIXELS_PER_ROOT: f64 = 2.0;
/// Pixels across and down, at least and at most.
const MIN_SIZE: f64 = 32.0;
const MAX_SIZE: f64 = 192.0;
/// Pixels of the noise image, across and down. Chosen by hand, as are the next two.
const NOISE_SIZE: usize = 64;
/// Cells across the image of each grain of noise, the coarsest first.
const GRAIN_CELLS: [usize; 5] = [2, 4, 8, 16, 32];
/// Shift of texture coordinates from one submesh to the next, so that their colours differ.
const SUBMESH_SHIFT: [f32; 2] = [0.37, 0.61];

/// The noise image as the texture of any object.
pub(super) fn noise() -> Arc<[Pyramid]> {
    [Pyramid::new(&noise_image())].into()
}

/// An object as it looks from all sides, in rounds of pictures.
pub(super) struct ObjectPictures<'a> {
    mesh: &'a Mesh,
    appearance: Appearance,
    noise: Arc<[Pyramid]>,
    rounds: [OnceCell<ReferenceKinds>; ROUNDS],
}

/// Rounds of pictures.
pub(super) const ROUNDS: usize = VIEWS.len();

impl<'a> ObjectPictures<'a> {
    /// Pictures of an object: shaded by its normals, and, if it has texture coordinates, with noise
    /// and with a checkerboard. `coordinates` are those that its submeshes use, `noise` is
    /// [`noise()`]. They are taken when they are needed: fewer and smaller than those of `compare`,
    /// to save time, and from other sides, so that levels are not chosen by the pictures that
    /// measure them.
    pub(super) fn new(mesh: &'a Mesh, coordinates: &[Coordinates], noise: &Arc<[Pyramid]>) -> Self {
        let (appearance, noise) = (noise_appearance(coordinates), Arc::clone(noise));
        Self { mesh, appearance, noise, rounds: Default::default() }
    }

    /// How far a level looks from the object in a round of pictures, one for each kind.
    pub(super) fn differences(&self, level: &Mesh, round: usize) -> Vec<Difference> {
        let level = surface(level, &self.appearance, &self.noise).surface;
        self.rounds[round].get_or_init(|| self.reference(VIEWS[round])).compare(&level)
    }

    fn reference(&self, views: u32) -> ReferenceKinds {
        let scene_surface = surface(self.mesh, &self.appearance, &self.noise);
        // Colours of vertices are read from the input, not fitted: they must not decide on places.
        let shading = scene_surface.common_shading(&scene_surface);
        let all = ShadingOptions { vertex_colours: false, ..shading };
        let shaded = ShadingOptions { materials: false, ..all };
        let checkerboard = ShadingOptions { checkerboard: scene_surface.all_textured, ..shaded };
        let mut kinds = vec![shaded];
        if all.materials {
            kinds.push(all);
            // Where a submesh has no texture coordinates, it would be the first kind again.
            kinds.extend(Some(checkerboard).filter(|kind| *kind != shaded));
        }
        let triangles = self.mesh.triangles().len() as f64;
        let size = (PIXELS_PER_ROOT * triangles.sqrt()).clamp(MIN_SIZE, MAX_SIZE) as u32;
        ReferenceKinds::new(&scene_surface.surface, Viewing { views, size }, kinds)
    }
}

/// The surface of an object by itself.
fn surface(mesh: &Mesh, appearance: &Appearance, noise: &Arc<[Pyramid]>) -> SceneSurface {
    let scene = Arrangement::new(&Graph::default(), &Pose::default(), 1);
    SceneSurface::with_images(&[mesh], &scene, appearance, || Arc::clone(noise))
}

/// A material with noise as its texture for each submesh.
fn noise_appearance(coordinates: &[Coordinates]) -> Appearance {
    let material = |(submesh, coordinates): (usize, &Coordinates)| {
        let Coordinates { set, mut transform } = *coordinates;
        for (row, shift) in transform.iter_mut().zip(SUBMESH_SHIFT) {
            row[2] += shift * submesh as f32;
        }
        let wrap = [Wrap::Repeat; 2];
        let texture = Texture { image: 0, set, transform, wrap, nearest: false };
        let coordinates = Coordinates { set, transform };
        Material { texture: Some(texture), coordinates, ..Material::default() }
    };
    Appearance {
        materials: coordinates.iter().enumerate().map(material).collect(),
        of_submesh: vec![(0..coordinates.len()).collect()],
        ..Appearance::default()
    }
}

/// Noise that repeats across and down: the sum of all grains, with independent red, green and blue.
fn noise_image() -> Image {
    let mut random = SplitMix64::new(0x6e6f_6973);
    let mut sums = vec![[0.0f32; 3]; NOISE_SIZE * NOISE_SIZE];
    for cells in GRAIN_CELLS {
        let values: Vec<[f32; 3]> =
            (0..cells * cells).map(|_| std::array::from_fn(|_| random.unit())).collect();
        // The two cells around a pixel along one axis, and its share of the way between them.
        let neighbours = |pixel: usize| {
            let cell = (pixel * cells) as f32 / NOISE_SIZE as f32;
            let first = cell as usize;
            ([first, (first + 1) % cells], cell - first as f32)
        };
        for (i, sum) in sums.iter_mut().enumerate() {
            let (x, y) = (neighbours(i % NOISE_SIZE), neighbours(i / NOISE_SIZE));
            for (c, sum) in sum.iter_mut().enumerate() {
                let value = |column: usize, row: usize| values[y.0[row] * cells + x.0[column]][c];
                let [top, bottom] =
                    [0, 1].map(|row| value(0, row) + x.1 * (value(1, row) - value(0, row)));
                *sum += top + y.1 * (bottom - top);
            }
        }
    }
    // Sums of this many grains are near the middle: 100 spreads them over most of 0 to 255. Chosen
    // by hand.
    let shade = |sum: f32| {
        let middle = GRAIN_CELLS.len() as f32 / 2.0;
        (127.5 + 100.0 * (sum - middle)).clamp(0.0, 255.0) as u8
    };
    let bytes = sums.iter().flat_map(|&[r, g, b]| [shade(r), shade(g), shade(b), 255]).collect();
    Image { width: NOISE_SIZE as u32, height: NOISE_SIZE as u32, bytes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_fixtures::{Coincident, coincident};
    use lodc_measure::{ImageError, ReferencePictures, SceneSurface};
    use lodc_simplify::{Options, simplify};

    const VIEWING: Viewing = Viewing { views: 17, size: 256 };

    /// Image errors of levels with about these shares of the triangles, as `compare` shows them.
    fn image_errors(mesh: &Mesh, shares: [f64; 4]) -> [(usize, ImageError); 4] {
        let scene_surface = |mesh: &Mesh| -> SceneSurface {
            let coordinates = vec![Coordinates::PLAIN; mesh.submeshes().len()];
            surface(mesh, &noise_appearance(&coordinates), &noise())
        };
        let simplified = simplify(mesh, &Options::DEFAULT, &|_, _| {});
        let whole = scene_surface(mesh);
        let reference =
            ReferencePictures::new(&whole.surface, VIEWING, whole.common_shading(&whole));
        shares.map(|share| {
            let wanted = (share * mesh.triangles().len() as f64) as u32;
            let lod = simplified.collapses().lod_for_triangles(wanted);
            let triangles = simplified.triangles_at(lod);
            let level = simplified.mesh().extract(&triangles).expect("a level is a mesh");
            (level.triangles().len(), reference.compare(&scene_surface(&level).surface))
        })
    }

    #[test]
    fn levels_of_a_doubled_surface_look_like_those_of_the_single_one() {
        let mut compared = 0;
        for (name, make) in lodc_fixtures::ALL {
            let mesh = make();
            // A Möbius strip has only one side.
            if mesh.triangles().len() < 100 || *name == "mobius_strip" {
                continue;
            }
            let single = image_errors(&mesh, [0.5, 0.25, 0.1, 0.05]);
            for kind in [Coincident::TwoSided, Coincident::Doubled] {
                let doubled = coincident(&mesh, kind);
                let share = |i: usize| single[i].0 as f64 / mesh.triangles().len() as f64;
                let errors = image_errors(&doubled, [0, 1, 2, 3].map(share));
                for ((_, one), (_, two)) in single.iter().zip(errors) {
                    let most = 1.03 * one.rmse + 0.05;
                    assert!(two.rmse <= most, "{name}, {kind:?}: {} for {}", two.rmse, one.rmse);
                    compared += u32::from(one.rmse > 1.0);
                }
            }
        }
        assert!(compared > 50, "{compared} levels that differ from their meshes");
    }
}
