//! The shapes that a scene gives an object: at rest, and in its postures, the moments of animations
//! and the morph targets that change it.

mod choice;

use crate::animation::Animation;
use crate::graph::Graph;
use crate::placement::{Arrangement, Placement};
use crate::scale::representative;
use crate::shape::Shape;
use crate::transform::Transform;
use lodc_mesh::{Mesh, Posture};

/// A scene at rest, and its animations.
#[derive(Clone, Debug)]
pub struct Motion {
    graph: Graph,
    animations: Vec<Animation>,
    rest: Arrangement,
}

impl Motion {
    /// A scene of `objects` objects.
    #[must_use]
    pub fn new(graph: Graph, animations: Vec<Animation>, objects: usize) -> Self {
        let rest = Arrangement::new(&graph, &graph.rest_pose(), objects);
        Self { graph, animations, rest }
    }

    /// The objects at rest.
    #[must_use]
    pub fn rest(&self) -> &Arrangement {
        &self.rest
    }

    /// The shapes of an object: at rest, then in each posture at the same placement and scale.
    /// Postures that do not apply, such as one of an animation that does not exist, are skipped.
    /// `mesh` is the object at full detail.
    #[must_use]
    pub fn shapes(&self, mesh: &Mesh, object: usize, postures: &[Posture]) -> Vec<Shape> {
        let mut shapes = vec![Shape::at_rest(mesh, object, &self.rest)];
        if let (Some(rest), scale) = representative(mesh, object, &self.rest) {
            let placed = |&posture: &Posture| self.placed(rest, posture);
            let shape = |placement| Shape::placed(mesh, placement, scale);
            shapes.extend(postures.iter().filter_map(placed).filter_map(shape));
        }
        shapes
    }

    /// Returns a rest placement changed by a posture; none if the posture does not apply.
    #[must_use]
    pub fn placed(&self, rest: &Placement, posture: Posture) -> Option<Placement> {
        match posture {
            Posture::Moment { animation, seconds } => {
                let animation = self.animations.get(animation as usize)?;
                Some(self.moment(animation, seconds).placed(&self.graph, rest))
            }
            Posture::Target(target) => {
                let target = target as usize;
                let mut weights = rest.weights.to_vec();
                weights.resize(weights.len().max(target + 1), 0.0);
                weights[target] = 1.0;
                Some(Placement { weights: weights.into(), ..rest.clone() })
            }
        }
    }

    fn moment(&self, animation: &Animation, seconds: f64) -> Moment {
        let pose = animation.pose(&self.graph, seconds);
        Moment { world: self.graph.world_transforms(&pose), weights: pose.weights }
    }
}

/// A moment of an animation: the world transforms of all nodes, and their morph weights.
struct Moment {
    world: Vec<Transform>,
    weights: Vec<Vec<f64>>,
}

impl Moment {
    /// Returns a rest placement at this moment. An object without joints keeps the transform of its
    /// node at rest, since motion as a whole is no change of shape.
    fn placed(&self, graph: &Graph, rest: &Placement) -> Placement {
        let Some(node) = rest.node.map(|node| node as usize) else { return rest.clone() };
        let skin = graph.nodes[node].skin.and_then(|skin| graph.skins.get(skin as usize));
        let weights = self.weights.get(node).map_or(&[][..], Vec::as_slice);
        Placement {
            transform: if rest.joints.is_empty() { rest.transform } else { self.world[node] },
            joints: skin.map(|skin| skin.matrices(&self.world)).unwrap_or_default(),
            weights: weights.into(),
            ..rest.clone()
        }
    }
}

#[cfg(test)]
#[path = "motion/tests.rs"]
mod tests;
