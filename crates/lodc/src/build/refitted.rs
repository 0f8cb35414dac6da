//! Refitted levels: closer in space, and held back where pictures would get worse.

use super::Paints;
use crate::LodObject;
use crate::level_mesh::{LevelMesh, Order, ordered};
use lodc_measure::{Original, Portrait, Sampling, SceneSurface, Surface, TriangleTree, Viewing};
use lodc_mesh::{Lod, Mesh};
use lodc_refit::{Options, Refit};
use lodc_scene::{Appearance, Arrangement, Graph, Pose};
use rayon::prelude::*;
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

/// Makes the meshes of the objects at `lods`, one each, with vertices where they fit the input
/// best. `paints` is what they are judged in.
#[must_use]
pub fn refitted_meshes(
    objects: &[LodObject],
    lods: &[Lod],
    order: Order,
    paints: &Paints,
) -> Vec<LevelMesh> {
    let one = |(i, (object, &lod)): (usize, (&LodObject, &Lod))| {
        let (mesh, error, rms) = refitted(object, lod, (paints, i));
        LevelMesh { mesh: ordered(mesh, order), error, rms: Some(rms) }
    };
    objects.par_iter().zip(lods).enumerate().map(one).collect()
}

/// Measures meshes against the objects that they are levels of: for each an upper bound of its
/// distance, and the root mean square distance. For levels that no sequence has.
#[must_use]
pub fn measured(objects: &[LodObject], meshes: Vec<Mesh>) -> Vec<LevelMesh> {
    let one = |(object, mesh): (&LodObject, Mesh)| {
        let from_input = original(object.simplified.mesh(), None);
        let (error, rms) = from_input.bound_and_rms(&bare(&mesh));
        LevelMesh { mesh, error, rms: Some(rms) }
    };
    objects.par_iter().zip(meshes).map(one).collect()
}

/// A refitted level of an object of a scene, its error and its root mean square distance. These are
/// measured: the stored ones are of the vertices where they were.
fn refitted(object: &LodObject, lod: Lod, (paints, number): (&Paints, usize)) -> (Mesh, f64, f64) {
    let input = object.simplified.mesh();
    let found = Refit::new(&object.simplified, lod, &Options::DEFAULT);
    if lod.0 == 0 {
        return (found.mesh(0.0), 0.0, 0.0);
    }
    let unmoved = found.mesh(0.0);
    let looks = paints.looks_of(number);
    let from_input = original(input, found.tree());
    let before = from_input.bound_and_rms(&bare(&unmoved));
    let farthest = FARTHER * before.0;
    let worse = looks_worse(input, &unmoved, (paints, &looks));
    for share in SHARES {
        let mesh = found.mesh(share);
        let (error, rms) = from_input.bound_and_rms(&bare(&mesh));
        if error <= farthest && !worse(&mesh) {
            return (mesh, error, rms);
        }
    }
    (unmoved, before.0, before.1)
}

/// A mesh, ready for levels to be measured from it. `tree` is that of its triangles, if there is
/// one.
fn original(mesh: &Mesh, tree: Option<Arc<TriangleTree>>) -> Original {
    let surface = bare(mesh);
    let tree = tree.unwrap_or_else(|| Arc::new(surface.tree()));
    Original::with_tree(&surface, tree, &Sampling::DEFAULT)
}

/// Returns the question whether a mesh looks worse than where the simplifier left it. Meshes
/// without attributes never do.
fn looks_worse<'a>(
    original: &Mesh,
    unmoved: &Mesh,
    (paints, looks): (&'a Paints, &'a Appearance),
) -> Box<dyn Fn(&Mesh) -> bool + 'a> {
    if original.attributes().is_empty() {
        return Box::new(|_| false);
    }
    let surface = |mesh: &Mesh| {
        let scene = Arrangement::new(&Graph::default(), &Pose::default(), 1);
        SceneSurface::with_images(&[mesh], &scene, looks, || paints.images())
    };
    let whole = surface(original);
    let portrait = Portrait::new(&whole.surface, VIEWING, whole.common_looks(&whole));
    let error = move |mesh: &Mesh| portrait.compare(&surface(mesh).surface).rmse;
    let most = WORSE * error(unmoved) + NOTHING;
    Box::new(move |mesh| error(mesh) > most)
}

fn bare(mesh: &Mesh) -> Surface {
    Surface {
        positions: mesh.positions().iter().map(|&p| p.into()).collect(),
        triangles: mesh.triangles().to_vec(),
        ..Surface::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image_error(original: &Mesh, level: &Mesh) -> f64 {
        let scene = Arrangement::new(&Graph::default(), &Pose::default(), 1);
        let surface = |mesh| SceneSurface::new(&[mesh], &scene, &Appearance::default());
        let [original, level] = [original, level].map(surface);
        let looks = original.common_looks(&original);
        Portrait::new(&original.surface, VIEWING, looks).compare(&level.surface).rmse
    }

    #[test]
    fn levels_that_look_worse_are_known() {
        let (paints, looks) = (Paints::default(), Appearance::default());
        let (mut moved, mut held) = (0, 0);
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
            let worse = looks_worse(simplified.mesh(), &none, (&paints, &looks));
            let [before, after] = [&none, &whole].map(|m| image_error(simplified.mesh(), m));
            assert!(!worse(&none), "{name}");
            assert_eq!(worse(&whole), after > WORSE * before + NOTHING, "{name}: {before} {after}");
            held += u32::from(worse(&whole));
            moved += u32::from(!worse(&whole));
        }
        assert!(moved > 0 && held > 0, "{moved} moved, {held} held back");
    }
}
