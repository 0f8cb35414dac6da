//! Refitted levels: their vertices are moved closer to the input, as far as pictures do not get
//! worse.

use super::errors::LevelDistance;
use super::object_pictures::{ObjectPictures, ROUNDS, noise};
use crate::level_mesh::{LevelMesh, MeshOptions, Order, extracted, ordered};
use crate::{Error, LodObject, stated_shapes};
use lodc_errors::{Distances, Measurable, Tick};
use lodc_formats::{Document, Limits, ObjectInfo, coordinates};
use lodc_measure::{Difference, Pyramid};
use lodc_mesh::{Lod, Mesh};
use lodc_refit::{Options, Refit};
use lodc_scene::{Coordinates, ObjectShapes, Shape};
use rayon::prelude::*;
use std::cell::OnceCell;
use std::ops::Range;
use std::sync::Arc;

/// Shares of the way to the best fit that are tried in order: the first that looks clearly better
/// counts, else the one that looks best. 0 fits normals and texture coordinates alone. Chosen by
/// hand.
const FIT_SHARES: [f64; 3] = [1.0, 0.5, 0.0];
/// Factor by which refitting may raise the bound of a level at most. Chosen by hand.
const MAX_BOUND_GROWTH: f64 = 1.05;
/// A level looks clearly better if it keeps at most this share of its image error. Chosen by hand,
/// as is the next.
const CLEARLY_BETTER: f64 = 0.95;
/// It looks better if it keeps less than this share; else it stays as it was.
const BETTER: f64 = 0.97;
/// Where a level keeps at least this share, no position on the way there is tried, but normals and
/// texture coordinates alone. Chosen by hand.
const HOPELESS: f64 = 1.05;
/// Shares that more pictures are taken for. Chosen by hand.
const UNCLEAR: Range<f64> = 0.92..1.0;

/// How far refitting may raise the distances of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Growth {
    /// The bound by 5 %.
    Little,
    /// Not beyond what the object states at the level, if that was measured, so that one that was
    /// chosen by its error keeps it.
    None,
}

/// Makes the meshes of the objects at `lods`, one each, with vertices and normals where they fit
/// the input best, or as they are where that does not look better. The same objects and document
/// give the same meshes, whether they come from a mesh or from a file of its levels, with or
/// without textures. `tick` is called now and then.
///
/// # Errors
/// If the stored document is damaged.
pub fn refitted_meshes(
    objects: &[LodObject],
    document: &Document,
    lods: &[Lod],
    (order, growth): (Order, Growth),
    limits: &Limits,
    tick: &Tick<'_>,
) -> Result<Vec<LevelMesh>, Error> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
    let coordinates = coordinates(document, &infos, limits)?;
    let shapes = stated_shapes(objects, document, limits)?;
    let noise = noise();
    let one = |((object, &lod), (coordinates, shapes)): (_, (&Vec<_>, &ObjectShapes))| {
        let texture = NoiseTexture { coordinates, noise: &noise };
        let (moved, distances) = refitted(object, lod, shapes.all(), texture, growth, tick);
        let refitted = moved.is_some();
        let mesh = match moved {
            Some(mesh) => ordered(mesh, order),
            None => {
                let options = MeshOptions { model: None, order };
                ordered(extracted(object, lod, options)?.mesh, order)
            }
        };
        Ok(LevelMesh { mesh, error: distances.upper, rms: Some(distances.rms), refitted })
    };
    objects.par_iter().zip(lods).zip(coordinates.par_iter().zip(&shapes)).map(one).collect()
}

/// Measures meshes that are levels of the objects but not of their collapse sequences: for each an
/// upper bound of its distance and the root mean square distance, the largest over the shapes that
/// the objects' stated errors are over.
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
    let one = |((object, mesh), shapes): ((&LodObject, Mesh), &ObjectShapes)| {
        let input = object.simplified.mesh();
        let distances = largest(&Originals::new(shapes.all(), input).distances(&mesh));
        LevelMesh { mesh, error: distances.upper, rms: Some(distances.rms), refitted: false }
    };
    Ok(objects.par_iter().zip(meshes).zip(&shapes).map(one).collect())
}

/// An input in the shapes that its errors are the largest over. A skin at rest, default morph
/// weights or an uneven scale may make the first another than that of the mesh as it is.
pub(super) struct Originals<'a> {
    pub(super) shapes: &'a [Shape],
    pub(super) originals: Vec<Measurable>,
}

impl<'a> Originals<'a> {
    pub(super) fn new(shapes: &'a [Shape], input: &Mesh) -> Self {
        let originals = shapes.iter().map(|shape| measurable(input, &shape.of(input))).collect();
        Self { shapes, originals }
    }

    /// The distances of a level in each shape.
    fn distances(&self, level: &Mesh) -> Vec<Distances> {
        let shapes = self.shapes.iter().zip(&self.originals);
        let in_shape = |(shape, original): (&Shape, &Measurable)| {
            original.distances(&measurable(level, &shape.of(level)))
        };
        shapes.map(in_shape).collect()
    }
}

fn largest(distances: &[Distances]) -> Distances {
    distances.iter().fold(Distances::default(), |most, &distances| most.max(distances))
}

/// A refitted level of an object, none where it stays as it is, with its distances, the largest
/// over all shapes. These are measured: the stored ones are those of the vertices before they were
/// moved. What would spoil the level in one of the shapes is held back.
fn refitted(
    object: &LodObject,
    lod: Lod,
    shapes: &[Shape],
    texture: NoiseTexture<'_>,
    growth: Growth,
    tick: &Tick<'_>,
) -> (Option<Mesh>, Distances) {
    if lod.0 == 0 {
        return (None, Distances::default());
    }
    let input = object.simplified.mesh();
    let refit = Refit::new(&object.simplified, lod, &Options::DEFAULT, tick);
    let unmoved = refit.unmoved();
    let originals = Originals::new(shapes, input);
    // What is written states its distances, so those of the level before are only measured where
    // they decide.
    let before = OnceCell::new();
    let before = || before.get_or_init(|| originals.distances(&unmoved));
    let judge = Judge::new(input, &unmoved, texture);
    let is_as_modelled = matches!(shapes, [shape] if shape.is_as_modelled());
    let stated = match growth {
        Growth::Little => None,
        // Estimates bound nothing.
        Growth::None => {
            object.simplified.collapses().is_measured().then(|| LevelDistance::stated(object, lod))
        }
    };
    let is_within = |now: &Distances| {
        stated.is_none_or(|stated| {
            now.upper <= stated.error && stated.rms.is_none_or(|rms| now.rms <= rms)
        })
    };
    let is_spoilt = |distances: &[Distances]| {
        if !distances.iter().all(is_within) {
            return true;
        }
        let known = if is_as_modelled { refit.unmoved_distance() } else { 0.0 };
        let spoils =
            |(now, before): (&Distances, &Distances)| now.upper > MAX_BOUND_GROWTH * before.upper;
        distances.iter().any(|now| now.upper > MAX_BOUND_GROWTH * known)
            && distances.iter().zip(before()).any(spoils)
    };
    // The best level so far, and the share of its image error that a better one has to be below.
    let (mut best, mut least_kept) = (None, BETTER);
    let mut next = if refit.moves() { Some(FIT_SHARES[0]) } else { FIT_SHARES.last().copied() };
    while let Some(share) = next {
        tick();
        next = FIT_SHARES.iter().copied().find(|&s| s < share);
        let mesh = refit.mesh(share);
        let distances = if share > 0.0 { originals.distances(&mesh) } else { before().clone() };
        if is_spoilt(&distances) {
            continue;
        }
        let share_kept = judge.as_ref().map_or(0.0, |judge| judge.kept_share(&mesh));
        if share_kept < least_kept {
            (best, least_kept) = (Some((mesh, largest(&distances))), share_kept);
        }
        if share_kept <= CLEARLY_BETTER {
            break;
        }
        if share_kept >= HOPELESS {
            next = FIT_SHARES.last().copied().filter(|&s| s < share);
        }
    }
    if let Some((mesh, distances)) = best {
        return (Some(mesh), distances);
    }
    let mut distances = largest(before());
    if let Some(stated) = stated {
        distances.upper = distances.upper.min(stated.error);
        distances.rms = stated.rms.map_or(distances.rms, |rms| distances.rms.min(rms));
    }
    (None, distances)
}

/// Noise as the texture of an object.
#[derive(Clone, Copy)]
struct NoiseTexture<'a> {
    /// By submesh, the texture coordinates that it uses.
    coordinates: &'a [Coordinates],
    noise: &'a Arc<[Pyramid]>,
}

/// Compares pictures of a refitted level with pictures of the level as the simplifier left it.
struct Judge<'a> {
    pictures: ObjectPictures<'a>,
    unmoved: &'a Mesh,
    /// How far the level as the simplifier left it looks from the object, by round.
    before: [OnceCell<Vec<Difference>>; ROUNDS],
}

impl<'a> Judge<'a> {
    /// None for meshes without attributes: for them, closer counts as better.
    fn new(input: &'a Mesh, unmoved: &'a Mesh, texture: NoiseTexture<'_>) -> Option<Self> {
        if input.attributes().is_empty() {
            return None;
        }
        let pictures = ObjectPictures::new(input, texture.coordinates, texture.noise);
        Some(Self { pictures, unmoved, before: Default::default() })
    }

    /// The share of its image error that a level keeps, in the kind of picture that gains least;
    /// may be above 1. The first round of pictures decides where it is clear.
    fn kept_share(&self, level: &Mesh) -> f64 {
        let mut sums: Option<[Vec<Difference>; 2]> = None;
        let mut kept = f64::INFINITY;
        for round in 0..ROUNDS {
            let before =
                self.before[round].get_or_init(|| self.pictures.differences(self.unmoved, round));
            let now = self.pictures.differences(level, round);
            let and = |a: &[Difference], b: &[Difference]| -> Vec<Difference> {
                a.iter().zip(b).map(|(a, b)| a.and(*b)).collect()
            };
            let both = match sums {
                Some([a, b]) => [and(&a, before), and(&b, &now)],
                None => [before.clone(), now],
            };
            let [errors_before, errors_now] =
                [&both[0], &both[1]].map(|d| d.iter().map(|d| d.error().rmse).collect::<Vec<_>>());
            kept = kept_share(&errors_before, &errors_now);
            if !UNCLEAR.contains(&kept) {
                break;
            }
            sums = Some(both);
        }
        kept
    }
}

fn kept_share(before: &[f64], now: &[f64]) -> f64 {
    let share = |(&before, &now): (&f64, &f64)| if now == 0.0 { 0.0 } else { now / before };
    before.iter().zip(now).map(share).fold(0.0, f64::max)
}

/// The surface of a mesh with its vertices at other positions.
fn measurable(mesh: &Mesh, positions: &[[f32; 3]]) -> Measurable {
    measurable_of(mesh.triangles(), |v| positions[v as usize])
}

/// The surface of triangles, given the positions of their corners.
pub(super) fn measurable_of(triangles: &[[u32; 3]], at: impl Fn(u32) -> [f32; 3]) -> Measurable {
    Measurable::new(triangles.iter().map(|t| t.map(&at)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::PoseKey;
    use lodc_scene::{Graph, Motion, Node};

    #[test]
    fn no_shape_is_spoilt() {
        let noise = noise();
        let node = Node { objects: vec![0], ..Node::default() };
        let graph = Graph { roots: vec![0], nodes: vec![node], skins: Vec::new() };
        let motion = Motion::new(graph, Vec::new(), 1);
        let mesh = lodc_fixtures::named("morphing_sphere").expect("a shape");
        let coordinates = vec![Coordinates::PLAIN; mesh.submeshes().len()];
        let texture = NoiseTexture { coordinates: &coordinates, noise: &noise };
        let options = lodc_simplify::Options::DEFAULT;
        let object = object_of("sphere", lodc_simplify::simplify(&mesh, &options, &|_, _| {}));
        let input = object.simplified.mesh();
        let shapes = motion.shapes(input, 0, &[PoseKey::Target(0), PoseKey::Target(1)]);
        assert_eq!(shapes.all().len(), 3);
        let originals = Originals::new(shapes.all(), input);
        for part in [2, 4, 8, 20] {
            let triangles = mesh.triangles().len() as u32 / part;
            let lod = object.simplified.collapses().lod_for_triangles(triangles);
            let unmoved = Refit::new(&object.simplified, lod, &Options::DEFAULT, &|| ()).unmoved();
            let growth = Growth::Little;
            let (moved, stated) = refitted(&object, lod, shapes.all(), texture, growth, &|| ());
            let level = moved.unwrap_or_else(|| unmoved.clone());
            let [before, after] = [&unmoved, &level].map(|mesh| originals.distances(mesh));
            for (before, after) in before.iter().zip(&after) {
                assert!(after.upper <= MAX_BOUND_GROWTH * before.upper, "{after:?} {before:?}");
            }
            assert_eq!(stated, largest(&after));
        }
    }

    fn object_of(name: &str, simplified: lodc_mesh::Simplified) -> LodObject {
        let info = ObjectInfo {
            name: name.to_string(),
            submeshes: Vec::new(),
            world_scale: 1.0,
            poses: vec![],
            document_mesh: 0,
        };
        LodObject { info, simplified: Arc::new(simplified), models: Vec::new() }
    }

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
            let coordinates = vec![Coordinates::PLAIN; mesh.submeshes().len()];
            let texture = NoiseTexture { coordinates: &coordinates, noise: &noise };
            let object = object_of(name, simplified);
            let unmoved = Refit::new(&object.simplified, lod, &Options::DEFAULT, &|| ()).unmoved();
            let judge = Judge::new(&mesh, &unmoved, texture).expect("attributes");
            let shapes = [Shape::AS_MODELLED];
            let (level, ..) = refitted(&object, lod, &shapes, texture, Growth::Little, &|| ());
            let is_held = level.is_none();
            assert!(level.is_none_or(|l| judge.kept_share(&l) <= BETTER), "{name}");
            held += u32::from(is_held);
            moved += u32::from(!is_held);
        }
        assert!(moved > 0 && held > 0, "{moved} moved, {held} held back");
    }

    #[test]
    fn the_kind_of_picture_that_gains_least_decides() {
        assert_eq!(kept_share(&[2.0, 4.0], &[1.0, 3.0]), 0.75);
        assert_eq!(kept_share(&[2.0, 0.0], &[1.0, 0.0]), 0.5);
        assert!(kept_share(&[2.0, 0.0], &[1.0, 0.1]).is_infinite());
    }
}
