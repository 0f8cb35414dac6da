//! Names that a scene has for its parts.

use super::json::{as_index, parse_json};
use crate::{Document, FormatError, ObjectInfo};
use serde_json::Value;

/// The names of the parts of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartNames {
    /// By object and submesh the material's name; empty where there is none.
    pub materials: Vec<Vec<String>>,
    /// By object the names of all nodes that show it.
    pub nodes: Vec<Vec<String>>,
}

impl PartNames {
    /// Reads the names of a document's parts.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub fn new(document: &Document, objects: &[&ObjectInfo]) -> Result<Self, FormatError> {
        match document {
            Document::Obj(_) => Ok(Self::of_obj(objects)),
            Document::Gltf(gltf) => Ok(Self::of_gltf(&parse_json(gltf)?, objects)),
        }
    }

    fn of_obj(objects: &[&ObjectInfo]) -> Self {
        let materials = |o: &&ObjectInfo| {
            o.submeshes.iter().map(|s| s.material.clone().unwrap_or_default()).collect()
        };
        Self {
            materials: objects.iter().map(materials).collect(),
            nodes: objects.iter().map(|o| vec![o.name.clone()]).collect(),
        }
    }

    fn of_gltf(json: &Value, objects: &[&ObjectInfo]) -> Self {
        let name = |v: &Value| v["name"].as_str().unwrap_or_default().to_owned();
        let materials = |o: &&ObjectInfo| {
            let primitives = &json["meshes"][o.document_mesh as usize]["primitives"];
            let of = |primitive: u32| match as_index(&primitives[primitive as usize]["material"]) {
                Some(m) => name(&json["materials"][m]),
                None => String::new(),
            };
            o.submeshes.iter().map(|s| of(s.document_primitive)).collect()
        };
        let nodes = |o: &&ObjectInfo| {
            let all = json["nodes"].as_array().into_iter().flatten();
            let shows = |n: &&Value| as_index(&n["mesh"]) == Some(o.document_mesh as usize);
            all.filter(shows).map(name).filter(|n| !n.is_empty()).collect()
        };
        Self {
            materials: objects.iter().map(materials).collect(),
            nodes: objects.iter().map(nodes).collect(),
        }
    }
}
