//! Refitted levels: closer in space, and held back where pictures would get worse.

use super::likeness::Likeness;
use crate::level_mesh::{LevelMesh, Order, ordered};
use crate::{Error, LodObject};
use lodc_formats::{Document, Limits, ObjectInfo, coordinates};
use lodc_measure::{Original, Sampling, Surface, TriangleTree};
use lodc_mesh::{Lod, Mesh};
use lodc_refit::{Options, Refit};
use lodc_scene::Coordinates;
use rayon::prelude::*;
use std::sync::Arc;

/// Shares of the way to the best fit, of which the first that looks better counts.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];
/// Most that the largest distance may grow.
const FARTHER: f64 = 1.05;
/// Share of its image error that a level keeps at most, in the mean of all kinds of pictures.
const BETTER: f64 = 0.99;

/// Makes the meshes of the objects at `lods`, one each, with vertices and normals where they fit
/// the input best. The same objects and document give the same meshes, whether they come from a
/// mesh or from a file of its levels, with textures at hand or without.
///
/// # Errors
/// If the stored document is damaged.
pub fn refitted_meshes(
    objects: &[LodObject],
    document: &Document,
    lods: &[Lod],
    order: Order,
    limits: &Limits,
) -> Result<Vec<LevelMesh>, Error> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
    let shown = coordinates(document, &infos, limits)?;
    let one = |((object, &lod), shown): ((&LodObject, &Lod), &Vec<Coordinates>)| {
        let (mesh, error, rms) = refitted(object, lod, shown);
        LevelMesh { mesh: ordered(mesh, order), error, rms: Some(rms) }
    };
    Ok(objects.par_iter().zip(lods).zip(&shown).map(one).collect())
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
/// measured: the stored ones are of the vertices where they were. `shown` are the texture
/// coordinates of its submeshes.
fn refitted(object: &LodObject, lod: Lod, shown: &[Coordinates]) -> (Mesh, f64, f64) {
    let input = object.simplified.mesh();
    let found = Refit::new(&object.simplified, lod, &Options::DEFAULT);
    if lod.0 == 0 {
        return (found.unmoved(), 0.0, 0.0);
    }
    let unmoved = found.unmoved();
    let from_input = original(input, found.tree());
    let before = from_input.bound_and_rms(&bare(&unmoved));
    let farthest = FARTHER * before.0;
    let better = looks_better(input, &unmoved, shown);
    for share in SHARES {
        let mesh = found.mesh(share);
        let (error, rms) = from_input.bound_and_rms(&bare(&mesh));
        if error <= farthest && better(&mesh) {
            return (mesh, error, rms);
        }
    }
    let shaded = found.mesh(0.0);
    (if better(&shaded) { shaded } else { unmoved }, before.0, before.1)
}

/// A mesh, ready for levels to be measured from it. `tree` is that of its triangles, if there is
/// one.
fn original(mesh: &Mesh, tree: Option<Arc<TriangleTree>>) -> Original {
    let surface = bare(mesh);
    let tree = tree.unwrap_or_else(|| Arc::new(surface.tree()));
    Original::with_tree(&surface, tree, &Sampling::DEFAULT)
}

/// Returns the question whether a mesh looks better than where the simplifier left it: no worse in
/// any kind of picture. Meshes without attributes always do.
fn looks_better(
    original: &Mesh,
    unmoved: &Mesh,
    shown: &[Coordinates],
) -> Box<dyn Fn(&Mesh) -> bool> {
    if original.attributes().is_empty() {
        return Box::new(|_| true);
    }
    let likeness = Likeness::new(original, shown);
    let before = likeness.errors(unmoved);
    Box::new(move |mesh| is_better(&before, &likeness.errors(mesh)))
}

/// Returns whether no image error grew, and all together fell by enough to count.
fn is_better(before: &[f64], now: &[f64]) -> bool {
    let pairs = || before.iter().zip(now);
    let shares: Vec<f64> = pairs().filter(|(b, _)| **b > 0.0).map(|(b, n)| n / b).collect();
    let enough = shares.iter().sum::<f64>() <= BETTER * shares.len() as f64;
    pairs().all(|(b, n)| n <= b) && !shares.is_empty() && enough
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

    #[test]
    fn levels_look_better_or_stay() {
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
            let shown = vec![Coordinates::PLAIN; mesh.submeshes().len()];
            let better = looks_better(simplified.mesh(), &found.unmoved(), &shown);
            assert!(!better(&found.unmoved()), "{name}");
            held += u32::from(!better(&found.mesh(1.0)));
            moved += u32::from(better(&found.mesh(1.0)));
        }
        assert!(moved > 0 && held > 0, "{moved} moved, {held} held back");
    }

    #[test]
    fn better_is_worse_in_no_picture() {
        assert!(is_better(&[2.0, 4.0], &[2.0, 3.8]) && is_better(&[2.0, 0.0], &[1.0, 0.0]));
        assert!(!is_better(&[2.0, 4.0], &[2.1, 1.0]) && !is_better(&[2.0, 0.0], &[1.0, 0.1]));
        assert!(!is_better(&[2.0, 4.0], &[2.0, 3.99]) && !is_better(&[0.0], &[0.0]));
    }
}
