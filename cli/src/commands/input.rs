//! The objects of an input: meshes as they are, or objects with levels of detail.

use lodc::LodObject;
use lodc_formats::{ObjectInfo, SceneObject};
use lodc_mesh::Mesh;

/// Objects with levels of detail or without.
pub(super) enum Objects {
    Simplified(Vec<LodObject>),
    Meshes(Vec<SceneObject>),
}

impl Objects {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Simplified(objects) => objects.len(),
            Self::Meshes(objects) => objects.len(),
        }
    }

    /// The mesh of an object; with levels, LOD 0.
    pub(super) fn mesh(&self, object: usize) -> &Mesh {
        match self {
            Self::Simplified(objects) => objects[object].simplified.mesh(),
            Self::Meshes(objects) => &objects[object].mesh,
        }
    }

    pub(super) fn info(&self, object: usize) -> &ObjectInfo {
        match self {
            Self::Simplified(objects) => &objects[object].info,
            Self::Meshes(objects) => &objects[object].info,
        }
    }

    pub(super) fn infos(&self) -> Vec<&ObjectInfo> {
        (0..self.len()).map(|object| self.info(object)).collect()
    }
}
