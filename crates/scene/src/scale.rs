//! World scale: how much larger a scene shows an object than it was modelled (world units per mesh
//! unit).

use crate::placement::{Arrangement, Placement};
use crate::posed::Streams;
use crate::transform::{Transform, largest_stretch};
use lodc_mesh::{Mesh, PoseKey};
use std::sync::Arc;

/// Returns every placement of an object with its scale: the largest factor by which it stretches
/// the object, with a skin that of the joints that lead its vertices (have the most weight there).
#[must_use]
pub fn placement_scales<'a>(
    mesh: &Mesh,
    object: usize,
    scene: &'a Arrangement,
) -> Vec<(&'a Placement, f64)> {
    let mut scales = PlacementScales::new(mesh);
    scene.of(object).map(|placement| (placement, scales.of(placement))).collect()
}

/// The scales of an object's placements.
pub(crate) struct PlacementScales<'a> {
    mesh: &'a Mesh,
    leading: Option<LeadingJoints>,
    /// The latest joints with their scale: instances share their joints.
    latest: Option<(Arc<[Transform]>, f64)>,
}

impl<'a> PlacementScales<'a> {
    pub(crate) fn new(mesh: &'a Mesh) -> Self {
        Self { mesh, leading: None, latest: None }
    }

    /// Returns the largest factor by which a placement stretches the object: the largest singular
    /// value of its transform. With a skin, it is the largest one of the joints that lead some
    /// vertex (have the most weight there), and of the node's transform if some vertex has no
    /// weight.
    pub(crate) fn of(&mut self, placement: &Placement) -> f64 {
        let node_scale = largest_stretch(&placement.transform.matrix3);
        if placement.joints.is_empty() {
            return node_scale;
        }
        let leading = self.leading.get_or_insert_with(|| LeadingJoints::of(self.mesh, placement));
        let joint_scale = match &self.latest {
            Some((joints, scale)) if Arc::ptr_eq(joints, &placement.joints) => *scale,
            _ => leading.scale(&placement.joints),
        };
        self.latest = Some((Arc::clone(&placement.joints), joint_scale));
        let node_moves_some = leading.leave_some_to_node(&placement.joints);
        if node_moves_some { joint_scale.max(node_scale) } else { joint_scale }
    }

    /// Returns the moment at which some joint that leads a vertex stretches it most, given that of
    /// each joint of the placement's skin; none if that is no more than at rest.
    pub(crate) fn largest_moment(
        &mut self,
        placement: &Placement,
        joints: &[Option<(f64, PoseKey)>],
    ) -> Option<PoseKey> {
        let at_rest = self.of(placement);
        let leading = self.leading.as_ref()?;
        let of_leading = leading.joints.iter().filter_map(|&j| *joints.get(j)?);
        let largest = of_leading.reduce(|a, b| if b.0 > a.0 { b } else { a });
        largest.filter(|(scale, _)| *scale > at_rest * (1.0 + MAX_ROUNDING)).map(|(_, at)| at)
    }
}

/// Stretches that differ by a smaller share are the same. Chosen by hand.
const MAX_ROUNDING: f64 = 1e-4;

/// The joints that lead some vertex: have the most weight there.
struct LeadingJoints {
    /// Indices in the skin, rising, each once.
    joints: Vec<usize>,
    /// True if some vertex has no weight.
    has_unweighted_vertex: bool,
}

impl LeadingJoints {
    fn of(mesh: &Mesh, placement: &Placement) -> Self {
        let streams = Streams::of(mesh, placement);
        let mut joints = Vec::new();
        let mut has_unweighted_vertex = false;
        for v in 0..mesh.vertex_count() as u32 {
            let mut strongest: Option<(usize, f64)> = None;
            streams.each_joint(mesh, v, |joint, weight| {
                if strongest.is_none_or(|(_, w)| weight > w) {
                    strongest = Some((joint, weight));
                }
            });
            match strongest {
                Some((joint, _)) => joints.push(joint),
                None => has_unweighted_vertex = true,
            }
        }
        joints.sort_unstable();
        joints.dedup();
        Self { joints, has_unweighted_vertex }
    }

    /// Returns the largest stretch of these joints, given the matrices of the skin.
    fn scale(&self, skin: &[Transform]) -> f64 {
        let present = self.joints.iter().take_while(|&&j| j < skin.len());
        present.map(|&j| largest_stretch(&skin[j].matrix3)).fold(0.0, f64::max)
    }

    /// Returns whether some vertex may follow the node: one without weight, or one whose leading
    /// joint does not exist.
    fn leave_some_to_node(&self, skin: &[Transform]) -> bool {
        self.has_unweighted_vertex || self.joints.last().is_some_and(|&j| j >= skin.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Graph, LocalTransform, Node, Skin};
    use glam::DVec3;
    use lodc_mesh::{Attribute, Component, MeshParts, Semantic, Submesh};

    fn bytes(semantic: Semantic, values: &[[u8; 4]; 3]) -> Attribute {
        Attribute {
            normalized: semantic == Semantic::Weights(0),
            semantic,
            morph_target: None,
            component: Component::U8,
            components: 4,
            bytes: values.concat(),
        }
    }

    /// A triangle whose corners have the joints 0 to 3 with these weights.
    fn triangle(weights: [[u8; 4]; 3]) -> Mesh {
        let joints = bytes(Semantic::Joints(0), &[[0, 1, 2, 3]; 3]);
        Mesh::try_from(MeshParts {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            vertex_submesh: vec![0; 3],
            triangles: vec![[0, 1, 2]],
            attributes: vec![joints, bytes(Semantic::Weights(0), &weights)],
            submeshes: vec![Submesh {
                first_triangle: 0,
                triangle_count: 1,
                attributes: vec![0, 1],
            }],
        })
        .expect("a triangle")
    }

    /// The scale of one object at a node that scales by 1000, with joints of these scales.
    fn skinned(mesh: &Mesh, scales: [f64; 4]) -> f64 {
        let scale = |s| LocalTransform::Matrix(Transform::from_scale(DVec3::splat(s)));
        let shows =
            Node { local: scale(1000.0), objects: vec![0], skin: Some(0), ..Node::default() };
        let joints = scales.map(|s| Node { local: scale(s), ..Node::default() });
        let graph = Graph {
            nodes: [shows].into_iter().chain(joints).collect(),
            roots: vec![0],
            skins: vec![Skin { joints: vec![1, 2, 3, 4], inverse_bind: Vec::new() }],
        };
        let scene = Arrangement::new(&graph, &graph.rest_pose(), 1);
        placement_scales(mesh, 0, &scene)[0].1
    }

    #[test]
    fn only_joints_with_weight_scale_an_object() {
        // A helper joint of a rig, 105 times as large, to which nothing is weighted; and the node,
        // which does not move what joints move.
        let mesh = triangle([[255, 0, 0, 0], [0, 255, 0, 0], [128, 127, 0, 0]]);
        let scale = skinned(&mesh, [0.01, 0.02, 1.05, 9.0]);
        assert!((scale - 0.02).abs() < 1e-12, "{scale}");
    }

    #[test]
    fn a_trace_of_weight_does_not_count() {
        let mesh = triangle([[255, 0, 0, 0], [255, 0, 0, 0], [254, 0, 0, 1]]);
        assert_eq!(skinned(&mesh, [1.0, 1.0, 1.0, 50.0]), 1.0);
    }

    #[test]
    fn a_vertex_without_weights_follows_its_node() {
        let mesh = triangle([[255, 0, 0, 0], [255, 0, 0, 0], [0; 4]]);
        assert_eq!(skinned(&mesh, [1.0; 4]), 1000.0);
    }
}
