//! Refitted levels: closer in space, and held back where pictures would get worse.

use super::object_pictures::{ObjectPictures, noise};
use crate::level_mesh::{LevelMesh, Order, ordered};
use crate::{Error, LodObject, stated_shapes};
use lodc_errors::Tick;
use lodc_formats::{Document, Limits, ObjectInfo, coordinates};
use lodc_measure::{Original, Pyramid, Sampling, Surface, TriangleTree};
use lodc_mesh::{Lod, Mesh};
use lodc_refit::{Options, Refit};
use lodc_scene::{Coordinates, Shape};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;

/// Shares of the way to the best fit, of which the first that looks plainly better counts, else the
/// one that looks best. With none of it normals alone are fitted.
const SHARES: [f64; 4] = [1.0, 0.5, 0.25, 0.0];
/// Most that the largest distance may grow.
const FARTHER: f64 = 1.05;
/// Share of its image error that a level keeps at most to look plainly better, and better.
const PLAINLY: f64 = 0.95;
const BETTER: f64 = 0.97;

/// Makes the meshes of the objects at `lods`, one each, with vertices and normals where they fit
/// the input best. The same objects and document give the same meshes, whether they come from a
/// mesh or from a file of its levels, with textures at hand or without. `tick` is called now and
/// then.
///
/// # Errors
/// If the stored document is damaged.
pub fn refitted_meshes(
    objects: &[LodObject],
    document: &Document,
    lods: &[Lod],
    order: Order,
    limits: &Limits,
    tick: &Tick<'_>,
) -> Result<Vec<LevelMesh>, Error> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
    let shown = coordinates(document, &infos, limits)?;
    let shapes = stated_shapes(objects, document, limits)?;
    let noise = noise();
    let one = |((object, &lod), (shown, shapes)): ((&LodObject, &Lod), (&Vec<_>, &Vec<Shape>))| {
        let (mesh, at_rest) = refitted(object, lod, (shown, &noise), tick);
        let (error, rms) = over(shapes, object.simplified.mesh(), &mesh, Some(at_rest));
        LevelMesh { mesh: ordered(mesh, order), error, rms: Some(rms) }
    };
    Ok(objects.par_iter().zip(lods).zip(shown.par_iter().zip(&shapes)).map(one).collect())
}

/// Measures meshes against the objects that they are levels of: for each an upper bound of its
/// distance, and the root mean square distance, the largest over the shapes that the objects'
/// errors are over. For levels that no sequence has.
///
/// # Errors
/// If the stored document is damaged.
pub fn measured(
    objects: &[LodObject],
    document: &Document,
    meshes: Vec<Mesh>,
    limits: &Limits,
) -> Result<Vec<LevelMesh>, Error> {
    let shapes = stated_shapes(objects, document, limits)?;
    let one = |((object, mesh), shapes): ((&LodObject, Mesh), &Vec<Shape>)| {
        let (error, rms) = over(shapes, object.simplified.mesh(), &mesh, None);
        LevelMesh { mesh, error, rms: Some(rms) }
    };
    Ok(objects.par_iter().zip(meshes).zip(&shapes).map(one).collect())
}

/// Points that the mean distance in a pose is of.
const IN_POSE: Sampling = Sampling { samples: 20_000, ..Sampling::DEFAULT };

/// The bound and the root mean square distance of a level, the largest over some shapes, the first
/// of them at rest. `as_modelled` are those of the meshes as they are, if they are known.
fn over(
    shapes: &[Shape],
    input: &Mesh,
    level: &Mesh,
    as_modelled: Option<(f64, f64)>,
) -> (f64, f64) {
    let in_shape = |(number, shape): (usize, &Shape)| {
        let [places, own] = [shape.of(input), shape.of(level)];
        if let (Cow::Borrowed(_), Some(known)) = (&places, as_modelled) {
            return known;
        }
        let sampling = if number == 0 { Sampling::DEFAULT } else { IN_POSE };
        let original = Original::new(&surface(input, &places), &sampling);
        original.bound_and_rms(&surface(level, &own))
    };
    let all = shapes.iter().enumerate().map(in_shape);
    all.fold((0.0, 0.0), |(error, rms), (e, r)| (f64::max(error, e), f64::max(rms, r)))
}

/// A refitted level of an object, with its error and its root mean square distance as the object
/// was modelled. These are measured: the stored ones are of the vertices where they were. `shown`
/// are the texture coordinates of its submeshes, and what is painted by them.
fn refitted(
    object: &LodObject,
    lod: Lod,
    shown: TextureNoise<'_>,
    tick: &Tick<'_>,
) -> (Mesh, (f64, f64)) {
    let input = object.simplified.mesh();
    let found = Refit::new(&object.simplified, lod, &Options::DEFAULT, tick);
    if lod.0 == 0 {
        return (found.unmoved(), (0.0, 0.0));
    }
    let unmoved = found.unmoved();
    let from_input = original(input, found.tree());
    let before = from_input.bound_and_rms(&bare(&unmoved));
    let judge = Judge::new(input, &unmoved, shown);
    let mut best = (BETTER, (unmoved, before));
    for share in SHARES {
        tick();
        let mesh = found.mesh(share);
        let (error, rms) = from_input.bound_and_rms(&bare(&mesh));
        if error > FARTHER * before.0 {
            continue;
        }
        let kept = judge.as_ref().map_or(0.0, |judge| judge.kept(&mesh));
        if kept < best.0 {
            best = (kept, (mesh, (error, rms)));
        }
        if kept <= PLAINLY {
            break;
        }
    }
    best.1
}

/// A mesh, ready for levels to be measured from it. `tree` is that of its triangles, if there is
/// one.
fn original(mesh: &Mesh, tree: Option<Arc<TriangleTree>>) -> Original {
    let surface = bare(mesh);
    let tree = tree.unwrap_or_else(|| Arc::new(surface.tree()));
    Original::with_tree(&surface, tree, &Sampling::DEFAULT)
}

/// The texture coordinates of an object's submeshes, and the noise that is painted by them.
type TextureNoise<'a> = (&'a [Coordinates], &'a Arc<[Pyramid]>);

/// Tells how much better a refitted level looks than where the simplifier left it.
struct Judge {
    pictures: ObjectPictures,
    before: Vec<f64>,
}

impl Judge {
    /// None for meshes without attributes: whatever is closer looks better.
    fn new(input: &Mesh, unmoved: &Mesh, (shown, noise): TextureNoise<'_>) -> Option<Self> {
        if input.attributes().is_empty() {
            return None;
        }
        let pictures = ObjectPictures::new(input, shown, noise);
        let before = pictures.errors(unmoved);
        Some(Self { pictures, before })
    }

    /// The share of its image error that a level keeps, in the kind of picture that gains least.
    fn kept(&self, level: &Mesh) -> f64 {
        kept(&self.before, &self.pictures.errors(level))
    }
}

fn kept(before: &[f64], now: &[f64]) -> f64 {
    let share = |(&before, &now): (&f64, &f64)| if now == 0.0 { 0.0 } else { now / before };
    before.iter().zip(now).map(share).fold(0.0, f64::max)
}

fn bare(mesh: &Mesh) -> Surface {
    surface(mesh, mesh.positions())
}

/// The triangles of a mesh with its vertices at other places.
fn surface(mesh: &Mesh, places: &[[f32; 3]]) -> Surface {
    Surface {
        positions: places.iter().map(|&p| p.into()).collect(),
        triangles: mesh.triangles().to_vec(),
        ..Surface::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_look_better_or_stay() {
        let (noise, mut moved, mut held) = (noise(), 0, 0);
        for (name, make) in lodc_fixtures::ALL {
            let mesh = make();
            if mesh.attributes().is_empty() || mesh.triangles().len() < 100 {
                continue;
            }
            let options = lodc_simplify::Options::DEFAULT;
            let simplified = lodc_simplify::simplify(&mesh, &options, &|_, _| {});
            let lod = simplified.collapses().lod_for_triangles(mesh.triangles().len() as u32 / 4);
            let shown = vec![Coordinates::PLAIN; mesh.submeshes().len()];
            let info = ObjectInfo {
                name: name.to_string(),
                submeshes: Vec::new(),
                world_scale: 1.0,
                poses: vec![],
                document_mesh: 0,
            };
            let simplified = Arc::new(simplified);
            let object = LodObject { info, simplified, models: Vec::new() };
            let unmoved = Refit::new(&object.simplified, lod, &Options::DEFAULT, &|| ()).unmoved();
            let judge = Judge::new(&mesh, &unmoved, (&shown, &noise)).expect("attributes");
            let (level, ..) = refitted(&object, lod, (&shown, &noise), &|| ());
            let is_held = level == unmoved;
            assert!(is_held || judge.kept(&level) <= BETTER, "{name}");
            held += u32::from(is_held);
            moved += u32::from(!is_held);
        }
        assert!(moved > 0 && held > 0, "{moved} moved, {held} held back");
    }

    #[test]
    fn the_kind_of_picture_that_gains_least_decides() {
        assert_eq!(kept(&[2.0, 4.0], &[1.0, 3.0]), 0.75);
        assert_eq!(kept(&[2.0, 0.0], &[1.0, 0.0]), 0.5);
        assert!(kept(&[2.0, 0.0], &[1.0, 0.1]).is_infinite());
    }
}
