//! The checks of shipped levels, as engines load them, against the mesh that they were made from:
//! errors, vertices, facing, and everything else.

use super::facing::{Facing, Moved};
use super::report::CheckReport;
use glam::DVec3;
use lodc_formats::import::document_difference;
use lodc_formats::{
    Document, FormatError, Limits, ObjectInfo, Scene, SceneObject, ShippedLevels, scene_motion,
};
use lodc_measure::{Original, Sampling, Surface};
use lodc_mesh::{Attribute, Mesh, Posture, Semantic};
use lodc_scene::{Arrangement, Motion, Placement, posed, representative};

/// A measured distance may be at most this many times the error that a level states. Chosen by
/// hand: stated errors are made from samples.
const MAX_MEASURED: f64 = 1.05;

/// The error that a level states may be at most this many times its largest distance. Chosen by
/// hand: errors never fall from level to level, so that some are above their distance.
const MAX_STATED: f64 = 1.5;

/// Fewer samples than by default: around the farthest of them triangles are searched. Chosen by
/// hand.
const SAMPLING: Sampling = Sampling { samples: 20_000, lattice: 30_000, seed: 0x1e7e1 };

/// Distances below this share of the diagonal are rounding errors, or not worth a refusal. Chosen
/// by hand.
const NEGLIGIBLE_SHARE: f64 = 1e-6;

/// Checks levels against the mesh that they were made from: that it is this one, that each errs no
/// more than it states, that vertices are the mesh's, that nothing but geometry changed, and that
/// levels of one file share what they should.
///
/// # Errors
/// If a stored document is damaged.
pub fn check_levels(
    shipped: &ShippedLevels,
    source: &Scene,
    limits: &Limits,
) -> Result<Vec<CheckReport>, FormatError> {
    let stated = &shipped.stated;
    let (ours, theirs) = (stated.source, source.source.content_hash);
    let other = (ours != theirs).then(|| {
        format!("the levels are of a mesh with hash {ours:032x}, this one's is {theirs:032x}")
    });
    let mut checks = vec![CheckReport::new(None, "source", "levels are of this mesh").of(1, other)];
    let report = |check| CheckReport::new(None, "levels", check);
    let count = shipped.levels.len() as u64;

    let measure = Measure::new(source, stated.poses.as_deref(), limits)?;
    let error = |number: usize, level: &Scene| {
        measure.difference(level, stated.levels[number].error, limits)
    };
    checks.push(report("errors hold").of(count, first(shipped, error)?));

    let has_source_values =
        !stated.refitted && shipped.levels.iter().all(|level| keeps_values(level, source));
    checks.push(if has_source_values {
        let vertices = Vertices::of(source);
        report("vertices are the input's")
            .of(count, first(shipped, |_, level| Ok(vertices.difference(level)))?)
    } else {
        let why = "values were refitted, quantised, compressed or put into another format";
        CheckReport { skipped: Some(why.to_owned()), ..report("vertices are the input's") }
    });

    let facings: Vec<Facing> = source.objects.iter().map(|o| Facing::of(&o.mesh)).collect();
    let turned = |_, level: &Scene| Ok(turned(level, source, &facings, stated.refitted));
    checks.push(report("triangles face as the input's").of(count, first(shipped, turned)?));

    let document =
        |_, level: &Scene| document_difference(&source.document, &level.document, limits);
    checks.push(report("nothing else changed").of(count, first(shipped, document)?));
    if count > 1 {
        checks.push(report("levels share vertices").of(count, shipped.difference.clone()));
    }
    Ok(checks)
}

/// The first difference that `check` finds in a level.
fn first(
    shipped: &ShippedLevels,
    check: impl Fn(usize, &Scene) -> Result<Option<String>, FormatError>,
) -> Result<Option<String>, FormatError> {
    for (number, level) in shipped.levels.iter().enumerate() {
        if let Some(what) = check(number, level)? {
            return Ok(Some(format!("level {number}: {what}")));
        }
    }
    Ok(None)
}

/// The source, prepared for measuring levels.
struct Measure<'a> {
    source: &'a Scene,
    motion: Motion,
    /// The poses of each object that its errors are the largest over; none if that is not known.
    poses: Option<&'a [Vec<Posture>]>,
    units: Units,
    diagonal: f64,
}

/// The units of what is compared: coordinates near the origin, in the units of stated errors.
#[derive(Clone, Copy)]
struct Units {
    /// A point of the source, in world space.
    origin: DVec3,
    /// World units per unit: one object states errors in its own.
    world: f64,
}

impl<'a> Measure<'a> {
    fn new(
        source: &'a Scene,
        poses: Option<&'a [Vec<Posture>]>,
        limits: &Limits,
    ) -> Result<Self, FormatError> {
        let motion = motion(source, limits)?;
        let world = match &source.objects[..] {
            [one] => one.info.world_scale,
            _ => 1.0,
        };
        let first_placement = motion.rest().placements().first();
        let first_placement =
            first_placement.map(|at| posed(&source.objects[at.object].mesh, at).positions);
        let origin =
            first_placement.and_then(|positions| positions.first().copied()).unwrap_or_default();
        let units = Units { origin, world };
        let diagonal = scene_surface(source, motion.rest(), units).diagonal();
        Ok(Self { source, motion, poses, units, diagonal })
    }

    /// Returns a difference if a level has a larger error than it states, or a far smaller one.
    fn difference(
        &self,
        level: &Scene,
        stated: f64,
        limits: &Limits,
    ) -> Result<Option<String>, FormatError> {
        if !stated.is_finite() {
            // A level without triangles: every distance is within its error.
            return Ok(None);
        }
        let shown = motion(level, limits)?;
        let pairs = self.pairs(level, &shown);
        let pairs: Vec<_> =
            pairs.iter().map(|[from, to]| (Original::new(from, &SAMPLING), to)).collect();
        let measured = |(original, to): &(Original, &Surface)| {
            original.distances(to).hausdorff.into_iter().fold(0.0, f64::max)
        };
        let largest = pairs.iter().map(measured).fold(0.0, f64::max);
        let negligible = NEGLIGIBLE_SHARE * self.diagonal;
        if largest > MAX_MEASURED * stated + negligible {
            return Ok(Some(format!("the error is {stated}, measured are {largest}")));
        }
        let allowed =
            |distance| MAX_STATED * distance + self.rounding(level, shown.rest()) + negligible;
        // Errors may be the largest over poses that are not known, as in an OBJ.
        let bends = self.source.objects.iter().any(|o| bends(&o.mesh));
        let poses_known = !bends || self.poses.is_some() && !self.is_flattened(level);
        if !poses_known || stated <= allowed(largest) || pairs.len() < self.source.objects.len() {
            return Ok(None);
        }
        // Samples may miss a small part, so only an upper bound shows that the error is too large.
        let bound = pairs.iter().map(|(original, to)| original.bound_and_rms(to).0);
        let bound = bound.fold(0.0, f64::max);
        let what = || format!("the error is {stated}, no point is farther than {bound}");
        Ok((stated > allowed(bound)).then(what))
    }

    /// Half the diagonal of a cell of the coarsest grid that a level's vertices are on, which
    /// stated errors include.
    fn rounding(&self, level: &Scene, shown: &Arrangement) -> f64 {
        if !has_own_grids(level, self.source) {
            return 0.0;
        }
        // Coordinates are whole numbers, so the scale of an object's placement is the step of its
        // grid.
        let step = |(o, object): (usize, &SceneObject)| representative(&object.mesh, o, shown).1;
        let largest = level.objects.iter().enumerate().map(step).fold(0.0, f64::max);
        0.5 * 3f64.sqrt() * largest / self.units.world
    }

    /// Returns whether a level does not have the source's objects one by one: it is one mesh, or
    /// some of them are gone.
    fn is_flattened(&self, level: &Scene) -> bool {
        let is_one = !level.source.format.is_gltf();
        is_one || level.objects.len() != self.source.objects.len()
    }

    /// Surfaces of the source and of a level that belong together: of each object at rest and in
    /// the poses that its errors are the largest over.
    fn pairs(&self, level: &Scene, shown: &Motion) -> Vec<[Surface; 2]> {
        if self.is_flattened(level) {
            let [source, level] = [(self.source, &self.motion), (level, shown)];
            let surface = |(scene, motion): (&Scene, &Motion)| {
                scene_surface(scene, motion.rest(), self.units)
            };
            return vec![[source, level].map(surface)];
        }
        let object_pairs = |object: usize| {
            let meshes = [&self.source.objects[object].mesh, &level.objects[object].mesh];
            let as_modelled = Placement::as_modelled(object);
            let (source_at, _) = representative(meshes[0], object, self.motion.rest());
            let source_at = source_at.unwrap_or(&as_modelled);
            let level_at = same_placement(source_at, self.motion.rest(), shown.rest());
            let level_at = level_at.unwrap_or(&as_modelled);
            let pair = |placements: [&Placement; 2]| {
                [0, 1].map(|side| {
                    let mut surface = Surface::default();
                    add(&mut surface, meshes[side], placements[side], self.units);
                    surface
                })
            };
            let in_pose = |&pose: &Posture| {
                let placements =
                    [self.motion.placed(source_at, pose)?, shown.placed(level_at, pose)?];
                Some(pair(placements.each_ref()))
            };
            let poses =
                self.poses.and_then(|poses| poses.get(object)).map_or(&[][..], Vec::as_slice);
            std::iter::once(pair([source_at, level_at]))
                .chain(poses.iter().filter_map(in_pose))
                .collect::<Vec<_>>()
        };
        (0..level.objects.len()).flat_map(object_pairs).collect()
    }
}

/// The placement of a level's object that corresponds to one of the source. Their nodes come in the
/// same order: an object on a grid has been moved to a child of its node.
fn same_placement<'a>(
    at: &Placement,
    source: &Arrangement,
    level: &'a Arrangement,
) -> Option<&'a Placement> {
    let number = source.of(at.object).position(|other| std::ptr::eq(other, at))?;
    level.of(at.object).nth(number).or_else(|| level.of(at.object).next())
}

fn motion(scene: &Scene, limits: &Limits) -> Result<Motion, FormatError> {
    let infos: Vec<&ObjectInfo> = scene.objects.iter().map(|o| &o.info).collect();
    scene_motion(&scene.document, &infos, limits)
}

/// Returns whether joints or morph targets may give a mesh another shape.
fn bends(mesh: &Mesh) -> bool {
    let moves =
        |a: &Attribute| matches!(a.semantic, Semantic::Joints(_)) || a.morph_target.is_some();
    mesh.attributes().iter().any(moves)
}

/// The surface of everything that a scene shows.
fn scene_surface(scene: &Scene, arrangement: &Arrangement, units: Units) -> Surface {
    let mut all = Surface::default();
    for placement in arrangement.placements() {
        add(&mut all, &scene.objects[placement.object].mesh, placement, units);
    }
    all
}

fn add(surface: &mut Surface, mesh: &Mesh, placement: &Placement, units: Units) {
    let first = surface.positions.len() as u32;
    let positions = posed(mesh, placement).positions;
    surface
        .positions
        .extend(positions.iter().map(|&p| ((p - units.origin) / units.world).as_vec3()));
    surface.triangles.extend(mesh.triangles().iter().map(|t| t.map(|v| first + v)));
}

/// Returns whether the values of a level were put on grids that are not the source's.
fn has_own_grids(level: &Scene, source: &Scene) -> bool {
    level.quantized && (level.requantized || !source.quantized)
}

/// Returns whether a level has the bits of the source's values.
fn keeps_values(level: &Scene, source: &Scene) -> bool {
    let same_kind = match (&source.document, &level.document) {
        (Document::Gltf(_), Document::Gltf(_)) => !has_own_grids(level, source),
        (Document::Obj(_), Document::Obj(_)) => true,
        _ => false,
    };
    same_kind && (!level.compressed || source.compressed)
}

/// Returns which triangle of a level is turned over. Objects correspond by their numbers or, where
/// some are gone, by their names; one that corresponds to none is only checked if all objects of
/// the source are closed.
fn turned(level: &Scene, source: &Scene, facings: &[Facing], is_refitted: bool) -> Option<String> {
    let moved = match has_own_grids(level, source) {
        true => Moved::IntoOtherUnits,
        false if is_refitted || !keeps_values(level, source) => Moved::Freely,
        false => Moved::ToPositions,
    };
    let object_of_name = |object: &SceneObject| {
        let mut same =
            (0..source.objects.len()).filter(|&o| source.objects[o].info.name == object.info.name);
        same.next().filter(|_| same.next().is_none())
    };
    let all_closed = facings.iter().all(Facing::is_closed);
    let all_there = level.objects.len() == source.objects.len();
    level.objects.iter().enumerate().find_map(|(o, object)| {
        let source_object = if all_there { Some(o) } else { object_of_name(object) };
        let facing = &facings[source_object.or(all_closed.then_some(0))?];
        let triangle = facing.turned_over(&object.mesh, moved)?;
        Some(format!("{}: triangle {triangle} is turned over", object.info.name))
    })
}

/// The vertices of the source, object by object: the bytes of their positions, and apart from these
/// the bytes of their other values. A vertex may move to a position at which none has its values,
/// so that pairs of both would refuse too much.
struct Vertices {
    /// For each object the positions and the other values, sorted.
    by_object: Vec<[Vec<Vec<u8>>; 2]>,
}

impl Vertices {
    fn of(source: &Scene) -> Self {
        let sets = |object: &SceneObject| {
            let (positions, values) = vertices(&object.mesh).map(<(_, _)>::from).unzip();
            [positions, values].map(|mut all: Vec<Vec<u8>>| {
                all.sort_unstable();
                all.dedup();
                all
            })
        };
        Self { by_object: source.objects.iter().map(sets).collect() }
    }

    /// Searches for the vertices of each object among those of the source's object; where objects
    /// are gone, among those of all.
    fn difference(&self, level: &Scene) -> Option<String> {
        let all_there = level.objects.len() == self.by_object.len();
        level.objects.iter().enumerate().find_map(|(o, object)| {
            let source_vertices =
                if all_there { &self.by_object[o..=o] } else { &self.by_object[..] };
            let is_in_source = |(kind, bytes): (usize, &Vec<u8>)| {
                source_vertices.iter().any(|sets| sets[kind].binary_search(bytes).is_ok())
            };
            vertices(&object.mesh).enumerate().find_map(|(v, vertex)| {
                let kind = vertex.iter().enumerate().position(|bytes| !is_in_source(bytes))?;
                let what = ["position", "values"][kind];
                let name = &object.info.name;
                Some(format!("{name}: the source has no vertex with the {what} of vertex {v}"))
            })
        })
    }
}

/// The bytes of each vertex: first its position with what belongs to it, as joints and offsets of
/// morph targets do, then its other attributes, each after its meaning.
fn vertices(mesh: &Mesh) -> impl Iterator<Item = [Vec<u8>; 2]> {
    let meaning = |a: &Attribute| format!("{:?}{:?}", a.semantic, a.morph_target).into_bytes();
    let meanings: Vec<Vec<u8>> = mesh.attributes().iter().map(meaning).collect();
    (0..mesh.vertex_count() as u32).map(move |v| {
        let position = mesh.positions()[v as usize].iter().flat_map(|x| x.to_bits().to_le_bytes());
        let mut bytes = [position.collect(), Vec::new()];
        let submesh = mesh.vertex_submesh()[v as usize] as usize;
        for number in mesh.submeshes()[submesh].attributes.iter().map(|&a| a as usize) {
            let attribute = &mesh.attributes()[number];
            let kind = &mut bytes[usize::from(!attribute.is_spatial())];
            kind.extend(&meanings[number]);
            kind.extend(attribute.at(v));
        }
        bytes
    })
}
