//! Feature ids that are numbers of vertices become an attribute: simplification renumbers vertices,
//! and the features of a file of 3D Tiles have to stay theirs.

use crate::gltf::accessor::component_number;
use crate::gltf::json::{Json, Object, object};
use crate::gltf::views::{Buffers, put};
use crate::words::counted;
use lodc_mesh::Component;
use std::collections::BTreeMap;

/// Whole numbers up to this are exact in single precision.
const MAX_ID: usize = 1 << 24;

/// Ids of a primitive's features that follow from the numbers of its vertices: `constant +
/// ⌊vertex ÷ divisor⌋`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Implicit {
    vertices: usize,
    constant: u32,
    divisor: usize,
}

impl Implicit {
    /// The id of a vertex.
    fn of(self, vertex: usize) -> usize {
        (self.constant as usize).saturating_add(vertex / self.divisor)
    }
}

/// Accessors and bytes that are added to a document.
struct Added {
    bytes: Vec<u8>,
    views: Vec<Json>,
    accessors: Vec<Json>,
    /// The accessor of ids that several primitives have.
    of_ids: BTreeMap<Implicit, usize>,
    /// Numbers of the first view and accessor that are added.
    first: [usize; 2],
}

/// Makes implicit ids of triangles explicit. Returns the number of bytes that this adds.
pub(super) fn make_explicit(
    root: &mut Object,
    buffers: &mut Buffers<'_>,
    warnings: &mut Vec<String>,
) -> u64 {
    let counts: Vec<usize> =
        root.entries("accessors").map(|a| a["count"].as_index().unwrap_or(0)).collect();
    let mut added = Added {
        bytes: Vec::new(),
        views: Vec::new(),
        accessors: Vec::new(),
        of_ids: BTreeMap::new(),
        first: [root.entries("bufferViews").len(), counts.len()],
    };
    let (mut made, mut dropped) = (0, 0);
    for mesh in root.objects_mut("meshes") {
        for primitive in mesh.objects_mut("primitives") {
            let draws_triangles = primitive["mode"].as_u64().is_none_or(|mode| mode >= 4);
            let position = primitive["attributes"]["POSITION"].as_index();
            let vertices = position.and_then(|a| counts.get(a)).copied().unwrap_or(0);
            if draws_triangles && vertices > 0 {
                made += of_primitive(primitive, vertices, &mut added, &mut dropped);
            }
        }
    }
    let (one, several) = ("set of implicit feature ids was", "sets of implicit feature ids were");
    if dropped > 0 {
        let sets = counted(dropped, one, several);
        warnings.push(format!("{sets} dropped: ids beyond 2^24"));
    }
    if made == 0 {
        return 0;
    }
    let sets = counted(made, one, several);
    warnings.push(format!("{sets} made explicit, because vertices are renumbered"));
    let length = added.bytes.len();
    let buffer = root.entries("buffers").len();
    root.append("buffers", vec![object! { "byteLength" => length }]);
    added.views.iter_mut().for_each(|view| view["buffer"] = buffer.into());
    root.append("bufferViews", added.views);
    root.append("accessors", added.accessors);
    buffers.push(Some(added.bytes.into()));
    length as u64
}

/// Gives a primitive its ids as attributes; returns the number of sets.
fn of_primitive(
    primitive: &mut Object,
    vertices: usize,
    added: &mut Added,
    dropped: &mut usize,
) -> usize {
    let mut made = 0;
    for (extension, list) in
        [("EXT_mesh_features", "featureIds"), ("EXT_feature_metadata", "featureIdAttributes")]
    {
        let all = primitive.get_mut("extensions").and_then(|all| all.get_mut(extension));
        let sets = all.and_then(|extension| extension.get_mut(list)?.as_array_mut());
        let Some(mut sets) = sets.map(std::mem::take) else { continue };
        let count_before = sets.len();
        sets.retain_mut(|set| {
            let Some(ids) = implicit(extension, set, vertices) else { return true };
            if ids.of(vertices - 1) > MAX_ID {
                return false;
            }
            let taken = |n: &usize| primitive["attributes"].get(&name(*n)).is_none();
            let number = (0..).find(taken).expect("attributes are fewer than numbers");
            primitive["attributes"][&*name(number)] = added.accessor(ids).into();
            match extension {
                "EXT_mesh_features" => set["attribute"] = number.into(),
                _ => set["featureIds"] = object! { "attribute" => name(number) },
            }
            made += 1;
            true
        });
        *dropped += count_before - sets.len();
        primitive["extensions"][extension][list] = sets.into();
    }
    made
}

fn name(number: usize) -> String {
    format!("_FEATURE_ID_{number}")
}

/// The ids of a set, if they follow from the numbers of vertices.
fn implicit(extension: &str, set: &Json, vertices: usize) -> Option<Implicit> {
    if extension == "EXT_mesh_features" {
        let is_implicit =
            set.is_object() && set.get("attribute").is_none() && set.get("texture").is_none();
        return is_implicit.then_some(Implicit { vertices, constant: 0, divisor: 1 });
    }
    let ids = &set["featureIds"];
    let divisor = ids["divisor"].as_index().filter(|divisor| *divisor > 0)?;
    let constant = ids["constant"].as_u64().and_then(|c| u32::try_from(c).ok()).unwrap_or(0);
    ids.get("attribute").is_none().then_some(Implicit { vertices, constant, divisor })
}

impl Added {
    /// The accessor of some ids.
    fn accessor(&mut self, ids: Implicit) -> usize {
        if let Some(&accessor) = self.of_ids.get(&ids) {
            return accessor;
        }
        let value = |vertex: usize| ids.of(vertex) as f32;
        let bytes: Vec<u8> = (0..ids.vertices).flat_map(|v| value(v).to_le_bytes()).collect();
        let [first_view, first_accessor] = self.first;
        let view = first_view + self.views.len();
        self.views.push(put(&mut self.bytes, &bytes));
        let accessor = first_accessor + self.accessors.len();
        self.accessors.push(object! {
            "bufferView" => view, "componentType" => component_number(Component::F32),
            "count" => ids.vertices, "type" => "SCALAR",
        });
        self.of_ids.insert(ids, accessor);
        accessor
    }
}
