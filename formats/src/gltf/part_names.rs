//! Names of a scene's materials and nodes by object and submesh, as they are used to select parts
//! on the command line.

use super::json::Object;
use crate::{Document, FormatError, Limits, ObjectInfo, SubmeshInfo};

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
            Document::Gltf(gltf) => Ok(Self::of_gltf(gltf.root(&Limits::DEFAULT)?, objects)),
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

    fn of_gltf(root: &Object, objects: &[&ObjectInfo]) -> Self {
        let name = |v: &Object| v["name"].as_str().unwrap_or_default().to_owned();
        let material_names: Vec<String> = root.entries("materials").map(name).collect();
        let materials = |o: &&ObjectInfo| {
            let primitives = &root["meshes"][o.document_mesh as usize]["primitives"];
            let material_name = |s: &SubmeshInfo| {
                let material = primitives[s.document_primitive as usize]["material"].as_index();
                material.and_then(|m| material_names.get(m)).cloned().unwrap_or_default()
            };
            o.submeshes.iter().map(material_name).collect()
        };
        let nodes = |o: &&ObjectInfo| {
            let shows = |n: &&Object| n["mesh"].as_index() == Some(o.document_mesh as usize);
            let names = root.entries("nodes").filter(shows).map(name);
            names.filter(|n| !n.is_empty()).collect()
        };
        Self {
            materials: objects.iter().map(materials).collect(),
            nodes: objects.iter().map(nodes).collect(),
        }
    }
}
