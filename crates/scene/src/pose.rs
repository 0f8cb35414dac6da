//! Poses of a scene: the transforms of its nodes and their morph weights at one moment.

use crate::graph::Graph;
use crate::transform::{LocalTransform, Transform};

/// The transforms of all nodes relative to their parents, and their morph weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// One per node of the graph.
    pub locals: Vec<LocalTransform>,
    /// Morph weights, one list per node of the graph.
    pub weights: Vec<Vec<f64>>,
}

impl Graph {
    /// The pose of the file: nodes and joints as stored, default morph weights.
    #[must_use]
    pub fn rest_pose(&self) -> Pose {
        Pose {
            locals: self.nodes.iter().map(|n| n.local).collect(),
            weights: self.nodes.iter().map(|n| n.weights.clone()).collect(),
        }
    }

    /// Returns the transform of every node to world space. This includes nodes outside the default
    /// scene, since joints need not be in the scene that shows their mesh.
    #[must_use]
    pub fn world_transforms(&self, pose: &Pose) -> Vec<Transform> {
        let mut world = vec![Transform::IDENTITY; self.nodes.len()];
        for visit in self.walk(self.topmost().into_iter()) {
            let local = pose.locals.get(visit.node).copied().unwrap_or_default().matrix();
            world[visit.node] = visit.parent.map_or(local, |parent| world[parent] * local);
        }
        world
    }
}
