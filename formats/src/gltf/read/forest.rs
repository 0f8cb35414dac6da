//! Checks that the node hierarchy is a forest (no cycles, one parent each), and computes the
//! largest scale at which its nodes ever show each mesh, which turns errors in world units into
//! those of the mesh.

use crate::gltf::animations::sound_animations;
use crate::gltf::graph::{Numbers, gltf_graph};
use crate::gltf::json::{Json, Object, malformed};
use crate::{FormatError, SceneObject};
use lodc_scene::Motion;

/// Errors that are too large by less than this factor are no reason to warn. Chosen by hand.
const NOTICEABLE: f64 = 1.1;

/// Checks that no node has two parents and none is its own ancestor, without recursion.
/// Returns the nodes, parents before their children.
fn forest(root: &Object) -> Result<Vec<usize>, FormatError> {
    let nodes = root.entries("nodes").len();
    let mut parent = vec![None; nodes];
    for (i, node) in root.entries("nodes").enumerate() {
        for child in children(node) {
            if let Some(other) = parent[child].replace(i) {
                let problem = format!(
                    "is a child of nodes[{other}] and of nodes[{i}]: the scene is not a tree"
                );
                return Err(malformed(format!("nodes[{child}]"), problem));
            }
        }
    }
    let mut order: Vec<usize> = (0..nodes).filter(|&i| parent[i].is_none()).collect();
    let all: Vec<&Object> = root.entries("nodes").collect();
    let mut visited = 0;
    while let Some(&node) = order.get(visited) {
        order.extend(children(all[node]));
        visited += 1;
    }
    if order.len() < nodes {
        let mut reached = vec![false; nodes];
        order.iter().for_each(|&i| reached[i] = true);
        let node = reached.iter().position(|r| !r).unwrap_or(0);
        return Err(malformed(
            format!("nodes[{node}]"),
            "is its own ancestor: the nodes form a loop",
        ));
    }
    Ok(order)
}

/// The numbers of a node's children.
pub(super) fn children(node: &Object) -> impl Iterator<Item = usize> {
    node.list("children").iter().filter_map(Json::as_index)
}

/// Checks that the nodes are a forest.
///
/// # Errors
/// If a node has two parents or is its own ancestor.
pub(super) fn check(root: &Object) -> Result<(), FormatError> {
    forest(root).map(|_| ())
}

/// Sets the world scale of every object: how much larger the default scene shows it than it was
/// modelled, at rest or at any moment of the animations. Warns of those that it shows in more
/// unlike placements than errors are measured in, or at more moments than are looked at.
pub(super) fn set_world_scales(
    root: &Object,
    objects: &mut [SceneObject],
    numbers: &Numbers<'_>,
    warnings: &mut Vec<String>,
) -> Result<(), FormatError> {
    let meshes: Vec<u32> = objects.iter().map(|o| o.info.document_mesh).collect();
    let graph = gltf_graph(root, &meshes, numbers)?;
    let motion = Motion::new(graph, sound_animations(root, numbers), objects.len());
    for (number, object) in objects.iter_mut().enumerate() {
        let measured = motion.measured_placements(&object.mesh, number);
        object.info.world_scale = measured.scale;
        if measured.looseness > NOTICEABLE {
            warnings.push(format!(
                "{}: it is shown in so many unlike placements that errors may be stated up to \
                 {:.2} times too large",
                object.info.name, measured.looseness
            ));
        }
        if !measured.is_whole {
            warnings.push(format!(
                "{}: animations stretch it at more moments than are looked at: it may err more at \
                 others",
                object.info.name
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;
    use crate::gltf::json::parse;

    #[test]
    fn loops_and_second_parents_are_refused() {
        for nodes in [
            r#"[{"children":[0]}]"#,
            r#"[{"children":[1]},{"children":[0]}]"#,
            r#"[{"children":[2]},{"children":[2]},{}]"#,
        ] {
            let root = json_object(&format!(r#"{{"nodes":{nodes}}}"#));
            assert!(forest(&root).is_err(), "{nodes}");
        }
        let root = json_object(r#"{"nodes":[{},{"children":[0,2]},{}]}"#);
        assert_eq!(forest(&root).ok(), Some(vec![1, 0, 2]));
    }

    fn json_object(text: &str) -> Object {
        parse(text.as_bytes(), &Limits::DEFAULT).expect("JSON of the test")
    }
}
