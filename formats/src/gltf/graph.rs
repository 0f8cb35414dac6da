//! The node hierarchy, skins and default scene of a glTF document as [`lodc_scene`] types.

use super::document::Stored;
use super::extensions::INSTANCING;
use super::json::{Json, Object};
use crate::{Document, Fault, FormatError, Limits, ObjectInfo};
use lodc_scene::{Graph, LocalTransform, Node, Skin, Transform, transform_from_columns};
use std::collections::BTreeMap;

/// More instances than this in one document are refused: a small file can ask for any number.
/// Chosen by hand.
const MAX_INSTANCES: usize = 1 << 22;

/// Reads all components of all elements of an accessor, and how many components an element has.
pub(crate) type Numbers<'a> = dyn Fn(usize) -> Result<(Vec<f64>, usize), FormatError> + 'a;

/// Returns the nodes of a scene, each with the indices of the `objects` that it shows. The default
/// scene is the one that the document names, else its first one; all nodes where it has no scenes.
/// An OBJ shows each object once.
///
/// # Errors
/// If the stored document is damaged, or has more than four million instances.
pub fn scene_graph(
    document: &Document,
    objects: &[&ObjectInfo],
    limits: &Limits,
) -> Result<Graph, FormatError> {
    match document {
        Document::Obj(obj) => Ok(Graph::of_objects_at(objects.len() as u32, obj.offset)),
        Document::Gltf(gltf) => Stored::read(gltf, limits, |stored, root| {
            let meshes: Vec<u32> = objects.iter().map(|o| o.document_mesh).collect();
            gltf_graph(root, &meshes, &|accessor| stored.numbers(accessor))
        }),
    }
}

/// Reads the nodes of a glTF document. `meshes` has for each object the number of its mesh.
pub(crate) fn gltf_graph(
    root: &Object,
    meshes: &[u32],
    read: &Numbers<'_>,
) -> Result<Graph, FormatError> {
    let mut objects_by_mesh: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (object, &mesh) in (0..).zip(meshes) {
        objects_by_mesh.entry(mesh).or_default().push(object);
    }
    let meshes: Vec<&Object> = root.entries("meshes").collect();
    let mut instance_count = 0;
    let mut nodes = Vec::with_capacity(root.entries("nodes").len());
    for source in root.entries("nodes") {
        let mesh = source["mesh"].as_index();
        let weights = [Some(source), mesh.and_then(|m| meshes.get(m).copied())];
        let weights = weights.into_iter().flatten().find_map(|o| o.get("weights")?.as_array());
        let weight = |w: &Json| w.as_f64().unwrap_or(0.0);
        let node = Node {
            name: source["name"].as_str().unwrap_or_default().to_owned(),
            local: local(source),
            children: indices(source, "children"),
            objects: mesh
                .and_then(|m| objects_by_mesh.get(&(m as u32)))
                .cloned()
                .unwrap_or_default(),
            skin: source["skin"].as_index().map(|s| s as u32),
            weights: weights.into_iter().flatten().map(weight).collect(),
            instances: source.extension(INSTANCING).map(|e| instances(e, read)).transpose()?,
        };
        instance_count += node.instances.as_ref().map_or(0, Vec::len);
        if instance_count > MAX_INSTANCES {
            let problem = format!("show more than {MAX_INSTANCES} instances");
            return Err(FormatError::new(Fault::Limit, "nodes", problem));
        }
        nodes.push(node);
    }
    let skins = root.entries("skins").map(|s| skin(s, read)).collect::<Result<_, _>>()?;
    let mut graph = Graph { nodes, roots: Vec::new(), skins };
    let scenes: Vec<&Object> = root.entries("scenes").collect();
    graph.roots = match scenes.get(root["scene"].as_index().unwrap_or(0)) {
        Some(scene) => indices(scene, "nodes"),
        None if root.contains_key("scenes") => Vec::new(),
        None => graph.topmost(),
    };
    Ok(graph)
}

fn indices(object: &Object, key: &str) -> Vec<u32> {
    let all = object.list(key).iter().filter_map(Json::as_u64);
    all.filter_map(|i| u32::try_from(i).ok()).collect()
}

fn local(node: &Object) -> LocalTransform {
    if node.list("matrix").len() == 16 {
        return LocalTransform::from_columns(&node["matrix"].numbers([0.0; 16]));
    }
    LocalTransform::Trs {
        translation: node["translation"].numbers([0.0; 3]),
        rotation: node["rotation"].numbers([0.0, 0.0, 0.0, 1.0]),
        scale: node["scale"].numbers([1.0; 3]),
    }
}

fn skin(skin: &Object, read: &Numbers<'_>) -> Result<Skin, FormatError> {
    let (values, components) = match skin["inverseBindMatrices"].as_index() {
        Some(accessor) => read(accessor)?,
        None => (Vec::new(), 16),
    };
    // Matrices of another shape are ignored.
    let matrices = if components == 16 { values.as_chunks::<16>().0 } else { &[] };
    Ok(Skin {
        joints: indices(skin, "joints"),
        inverse_bind: matrices.iter().map(transform_from_columns).collect(),
    })
}

/// The transforms of instances. A property that they do not have is that of a node without it.
fn instances(extension: &Object, read: &Numbers<'_>) -> Result<Vec<Transform>, FormatError> {
    let attributes = &extension["attributes"];
    let column = |name: &str, components: usize| -> Result<Option<Vec<f64>>, FormatError> {
        let Some(accessor) = attributes[name].as_index() else { return Ok(None) };
        let (values, found) = read(accessor)?;
        Ok((found == components).then_some(values))
    };
    let translations = column("TRANSLATION", 3)?;
    let rotations = column("ROTATION", 4)?;
    let scales = column("SCALE", 3)?;
    let counts = [(&translations, 3), (&rotations, 4), (&scales, 3)];
    let counts = counts.into_iter().filter_map(|(c, n)| Some(c.as_ref()?.len() / n));
    let count = counts.min().unwrap_or(1);
    let vector = |column: &Option<Vec<f64>>, i: usize, default: f64| match column {
        Some(values) => [values[3 * i], values[3 * i + 1], values[3 * i + 2]],
        None => [default; 3],
    };
    let transform = |i: usize| {
        let rotation = rotations.as_ref().map(|r| std::array::from_fn(|k| r[4 * i + k]));
        let local = LocalTransform::Trs {
            translation: vector(&translations, i, 0.0),
            rotation: rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]),
            scale: vector(&scales, i, 1.0),
        };
        local.matrix()
    };
    Ok((0..count).map(transform).collect())
}

#[cfg(test)]
#[path = "graph_tests.rs"]
mod tests;
