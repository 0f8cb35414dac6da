//! Pictures that tell whether a level of one object looks more like it: from all sides, by what
//! the mesh itself knows.
//!
//! Its textures are not used: a source mesh has them, a file of its levels may not, and both are to
//! give the same levels. Noise takes their place, with equal detail of every size, as photographs
//! have.

use lodc_measure::{Pyramid, ReferencePictures, SceneSurface, ShadingOptions, Viewing};
use lodc_mesh::{Mesh, SplitMix64};
use lodc_scene::{
    Appearance, Arrangement, Coordinates, Graph, Image, Material, Pose, Texture, Wrap,
};
use std::sync::Arc;

/// The pictures: fewer and smaller than those of `compare`, and from other sides, so that levels
/// are not chosen by the very pictures that measure them.
const VIEWING: Viewing = Viewing { views: 17, size: 256 };
/// Pixels of the noise, across and down.
const NOISE: usize = 256;
/// Cells across of its coarsest and its finest grain, each twice the one before.
const GRAINS: [usize; 6] = [2, 4, 8, 16, 32, 64];
/// Shift of texture coordinates from one submesh to the next, so that each has colours of its own.
const SHIFT: [f32; 2] = [0.37, 0.61];

/// The noise, ready to be shown on any object.
pub(super) fn noise() -> Arc<[Pyramid]> {
    [Pyramid::new(&image())].into()
}

/// An object as it looks from all sides.
pub(super) struct ObjectPictures {
    looks: Appearance,
    noise: Arc<[Pyramid]>,
    references: Vec<ReferencePictures>,
}

impl ObjectPictures {
    /// Takes the pictures: shaded by its normals, and painted by its texture coordinates where it
    /// has any. `coordinates` are those that its submeshes show, `noise` is [`noise()`].
    pub(super) fn new(mesh: &Mesh, coordinates: &[Coordinates], noise: &Arc<[Pyramid]>) -> Self {
        let looks = painted(coordinates);
        let shown = surface(mesh, &looks, noise);
        let all = shown.common_looks(&shown);
        let shaded = ShadingOptions { materials: false, ..all };
        let mut kinds = vec![shaded];
        if all.materials {
            kinds.push(all);
            kinds.push(ShadingOptions { checkerboard: shown.all_textured, ..shaded });
        }
        kinds.dedup();
        let references = kinds
            .into_iter()
            .map(|looks| ReferencePictures::new(&shown.surface, VIEWING, looks))
            .collect();
        Self { looks, noise: Arc::clone(noise), references }
    }

    /// The image errors of a level, one for each kind of picture: 0 to 255.
    pub(super) fn errors(&self, level: &Mesh) -> Vec<f64> {
        let shown = surface(level, &self.looks, &self.noise).surface;
        self.references.iter().map(|p| p.compare(&shown).rmse).collect()
    }
}

/// An object by itself.
fn surface(mesh: &Mesh, looks: &Appearance, noise: &Arc<[Pyramid]>) -> SceneSurface {
    let scene = Arrangement::new(&Graph::default(), &Pose::default(), 1);
    SceneSurface::with_images(&[mesh], &scene, looks, || Arc::clone(noise))
}

/// A material of noise for each submesh.
fn painted(coordinates: &[Coordinates]) -> Appearance {
    let material = |(s, read): (usize, &Coordinates)| {
        let Coordinates { set, mut transform } = *read;
        for (row, shift) in transform.iter_mut().zip(SHIFT) {
            row[2] += shift * s as f32;
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

/// Noise that repeats both ways: equal parts of all grains, each red, green and blue of its own.
fn image() -> Image {
    let mut random = SplitMix64::new(0x6e6f_6973);
    let mut sums = vec![[0.0f32; 3]; NOISE * NOISE];
    for cells in GRAINS {
        let values: Vec<[f32; 3]> =
            (0..cells * cells).map(|_| std::array::from_fn(|_| random.unit())).collect();
        let along = |pixel: usize| {
            let at = (pixel * cells) as f32 / NOISE as f32;
            let first = at as usize;
            ([first, (first + 1) % cells], at - first as f32)
        };
        for (i, sum) in sums.iter_mut().enumerate() {
            let (x, y) = (along(i % NOISE), along(i / NOISE));
            for (c, sum) in sum.iter_mut().enumerate() {
                let value = |column: usize, row: usize| values[y.0[row] * cells + x.0[column]][c];
                let [top, bottom] =
                    [0, 1].map(|row| value(0, row) + x.1 * (value(1, row) - value(0, row)));
                *sum += top + y.1 * (bottom - top);
            }
        }
    }
    // Sums of that many grains are near the middle.
    let shade = |sum: f32| {
        let middle = GRAINS.len() as f32 / 2.0;
        (127.5 + 100.0 * (sum - middle)).clamp(0.0, 255.0) as u8
    };
    let bytes = sums.iter().flat_map(|&[r, g, b]| [shade(r), shade(g), shade(b), 255]).collect();
    Image { width: NOISE as u32, height: NOISE as u32, bytes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_fixtures::{Twin, twin};
    use lodc_measure::{ImageError, SceneSurface};
    use lodc_simplify::{Options, simplify};

    /// Image errors of levels with about these shares of the triangles, as `compare` shows them.
    fn image_errors(mesh: &Mesh, shares: [f64; 4]) -> [(usize, ImageError); 4] {
        let shown = |mesh: &Mesh| -> SceneSurface {
            let coordinates = vec![Coordinates::PLAIN; mesh.submeshes().len()];
            surface(mesh, &painted(&coordinates), &noise())
        };
        let simplified = simplify(mesh, &Options::DEFAULT, &|_, _| {});
        let whole = shown(mesh);
        let reference = ReferencePictures::new(&whole.surface, VIEWING, whole.common_looks(&whole));
        shares.map(|share| {
            let wanted = (share * mesh.triangles().len() as f64) as u32;
            let lod = simplified.collapses().lod_for_triangles(wanted);
            let triangles = simplified.triangles_at(lod);
            let level = simplified.mesh().extract(&triangles).expect("a level is a mesh");
            (level.triangles().len(), reference.compare(&shown(&level).surface))
        })
    }

    #[test]
    fn levels_of_a_doubled_surface_look_like_those_of_the_single_one() {
        let mut compared = 0;
        for (name, make) in lodc_fixtures::ALL {
            let mesh = make();
            // The two sides of a Möbius strip are one.
            if mesh.triangles().len() < 100 || *name == "mobius_strip" {
                continue;
            }
            let single = image_errors(&mesh, [0.5, 0.25, 0.1, 0.05]);
            for kind in [Twin::TwoSided, Twin::Doubled] {
                let doubled = twin(&mesh, kind);
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
