//! The node hierarchy: a forest, and the largest scale at which it shows each mesh.

use super::accessor::Accessor;
use super::extensions::INSTANCING;
use super::json::{self, Object, entries, integer, list, malformed};
use super::views::Views;
use crate::FormatError;
use lodc_mesh::Component;
use serde_json::Value;

/// The linear part of a transformation, by columns.
type Linear = [[f64; 3]; 3];

const IDENTITY: Linear = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Nodes, parents before their children, and each one's parent.
#[derive(Debug)]
struct Forest {
    order: Vec<usize>,
    parent: Vec<Option<usize>>,
}

/// Checks that no node has two parents and none is its own ancestor, without recursion.
fn forest(root: &Object) -> Result<Forest, FormatError> {
    let nodes = entries(root, "nodes").len();
    let mut parent = vec![None; nodes];
    for (i, node) in entries(root, "nodes").enumerate() {
        for child in children(node) {
            if let Some(other) = parent[child].replace(i) {
                let what = format!(
                    "is a child of nodes[{other}] and of nodes[{i}]: the scene is not a tree"
                );
                return Err(malformed(format!("nodes[{child}]"), what));
            }
        }
    }
    let mut order: Vec<usize> = (0..nodes).filter(|&i| parent[i].is_none()).collect();
    let all: Vec<&Object> = entries(root, "nodes").collect();
    let mut at = 0;
    while let Some(&node) = order.get(at) {
        order.extend(children(all[node]));
        at += 1;
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
    Ok(Forest { order, parent })
}

fn children(node: &Object) -> impl Iterator<Item = usize> {
    list(node, "children").iter().filter_map(integer).map(|i| i as usize)
}

fn index(object: &Object, key: &str) -> Option<usize> {
    object.get(key).and_then(integer).map(|i| i as usize)
}

/// The largest scale at which a node of the default scene (of any scene if there is no default one,
/// or of the whole file if there are no scenes) shows each mesh: the largest singular value of the
/// node's world matrix; for skinned meshes of any joint's skinning matrix at rest; for instanced
/// ones times their largest scale. 1 for meshes that nothing shows. Fails if the nodes are no
/// forest.
pub(super) fn world_scales(
    root: &Object,
    accessors: &[Option<Accessor>],
    views: &Views<'_>,
) -> Result<Vec<f64>, FormatError> {
    let forest = forest(root)?;
    let nodes: Vec<&Object> = entries(root, "nodes").collect();
    let mut world = vec![IDENTITY; nodes.len()];
    for &i in &forest.order {
        let own = local(nodes[i]);
        world[i] = forest.parent[i].map_or(own, |p| product(&world[p], &own));
    }
    let mut largest: Vec<Option<f64>> = vec![None; entries(root, "meshes").len()];
    for i in visible(root, &forest) {
        let Some(mesh) = index(nodes[i], "mesh") else { continue };
        let mut scale = match index(nodes[i], "skin") {
            Some(skin) => skinned(root, skin, &world, accessors, views)?,
            None => singular_value(&world[i]),
        };
        if let Some(instancing) = json::extension(nodes[i], INSTANCING) {
            scale *= instances(instancing, accessors, views)?;
        }
        largest[mesh] = Some(largest[mesh].map_or(scale, |s| s.max(scale)));
    }
    // A scale of nothing, or one beyond all numbers, says nothing about where detail is needed.
    let usable = |s: &f64| s.is_finite() && *s > 0.0;
    Ok(largest.into_iter().map(|s| s.filter(usable).unwrap_or(1.0)).collect())
}

fn visible(root: &Object, forest: &Forest) -> Vec<usize> {
    let scenes: Vec<&Object> = entries(root, "scenes").collect();
    let mut shown = vec![scenes.is_empty(); forest.parent.len()];
    let chosen = index(root, "scene").map_or(0..scenes.len(), |s| s..s + 1);
    for scene in &scenes[chosen] {
        for node in list(scene, "nodes").iter().filter_map(integer) {
            shown[node as usize] = true;
        }
    }
    for &i in &forest.order {
        if forest.parent[i].is_some_and(|p| shown[p]) {
            shown[i] = true;
        }
    }
    (0..shown.len()).filter(|&i| shown[i]).collect()
}

fn local(node: &Object) -> Linear {
    let numbers =
        |key: &str| -> Vec<f64> { list(node, key).iter().filter_map(Value::as_f64).collect() };
    if let [a, b, c, _, d, e, f, _, g, h, i, ..] = numbers("matrix")[..] {
        return [[a, b, c], [d, e, f], [g, h, i]];
    }
    let mut m = IDENTITY;
    if let [x, y, z, w] = numbers("rotation")[..] {
        let n = x * x + y * y + z * z + w * w;
        if n > 0.0 && n.is_finite() {
            let s = 2.0 / n;
            m = [
                [1.0 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)],
                [s * (x * y - z * w), 1.0 - s * (x * x + z * z), s * (y * z + x * w)],
                [s * (x * z + y * w), s * (y * z - x * w), 1.0 - s * (x * x + y * y)],
            ];
        }
    }
    if let [x, y, z] = numbers("scale")[..] {
        for (column, s) in m.iter_mut().zip([x, y, z]) {
            column.iter_mut().for_each(|v| *v *= s);
        }
    }
    m
}

fn product(a: &Linear, b: &Linear) -> Linear {
    b.map(|column| std::array::from_fn(|row| (0..3).map(|k| a[k][row] * column[k]).sum()))
}

/// The factor by which a transformation stretches at most: the root of the largest eigenvalue of
/// its Gram matrix, found by Jacobi's rotations.
fn singular_value(m: &Linear) -> f64 {
    let size = m.iter().flatten().fold(0.0f64, |s, v| s.max(v.abs()));
    if size == 0.0 || !size.is_finite() {
        return size;
    }
    // Scaled, so that squares neither vanish nor overflow.
    let dot = |i: usize, j: usize| (0..3).map(|k| (m[i][k] / size) * (m[j][k] / size)).sum::<f64>();
    let mut g: Linear = std::array::from_fn(|i| std::array::from_fn(|j| dot(i, j)));
    for _ in 0..16 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if g[p][q] == 0.0 {
                continue;
            }
            let theta = (g[q][q] - g[p][p]) / (2.0 * g[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut g {
                let (a, b) = (row[p], row[q]);
                (row[p], row[q]) = (c * a - s * b, s * a + c * b);
            }
            let (a, b) = (g[p], g[q]);
            g[p] = std::array::from_fn(|k| c * a[k] - s * b[k]);
            g[q] = std::array::from_fn(|k| s * a[k] + c * b[k]);
        }
    }
    size * g[0][0].max(g[1][1]).max(g[2][2]).max(0.0).sqrt()
}

fn skinned(
    root: &Object,
    skin: usize,
    world: &[Linear],
    accessors: &[Option<Accessor>],
    views: &Views<'_>,
) -> Result<f64, FormatError> {
    let Some(skin) = entries(root, "skins").nth(skin) else { return Ok(1.0) };
    let inverse = match index(skin, "inverseBindMatrices").and_then(|a| accessors[a].as_ref()) {
        Some(a) if a.shape.components() == 16 && a.component == Component::F32 => {
            Some((a.count, a.reader(views)?))
        }
        _ => None,
    };
    let mut largest = 0.0f64;
    let mut bytes = Vec::with_capacity(64);
    for (i, joint) in list(skin, "joints").iter().filter_map(integer).enumerate() {
        let mut m = world[joint as usize];
        if let Some((_, reader)) = inverse.as_ref().filter(|(count, _)| i < *count) {
            bytes.clear();
            reader.append(i as u32, &mut bytes);
            let v = |k: usize| {
                bytes
                    .get(4 * k..4 * k + 4)
                    .map_or(0.0, |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])))
            };
            m = product(&m, &std::array::from_fn(|c| std::array::from_fn(|r| v(4 * c + r))));
        }
        largest = largest.max(singular_value(&m));
    }
    Ok(largest)
}

/// The largest scale of any instance in any direction.
fn instances(
    extension: &Object,
    accessors: &[Option<Accessor>],
    views: &Views<'_>,
) -> Result<f64, FormatError> {
    let scale = extension.get("attributes").and_then(|a| a.get("SCALE")).and_then(integer);
    let Some(accessor) = scale.and_then(|a| accessors[a as usize].as_ref()) else { return Ok(1.0) };
    if accessor.component != Component::F32 || !accessor.has_data() {
        return Ok(1.0);
    }
    let reader = accessor.reader(views)?;
    let mut bytes = Vec::new();
    let mut largest = 0.0f64;
    for i in 0..accessor.count {
        bytes.clear();
        reader.append(i as u32, &mut bytes);
        for b in bytes.chunks_exact(4) {
            largest = largest.max(f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])).abs());
        }
    }
    Ok(largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_singular_value_is_the_largest_stretch() {
        let turned = local(
            json_object(r#"{"rotation":[0.5,0.5,0.5,0.5],"scale":[2,-7,3]}"#)
                .as_object()
                .expect("one"),
        );
        assert!((singular_value(&turned) - 7.0).abs() < 1e-12);
        // A shear stretches more than its longest column: the golden ratio.
        let shear = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!((singular_value(&shear) - (1.0 + 5.0f64.sqrt()) / 2.0).abs() < 1e-12);
        assert_eq!(singular_value(&[[0.0; 3]; 3]), 0.0);
        assert!(
            (singular_value(&IDENTITY.map(|c| c.map(|v| v * 1e200))) / 1e200 - 1.0).abs() < 1e-12
        );
    }

    #[test]
    fn loops_and_second_parents_are_refused() {
        for nodes in [
            r#"[{"children":[0]}]"#,
            r#"[{"children":[1]},{"children":[0]}]"#,
            r#"[{"children":[2]},{"children":[2]},{}]"#,
        ] {
            let root = json_object(&format!(r#"{{"nodes":{nodes}}}"#));
            assert!(forest(root.as_object().expect("one")).is_err(), "{nodes}");
        }
        let root = json_object(r#"{"nodes":[{},{"children":[0,2]},{}]}"#);
        assert_eq!(
            forest(root.as_object().expect("one")).map(|f| f.order).ok(),
            Some(vec![1, 0, 2])
        );
    }

    fn json_object(text: &str) -> Value {
        serde_json::from_str(text).expect("JSON of the test")
    }
}
