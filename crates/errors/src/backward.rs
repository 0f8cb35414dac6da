//! The backward pass: how far new faces are from the input. *E* is the largest distance so far.

use crate::block::{Block, StepView, TouchedFace};
use crate::gap::{Moved, fan_gap};
use crate::input::Input;
use crate::origin::Origin;
use crate::settings::Settings;
use crate::work::{ROUNDING_SQUARED, Work};
use glam::DVec3;
use lodc_nearest::{
    FarthestSearch, MovingSurface, Query, Surface, TriangleSearcher, area, centroid, point_at,
};

/// The search for a triangle near one of the four points of a face ends within this share of E. A
/// face with a point beyond the second share is searched as a whole. Without these points errors of
/// up to 1.9 E went unseen; the shares are chosen by hand.
const NEAR_ENOUGH: f64 = 0.39;
const SEARCHED_BEYOND: f64 = 0.5;

/// Where no more faces than this are left, every one is searched as a whole: faces are large there,
/// and four points say little of them. Doing so always takes twice the time on the bunny.
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
    pub(crate) block: Block,
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
    searcher: TriangleSearcher,
    /// E², the square of the largest distance so far, of either pass.
    max_squared: f64,
    /// Sums over faces: of area times mean squared distance, and of area.
    area_times_squared: f64,
    area: f64,
    work: Work,
    /// Work of the forward pass at the end of the block.
    forward_work: Work,
    /// The border of the fan that a step removes.
    link: Vec<DVec3>,
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
        Self {
            input,
            settings,
            faces,
            searcher: TriangleSearcher::new(FarthestSearch::for_size(input.diagonal)),
            max_squared: 0.0,
            area_times_squared: 0.0,
            area,
            work: Work::default(),
            forward_work: Work::default(),
            link: vec![],
        }
    }

    /// Follows the steps of a block, or the first of them if the limit of work is reached.
    pub(crate) fn run(&mut self, block: Block) -> FollowedBlock {
        let mut distances = Vec::with_capacity(block.steps.len());
        self.forward_work = block.work;
        for view in block.views() {
            if (self.work + self.forward_work).exceeds_limit(self.input) {
                break;
            }
            self.max_squared = self.max_squared.max(view.step.max_squared);
            self.work.0 += view.touched.len() as u64;
            if !view.touched.is_empty() {
                self.follow(view);
            }
            let (sum, area) = (self.area_times_squared, self.area);
            let mean_square = if area > 0.0 { (sum / area).max(0.0) } else { 0.0 };
            distances.push(StepDistances { max_squared: self.max_squared, mean_square });
        }
        FollowedBlock { block, distances, max_squared: self.max_squared, work: self.work }
    }

    /// Decides how far every face of a step is from the input, and sets its mean distance.
    fn follow(&mut self, view: StepView<'_>) {
        let fan_bound = self.fan_bound(view);
        let max_distance = self.max_squared.max(ROUNDING_SQUARED).sqrt();
        for &touched in view.touched {
            if !touched.is_live {
                self.set_mean(touched.face, 0.0, 0.0);
                continue;
            }
            let corners = self.input.corners_of(touched.points);
            match fan_bound {
                Some(bound) if bound <= max_distance => {
                    self.faces[touched.face as usize].max_distance = bound as f32;
                }
                // Where a fan became a smaller one, no hole hides between the four points.
                Some(_)
                    if view.step.live_faces > FEW_FACES
                        && !self.is_far_at_points(touched, corners) => {}
                _ => self.search_face(touched, corners),
            }
            let is_small = self.input.triangles.len() <= self.settings.exhaustive_triangles;
            let mean_square = match f64::from(touched.mean_square) {
                _ if is_small => Some(self.mean_square_at(touched.face, corners, &NINE_POINTS)),
                mean if !mean.is_nan() => Some(mean),
                _ if self.settings.look_up_means => {
                    Some(self.mean_square_at(touched.face, corners, &[CENTROID]))
                }
                _ => None,
            };
            match mean_square {
                Some(mean) => self.set_mean(touched.face, mean, area(corners) as f32),
                None => self.set_mean(touched.face, 0.0, 0.0),
            }
        }
    }

    /// Returns how far the new faces are from the input at most, where a closed fan became a
    /// smaller one: the gap between both fans, and how far the old one was.
    fn fan_bound(&mut self, view: StepView<'_>) -> Option<f64> {
        let faces = view.touched.iter().map(|touched| (touched.is_live, touched.points));
        let moved = Moved { source: view.step.source, targets: view.targets };
        let gap = fan_gap(self.input, moved, faces, &mut self.link)?;
        let old = |touched: &TouchedFace| f64::from(self.faces[touched.face as usize].max_distance);
        Some((gap + view.touched.iter().map(old).fold(0.0, f64::max)) * ROUND_UP)
    }

    /// Measures the centroid of a face and the midpoints of its edges. Returns whether one is so
    /// far that another point of the face may be beyond E.
    fn is_far_at_points(&mut self, touched: TouchedFace, corners: [DVec3; 3]) -> bool {
        self.update_hint(touched);
        let Self { input, work, max_squared, .. } = self;
        let face = &mut self.faces[touched.face as usize];
        let surface = MovingSurface { triangles: *input, tree: &input.tree };
        let max_boxes = (*work + self.forward_work).boxes_nearest(input);
        let mut farthest_squared = 0.0f64;
        let [a, b, c] = corners;
        for p in [centroid(corners), (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5] {
            let enough = (*max_squared * (NEAR_ENOUGH * NEAR_ENOUGH))
                .max(ROUNDING_SQUARED)
                .max(farthest_squared);
            let query = Query { point: p, hint: face.hint, enough, max_boxes };
            let (hit, opened_boxes) = surface.near(query);
            face.hint = hit.triangle;
            farthest_squared = farthest_squared.max(hit.squared);
            work.0 += u64::from(opened_boxes) + 1;
        }
        face.max_distance = farthest_squared.sqrt() as f32;
        farthest_squared
            > (*max_squared * (SEARCHED_BEYOND * SEARCHED_BEYOND)).max(ROUNDING_SQUARED)
    }

    /// Looks for a point of a face that is beyond E, and raises E to its distance.
    fn search_face(&mut self, touched: TouchedFace, corners: [DVec3; 3]) {
        self.update_hint(touched);
        let Self { input, work, searcher, max_squared, .. } = self;
        let face = &mut self.faces[touched.face as usize];
        let distance = max_squared.max(ROUNDING_SQUARED).sqrt();
        let surface = MovingSurface { triangles: *input, tree: &input.tree };
        let max_boxes = (*work + self.forward_work).boxes_farthest(input);
        let found = searcher.search(distance, corners, face.hint, &surface, max_boxes);
        face.max_distance = (found.upper * ROUND_UP) as f32;
        if found.lower > distance {
            *max_squared = found.lower * found.lower;
        }
        work.0 += found.opened_boxes;
    }

    fn update_hint(&mut self, TouchedFace { face, origin, .. }: TouchedFace) {
        if origin != Origin::NONE {
            self.faces[face as usize].hint = origin.triangles(self.input).as_slice()[0];
        }
    }

    /// Returns the mean squared distance of points of a face, given by barycentric coordinates.
    fn mean_square_at(&mut self, face: u32, corners: [DVec3; 3], points: &[[f64; 3]]) -> f64 {
        let Self { input, work, .. } = self;
        let hint = &mut self.faces[face as usize].hint;
        let surface = MovingSurface { triangles: *input, tree: &input.tree };
        let max_boxes = (*work + self.forward_work).boxes_nearest(input);
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
    fn set_mean(&mut self, face: u32, mean_square: f64, area: f32) {
        let f = &mut self.faces[face as usize];
        let (old_mean, old_area) = (f64::from(f.mean_square), f64::from(f.area));
        (f.mean_square, f.area) = (mean_square as f32, area);
        self.area_times_squared +=
            f64::from(f.mean_square) * f64::from(f.area) - old_mean * old_area;
        self.area += f64::from(f.area) - old_area;
    }
}
