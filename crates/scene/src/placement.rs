//! Where a scene shows its objects: one placement per node and instance, with the transform, joint
//! matrices and morph weights.

use crate::graph::{Graph, Skin};
use crate::pose::Pose;
use crate::transform::Transform;
use lodc_mesh::Csr;
use std::sync::Arc;

/// An object where a node of the scene shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Index of the object.
    pub object: usize,
    /// Index of the node; none for an object as it was modelled, in a scene that shows nothing.
    pub node: Option<u32>,
    /// The number of the node's instance; 0 for a node without instances.
    pub instance: u32,
    /// From the object's space to world space. Vertices that joints move do not use it.
    pub transform: Transform,
    /// The skinning matrix of every joint (world transform times inverse bind matrix; glTF 2.0,
    /// 3.7.3); empty without a skin.
    pub joints: Arc<[Transform]>,
    /// The weight of each morph target.
    pub weights: Arc<[f64]>,
}

impl Placement {
    /// An object as it was modelled.
    #[must_use]
    pub fn as_modelled(object: usize) -> Self {
        Self {
            object,
            node: None,
            instance: 0,
            transform: Transform::IDENTITY,
            joints: Arc::default(),
            weights: Arc::default(),
        }
    }
}

/// All placements of a scene's objects.
#[derive(Clone, Debug, Default)]
pub struct Arrangement {
    placements: Vec<Placement>,
    /// The placements of each object.
    of_object: Csr,
}

impl Arrangement {
    /// Arranges the objects numbered below `objects`: one placement for every node of the default
    /// scene and every instance that shows the object, in the order of the nodes. If the scene
    /// shows no object, each has one placement as it was modelled.
    #[must_use]
    pub fn new(graph: &Graph, pose: &Pose, objects: usize) -> Self {
        let mut placements = graph.placements(pose);
        placements.retain(|p| p.object < objects);
        if placements.is_empty() {
            placements.extend((0..objects).map(Placement::as_modelled));
        }
        Self::from_placements(placements, objects)
    }

    fn from_placements(placements: Vec<Placement>, objects: usize) -> Self {
        let numbers = placements.iter().zip(0..).map(|(p, i)| (p.object as u32, i));
        Self { of_object: Csr::new(objects, numbers), placements }
    }

    /// Counts the triangles of all placements, where `triangles` tells those of an object.
    pub fn triangles(&self, triangles: impl Fn(usize) -> usize) -> usize {
        let counts = self.placements.iter().map(|p| triangles(p.object));
        counts.fold(0, usize::saturating_add)
    }

    /// Returns a share of each object's placements: [`evenly_spread`] over them.
    #[must_use]
    pub fn thinned(&self, share: f64) -> Self {
        let objects = self.of_object.rows();
        let mut is_kept = vec![false; self.placements.len()];
        for object in 0..objects as u32 {
            let all = self.of_object.row(object);
            evenly_spread(all.len(), share).for_each(|i| is_kept[all[i] as usize] = true);
        }
        let kept = self.placements.iter().zip(is_kept).filter(|&(_, is_kept)| is_kept);
        Self::from_placements(kept.map(|(p, _)| p.clone()).collect(), objects)
    }

    /// Returns the same placements of the same objects, each changed.
    pub(crate) fn mapped(&self, change: impl Fn(&Placement) -> Placement) -> Self {
        Self {
            placements: self.placements.iter().map(change).collect(),
            of_object: self.of_object.clone(),
        }
    }

    /// Returns the same placements, each moved.
    #[must_use]
    pub fn moved(&self, by: [f64; 3]) -> Self {
        let translation = Transform::from_translation(by.into());
        self.mapped(|placement| Placement {
            transform: translation * placement.transform,
            joints: placement.joints.iter().map(|joint| translation * *joint).collect(),
            ..placement.clone()
        })
    }

    /// Every placement, in the order of the nodes.
    #[must_use]
    pub fn placements(&self) -> &[Placement] {
        &self.placements
    }

    /// The placements of one object; none if the scene does not show it.
    pub fn of(&self, object: usize) -> impl Iterator<Item = &Placement> {
        self.of_object.row(object as u32).iter().map(|&p| &self.placements[p as usize])
    }
}

/// Returns the share of each object's placements that pictures of a scene need to show, from its
/// number of triangles, instances counted: in a crowd each instance is smaller than a pixel.
#[must_use]
pub fn share_in_pictures(triangles: usize) -> f64 {
    /// All are shown up to here. Chosen by hand.
    const THINNED_FROM: usize = 1 << 20;
    (THINNED_FROM as f64 / triangles as f64).min(1.0)
}

/// Returns a share (above 0, up to 1) of some numbers below `count`, evenly spread and rising; at
/// least one if there is any.
pub fn evenly_spread(count: usize, share: f64) -> impl Iterator<Item = usize> {
    let chosen = (count as f64 * share).ceil() as usize;
    (0..chosen).map(move |i| i * count / chosen)
}

impl Graph {
    /// Counts the placements of the default scene; 0 if it shows nothing.
    #[must_use]
    pub fn placement_count(&self) -> usize {
        let count = |&n: &u32| {
            let node = &self.nodes[n as usize];
            node.objects.len().saturating_mul(node.instances.as_ref().map_or(1, Vec::len))
        };
        self.visible().iter().map(count).fold(0, usize::saturating_add)
    }

    fn placements(&self, pose: &Pose) -> Vec<Placement> {
        let world = self.world_transforms(pose);
        let skins: Vec<Arc<[Transform]>> = self.skins.iter().map(|s| s.matrices(&world)).collect();
        let mut placements = Vec::new();
        for number in self.visible() {
            let node = &self.nodes[number as usize];
            if node.objects.is_empty() {
                continue;
            }
            let joints = node.skin.and_then(|s| skins.get(s as usize)).cloned().unwrap_or_default();
            let weights = pose.weights.get(number as usize).map_or(&[][..], Vec::as_slice);
            let weights: Arc<[f64]> = weights.into();
            let single = [Transform::IDENTITY];
            for (instance, local) in (0..).zip(node.instances.as_deref().unwrap_or(&single)) {
                let transform = world[number as usize] * *local;
                // A transform that overflows is ignored: the object stays as it was modelled.
                let finite = transform.is_finite();
                let transform = if finite { transform } else { Transform::IDENTITY };
                placements.extend(node.objects.iter().map(|&object| Placement {
                    object: object as usize,
                    node: Some(number),
                    instance,
                    transform,
                    joints: Arc::clone(&joints),
                    weights: Arc::clone(&weights),
                }));
            }
        }
        placements
    }
}

impl Skin {
    /// Returns the skinning matrix of every joint, given the world transforms of all nodes.
    pub(crate) fn matrices(&self, world: &[Transform]) -> Arc<[Transform]> {
        let matrix = |(i, &joint): (usize, &u32)| {
            let world = world.get(joint as usize).copied().unwrap_or_default();
            world * self.inverse_bind.get(i).copied().unwrap_or_default()
        };
        self.joints.iter().enumerate().map(matrix).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::{Arrangement, Graph, LocalTransform, Node, Pose, Skin, Transform};
    use glam::DVec3;

    fn moved(x: f64) -> LocalTransform {
        LocalTransform::Matrix(Transform::from_translation(DVec3::new(x, 0.0, 0.0)))
    }

    #[test]
    fn nodes_stand_relative_to_their_parents_and_instances_to_their_node() {
        let instances = [0.25, 0.5].map(|x| moved(x).matrix()).to_vec();
        let nodes = vec![
            Node { local: moved(1.0), children: vec![1, 2], ..Node::default() },
            Node { local: moved(2.0), objects: vec![0], ..Node::default() },
            Node {
                local: moved(4.0),
                objects: vec![1],
                instances: Some(instances),
                ..Node::default()
            },
            Node { local: moved(8.0), objects: vec![1], ..Node::default() },
        ];
        let graph = Graph { nodes, roots: vec![0], skins: Vec::new() };
        let mut pose = graph.rest_pose();
        let at = |pose: &Pose| -> Vec<(usize, f64)> {
            let arrangement = Arrangement::new(&graph, pose, 2);
            arrangement.placements().iter().map(|p| (p.object, p.transform.translation.x)).collect()
        };
        // The last node is in no scene.
        assert_eq!(at(&pose), [(0, 3.0), (1, 5.25), (1, 5.5)]);
        assert_eq!(graph.placement_count(), 3);
        pose.locals[0] = moved(10.0);
        assert_eq!(at(&pose), [(0, 12.0), (1, 14.25), (1, 14.5)]);
    }

    #[test]
    fn of_many_placements_a_share_of_each_object_stays() {
        let shown = |x: u32, object| Node {
            local: moved(f64::from(x)),
            objects: vec![object],
            ..Node::default()
        };
        let nodes = (0..12).map(|x| shown(x, u32::from(x == 4))).collect();
        let graph = Graph { nodes, roots: (0..12).collect(), skins: Vec::new() };
        let all = Arrangement::new(&graph, &graph.rest_pose(), 3);
        let nodes = |share| -> Vec<Option<u32>> {
            all.thinned(share).placements().iter().map(|p| p.node).collect()
        };
        assert_eq!(nodes(0.3), [0, 2, 4, 6, 9].map(Some));
        assert_eq!(nodes(1e-9), [0, 4].map(Some));
        assert_eq!(nodes(1.0), (0..12).map(Some).collect::<Vec<_>>());
        let thinned = all.thinned(0.3);
        assert_eq!([0, 1, 2].map(|object| thinned.of(object).count()), [4, 1, 0]);
    }

    #[test]
    fn joints_outside_the_scene_have_their_world_transforms() {
        let nodes = vec![
            Node { objects: vec![0], skin: Some(0), ..Node::default() },
            Node { local: moved(5.0), children: vec![2], ..Node::default() },
            Node { local: moved(1.0), ..Node::default() },
        ];
        let skins = vec![Skin { joints: vec![2, 99], inverse_bind: vec![moved(-2.0).matrix()] }];
        let graph = Graph { nodes, roots: vec![0], skins };
        let arrangement = Arrangement::new(&graph, &graph.rest_pose(), 1);
        let placements = arrangement.placements();
        assert_eq!(placements[0].joints.len(), 2);
        assert_eq!(placements[0].joints[0].translation.x, 4.0);
        assert_eq!(placements[0].joints[1], Transform::IDENTITY);
    }

    #[test]
    fn loops_end_and_an_empty_scene_shows_objects_as_modelled() {
        let nodes = vec![Node { children: vec![0, 7], ..Node::default() }];
        let graph = Graph { nodes, roots: vec![0, 0, 5], skins: Vec::new() };
        let arrangement = Arrangement::new(&graph, &graph.rest_pose(), 2);
        let placements = arrangement.placements();
        assert_eq!(placements.iter().map(|p| p.object).collect::<Vec<_>>(), [0, 1]);
        assert!(placements.iter().all(|p| p.node.is_none()));
    }
}
