//! The backward pass: how far new faces are from the input. *E* is the largest distance so far.

use crate::block::{Block, StepView, TouchedFace};
use crate::components::Components;
use crate::gap::{Moved, fan_gap};
use crate::input::Input;
use crate::origin::Origin;
use crate::settings::{FEW_TRIANGLES, Limits};
use crate::work::{ROUNDING_SQUARED, Work};
use glam::DVec3;
use lodc_nearest::{FarthestSearch, MovingSurface, TriangleSearcher};
use rayon::prelude::*;

/// Every new face is searched in meshes of few triangles; in larger ones where no more faces are
/// left than the first, or than the mesh has triangles, divided by the second. Chosen by hand: of
/// scans a level at 1.5 % was farther than it stated with 600 faces.
const FEW_FACES: u32 = 4_096;
const FEW_DIVISOR: u32 = 32;

/// Bounds on distances are rounded up by this, more than an `f32` loses.
const ROUND_UP: f64 = 1.0 + 1e-6;

/// A face of the level, or one that was.
#[derive(Clone, Copy, Debug)]
struct Face {
    /// A triangle of the input that is probably near its centroid.
    hint: u32,
    /// No point of it is farther from the input than this, as far as samples can know.
    max_distance: f32,
}

/// A block that the backward pass has followed.
pub(crate) struct FollowedBlock {
    /// E² of both passes after each of its steps; fewer if the limit of work was reached.
    pub(crate) max_squared_at: Vec<f64>,
    /// E² and the work of the backward pass at its end.
    pub(crate) max_squared: f64,
    pub(crate) work: Work,
}

/// The faces of the level, and how far they are from the input.
pub(crate) struct Backward<'a> {
    input: &'a Input,
    limits: Limits,
    faces: Vec<Face>,
    components: Components,
    /// E², the square of the largest distance so far, of either pass.
    max_squared: f64,
    work: Work,
}

impl<'a> Backward<'a> {
    /// Starts at LOD 0.
    pub(crate) fn new(input: &'a Input, limits: Limits) -> Self {
        let face = |hint| Face { hint, max_distance: 0.0 };
        let faces: Vec<Face> = (0..input.triangles.len() as u32).map(face).collect();
        let components = Components::new(faces.len());
        Self { input, limits, faces, components, max_squared: 0.0, work: Work::default() }
    }

    /// Follows the steps of a block, or the first of them if the limit of work is reached.
    ///
    /// Its components are followed in parallel. Each knows E as it was before the block, what the
    /// forward pass knew of it at each step, and what it finds itself.
    pub(crate) fn run(&mut self, block: &Block) -> FollowedBlock {
        let Self { input, limits, components, .. } = self;
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
                limits: *limits,
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
        let max_work = self.limits.max_work(self.input.triangles.len());
        let has_reached_limit = (self.work + block.work).0 > max_work;
        let mut steps = vec![FollowedStep::UNTOUCHED; block.steps.len()];
        for component in followed {
            self.work = self.work + component.work;
            component.steps.into_iter().for_each(|(step, found)| steps[step as usize] = found);
        }
        let mut max_squared_at = Vec::with_capacity(block.steps.len());
        for (step, found) in block.steps.iter().zip(steps) {
            if has_reached_limit || !found.is_followed {
                break;
            }
            self.max_squared = self.max_squared.max(step.max_squared).max(found.max_squared);
            max_squared_at.push(self.max_squared);
        }
        FollowedBlock { max_squared_at, max_squared: self.max_squared, work: self.work }
    }
}

/// What was found at a step of a component.
#[derive(Clone, Copy, Debug)]
struct FollowedStep {
    /// Whether it was followed: not if the limit of work was reached before.
    is_followed: bool,
    /// E² as far as the component knows.
    max_squared: f64,
}

impl FollowedStep {
    /// A step that touches no face.
    const UNTOUCHED: Self = Self { is_followed: true, max_squared: 0.0 };
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
    limits: Limits,
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
        let max_work = self.limits.max_work(self.input.triangles.len());
        let follow = |&step: &u32| {
            if (self.work_before + self.work).0 > max_work {
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

    /// Decides how far every face of a step is from the input.
    fn follow(&mut self, view: StepView<'_>, face_indices: &[u32]) -> FollowedStep {
        let first_face = self.first_face;
        let touched = || {
            let indices = face_indices.iter().map(|&index| (index - first_face) as usize);
            view.touched.iter().copied().zip(indices)
        };
        let old_bounds = touched().map(|(_, face)| f64::from(self.faces[face].max_distance));
        let old_bound = old_bounds.fold(0.0, f64::max);
        let fan_bound = self.fan_gap(view).map(|gap| (gap + old_bound) * ROUND_UP);
        let triangles = self.input.triangles.len() as u32;
        let searches_all = view.step.live_faces <= max_searched_faces(triangles);
        for (touched, face) in touched().filter(|(touched, _)| touched.is_live) {
            match fan_bound {
                // Where a fan became a smaller one, no hole opens and nothing spans one: the new
                // faces are hardly farther than the samples of the old ones.
                Some(bound) if !searches_all => {
                    let max_distance = self.max_squared.max(ROUNDING_SQUARED).sqrt();
                    self.faces[face].max_distance = bound.min(max_distance) as f32;
                }
                _ => self.search_face(touched, face, self.input.corners_of(touched.points)),
            }
        }
        FollowedStep { is_followed: true, max_squared: self.max_squared }
    }

    /// Returns how far the new faces are from the old ones at most, where a closed fan became a
    /// smaller one.
    fn fan_gap(&mut self, view: StepView<'_>) -> Option<f64> {
        let faces = view.touched.iter().map(|touched| (touched.is_live, touched.points));
        let moved = Moved { source: view.step.source, targets: view.targets };
        fan_gap(self.input, moved, faces, self.link)
    }

    /// Looks for a point of a face that is beyond E, and raises E to its distance.
    fn search_face(&mut self, touched: TouchedFace, face: usize, corners: [DVec3; 3]) {
        self.update_hint(touched, face);
        let max_boxes = self.limits.boxes_farthest;
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
}

/// Of a mesh of some triangles, the most faces with which every new one is searched.
fn max_searched_faces(triangles: u32) -> u32 {
    if triangles <= FEW_TRIANGLES { triangles } else { FEW_FACES.max(triangles / FEW_DIVISOR) }
}
