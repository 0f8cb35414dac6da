//! The node graph of a scene: transforms, objects, skins and instances, and walks over it.

use crate::transform::{LocalTransform, Transform};

/// A node: its transform relative to its parent, and which objects it shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Node {
    /// The node's name in the file; may be empty.
    pub name: String,
    /// Transform relative to the parent, at rest.
    pub local: LocalTransform,
    /// Indices of child nodes.
    pub children: Vec<u32>,
    /// Indices of the objects that it shows. Empty for a node without a mesh, or if importing the
    /// mesh left no object.
    pub objects: Vec<u32>,
    /// Index of the skin that moves these objects, if any.
    pub skin: Option<u32>,
    /// Morph weights at rest; targets without one have 0.
    pub weights: Vec<f64>,
    /// The transforms, relative to the node, at which its objects are repeated
    /// (`EXT_mesh_gpu_instancing`); none for a node without instances, which shows them once.
    pub instances: Option<Vec<Transform>>,
}

/// Joints that move the vertices of objects.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Indices of the joints' nodes.
    pub joints: Vec<u32>,
    /// The inverse bind matrix of each joint; the identity where there are fewer than joints.
    pub inverse_bind: Vec<Transform>,
}

/// The nodes of a file and its default scene.
///
/// Indices out of range are ignored, and each node is visited once, so that a graph may hold the
/// contents of any file, also invalid ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Graph {
    /// All nodes.
    pub nodes: Vec<Node>,
    /// Topmost nodes of the default scene.
    pub roots: Vec<u32>,
    /// All skins.
    pub skins: Vec<Skin>,
}

impl Graph {
    /// A graph for a file without nodes: it shows each object once, as it was modelled.
    #[must_use]
    pub fn of_objects(objects: u32) -> Self {
        Self::of_objects_at(objects, [0.0; 3])
    }

    /// A graph for a file without nodes: it shows each object once, at an offset.
    #[must_use]
    pub fn of_objects_at(objects: u32, offset: [f64; 3]) -> Self {
        let local = match offset {
            [0.0, 0.0, 0.0] => LocalTransform::default(),
            translation => {
                LocalTransform::Trs { translation, rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] }
            }
        };
        let node = |object| Node { objects: vec![object], local, ..Node::default() };
        Self {
            nodes: (0..objects).map(node).collect(),
            roots: (0..objects).collect(),
            skins: Vec::new(),
        }
    }

    /// Returns some nodes and all nodes below them, parents first, in the order of the file; each
    /// once.
    pub(crate) fn walk(&self, roots: impl DoubleEndedIterator<Item = u32>) -> Vec<Visit> {
        let mut visited = vec![false; self.nodes.len()];
        let mut order = Vec::new();
        let mut stack: Vec<Visit> =
            roots.rev().map(|node| Visit { node: node as usize, parent: None }).collect();
        while let Some(visit) = stack.pop() {
            let Some(node) = self.nodes.get(visit.node) else { continue };
            if std::mem::replace(&mut visited[visit.node], true) {
                continue;
            }
            let child = |&c: &u32| Visit { node: c as usize, parent: Some(visit.node) };
            stack.extend(node.children.iter().rev().map(child));
            order.push(visit);
        }
        order
    }

    /// Returns the nodes of the default scene, parents first.
    #[must_use]
    pub fn visible(&self) -> Vec<u32> {
        self.walk(self.roots.iter().copied()).into_iter().map(|v| v.node as u32).collect()
    }

    /// Returns the nodes without a parent.
    #[must_use]
    pub fn topmost(&self) -> Vec<u32> {
        let mut is_child = vec![false; self.nodes.len()];
        for &child in self.nodes.iter().flat_map(|n| &n.children) {
            if let Some(c) = is_child.get_mut(child as usize) {
                *c = true;
            }
        }
        (0..self.nodes.len() as u32).filter(|&n| !is_child[n as usize]).collect()
    }
}

/// A node on a walk, and the node above it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Visit {
    pub(crate) node: usize,
    pub(crate) parent: Option<usize>,
}
