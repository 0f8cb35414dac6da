//! Where the nodes of a glTF stand: world matrices, joints at rest, weights of morph targets,
//! instances.

use super::Placement;
use crate::nodes::{IDENTITY, Matrix, as_index, local, product, roots};
use crate::{Fault, FormatError};
use serde_json::{Value, json};

/// More placements than this are refused.
const MOST: usize = 1 << 20;

/// Reads numbers of an accessor: all components of all elements, and how many components there are.
pub(super) type Numbers<'a> = dyn Fn(usize) -> Result<(Vec<f64>, usize), FormatError> + 'a;

/// Every object for each node of the default scene that shows it; all as they are if no node shows
/// any. `meshes` says which of the document's meshes each object is.
pub(super) fn placements(
    document: &Value,
    meshes: &[usize],
    read: &Numbers<'_>,
) -> Result<Vec<Placement>, FormatError> {
    let nodes = document["nodes"].as_array().map(Vec::as_slice).unwrap_or_default();
    let world = worlds(nodes);
    let mut out = Vec::new();
    let mut visited = vec![false; nodes.len()];
    let mut open: Vec<usize> = roots(document, nodes).into_iter().rev().collect();
    while let Some(index) = open.pop() {
        let Some(node) = nodes.get(index) else { continue };
        if std::mem::replace(&mut visited[index], true) {
            continue;
        }
        if let Some(children) = node["children"].as_array() {
            open.extend(children.iter().rev().filter_map(as_index));
        }
        let Some(mesh) = as_index(&node["mesh"]) else { continue };
        let objects: Vec<usize> = (0..meshes.len()).filter(|&o| meshes[o] == mesh).collect();
        if objects.is_empty() {
            continue;
        }
        let weights = [&node["weights"], &document["meshes"][mesh]["weights"]]
            .into_iter()
            .find_map(Value::as_array);
        let weights: Vec<f64> =
            weights.into_iter().flatten().map(|w| w.as_f64().unwrap_or(0.0)).collect();
        let joints = match as_index(&node["skin"]) {
            Some(skin) => joints(&document["skins"][skin], &world, read)?,
            None => Vec::new(),
        };
        for instance in instances(&node["extensions"]["EXT_mesh_gpu_instancing"], read)? {
            for &object in &objects {
                let matrix = product(&world[index], &instance);
                out.push(Placement {
                    object,
                    matrix,
                    joints: joints.clone(),
                    weights: weights.clone(),
                });
            }
            if out.len() > MOST {
                return Err(FormatError::new(
                    Fault::Limit,
                    "nodes",
                    format!("show more than {MOST} instances"),
                ));
            }
        }
    }
    if out.is_empty() {
        let plain = |object| Placement {
            object,
            matrix: IDENTITY,
            joints: Vec::new(),
            weights: Vec::new(),
        };
        out.extend((0..meshes.len()).map(plain));
    }
    Ok(out)
}

/// The world matrix of every node; joints need not be in the scene that shows their mesh.
fn worlds(nodes: &[Value]) -> Vec<Matrix> {
    let mut is_child = vec![false; nodes.len()];
    let children = |node: &Value| -> Vec<usize> {
        node["children"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(as_index)
            .filter(|&c| c < nodes.len())
            .collect()
    };
    nodes.iter().flat_map(children).for_each(|c| is_child[c] = true);
    let mut world = vec![None; nodes.len()];
    let mut open: Vec<(usize, Matrix)> =
        (0..nodes.len()).filter(|&n| !is_child[n]).map(|n| (n, IDENTITY)).collect();
    while let Some((index, parent)) = open.pop() {
        if world[index].is_some() {
            continue;
        }
        let own = product(&parent, &local(&nodes[index]));
        world[index] = Some(own);
        open.extend(children(&nodes[index]).into_iter().map(|child| (child, own)));
    }
    world.into_iter().map(|m| m.unwrap_or(IDENTITY)).collect()
}

/// World matrix times inverse bind matrix of every joint (glTF 2.0, 3.7.3).
fn joints(skin: &Value, world: &[Matrix], read: &Numbers<'_>) -> Result<Vec<Matrix>, FormatError> {
    let inverse = match as_index(&skin["inverseBindMatrices"]) {
        Some(accessor) => read(accessor)?.0,
        None => Vec::new(),
    };
    let listed = skin["joints"].as_array().into_iter().flatten();
    let joint = |(i, joint): (usize, &Value)| {
        let world = as_index(joint).and_then(|j| world.get(j)).unwrap_or(&IDENTITY);
        let bind =
            inverse.get(16 * i..16 * i + 16).map_or(IDENTITY, |m| std::array::from_fn(|k| m[k]));
        product(world, &bind)
    };
    Ok(listed.enumerate().map(joint).collect())
}

/// The matrices of instances; one that does nothing where there is no such extension.
fn instances(extension: &Value, read: &Numbers<'_>) -> Result<Vec<Matrix>, FormatError> {
    let attributes = &extension["attributes"];
    if !attributes.is_object() {
        return Ok(vec![IDENTITY]);
    }
    let mut columns: Vec<(&str, Vec<f64>, usize)> = Vec::new();
    for (name, key) in
        [("TRANSLATION", "translation"), ("ROTATION", "rotation"), ("SCALE", "scale")]
    {
        if let Some(accessor) = as_index(&attributes[name]) {
            let (numbers, components) = read(accessor)?;
            columns.push((key, numbers, components));
        }
    }
    let count = columns
        .iter()
        .map(|(_, numbers, components)| numbers.len() / components)
        .min()
        .unwrap_or(1);
    if count > MOST {
        return Err(FormatError::new(
            Fault::Limit,
            "nodes",
            format!("show more than {MOST} instances"),
        ));
    }
    let one = |i: usize| {
        let mut node = json!({});
        for (key, numbers, components) in &columns {
            node[*key] = json!(numbers[i * components..(i + 1) * components]);
        }
        local(&node)
    };
    Ok((0..count).map(one).collect())
}
