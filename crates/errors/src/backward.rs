//! The backward pass: how far new faces are from the input. *E* is the largest distance so far.

use crate::block::{Block, StepView, TouchedFace};
use crate::components::Components;
use crate::gap::{Moved, fan_gap};
use crate::input::Input;
use crate::origin::Origin;
use crate::settings::Settings;
use crate::work::{ROUNDING_SQUARED, Work};
use glam::DVec3;
use lodc_nearest::{
    FarthestSearch, MovingSurface, Query, Surface, TriangleSearcher, area, centroid, point_at,
};
use rayon::prelude::*;

/// The search for a triangle near one of the four points of a face ends within this share of E. A
/// face with a point beyond the second share is searched as a whole. Without these points errors of
/// up to 1.9 E went unseen; with a second share of 0.8, 1.1 E (spot at 8 %).
const NEAR_ENOUGH: f64 = 0.39;
const SEARCHED_BEYOND: f64 = 0.6;

/// Where no more faces than this are left, every one is searched as a whole: faces are large there,
/// and four points say little of them. With 150, three of 5,000 mutated meshes have levels up to
/// 1.24 times as far as they state; doing so always takes twice the time on the bunny.
const FEW_FACES: u32 = 600;

/// Bounds on distances are rounded up by this, more than an `f32` loses.
const ROUND_UP: f64 = 1.0 + 1e-6;

/// Barycentric coordinates of a triangle's centroid, and of the centroids of nine equal parts.
const CENTROID: [f64; 3] = [1.0 / 3.0; 3];
const NINE_POINTS: [[f64; 3]; 9] = [
    [7.0 / 9.0, 1.0 / 9.0, 1.0 / 9.0],
    [1.0 / 9.0, 7.0 / 9.0, 1.0 / 9.0],
    [1.0 / 9.0, 1.0 / 9.0, 7.0 / 9.0],
    [4.0 / 9.0, 4.0 / 9.0, 1.0 / 9.0],
    [4.0 / 9.0, 1.0 / 9.0, 4.0 / 9.0],
    [1.0 / 9.0, 4.0 / 9.0, 4.0 / 9.0],
    [5.0 / 9.0, 2.0 / 9.0, 2.0 / 9.0],
    [2.0 / 9.0, 5.0 / 9.0, 2.0 / 9.0],
    [2.0 / 9.0, 2.0 / 9.0, 5.0 / 9.0],
];

/// A face of the level, or one that was.
#[derive(Clone, Copy, Debug)]
struct Face {
    /// A triangle of the input that is probably near its centroid.
    hint: u32,
    /// Its area, and the mean squared distance over it; 0 where that is not known.
    area: f32,
    mean_square: f32,
    /// No point of it is farther from the input than this, as far as samples can know.
    max_distance: f32,
}

/// Distances after a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepDistances {
    /// E² of both passes.
    pub(crate) max_squared: f64,
    /// The mean squared distance over the faces.
    pub(crate) mean_square: f64,
}

/// A block that the backward pass has followed.
pub(crate) struct FollowedBlock {
    /// Distances after each of its steps; fewer if the limit of work was reached.
    pub(crate) distances: Vec<StepDistances>,
    /// E² and the work of the backward pass at its end.
    pub(crate) max_squared: f64,
    pub(crate) work: Work,
}

/// The faces of the level, and how far they are from the input.
pub(crate) struct Backward<'a> {
    input: &'a Input,
    settings: Settings,
    faces: Vec<Face>,
    components: Components,
    /// E², the square of the largest distance so far, of either pass.
    max_squared: f64,
    /// Sums over faces: of area times mean squared distance, and of area.
    area_times_squared: f64,
    area: f64,
    work: Work,
}

impl<'a> Backward<'a> {
    /// Starts at LOD 0.
    pub(crate) fn new(input: &'a Input, settings: Settings) -> Self {
        let face = |(triangle, &points)| {
            let area = area(input.corners_of(points)) as f32;
            Face { hint: triangle, area, mean_square: 0.0, max_distance: 0.0 }
        };
        let faces: Vec<Face> = (0..).zip(&input.triangles).map(face).collect();
        let area = faces.iter().map(|f| f64::from(f.area)).sum();
        let components = Components::new(faces.len());
        Self {
            input,
            settings,
            faces,
            components,
            max_squared: 0.0,
            area_times_squared: 0.0,
            area,
            work: Work::default(),
        }
    }

    /// Follows the steps of a block, or the first of them if the limit of work is reached.
    ///
    /// Its components are followed in parallel. Each knows E as it was before the block, what the
    /// forward pass knew of it at each step, and what it finds itself.
    pub(crate) fn run(&mut self, block: &Block) -> FollowedBlock {
        let Self { input, settings, components, .. } = self;
        components.find(block);
        let face_of = |&face: &u32| self.faces[face as usize];
        let mut faces: Vec<Face> = components.faces.values.iter().map(face_of).collect();
        let mut tasks = Vec::with_capacity(components.faces.rows());
        let mut faces_left = &mut faces[..];
        for component in 0..components.faces.rows() as u32 {
            let range = components.faces.range(component);
            let (faces, others) = faces_left.split_at_mut(range.len());
            tasks.push((range.start as u32, faces, components.steps.row(component)));
            faces_left = others;
        }
        type Buffers = (TriangleSearcher, Vec<DVec3>);
        let follow = |(searcher, link): &mut Buffers, (first_face, faces, steps)| {
            let component = Component {
                input,
                settings: *settings,
                first_face,
                faces,
                searcher,
                link,
                max_squared: self.max_squared,
                work_before: self.work + block.work,
                work: Work::default(),
            };
            component.follow_all(block, &components.face_indices, steps)
        };
        let search = FarthestSearch::for_size(input.diagonal);
        let buffers = || (TriangleSearcher::new(search), Vec::new());
        let followed: Vec<FollowedComponent> =
            tasks.into_par_iter().map_init(buffers, follow).collect();
        for (&face, after) in components.faces.values.iter().zip(faces) {
            self.faces[face as usize] = after;
        }
        self.join(block, followed)
    }

    /// Puts together what was found in the components of a block, step by step.
    fn join(&mut self, block: &Block, followed: Vec<FollowedComponent>) -> FollowedBlock {
        let has_reached_limit = (self.work + block.work).exceeds_limit(self.input);
        let mut steps = vec![FollowedStep::UNTOUCHED; block.steps.len()];
        for component in followed {
            self.work = self.work + component.work;
            component.steps.into_iter().for_each(|(step, found)| steps[step as usize] = found);
        }
        let mut distances = Vec::with_capacity(block.steps.len());
        for (step, found) in block.steps.iter().zip(steps) {
            if has_reached_limit || !found.is_followed {
                break;
            }
            self.max_squared = self.max_squared.max(step.max_squared).max(found.max_squared);
            self.area_times_squared += found.area_times_squared;
            self.area += found.area;
            let (sum, area) = (self.area_times_squared, self.area);
            let mean_square = if area > 0.0 { (sum / area).max(0.0) } else { 0.0 };
            distances.push(StepDistances { max_squared: self.max_squared, mean_square });
        }
        FollowedBlock { distances, max_squared: self.max_squared, work: self.work }
    }
}

/// What a step of a component changed.
#[derive(Clone, Copy, Debug)]
struct FollowedStep {
    /// Whether it was followed: not if the limit of work was reached before.
    is_followed: bool,
    /// E² as far as the component knows.
    max_squared: f64,
    /// How the sums over faces change: of area times mean squared distance, and of area.
    area_times_squared: f64,
    area: f64,
}

impl FollowedStep {
    /// A step that touches no face.
    const UNTOUCHED: Self =
        Self { is_followed: true, max_squared: 0.0, area_times_squared: 0.0, area: 0.0 };
    /// A step after the limit of work was reached.
    const NOT_REACHED: Self = Self { is_followed: false, ..Self::UNTOUCHED };
}

/// The steps of a component, each with its index in the block, and the work that they took.
struct FollowedComponent {
    steps: Vec<(u32, FollowedStep)>,
    work: Work,
}

/// Faces that steps of a block touch and no other step does.
struct Component<'a> {
    input: &'a Input,
    settings: Settings,
    /// The index of its first face among those of the block.
    first_face: u32,
    faces: &'a mut [Face],
    /// Buffers: for searches, and for the border of the fan that a step removes.
    searcher: &'a mut TriangleSearcher,
    link: &'a mut Vec<DVec3>,
    /// E² as far as it is known here.
    max_squared: f64,
    /// Work of both passes before, and of this component.
    work_before: Work,
    work: Work,
}

impl Component<'_> {
    /// Follows its steps, given by their indices in the block. `face_indices` has the index of each
    /// touched face among those of the block.
    fn follow_all(
        mut self,
        block: &Block,
        face_indices: &[u32],
        steps: &[u32],
    ) -> FollowedComponent {
        let follow = |&step: &u32| {
            if (self.work_before + self.work).exceeds_limit(self.input) {
                return (step, FollowedStep::NOT_REACHED);
            }
            let view = block.view(step as usize);
            self.max_squared = self.max_squared.max(view.step.max_squared);
            self.work.0 += view.touched.len() as u64;
            let end = view.step.touched_end as usize;
            (step, self.follow(view, &face_indices[end - view.touched.len()..end]))
        };
        let steps = steps.iter().map(follow).collect();
        FollowedComponent { steps, work: self.work }
    }

    /// Decides how far every face of a step is from the input, and sets its mean distance.
    fn follow(&mut self, view: StepView<'_>, face_indices: &[u32]) -> FollowedStep {
        let first_face = self.first_face;
        let touched = || {
            let indices = face_indices.iter().map(|&index| (index - first_face) as usize);
            view.touched.iter().copied().zip(indices)
        };
        let sums_before = self.sums(touched().map(|(_, face)| face));
        let old_bounds = touched().map(|(_, face)| f64::from(self.faces[face].max_distance));
        let old_bound = old_bounds.fold(0.0, f64::max);
        let fan_bound = self.fan_gap(view).map(|gap| (gap + old_bound) * ROUND_UP);
        let max_distance = self.max_squared.max(ROUNDING_SQUARED).sqrt();
        for (touched, face) in touched() {
            if !touched.is_live {
                self.set_mean(face, 0.0, 0.0);
                continue;
            }
            let corners = self.input.corners_of(touched.points);
            match fan_bound {
                Some(bound) if bound <= max_distance => {
                    self.faces[face].max_distance = bound as f32;
                }
                // Where a fan became a smaller one, no hole hides between the four points.
                Some(_)
                    if view.step.live_faces > FEW_FACES
                        && !self.is_far_at_points(touched, face, corners) => {}
                _ => self.search_face(touched, face, corners),
            }
            let is_small = self.settings.is_exhaustive(self.input.triangles.len());
            let mean_square = match f64::from(touched.mean_square) {
                _ if is_small => Some(self.mean_square_at(face, corners, &NINE_POINTS)),
                mean if !mean.is_nan() => Some(mean),
                _ if self.settings.look_up_means => {
                    Some(self.mean_square_at(face, corners, &[CENTROID]))
                }
                _ => None,
            };
            match mean_square {
                Some(mean) => self.set_mean(face, mean, area(corners) as f32),
                None => self.set_mean(face, 0.0, 0.0),
            }
        }
        let sums = self.sums(touched().map(|(_, face)| face));
        FollowedStep {
            is_followed: true,
            max_squared: self.max_squared,
            area_times_squared: sums[0] - sums_before[0],
            area: sums[1] - sums_before[1],
        }
    }

    /// Returns sums over some faces: of area times mean squared distance, and of area.
    fn sums(&self, faces: impl Iterator<Item = usize>) -> [f64; 2] {
        faces.map(|face| &self.faces[face]).fold([0.0, 0.0], |[squared, area], face| {
            let (mean_square, face_area) = (f64::from(face.mean_square), f64::from(face.area));
            [squared + mean_square * face_area, area + face_area]
        })
    }

    /// Returns how far the new faces are from the old ones at most, where a closed fan became a
    /// smaller one.
    fn fan_gap(&mut self, view: StepView<'_>) -> Option<f64> {
        let faces = view.touched.iter().map(|touched| (touched.is_live, touched.points));
        let moved = Moved { source: view.step.source, targets: view.targets };
        fan_gap(self.input, moved, faces, self.link)
    }

    /// Measures the centroid of a face and the midpoints of its edges. Returns whether one is so
    /// far that another point of the face may be beyond E.
    fn is_far_at_points(&mut self, touched: TouchedFace, face: usize, corners: [DVec3; 3]) -> bool {
        self.update_hint(touched, face);
        let max_boxes = (self.work_before + self.work).boxes_nearest(self.input);
        let Self { input, work, max_squared, .. } = self;
        let face = &mut self.faces[face];
        let surface = MovingSurface { triangles: *input, tree: &input.tree };
        let share_of_max = |share: f64| (*max_squared * (share * share)).max(ROUNDING_SQUARED);
        let mut farthest_squared = 0.0f64;
        let [a, b, c] = corners;
        for p in [centroid(corners), (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5] {
            let enough = share_of_max(NEAR_ENOUGH).max(farthest_squared);
            let query = Query { point: p, hint: face.hint, enough, max_boxes };
            let (hit, opened_boxes) = surface.near(query);
            face.hint = hit.triangle;
            farthest_squared = farthest_squared.max(hit.squared);
            work.0 += u64::from(opened_boxes) + 1;
            if farthest_squared > share_of_max(SEARCHED_BEYOND) {
                return true;
            }
        }
        face.max_distance = farthest_squared.sqrt() as f32;
        false
    }

    /// Looks for a point of a face that is beyond E, and raises E to its distance.
    fn search_face(&mut self, touched: TouchedFace, face: usize, corners: [DVec3; 3]) {
        self.update_hint(touched, face);
        let max_boxes = (self.work_before + self.work).boxes_farthest(self.input);
        let Self { input, work, searcher, max_squared, .. } = self;
        let face = &mut self.faces[face];
        let distance = max_squared.max(ROUNDING_SQUARED).sqrt();
        let surface = MovingSurface { triangles: *input, tree: &input.tree };
        let found = searcher.search(distance, corners, face.hint, &surface, max_boxes);
        face.max_distance = (found.upper * ROUND_UP) as f32;
        if found.lower > distance {
            *max_squared = found.lower * found.lower;
        }
        work.0 += found.opened_boxes;
    }

    fn update_hint(&mut self, TouchedFace { origin, .. }: TouchedFace, face: usize) {
        if origin != Origin::NONE {
            self.faces[face].hint = origin.triangles(self.input).as_slice()[0];
        }
    }

    /// Returns the mean squared distance of points of a face, given by barycentric coordinates.
    fn mean_square_at(&mut self, face: usize, corners: [DVec3; 3], points: &[[f64; 3]]) -> f64 {
        let max_boxes = (self.work_before + self.work).boxes_nearest(self.input);
        let Self { input, work, .. } = self;
        let hint = &mut self.faces[face].hint;
        let surface = MovingSurface { triangles: *input, tree: &input.tree };
        let mut sum = 0.0;
        for &barycentric in points {
            let point = point_at(corners, barycentric);
            let query = Query { point, hint: *hint, enough: 0.0, max_boxes };
            let (hit, opened_boxes) = surface.near(query);
            *hint = hit.triangle;
            work.0 += u64::from(opened_boxes) + 1;
            sum += hit.squared;
        }
        sum / points.len() as f64
    }

    /// Sets the mean squared distance and the area of a face.
    fn set_mean(&mut self, face: usize, mean_square: f64, area: f32) {
        (self.faces[face].mean_square, self.faces[face].area) = (mean_square as f32, area);
    }
}
