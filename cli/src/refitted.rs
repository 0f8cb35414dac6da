//! Refitted levels: closer in space, and held back where pictures would get worse.

use lodc_formats::lodc::LodObject;
use lodc_measure::{Portrait, Sampling, SceneSurface, Surface, Viewing, distances};
use lodc_mesh::{Lod, Mesh};
use lodc_refit::{Options, Refit};
use lodc_scene::{Appearance, Arrangement, Graph, Pose};
use std::sync::Arc;

/// Pictures that decide whether attributes look right.
const VIEWING: Viewing = Viewing { views: 12, size: 256 };
/// Shares of the way to the best fit, of which the first that makes nothing worse counts.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];
/// Most that the largest distance may grow.
const FARTHER: f64 = 1.05;
/// Most that the image error may grow, as a share and in addition (of 255).
const WORSE: f64 = 1.005;
const NOTHING: f64 = 0.02;

/// A refitted level, its error and its root mean square distance. These are measured: the stored
/// ones are of the vertices where they were.
pub(crate) fn refitted(object: &LodObject, lod: Lod, looks: &Appearance) -> (Mesh, f64, f64) {
    let original = object.simplified.mesh();
    let found = Refit::new(&object.simplified, lod, &Options::DEFAULT);
    if lod.0 == 0 {
        return (found.mesh(0.0), 0.0, 0.0);
    }
    let unmoved = found.mesh(0.0);
    let before = errors(original, &unmoved);
    let worse = looks_worse(original, &unmoved, looks);
    for share in SHARES {
        let mesh = found.mesh(share);
        let after = errors(original, &mesh);
        if after.0 <= FARTHER * before.0 && !worse(&mesh) {
            return (mesh, after.0, after.1);
        }
    }
    (unmoved, before.0, before.1)
}

/// Measures the largest and the root mean square distance of a level from its original.
fn errors(original: &Mesh, level: &Mesh) -> (f64, f64) {
    let measured = distances(&bare(original), &bare(level), &Sampling::DEFAULT);
    let larger = |[a, b]: [f64; 2]| a.max(b);
    (larger(measured.hausdorff), larger(measured.rms))
}

/// Returns the question whether a mesh looks worse than where the simplifier left it. Meshes
/// without attributes never do.
fn looks_worse<'a>(
    original: &Mesh,
    unmoved: &Mesh,
    looks: &'a Appearance,
) -> Box<dyn Fn(&Mesh) -> bool + 'a> {
    if original.attributes().is_empty() {
        return Box::new(|_| false);
    }
    let whole = surface(original, looks);
    let portrait = Portrait::new(&whole.surface, VIEWING, whole.common_looks(&whole));
    let images = whole.surface.images;
    let error = move |mesh: &Mesh| {
        let scene = Arrangement::new(&Graph::default(), &Pose::default(), 1);
        let level = SceneSurface::with_images(&[mesh], &scene, looks, || Arc::clone(&images));
        portrait.compare(&level.surface).rmse
    };
    let most = WORSE * error(unmoved) + NOTHING;
    Box::new(move |mesh| error(mesh) > most)
}

/// An object as it was modelled, with its looks.
fn surface(mesh: &Mesh, looks: &Appearance) -> SceneSurface {
    SceneSurface::new(&[mesh], &Arrangement::new(&Graph::default(), &Pose::default(), 1), looks)
}

fn bare(mesh: &Mesh) -> Surface {
    Surface {
        positions: mesh.positions().iter().map(|&p| p.into()).collect(),
        triangles: mesh.triangles().to_vec(),
        ..Surface::default()
    }
}

/// The looks of one object of a scene, with the images that it shows.
pub(crate) fn of_object(looks: &Appearance, object: usize) -> Appearance {
    let Some(of_submesh) = looks.of_submesh.get(object) else { return Appearance::default() };
    let mut own = Appearance { of_submesh: vec![of_submesh.clone()], ..Appearance::default() };
    let mut number = vec![None; looks.images.len()];
    for (m, mut material) in looks.materials.iter().copied().enumerate() {
        // What other objects wear is nothing here.
        material.texture =
            material.texture.filter(|_| of_submesh.contains(&m)).map(|mut texture| {
                texture.image = *number[texture.image].get_or_insert_with(|| {
                    own.images.push(looks.images[texture.image].clone());
                    own.images.len() - 1
                });
                texture
            });
        own.materials.push(material);
    }
    own
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image_error(original: &Mesh, level: &Mesh) -> f64 {
        let [original, level] = [original, level].map(|m| surface(m, &Appearance::default()));
        let looks = original.common_looks(&original);
        Portrait::new(&original.surface, VIEWING, looks).compare(&level.surface).rmse
    }

    #[test]
    fn levels_that_look_worse_are_known() {
        let (looks, mut moved, mut held) = (Appearance::default(), 0, 0);
        for (name, make) in lodc_fixtures::ALL {
            let mesh = make();
            if mesh.attributes().is_empty() || mesh.triangles().len() < 100 {
                continue;
            }
            let options = lodc_simplify::Options::DEFAULT;
            let simplified = lodc_simplify::simplify(&mesh, &options, &|_, _| {});
            let lod = simplified.collapses().lod_for_triangles(mesh.triangles().len() as u32 / 4);
            let found = Refit::new(&simplified, lod, &Options::DEFAULT);
            let (whole, none) = (found.mesh(1.0), found.mesh(0.0));
            let worse = looks_worse(simplified.mesh(), &none, &looks);
            let [before, after] = [&none, &whole].map(|m| image_error(simplified.mesh(), m));
            assert!(!worse(&none), "{name}");
            assert_eq!(worse(&whole), after > WORSE * before + NOTHING, "{name}: {before} {after}");
            held += u32::from(worse(&whole));
            moved += u32::from(!worse(&whole));
        }
        assert!(moved > 0 && held > 0, "{moved} moved, {held} held back");
    }
}
