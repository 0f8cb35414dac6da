//! The characters of a crowd: each input in a few poses of its first animation, and the triangle
//! counts of its levels.

use super::walk::WalkerPosition;
use crate::error::LabError;
use crate::prepared::Input;
use lodc_formats::{Limits, ObjectInfo, animation, animation_names, scene_graph};
use lodc_mesh::Lod;
use lodc_scene::{Arrangement, Graph, Pose, posed};
use std::collections::BTreeMap;

/// Poses of an animation that a crowd shows at once. Chosen by hand.
const PHASES: usize = 8;

/// An input as it walks.
pub(crate) struct Figure<'a> {
    input: &'a Input,
    /// By phase.
    phases: Vec<Vec<Part>>,
    /// Triangles of objects at levels that were asked for.
    levels: BTreeMap<(usize, Lod), Vec<[u32; 3]>>,
}

/// An object where its input shows it. One size is the largest extent of the input; it stands on
/// the origin.
pub(crate) struct Part {
    pub(crate) object: usize,
    pub(crate) positions: Vec<[f32; 3]>,
    /// True if the corners of triangles are taken the other way round.
    pub(crate) mirrored: bool,
}

impl<'a> Figure<'a> {
    /// Poses an input.
    ///
    /// # Errors
    /// If the file's scene or its animation is damaged.
    fn new(input: &'a Input, limits: &Limits) -> Result<Self, LabError> {
        let name = &input.name;
        let infos: Vec<&ObjectInfo> = input.objects.iter().map(|o| &o.object.info).collect();
        let document = &input.document;
        let graph = scene_graph(document, &infos, limits).map_err(|e| e.in_file(name))?;
        let animated = !animation_names(document, limits).map_err(|e| e.in_file(name))?.is_empty();
        let poses: Vec<Pose> = if animated {
            let found = animation(document, 0, limits).map_err(|e| e.in_file(name))?;
            let moment = |i: usize| found.duration() * i as f64 / PHASES as f64;
            (0..PHASES).map(|i| found.pose(&graph, moment(i))).collect()
        } else {
            vec![graph.rest_pose()]
        };
        let mut phases: Vec<Vec<Part>> =
            poses.iter().map(|pose| parts(input, &graph, pose)).collect();
        put_on_ground(&mut phases);
        Ok(Self { input, phases, levels: BTreeMap::new() })
    }

    /// The parts of the input in a pose.
    pub(crate) fn parts(&self, phase: usize) -> &[Part] {
        &self.phases[phase]
    }

    /// Number of poses.
    pub(crate) fn phases(&self) -> usize {
        self.phases.len()
    }

    /// The pose of an instance in a frame, a tenth of a second each. The step of 5 from instance to
    /// instance is chosen by hand, so that neighbours do not walk in step.
    pub(crate) fn phase(&self, instance: usize, frame: usize) -> usize {
        (instance * 5 + frame) % self.phases.len()
    }

    /// Triangles of an object at a LOD.
    pub(crate) fn level(&mut self, object: usize, lod: Lod) -> &[[u32; 3]] {
        let simplified = &self.input.objects[object].object.simplified;
        let triangles =
            || simplified.triangles_at(lod).into_iter().map(|t| t.corners).collect::<Vec<_>>();
        self.levels.entry((object, lod)).or_insert_with(triangles)
    }
}

/// Poses all inputs.
///
/// # Errors
/// If a file's scene or its animation is damaged.
pub(super) fn all<'a>(inputs: &'a [Input], limits: &Limits) -> Result<Vec<Figure<'a>>, LabError> {
    inputs.iter().map(|input| Figure::new(input, limits)).collect()
}

/// Every object where a pose puts it.
fn parts(input: &Input, graph: &Graph, pose: &Pose) -> Vec<Part> {
    let arrangement = Arrangement::new(graph, pose, input.objects.len());
    arrangement
        .placements()
        .iter()
        .map(|placement| {
            let mesh = input.objects[placement.object].object.simplified.mesh();
            let posed = posed(mesh, placement);
            let positions = posed.positions.iter().map(|p| p.as_vec3().to_array()).collect();
            Part { object: placement.object, positions, mirrored: posed.mirrored }
        })
        .collect()
}

/// Moves the first pose's feet to the origin and makes its largest extent 1, the other poses with
/// it.
fn put_on_ground(phases: &mut [Vec<Part>]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in phases[0].iter().flat_map(|part| &part.positions) {
        for i in 0..3 {
            (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i]));
        }
    }
    let size = (0..3).map(|i| high[i] - low[i]).fold(0.0, f32::max);
    let size = if size > 0.0 && size.is_finite() { size } else { 1.0 };
    let middle = |i: usize| if low[i] <= high[i] { f32::midpoint(low[i], high[i]) } else { 0.0 };
    let origin = [middle(0), if low[1] <= high[1] { low[1] } else { 0.0 }, middle(2)];
    for p in phases.iter_mut().flatten().flat_map(|part| &mut part.positions) {
        *p = std::array::from_fn(|i| (p[i] - origin[i]) / size);
    }
}

/// Cosine and sine of the rotation that makes a figure, whose front looks along the third axis,
/// look where it walks.
pub(crate) fn rotation(walker: &WalkerPosition) -> [f32; 2] {
    [walker.direction[1] as f32, walker.direction[0] as f32]
}

/// The position of a walker on the ground, as a point in space.
pub(crate) fn ground_position(walker: &WalkerPosition) -> [f64; 3] {
    [walker.position[0], 0.0, walker.position[1]]
}
