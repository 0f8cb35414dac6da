//! What one level errs: the distances between two surfaces, of which only the triangles are known.
//! Everything that is stated of levels stands on this: it decides what the pass over all steps
//! proposes, and what `lodc verify` accepts.

use crate::Tick;
use crate::cover::cover_bound;
use crate::difference::{Difference, Estimate};
use crate::input::Input;
use crate::rough::RoughSquare;
use crate::settings::Limits;
use crate::step_errors::round_up;
use glam::DVec3;
use lodc_mesh::{Lod, NONE, Simplified, is_degenerate};
use lodc_nearest::{
    Farthest, FarthestSearch, MovingSurface, MovingTree, Surface, Triangles, area, is_within,
};
use rayon::prelude::*;

/// The tree over a level is that of the input, refitted, while no fewer faces are left than the
/// input has triangles, divided by this. Chosen by hand.
const REFITTED_DIVISOR: usize = 4;

/// Distances up to this share of the diagonal count as 0: single precision rounds coordinates by
/// more.
const FLOOR_SHARE: f64 = 2e-8;

/// How far a level is from LOD 0, in the mesh's units; infinite where a mesh that had triangles has
/// none left.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelError {
    /// An upper bound of the Hausdorff distance between both surfaces, about 2 % above it.
    pub error: f32,
    /// The root mean square distance over the area, the larger of both ways, from samples.
    pub rms: f32,
}

/// Measures some levels of a sequence, each by itself, without those before it: the largest
/// distances over all `shapes`, each a position for every vertex. A level may be nearer than a
/// finer one, and than [`measure`](crate::measure) states of it, which never falls.
///
/// All threads share the work; the result is the same with any number.
///
/// # Panics
/// If there are not as many positions as vertices in a shape.
#[must_use]
pub fn at_levels<S: AsRef<[[f32; 3]]>>(
    simplified: &Simplified,
    shapes: impl IntoIterator<Item = S>,
    lods: &[Lod],
    tick: &Tick<'_>,
) -> Vec<LevelError> {
    let mut errors = vec![LevelError::default(); lods.len()];
    for shape in shapes {
        let posed = shape.as_ref();
        assert_eq!(posed.len(), simplified.mesh().vertex_count(), "a position for each vertex");
        let (input, corner_vertices) = Input::new(simplified, posed);
        let original = Original::new(&input, simplified, &corner_vertices, Limits::DEFAULT);
        for (level, &lod) in errors.iter_mut().zip(lods) {
            tick();
            let known_distance = f64::from(level.error) / input.mesh_scale;
            let known_distance = known_distance / (1.0 + original.search.tolerance);
            let found = original.measure(lod, known_distance, Limits::DEFAULT.samples, None);
            let [error, rms] = [found.upper, found.rms].map(|d| round_up(d * input.mesh_scale));
            *level = LevelError { error: level.error.max(error), rms: level.rms.max(rms) };
        }
    }
    errors
}

/// LOD 0, ready for levels to be measured from it.
pub(crate) struct Original<'a> {
    pub(crate) input: &'a Input,
    simplified: &'a Simplified,
    /// The corners of the input's triangles as vertices of the mesh.
    corner_vertices: &'a [[u32; 3]],
    /// The area of each triangle, and of all.
    areas: Vec<f32>,
    area: f64,
    search: FarthestSearch,
}

/// Distances of a level from LOD 0, in units of the input's coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LevelDistances {
    /// A point of one of both surfaces is at least this far from the other, or this distance was
    /// known before.
    pub(crate) lower: f64,
    /// No point is farther.
    pub(crate) upper: f64,
    /// The root mean square distance.
    pub(crate) rms: f64,
    /// Boxes that were opened: the work that it took.
    pub(crate) boxes: u64,
}

impl LevelDistances {
    fn same(distance: f64) -> Self {
        Self { lower: distance, upper: distance, rms: distance, boxes: 0 }
    }
}

impl<'a> Original<'a> {
    pub(crate) fn new(
        input: &'a Input,
        simplified: &'a Simplified,
        corner_vertices: &'a [[u32; 3]],
        limits: Limits,
    ) -> Self {
        let [per_triangle, per_input, besides] = limits.boxes_per_level;
        let triangles = u32::try_from(input.triangles.len()).unwrap_or(u32::MAX);
        let boxes = [per_triangle, per_input.saturating_mul(triangles).saturating_add(besides)];
        let floor = FLOOR_SHARE * input.diagonal;
        let search = FarthestSearch { boxes, floor, ..FarthestSearch::for_size(input.diagonal) };
        let areas: Vec<f32> =
            (0..input.triangles.len() as u32).map(|t| area(input.corners(t)) as f32).collect();
        let area = areas.iter().copied().map(f64::from).sum();
        Self { input, simplified, corner_vertices, areas, area, search }
    }

    /// Returns the bound that is good enough where a distance is known.
    pub(crate) fn accepted(&self, known_distance: f64) -> f64 {
        self.search.accepted(known_distance)
    }

    /// Distances up to this are rounding errors.
    pub(crate) fn rounding(&self) -> f64 {
        2.0 * self.search.floor
    }

    /// Measures a level. Distances up to `known_distance`, which some point is known to be away,
    /// are not searched closely. `samples` points on either surface make the mean.
    ///
    /// `rough` may tell about how far each triangle of the input is: then of very many some are
    /// searched, the farthest by it and others spread over the surface, and all only if one of
    /// those is beyond the known distance.
    pub(crate) fn measure(
        &self,
        lod: Lod,
        known_distance: f64,
        samples: usize,
        rough: Option<&[RoughSquare]>,
    ) -> LevelDistances {
        let Self { input, search, .. } = self;
        let level = LevelSurface::new(self, lod);
        if level.face_count == 0 {
            let has_lost_all = !input.triangles.is_empty();
            return LevelDistances::same(if has_lost_all { f64::INFINITY } else { 0.0 });
        }
        if level.changed_triangles.is_empty() {
            return LevelDistances { lower: known_distance, ..LevelDistances::same(0.0) };
        }
        let corners = |t: u32| level.faces[t as usize].map(|p| input.coordinates[p as usize]);
        let tree = if level.face_count >= input.triangles.len() / REFITTED_DIVISOR {
            let moved = |t: u32| level.faces[t as usize] != input.triangles[t as usize];
            input.tree.refitted(|t| level.is_live(t).then(|| (corners(t), moved(t))))
        } else {
            let live = (0..level.faces.len() as u32).filter(|&t| level.is_live(t));
            MovingTree::of_some(live, corners)
        };
        let to_level = MovingSurface { triangles: &level, tree: &tree };
        let to_input = MovingSurface { triangles: *input, tree: &input.tree };
        let areas = |&t: &u32| self.areas[t as usize];
        let only_input =
            Difference::new(level.changed_triangles.iter().map(areas).collect(), self.area, |i| {
                level.changed_triangle(i)
            });
        let areas = |&t: &u32| area(level.corners(t)) as f32;
        let only_level =
            Difference::new(level.changed_faces.par_iter().map(areas).collect(), level.area, |i| {
                level.changed_face(i)
            });

        let accepted = search.accepted(known_distance);
        let rough = rough.filter(|_| known_distance > 0.0);
        let forward = || {
            let estimates = match rough {
                Some(rough) => only_input.known(|i| rough[level.changed_triangles[i] as usize]),
                None => only_input.estimate(&to_level),
            };
            (only_input.sample(&estimates, &to_level, samples), estimates)
        };
        let backward = || {
            let estimates = match rough {
                Some(rough) => only_level.known(|i| rough[level.changed_faces[i] as usize]),
                None => only_level.estimate(&to_input),
            };
            (only_level.sample(&estimates, &to_input, samples), estimates)
        };
        let ((forward_sampled, triangle_estimates), (backward_sampled, face_estimates)) =
            rayon::join(forward, backward);
        // The distance of a sample is a lower bound.
        let sampled = forward_sampled.max_distance.max(backward_sampled.max_distance);
        let is_known = rough.is_some() && sampled <= accepted;
        let known_distance = known_distance.max(sampled);
        let limit = search.accepted(known_distance);
        let find = |chosen: [Option<Vec<u32>>; 2]| {
            let [triangles, faces] = &chosen;
            rayon::join(
                || {
                    let of = |i: usize| (only_input.corners(i), triangle_estimates[i].near);
                    farthest_of(search, known_distance, triangles, only_input.len(), of, &to_level)
                },
                || {
                    let faces = level.not_covered(faces, limit, &face_estimates, &to_input);
                    let of = |i: usize| (only_level.corners(i), face_estimates[i].near);
                    farthest_of(search, known_distance, &Some(faces), 0, of, &to_input)
                },
            )
        };
        let (mut there, mut back) = find(if is_known {
            [only_input.choose(&triangle_estimates), only_level.choose(&face_estimates)]
        } else {
            [None, None]
        });
        if is_known && there.upper.max(back.upper) > search.accepted(limit) {
            (there, back) = find([None, None]);
        }
        // Faces that need no search are within the limit.
        let covered = if back.upper > 0.0 || !level.changed_faces.is_empty() { limit } else { 0.0 };
        let mean_square = forward_sampled.mean_square.max(backward_sampled.mean_square);
        let upper = there.upper.max(back.upper).max(covered).min(input.diagonal);
        let upper = if upper <= self.rounding() { 0.0 } else { upper };
        LevelDistances {
            lower: there.lower.max(back.lower).min(upper),
            upper,
            rms: mean_square.sqrt().min(upper),
            boxes: there.opened_boxes
                + back.opened_boxes
                + forward_sampled.boxes
                + backward_sampled.boxes,
        }
    }
}

/// The faces of a level, whose corners are points of the input.
struct LevelSurface<'a> {
    input: &'a Input,
    /// What each triangle of the input has become; [`NONE`] for corners of those that are gone.
    faces: Vec<[u32; 3]>,
    /// Number of faces that are left.
    face_count: usize,
    /// Triangles of the input that the level does not have.
    changed_triangles: Vec<u32>,
    /// Faces that the input does not have.
    changed_faces: Vec<u32>,
    /// The area of the whole level.
    area: f64,
}

impl<'a> LevelSurface<'a> {
    fn new(original: &Original<'a>, lod: Lod) -> Self {
        let Original { input, simplified, corner_vertices, .. } = *original;
        let vertex_at_lod = simplified.collapses().resolve_all(lod);
        let mut level = Self {
            input,
            faces: Vec::with_capacity(input.triangles.len()),
            face_count: 0,
            changed_triangles: vec![],
            changed_faces: vec![],
            area: original.area,
        };
        // Triangles that both surfaces have are nowhere apart. Corners are points of `Input`: a
        // position of the mesh, by which triangles are degenerate, and its coordinates in the
        // shape.
        for (t, (&points, vertices)) in (0..).zip(input.triangles.iter().zip(corner_vertices)) {
            let moved = vertices.map(|v| input.point_of_vertex[vertex_at_lod[v as usize] as usize]);
            let is_live = !is_degenerate(moved.map(|p| input.position_ids[p as usize]));
            level.face_count += usize::from(is_live);
            level.faces.push(if is_live { moved } else { [NONE; 3] });
            if points != moved {
                level.changed_triangles.push(t);
                level.area -= f64::from(original.areas[t as usize]);
                if is_live {
                    level.changed_faces.push(t);
                    level.area += area(input.corners_of(moved));
                }
            }
        }
        level
    }

    /// The corners of a triangle that only the input has, and the face that it has become.
    fn changed_triangle(&self, i: usize) -> ([DVec3; 3], u32) {
        let triangle = self.changed_triangles[i];
        (self.input.corners(triangle), if self.is_live(triangle) { triangle } else { NONE })
    }

    /// The corners of a face that only the level has, and the triangle that it was.
    fn changed_face(&self, i: usize) -> ([DVec3; 3], u32) {
        let face = self.changed_faces[i];
        (self.corners(face), face)
    }

    /// Returns those of the changed faces, or of some `chosen` ones, that have to be searched: all
    /// but those that one triangle, or triangles above and below, are near enough to.
    fn not_covered(
        &self,
        chosen: &Option<Vec<u32>>,
        limit: f64,
        estimates: &[Estimate],
        input: &(impl Surface + Sync),
    ) -> Vec<u32> {
        let is_left = |buffer: &mut Vec<u32>, i: u32| {
            let face = self.changed_faces[i as usize];
            let near = input.corners(estimates[i as usize].near);
            let is_near = |c: &DVec3| is_within(*c, near, limit * limit);
            if self.corners(face).iter().all(is_near) {
                return None;
            }
            let points = self.faces[face as usize];
            cover_bound(self.input, points, limit, buffer).is_none().then_some(i)
        };
        let count = self.changed_faces.len() as u32;
        let left: Vec<Option<u32>> = match chosen {
            Some(chosen) => chosen.par_iter().map_init(Vec::new, |b, &i| is_left(b, i)).collect(),
            None => (0..count).into_par_iter().map_init(Vec::new, is_left).collect(),
        };
        left.into_iter().flatten().collect()
    }
}

/// Looks for the point of some triangles, those of `chosen` or all `count`, that is farthest from a
/// surface. `of` returns the corners of each, and a triangle that is probably near.
fn farthest_of(
    search: &FarthestSearch,
    known_distance: f64,
    chosen: &Option<Vec<u32>>,
    count: usize,
    of: impl Fn(usize) -> ([DVec3; 3], u32) + Sync,
    to: &(impl Surface + Sync),
) -> Farthest {
    match chosen {
        Some(chosen) => {
            let of = |i: usize| of(chosen[i] as usize);
            search.farthest_with_hints(known_distance, chosen.len(), of, to)
        }
        None => search.farthest_with_hints(known_distance, count, of, to),
    }
}

impl Triangles for LevelSurface<'_> {
    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.input.corners_of(self.faces[triangle as usize])
    }
    #[inline]
    fn is_live(&self, triangle: u32) -> bool {
        self.faces[triangle as usize][0] != NONE
    }
}
