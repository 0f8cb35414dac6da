//! The shapes that a scene gives an object: in its placements, at rest and where animations stretch
//! it, and in its pose keys, the moments of animations and the morph targets that change it.

mod choice;
mod course;
mod envelope;
mod measured;
mod movers;
mod seen;
mod stretching;
mod unlike;

pub use measured::{MeasuredPlacement, MeasuredPlacements, Stretch};
pub use seen::{MAX_TARGET_SHAPES, SeenPositions, TargetShape};

use crate::animation::Animation;
use crate::graph::Graph;
use crate::placement::{Arrangement, Placement};
use crate::shape::Shape;
use crate::transform::{Transform, largest_stretch};
use glam::DMat3;
use lodc_mesh::{Mesh, PoseKey};
use movers::Mover;
use std::collections::{BTreeMap, BTreeSet};
use stretching::Stretching;

/// A scene at rest, and its animations.
#[derive(Clone, Debug)]
pub struct Motion {
    graph: Graph,
    animations: Vec<Animation>,
    rest: Arrangement,
    stretching: Stretching,
    /// By node the one above it.
    parents: Vec<Option<usize>>,
    /// The channels of an animation and a node, by their indices.
    channels: BTreeMap<(u32, u32), Vec<usize>>,
    /// The nodes whose morph weights an animation changes.
    morphed: BTreeSet<u32>,
}

/// The shapes of an object that its errors are the largest over, in mesh units: world units divided
/// by its world scale.
#[derive(Clone, Debug)]
pub struct ObjectShapes {
    all: Vec<Shape>,
    of_placements: usize,
    /// After each pose key the number of shapes of pose keys.
    pose_key_ends: Vec<usize>,
}

impl ObjectShapes {
    /// All of them, those of placements first.
    #[must_use]
    pub fn all(&self) -> &[Shape] {
        &self.all
    }

    /// Those of placements: at least one.
    #[must_use]
    pub fn of_placements(&self) -> &[Shape] {
        &self.all[..self.of_placements]
    }

    /// Those of pose keys.
    #[must_use]
    pub fn of_pose_keys(&self) -> &[Shape] {
        &self.all[self.of_placements..]
    }

    /// How many pose keys the first `shapes` shapes of pose keys belong to, and how many shapes
    /// these pose keys have.
    #[must_use]
    pub fn pose_keys_of(&self, shapes: usize) -> (usize, usize) {
        let before = self.pose_key_ends.partition_point(|&end| end < shapes);
        let last = self.pose_key_ends.get(before).filter(|_| shapes > 0);
        last.map_or((before, shapes), |&end| (before + 1, end))
    }
}

impl Motion {
    /// A scene of `objects` objects.
    #[must_use]
    pub fn new(graph: Graph, animations: Vec<Animation>, objects: usize) -> Self {
        let rest = Arrangement::new(&graph, &graph.rest_pose(), objects);
        let stretching = Stretching::new(&graph, &animations);
        let mut parents = vec![None; graph.nodes.len()];
        for visit in graph.walk(graph.topmost().into_iter()) {
            parents[visit.node] = visit.parent;
        }
        let all_channels = animations.iter().flat_map(|animation| &animation.channels);
        let morphs = all_channels.filter(|channel| channel.property.is_of_targets());
        let morphed = morphs.map(|channel| channel.node).collect();
        let mut channels: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
        for (animation, number) in animations.iter().zip(0..) {
            for (i, channel) in animation.channels.iter().enumerate() {
                channels.entry((number, channel.node)).or_default().push(i);
            }
        }
        Self { graph, animations, rest, stretching, parents, channels, morphed }
    }

    /// The nodes, also those that the scene does not show.
    #[must_use]
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// The objects at rest.
    #[must_use]
    pub fn rest(&self) -> &Arrangement {
        &self.rest
    }

    /// The objects at rest, those excepted that an animation shows larger: each placement of these
    /// is there at the moment when it is largest.
    #[must_use]
    pub fn largest(&self) -> Arrangement {
        let enlarged = |placement: &Placement| {
            let stretches = placement.node.and_then(|node| self.stretching.nodes.get(&node))?;
            if !placement.joints.is_empty() {
                return None;
            }
            let instance = self.instance(placement).matrix3;
            let at_rest = largest_stretch(&placement.transform.matrix3);
            let scale = |linear: DMat3| largest_stretch(&(linear * instance));
            let of_moments = stretches.kept.iter().map(|m| (scale(m.linear), m.moment));
            let most = of_moments.reduce(|a, b| if b.0 > a.0 { b } else { a });
            let (_, moment) = most.filter(|(scale, _)| *scale > at_rest)?;
            self.shown_at(placement, moment?)
        };
        if self.stretching.nodes.is_empty() {
            return self.rest.clone();
        }
        self.rest.mapped(|placement| enlarged(placement).unwrap_or_else(|| placement.clone()))
    }

    /// The shapes of an object: in its [measured placements](Self::measured_placements), and in
    /// each pose key, in the same units: in a moment that moves several placements a shape of each.
    /// Pose keys that do not apply, such as one of an animation that does not exist, are skipped.
    /// `mesh` is the object at full detail.
    #[must_use]
    pub fn shapes(&self, mesh: &Mesh, object: usize, pose_keys: &[PoseKey]) -> ObjectShapes {
        let measured = self.measured_placements(mesh, object);
        let shape = |at: &MeasuredPlacement| at.shape(mesh, measured.scale);
        let mut all: Vec<Shape> = measured.placements.iter().filter_map(shape).collect();
        if all.is_empty() {
            all.push(Shape::AS_MODELLED);
        }
        let of_placements = all.len();
        let movers = self.movers(object, &measured);
        let mut pose_key_ends = Vec::with_capacity(pose_keys.len());
        for &pose_key in pose_keys {
            let shape = |m: Mover| Shape::placed(mesh, m.placement, measured.scale / m.growth);
            all.extend(self.all_placed(&movers, pose_key).into_iter().filter_map(shape));
            pose_key_ends.push(all.len() - of_placements);
        }
        ObjectShapes { all, of_placements, pose_key_ends }
    }

    /// Returns placements of an object in a pose key: in a moment all that have shapes of their
    /// own, with a morph target the first; none if it does not apply.
    fn all_placed(&self, movers: &[Mover], pose_key: PoseKey) -> Vec<Mover> {
        match pose_key {
            PoseKey::Moment { animation, seconds } => {
                let animation = self.animations.get(animation as usize);
                let moment = animation.map(|animation| self.moment(animation, seconds));
                moment.map_or_else(Vec::new, |moment| moment.all_placed(&self.graph, movers))
            }
            PoseKey::Target(_) => {
                let placed = |first: &Mover| {
                    let placement = self.placed(&first.placement, pose_key)?;
                    Some(Mover { placement, growth: first.growth })
                };
                movers.first().and_then(placed).into_iter().collect()
            }
        }
    }

    /// Returns a rest placement changed by a pose key; none if the pose key does not apply.
    #[must_use]
    pub fn placed(&self, rest: &Placement, pose_key: PoseKey) -> Option<Placement> {
        match pose_key {
            PoseKey::Moment { animation, seconds } => {
                let animation = self.animations.get(animation as usize)?;
                Some(self.moment(animation, seconds).placed(&self.graph, rest))
            }
            PoseKey::Target(target) => {
                let target = target as usize;
                let mut weights = rest.weights.to_vec();
                weights.resize(weights.len().max(target + 1), 0.0);
                weights[target] = 1.0;
                Some(Placement { weights: weights.into(), ..rest.clone() })
            }
        }
    }

    /// Returns a rest placement at a moment, moved and stretched as a whole, too; its morph weights
    /// stay as at rest. None if the pose key is no moment of an animation that exists.
    #[must_use]
    pub fn shown_at(&self, rest: &Placement, moment: PoseKey) -> Option<Placement> {
        let PoseKey::Moment { animation: number, seconds } = moment else { return None };
        let animation = self.animations.get(number as usize)?;
        let Some(node) = rest.node else { return Some(rest.clone()) };
        let transform = self.node_at(node as usize, number, seconds) * self.instance(rest);
        if rest.joints.is_empty() {
            return Some(Placement { transform, ..rest.clone() });
        }
        let at = self.moment(animation, seconds).placed(&self.graph, rest);
        Some(Placement { transform, weights: rest.weights.clone(), ..at })
    }

    /// Returns a rest placement stretched as a measured one of the same object, maybe of another
    /// scene with the same nodes, is. None if the scene has no such moment.
    #[must_use]
    pub fn stretched_as(
        &self,
        measured: &MeasuredPlacement,
        rest: &Placement,
    ) -> Option<Placement> {
        let linear = match measured.stretch {
            Stretch::AtRest => return Some(rest.clone()),
            Stretch::At(moment) => return self.shown_at(rest, moment),
            Stretch::Envelope(linear) => linear,
        };
        // What is below the node is stretched with it.
        let (node, mut at) = (measured.placement.node, rest.node);
        let mut below = self.instance(rest);
        while let Some(number) = at.filter(|_| at != node) {
            below = self.graph.nodes[number as usize].local.matrix() * below;
            at = self.parents[number as usize].map(|parent| parent as u32);
        }
        let below = if rest.node.is_some() { below } else { rest.transform };
        let transform = Transform { matrix3: linear, ..Transform::IDENTITY } * below;
        Some(Placement { transform, ..rest.clone() })
    }

    /// The world transform of one node at a moment of an animation.
    fn node_at(&self, node: usize, animation: u32, seconds: f64) -> Transform {
        let mut world = Transform::IDENTITY;
        let mut at = Some(node);
        while let Some(node) = at {
            let mut local = self.graph.nodes[node].local;
            for &channel in self.channels.get(&(animation, node as u32)).into_iter().flatten() {
                self.animations[animation as usize].channels[channel].apply_to(&mut local, seconds);
            }
            world = local.matrix() * world;
            at = self.parents[node];
        }
        world
    }

    /// The transform of a placement relative to its node.
    fn instance(&self, placement: &Placement) -> Transform {
        let instances = |node: u32| self.graph.nodes[node as usize].instances.as_ref();
        let instances = placement.node.and_then(instances);
        let own = instances.and_then(|all| all.get(placement.instance as usize));
        own.copied().unwrap_or(Transform::IDENTITY)
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
