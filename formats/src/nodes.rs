//! The nodes of a glTF document: which of them a scene shows, and where they stand.

use serde_json::Value;

/// A 4×4 matrix, column by column, as glTF has it.
pub(crate) type Matrix = [f64; 16];

/// Nothing moves.
pub(crate) const IDENTITY: Matrix =
    [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];

/// An index into one of the document's lists.
pub(crate) fn as_index(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|i| usize::try_from(i).ok())
}

/// The topmost nodes of the default scene; of the whole file if there are no scenes.
pub(crate) fn roots(json: &Value, nodes: &[Value]) -> Vec<usize> {
    let scene = &json["scenes"][as_index(&json["scene"]).unwrap_or(0)];
    if let Some(listed) = scene["nodes"].as_array() {
        return listed.iter().filter_map(as_index).collect();
    }
    if json["scenes"].is_array() {
        return Vec::new();
    }
    let mut is_child = vec![false; nodes.len()];
    for child in
        nodes.iter().filter_map(|n| n["children"].as_array()).flatten().filter_map(as_index)
    {
        if let Some(c) = is_child.get_mut(child) {
            *c = true;
        }
    }
    (0..nodes.len()).filter(|&n| !is_child[n]).collect()
}

/// As many numbers as there should be, or the default.
pub(crate) fn numbers<const N: usize>(value: &Value, default: [f64; N]) -> [f64; N] {
    match value.as_array() {
        Some(a) if a.len() == N => std::array::from_fn(|i| a[i].as_f64().unwrap_or(default[i])),
        _ => default,
    }
}

/// A node's own matrix (glTF 2.0, 3.5.3).
pub(crate) fn local(node: &Value) -> Matrix {
    if node["matrix"].is_array() {
        return numbers(&node["matrix"], IDENTITY);
    }
    let t = numbers(&node["translation"], [0.0; 3]);
    let [x, y, z, w] = numbers(&node["rotation"], [0.0, 0.0, 0.0, 1.0]);
    let s = numbers(&node["scale"], [1.0; 3]);
    let rotation = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let mut m = IDENTITY;
    for column in 0..3 {
        for row in 0..3 {
            m[column * 4 + row] = rotation[column][row] * s[column];
        }
        m[12 + column] = t[column];
    }
    m
}

/// First `b`, then `a`.
pub(crate) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| (0..4).map(|k| a[k * 4 + i % 4] * b[i / 4 * 4 + k]).sum())
}

/// Of the upper left 3×3 part, column by column.
pub(crate) fn cofactors(m: &Matrix) -> [f64; 9] {
    std::array::from_fn(|i| {
        let at = |column: usize, row: usize| m[(i / 3 + column) % 3 * 4 + (i % 3 + row) % 3];
        at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)
    })
}

/// Whether a transformation turns surfaces inside out.
pub(crate) fn mirrors(m: &Matrix) -> bool {
    let c = cofactors(m);
    (0..3).map(|row| c[row] * m[row]).sum::<f64>() < 0.0
}
