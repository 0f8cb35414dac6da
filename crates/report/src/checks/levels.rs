//! The checks of exported levels, as engines load them, against the mesh that they were made from:
//! errors, vertices, facing, and everything else.

use super::facing::{Facing, Moved};
use super::report::CheckReport;
use glam::DVec3;
use lodc::geomorph::bends;
use lodc::pipeline::{Distances, Measurable};
use lodc_formats::import::document_difference;
use lodc_formats::{
    Document, ExportedLevels, FormatError, Limits, ObjDocument, ObjectInfo, Scene, SceneObject,
    scene_motion,
};
use lodc_mesh::{Attribute, Component, Mesh, PoseKey, Semantic};
use lodc_scene::{
    Arrangement, Graph, MeasuredPlacement, Motion, Node, Placement, Stretch, Transform,
    largest_stretch, posed_positions,
};
use rayon::prelude::*;
use std::borrow::Cow;

/// A measured distance may be at most this many times the error that a level states. Chosen by
/// hand: stated errors are made from samples.
const MAX_MEASURED: f64 = 1.05;

/// The error that a level states may be at most this many times its largest distance. Chosen by
/// hand: errors never fall from level to level, so that some are above their distance.
const MAX_STATED: f64 = 1.5;

/// The same for root mean square distances, either way; both are from samples, and stated ones
/// never fall from level to level. Chosen by hand.
const MAX_RMS_RATIO: f64 = 1.3;

/// Root mean square distances that differ by no more than this share of the error are not refused:
/// a small part of the surface decides them. Chosen by hand.
const RMS_SLACK: f64 = 0.004;

/// Of the distance below which an error is too large, the share that is not searched closely: how
/// much too large it is does not matter.
const UNSEARCHED_SHARE: f64 = 0.9;

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
    exported: &ExportedLevels,
    source: &Scene,
    limits: &Limits,
) -> Result<Vec<CheckReport>, FormatError> {
    let stated = &exported.stated;
    let (ours, theirs) = (stated.source, source.source.content_hash);
    let other = (ours != theirs).then(|| {
        format!("the levels are of a mesh with hash {ours:032x}, this one's is {theirs:032x}")
    });
    let mut checks = vec![CheckReport::new(None, "source", "levels are of this mesh").of(1, other)];
    let report = |check| CheckReport::new(None, "levels", check);
    let levels: Vec<Cow<'_, Scene>> =
        exported.levels.iter().map(|level| about_source(level, source)).collect();
    let count = levels.len() as u64;

    let measure = Measure::new(source, stated.poses.as_deref(), limits)?;
    let error = |number: usize, level: &Scene| {
        let facts = &stated.levels[number];
        measure.difference(level, facts.error, facts.rms, limits)
    };
    checks.push(report("errors hold").of(count, first(&levels, error)?));

    let has_source_values =
        !stated.refitted && levels.iter().all(|level| keeps_values(level, source));
    checks.push(if has_source_values {
        let vertices = Vertices::of(source);
        report("vertices are the input's")
            .of(count, first(&levels, |_, level| Ok(vertices.difference(level)))?)
    } else {
        let why = "values were refitted, quantised, compressed or put into another format";
        CheckReport { skipped: Some(why.to_owned()), ..report("vertices are the input's") }
    });

    let facings: Vec<Facing> = source.objects.iter().map(|o| Facing::of(&o.mesh)).collect();
    let turned = |_, level: &Scene| Ok(turned(level, source, &facings, stated.refitted));
    checks.push(report("triangles face as the input's").of(count, first(&levels, turned)?));

    let document =
        |_, level: &Scene| document_difference(&source.document, &level.document, limits);
    checks.push(report("nothing else changed").of(count, first(&levels, document)?));
    if count > 1 {
        checks.push(report("levels share vertices").of(count, exported.difference.clone()));
    }
    Ok(checks)
}

/// The first difference that `check` finds in a level.
fn first(
    levels: &[Cow<'_, Scene>],
    check: impl Fn(usize, &Scene) -> Result<Option<String>, FormatError>,
) -> Result<Option<String>, FormatError> {
    for (number, level) in levels.iter().enumerate() {
        if let Some(what) = check(number, level)? {
            return Ok(Some(format!("level {number}: {what}")));
        }
    }
    Ok(None)
}

/// A level with its mesh about the same offset as its source's, where these are OBJ or PLY files
/// far from the origin.
fn about_source<'a>(level: &'a Scene, source: &Scene) -> Cow<'a, Scene> {
    let (Document::Obj(to), Document::Obj(from)) = (&source.document, &level.document) else {
        return Cow::Borrowed(level);
    };
    if to.offset == from.offset {
        return Cow::Borrowed(level);
    }
    let mut moved = level.clone();
    let by: [f64; 3] = std::array::from_fn(|k| from.offset[k] - to.offset[k]);
    for object in &mut moved.objects {
        let mut parts = object.mesh.clone().into_parts();
        for p in &mut parts.positions {
            *p = std::array::from_fn(|k| (f64::from(p[k]) + by[k]) as f32);
        }
        // Slivers may lose a corner: then the level stays where it is, and is found to differ.
        let Ok(mesh) = Mesh::try_from(parts) else { return Cow::Borrowed(level) };
        object.mesh = mesh;
    }
    moved.document = Document::Obj(ObjDocument { offset: to.offset, ..from.clone() });
    Cow::Owned(moved)
}

/// The source, prepared for measuring levels.
struct Measure<'a> {
    source: &'a Scene,
    motion: Motion,
    /// The poses of each object that its errors are the largest over; none if that is not known.
    poses: Option<&'a [Vec<PoseKey>]>,
    /// The middle of the source's box, in world space.
    origin: DVec3,
    /// The diagonal of that box.
    diagonal: f64,
    /// Whether an animation stretches an object otherwise than at rest.
    stretches: bool,
    /// At least 1: errors may be larger by this factor than they are in any placement and pose.
    looseness: f64,
}

impl<'a> Measure<'a> {
    fn new(
        source: &'a Scene,
        poses: Option<&'a [Vec<PoseKey>]>,
        limits: &Limits,
    ) -> Result<Self, FormatError> {
        let motion = motion(source, limits)?;
        let [low, high] = scene_box(source, motion.rest());
        let (origin, diagonal) = match low.cmple(high).all() {
            true => (low.midpoint(high), low.distance(high)),
            false => (DVec3::ZERO, 0.0),
        };
        let (mut stretches, mut looseness) = (false, 1.0f64);
        for (number, object) in source.objects.iter().enumerate() {
            let measured = motion.measured_placements(&object.mesh, number);
            stretches |= measured.placements.iter().any(|at| at.stretch != Stretch::AtRest);
            // Morph targets of what has unlike placements are measured in the largest scale.
            if bends(&object.mesh) && measured.placements.len() > 1 {
                looseness = looseness.max(measured.unevenness);
            }
        }
        Ok(Self { source, motion, poses, origin, diagonal, stretches, looseness })
    }

    /// Returns a difference if a level is farther from the source than it states, or far nearer.
    fn difference(
        &self,
        level: &Scene,
        stated: f64,
        stated_rms: Option<f64>,
        limits: &Limits,
    ) -> Result<Option<String>, FormatError> {
        if !stated.is_finite() {
            // A level without triangles: every distance is within its error.
            return Ok(None);
        }
        let shown = motion(level, limits)?;
        let pairs = self.pairs(level, &shown);
        let negligible = NEGLIGIBLE_SHARE * self.diagonal;
        let slack = negligible + self.rounding(level, &shown);
        let looseness = MAX_STATED * self.looseness;
        // A distance of which the stated error is not too large.
        let least = (stated - slack).max(0.0) / looseness;
        let measured = |closely: bool| {
            let of = |[from, to]: &[Measurable; 2]| {
                from.check_distances(UNSEARCHED_SHARE * least, to, closely)
            };
            pairs.par_iter().map(of).reduce(Distances::default, Distances::max)
        };
        let Distances { lower, upper, rms } = measured(false);
        if lower > MAX_MEASURED * stated + negligible {
            return Ok(Some(format!("the error is {stated}, but {lower} was measured")));
        }
        // Errors may be the largest over poses that are not known, as in an OBJ.
        let bends = self.stretches || self.source.objects.iter().any(|o| bends(&o.mesh));
        let poses_known = !bends || self.poses.is_some() && !self.is_flattened(level);
        // What rounded weights of joints do to a vertex depends on where its joints have it.
        let may_be_too_large = poses_known
            && pairs.len() >= self.source.objects.len()
            && !rounds_weights(level, self.source);
        // A point that is known to be far enough may be missed, so that only the upper bound shows
        // that the error is too large.
        if may_be_too_large && least > upper {
            return Ok(Some(format!("the error is {stated}, no point is farther than {upper}")));
        }
        let Some(stated_rms) = stated_rms else { return Ok(None) };
        let slack = slack + RMS_SLACK * stated;
        let most = |rms: f64| MAX_RMS_RATIO * self.looseness * rms + slack;
        // The mean over a whole scene is not that of the object in which it is largest.
        let may_be_too_large = may_be_too_large && !self.is_flattened(level);
        let is_near = |rms: f64| {
            rms <= MAX_RMS_RATIO * stated_rms + slack
                && (!may_be_too_large || stated_rms <= most(rms))
        };
        if is_near(rms) {
            return Ok(None);
        }
        let Distances { rms, .. } = measured(true);
        let what =
            || format!("the root mean square distance is {stated_rms}, but {rms} was measured");
        Ok((!is_near(rms)).then(what))
    }

    /// Half the diagonal of a cell of the coarsest grid that a level's vertices are on, for what is
    /// at rest and for each morph target as much as it counts: stated errors include that.
    fn rounding(&self, level: &Scene, shown: &Motion) -> f64 {
        if !has_own_grids(level, self.source) {
            return 0.0;
        }
        let of_object = |(o, object): (usize, &SceneObject)| {
            // Coordinates are whole numbers, so the scale of an object's placement is the step of
            // its grid.
            let measured = shown.measured_placements(&object.mesh, o);
            let step = match measured.placements.first() {
                Some(at) if at.placement.node.is_some() => measured.scale,
                _ => largest_stretch(&self.unshown(level, shown, o).transform.matrix3),
            };
            step * (1.0 + self.largest_weights(o))
        };
        let largest = level.objects.iter().enumerate().map(of_object).fold(0.0, f64::max);
        0.5 * 3f64.sqrt() * largest
    }

    /// The largest sum of the weights of an object's morph targets, whatever their signs, in the
    /// shapes that its errors are the largest over.
    fn largest_weights(&self, object: usize) -> f64 {
        if object >= self.source.objects.len() {
            return 0.0;
        }
        let rest = || self.motion.rest().of(object);
        let poses = self.poses.and_then(|poses| poses.get(object)).map_or(&[][..], Vec::as_slice);
        let movers = std::iter::once(0).chain(self.motion.movers_besides(object, 0));
        let posed = movers
            .filter_map(|number| rest().nth(number))
            .flat_map(|rest| poses.iter().filter_map(|&pose| self.motion.placed(rest, pose)));
        let sum = |placement: &Placement| placement.weights.iter().map(|w| w.abs()).sum::<f64>();
        rest().map(sum).chain(posed.map(|placement| sum(&placement))).fold(0.0, f64::max)
    }

    /// An object that a level does not show, in the numbers of the source's mesh.
    fn unshown(&self, level: &Scene, shown: &Motion, object: usize) -> Placement {
        let as_modelled = Placement::as_modelled(object);
        if !has_own_grids(level, self.source) {
            return as_modelled;
        }
        let shows = |node: &&Node| node.objects.contains(&(object as u32));
        let skin = |graph: &Graph| -> Option<Transform> {
            let node = graph.nodes.iter().find(shows)?;
            graph.skins.get(node.skin? as usize)?.inverse_bind.first().copied()
        };
        let [from, to] = [self.motion.graph(), shown.graph()];
        let transform = match [skin(from), skin(to)] {
            [Some(from), Some(to)] => from.inverse() * to,
            // An object on a grid has been moved to a child of its node, behind all others.
            _ => to
                .nodes
                .iter()
                .skip(from.nodes.len())
                .find(shows)
                .map_or(Transform::IDENTITY, |node| node.local.matrix()),
        };
        Placement { transform, ..as_modelled }
    }

    /// Returns whether a level does not have the source's objects one by one: it is one mesh, or
    /// some of them are gone.
    fn is_flattened(&self, level: &Scene) -> bool {
        let is_one = !level.source.format.is_gltf();
        is_one || level.objects.len() != self.source.objects.len()
    }

    /// Surfaces of the source and of a level that belong together: of each object in the placements
    /// and the poses that its errors are the largest over.
    fn pairs(&self, level: &Scene, shown: &Motion) -> Vec<[Measurable; 2]> {
        if self.is_flattened(level) {
            let [source, level] = [(self.source, &self.motion), (level, shown)];
            let surface =
                |(scene, motion): (&Scene, &Motion)| self.scene_surface(scene, motion.rest());
            return vec![[source, level].map(surface)];
        }
        let object_pairs = |object: usize| {
            let meshes = [&self.source.objects[object].mesh, &level.objects[object].mesh];
            let as_modelled = Placement::as_modelled(object);
            let measured = self.motion.measured_placements(meshes[0], object).placements;
            let source_rest = |number: usize| self.motion.rest().of(object).nth(number).cloned();
            let level_rest = |number: usize| {
                let all = || shown.rest().of(object);
                // An object on a grid has been moved to a child of its node: nodes come in the same
                // order.
                let at = all().nth(number).or_else(|| all().next()).filter(|at| at.node.is_some());
                at.cloned().unwrap_or_else(|| self.unshown(level, shown, object))
            };
            let pair = |placements: [&Placement; 2], growth: f64| {
                let posed = [0, 1].map(|side| posed_positions(meshes[side], placements[side]));
                let origin = posed[0].first().copied().unwrap_or_default();
                [0, 1].map(|side| {
                    let at = |p: DVec3| (p - origin) * growth;
                    Measurable::new(triangles(meshes[side], &posed[side], at))
                })
            };
            let in_placement = |at: &MeasuredPlacement| {
                let level_at = shown.stretched_as(at, &level_rest(at.rest))?;
                Some(pair([&at.placement, &level_at], at.growth))
            };
            let poses =
                self.poses.and_then(|poses| poses.get(object)).map_or(&[][..], Vec::as_slice);
            let in_pose = |(at, &pose): (&MeasuredPlacement, &PoseKey)| {
                let rest = [source_rest(at.rest)?, level_rest(at.rest)];
                // What has no joints is moved and stretched as in the placement.
                let moved = |motion: &Motion, rest: &Placement| match rest.joints.is_empty() {
                    true => motion.stretched_as(at, rest),
                    false => Some(rest.clone()),
                };
                let at_pose = |motion: &Motion, rest| motion.placed(&moved(motion, rest)?, pose);
                let placements = [at_pose(&self.motion, &rest[0])?, at_pose(shown, &rest[1])?];
                Some(pair(placements.each_ref(), at.growth))
            };
            let is_moment = |pose: &&PoseKey| matches!(pose, PoseKey::Moment { .. });
            let by_itself = |(number, &pose): (usize, &PoseKey)| {
                let rest = [source_rest(number)?, level_rest(number)];
                let source_at = self.motion.placed(&rest[0], pose)?;
                Some(pair([&source_at, &shown.placed(&rest[1], pose)?], 1.0))
            };
            let first_rest = measured.first().map_or(0, |at| at.rest);
            let movers = self.motion.movers_besides(object, first_rest);
            let by_themselves = movers
                .iter()
                .flat_map(|&number| poses.iter().filter(is_moment).map(move |pose| (number, pose)));
            // Poses of morph targets change one placement at a time: they are those of the first.
            let first = measured.first().map(|at| &at.placement);
            let is_posed = |(number, at): &(usize, &MeasuredPlacement)| {
                let alike = |first: &Placement| {
                    first.joints.is_empty() && first.weights == at.placement.weights
                };
                *number == 0 || first.is_some_and(alike)
            };
            let posed = measured.iter().enumerate().filter(is_posed).map(|(_, at)| at);
            let in_poses = posed.flat_map(|at| poses.iter().map(move |pose| (at, pose)));
            let mut pairs: Vec<_> = measured.iter().filter_map(in_placement).collect();
            if measured.is_empty() {
                pairs.push(pair([&as_modelled, &self.unshown(level, shown, object)], 1.0));
            }
            pairs.extend(in_poses.filter_map(in_pose));
            pairs.extend(by_themselves.filter_map(by_itself));
            pairs
        };
        (0..level.objects.len()).into_par_iter().flat_map_iter(object_pairs).collect()
    }

    /// The surface of everything that a scene shows.
    fn scene_surface(&self, scene: &Scene, arrangement: &Arrangement) -> Measurable {
        let of = |placement: &Placement| {
            let mesh = &scene.objects[placement.object].mesh;
            let posed = posed_positions(mesh, placement);
            triangles(mesh, &posed, |p| p - self.origin).collect::<Vec<_>>()
        };
        Measurable::new(arrangement.placements().iter().flat_map(of))
    }
}

/// The triangles of a mesh with its vertices at `posed`, each moved by `at`.
fn triangles(
    mesh: &Mesh,
    posed: &[DVec3],
    at: impl Fn(DVec3) -> DVec3,
) -> impl Iterator<Item = [[f32; 3]; 3]> {
    mesh.triangles().iter().map(move |t| t.map(|v| at(posed[v as usize]).as_vec3().into()))
}

/// The lowest and the highest corner of a box around everything that a scene shows: of objects
/// without joints and morph weights around their boxes.
fn scene_box(scene: &Scene, arrangement: &Arrangement) -> [DVec3; 2] {
    let of_placement = |placement: &Placement| {
        let mesh = &scene.objects[placement.object].mesh;
        let bends = !placement.joints.is_empty() || placement.weights.iter().any(|&w| w != 0.0);
        let points = if bends {
            posed_positions(mesh, placement)
        } else {
            let (low, high) = mesh.bounds();
            let corner = |i: usize| {
                let coordinate =
                    |k: usize| f64::from(if i >> k & 1 == 0 { low[k] } else { high[k] });
                DVec3::from(std::array::from_fn::<f64, 3, _>(coordinate))
            };
            (0..8).map(|i| placement.transform.transform_point3(corner(i))).collect()
        };
        let finite = points.into_iter().filter(|p| p.is_finite());
        finite.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| {
            [low.min(p), high.max(p)]
        })
    };
    let boxes = arrangement.placements().par_iter().map(of_placement);
    boxes.reduce(
        || [DVec3::INFINITY, DVec3::NEG_INFINITY],
        |[low, high], [other_low, other_high]| [low.min(other_low), high.max(other_high)],
    )
}

fn motion(scene: &Scene, limits: &Limits) -> Result<Motion, FormatError> {
    let infos: Vec<&ObjectInfo> = scene.objects.iter().map(|o| &o.info).collect();
    scene_motion(&scene.document, &infos, limits)
}

/// Returns whether the values of a level were put on grids that are not the source's.
fn has_own_grids(level: &Scene, source: &Scene) -> bool {
    level.quantized && (level.requantized || !source.quantized)
}

/// Returns whether weights of joints that are floats in the source were rounded.
fn rounds_weights(level: &Scene, source: &Scene) -> bool {
    let has_floats = |mesh: &Mesh| {
        let is_float = |a: &Attribute| {
            matches!(a.semantic, Semantic::Weights(_)) && a.component == Component::F32
        };
        mesh.attributes().iter().any(is_float)
    };
    let mut pairs = level.objects.iter().zip(&source.objects);
    has_own_grids(level, source)
        && pairs.any(|(level, source)| has_floats(&source.mesh) && !has_floats(&level.mesh))
}

/// Returns whether a level has the bits of the source's values.
fn keeps_values(level: &Scene, source: &Scene) -> bool {
    let same_kind = match (&source.document, &level.document) {
        (Document::Gltf(_), Document::Gltf(_)) => !has_own_grids(level, source),
        // What stands at an offset is rounded anew by every file.
        (Document::Obj(a), Document::Obj(b)) => [a, b].iter().all(|obj| obj.offset == [0.0; 3]),
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
