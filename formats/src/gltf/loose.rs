//! Points and lines of a stored glTF where its default scene shows them, for formats without
//! nodes.

use super::document::Stored;
use super::graph::gltf_graph;
use super::json::{Json, Object};
use crate::loose::Loose;
use crate::{FormatError, GltfDocument, Limits};
use lodc_scene::{Transform, srgb_value};

/// Reads them, in world space.
///
/// # Errors
/// If the document is damaged.
pub(crate) fn loose(document: &GltfDocument) -> Result<Loose, FormatError> {
    Stored::read(document, &Limits::DEFAULT, |stored, root| {
        let mut loose = Loose::default();
        let has_any = root.entries("meshes").any(|m| m.list("primitives").iter().any(is_loose));
        if !has_any {
            return Ok(loose);
        }
        let numbers = |accessor| stored.numbers(accessor);
        let graph = gltf_graph(root, &[], &numbers)?;
        let transforms = graph.world_transforms(&graph.rest_pose());
        for node in graph.visible() {
            let mesh = root["nodes"][node as usize]["mesh"].as_index();
            let Some(mesh) = mesh.and_then(|m| root.list("meshes").get(m)) else { continue };
            for primitive in mesh["primitives"].list().iter().filter(|p| is_loose(p)) {
                let Some(primitive) = primitive.as_object() else { continue };
                add(primitive, &transforms[node as usize], stored, &mut loose)?;
            }
        }
        Ok(loose)
    })
}

/// Returns whether a primitive draws points or lines.
fn is_loose(primitive: &Json) -> bool {
    primitive["mode"].as_u64().is_some_and(|mode| mode < 4)
        && primitive["attributes"]["POSITION"].as_index().is_some()
}

fn add(
    primitive: &Object,
    transform: &Transform,
    stored: &Stored<'_>,
    loose: &mut Loose,
) -> Result<(), FormatError> {
    let attribute = |name: &str| {
        let accessor = primitive["attributes"][name].as_index();
        accessor.map(|a| stored.numbers(a)).transpose()
    };
    let Some((positions, 3)) = attribute("POSITION")? else { return Ok(()) };
    let first = loose.positions.len() as u32;
    let points = positions.as_chunks::<3>().0;
    let count = points.len() as u32;
    loose.positions.extend(points.iter().map(|&p| {
        let p = transform.transform_point3(p.into());
        p.to_array()
    }));
    if let Some((colors, components)) = attribute("COLOR_0")? {
        loose.colors.resize(first as usize, [1.0; 3]);
        let srgb = |c: &[f64]| {
            std::array::from_fn(|i| srgb_value(c.get(i).copied().unwrap_or(1.0) as f32))
        };
        loose.colors.extend(colors.chunks(components.max(1)).map(srgb));
    }
    if !loose.colors.is_empty() {
        loose.colors.resize(loose.positions.len(), [1.0; 3]);
    }
    let indices: Vec<u32> = match primitive["indices"].as_index() {
        Some(accessor) => stored.numbers(accessor)?.0.iter().map(|&i| i as u32).collect(),
        None => (0..count).collect(),
    };
    let vertices: Vec<u32> = indices.iter().filter(|&&i| i < count).map(|i| first + i).collect();
    // 0 points, 1 lines, 2 line loop, 3 line strip.
    match primitive["mode"].as_u64() {
        Some(0) => loose.points.extend(vertices),
        Some(1) => loose.lines.extend(vertices.as_chunks::<2>().0.iter().map(|l| l.to_vec())),
        mode => {
            let start = vertices.first().copied().filter(|_| mode == Some(2));
            loose.lines.push(vertices.into_iter().chain(start).collect());
        }
    }
    Ok(())
}
