//! A scene as plain meshes in one space, for formats without nodes.

use super::ExportObject;
use crate::nodes::{IDENTITY, Matrix, as_index, cofactors, local, mirrors, product, roots};
use crate::{Document, Fault, FormatError, GltfDocument};
use lodc_mesh::{Attribute, Mesh, Semantic};
use serde_json::Value;

/// Flattening repeats an object for every node that shows it, but not beyond this many triangles.
const MAX_TRIANGLES: usize = 1 << 28;

/// An object where a node of the scene shows it.
#[derive(Clone, Debug)]
pub(crate) struct Placed<'a> {
    /// The object.
    pub(crate) object: ExportObject<'a>,
    /// The node's name or, lacking that, the object's.
    pub(crate) name: String,
    /// From the object's space to the scene's; none where they are the same, so that bits survive.
    transform: Option<Matrix>,
}

impl Placed<'_> {
    /// A vertex's position in the scene.
    pub(crate) fn position(&self, vertex: u32) -> [f32; 3] {
        let p = self.object.mesh.positions()[vertex as usize];
        let Some(m) = &self.transform else { return p };
        let p = p.map(f64::from);
        std::array::from_fn(|row| {
            finite(m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row])
        })
    }

    /// A vertex's normal in the scene: as it is in the file where nothing moves, of length one
    /// otherwise.
    pub(crate) fn normal(&self, stream: &Attribute, vertex: u32) -> [f32; 3] {
        let n: [f32; 3] = std::array::from_fn(|i| component(stream, vertex, i));
        let Some(m) = &self.transform else { return n };
        let n = n.map(f64::from);
        // Cofactors are the inverse transpose times the determinant: no division, and its sign is
        // put right below.
        let c = cofactors(m);
        let sign = if self.mirrors() { -1.0 } else { 1.0 };
        let v: [f64; 3] =
            std::array::from_fn(|row| sign * (0..3).map(|k| c[k * 3 + row] * n[k]).sum::<f64>());
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.0 { v.map(|x| finite(x / length)) } else { n.map(finite) }
    }

    /// True if the transform turns the surface inside out, so that corners must be listed the other
    /// way round.
    pub(crate) fn mirrors(&self) -> bool {
        self.transform.as_ref().is_some_and(mirrors)
    }

    /// A triangle with its corners in the order that faces outwards in the scene.
    pub(crate) fn corners(&self, [a, b, c]: [u32; 3], mirrors: bool) -> [u32; 3] {
        if mirrors { [a, c, b] } else { [a, b, c] }
    }
}

/// Every object of an OBJ as it is; every object of a glTF for each node of the default scene that
/// shows it (its nodes all, if the file has no scene), and one that no node shows as it is. A
/// skinned object stands as it was modelled: its joints, not its node, would move it.
///
/// # Errors
/// If the document's JSON is damaged or the instances together are too large.
pub(crate) fn placed<'a>(
    document: &Document,
    objects: &[ExportObject<'a>],
) -> Result<Vec<Placed<'a>>, FormatError> {
    let plain = |object: &ExportObject<'a>| Placed {
        object: *object,
        name: object.info.name.clone(),
        transform: None,
    };
    let Document::Gltf(gltf) = document else { return Ok(objects.iter().map(plain).collect()) };
    let json = parse(gltf)?;
    let nodes = json["nodes"].as_array().map(Vec::as_slice).unwrap_or_default();
    let mut shown = vec![false; objects.len()];
    let mut visited = vec![false; nodes.len()];
    let mut out: Vec<Placed<'a>> = Vec::new();
    let mut triangles = 0;
    let mut open: Vec<(usize, Matrix)> =
        roots(&json, nodes).into_iter().rev().map(|n| (n, IDENTITY)).collect();
    while let Some((index, parent)) = open.pop() {
        let Some(node) = nodes.get(index) else { continue };
        if std::mem::replace(&mut visited[index], true) {
            continue;
        }
        let world = product(&parent, &local(node));
        if let Some(children) = node["children"].as_array() {
            open.extend(children.iter().rev().filter_map(as_index).map(|child| (child, world)));
        }
        let Some(mesh) = as_index(&node["mesh"]) else { continue };
        for (object, shown) in
            objects.iter().zip(&mut shown).filter(|(o, _)| o.info.document_mesh as usize == mesh)
        {
            *shown = true;
            triangles += object.mesh.triangles().len();
            if triangles > MAX_TRIANGLES {
                let what = format!(
                    "its instances have more than {MAX_TRIANGLES} triangles together: write a glTF instead"
                );
                return Err(FormatError::new(Fault::Limit, "", what));
            }
            let stays = world == IDENTITY
                || !node["skin"].is_null()
                || world.iter().any(|x| !x.is_finite());
            let name = node["name"].as_str().unwrap_or(&object.info.name).to_owned();
            out.push(Placed { object: *object, name, transform: (!stays).then_some(world) });
        }
    }
    out.extend(
        objects.iter().zip(shown).filter(|(_, shown)| !shown).map(|(object, _)| plain(object)),
    );
    Ok(out)
}

/// The document's JSON.
pub(crate) fn parse(gltf: &GltfDocument) -> Result<Value, FormatError> {
    serde_json::from_str(&gltf.json).map_err(|e| {
        FormatError::new(Fault::Malformed, "", format!("the stored glTF document is damaged: {e}"))
    })
}

#[expect(clippy::cast_possible_truncation, reason = "the formats store single precision")]
fn finite(x: f64) -> f32 {
    (x as f32).clamp(f32::MIN, f32::MAX) + 0.0 // a transform makes no -0
}

/// A component of a stream, zero if it has fewer.
pub(crate) fn component(stream: &Attribute, vertex: u32, i: usize) -> f32 {
    if i < usize::from(stream.components) { stream.value(vertex, i) } else { 0.0 }
}

/// The stream of a submesh with this meaning, at rest.
pub(crate) fn stream<'a>(
    mesh: &'a Mesh,
    submesh: usize,
    semantic: &Semantic,
) -> Option<&'a Attribute> {
    let attributes = mesh.submeshes()[submesh].attributes.iter();
    attributes
        .map(|&a| &mesh.attributes()[a as usize])
        .find(|a| a.semantic == *semantic && a.morph_target.is_none())
}

#[cfg(test)]
#[path = "flatten_tests.rs"]
pub(super) mod tests;
