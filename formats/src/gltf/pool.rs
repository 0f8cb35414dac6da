//! The lists of a document that indices are of.

use super::json::Object;

/// A top-level array that other members point into by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pool {
    Accessors,
    BufferViews,
    Buffers,
    Cameras,
    Images,
    Lights,
    Materials,
    Meshes,
    Nodes,
    Samplers,
    Scenes,
    Skins,
    Textures,
}

impl Pool {
    pub(crate) const ALL: [Self; 13] = [
        Self::Accessors,
        Self::BufferViews,
        Self::Buffers,
        Self::Cameras,
        Self::Images,
        Self::Lights,
        Self::Materials,
        Self::Meshes,
        Self::Nodes,
        Self::Samplers,
        Self::Scenes,
        Self::Skins,
        Self::Textures,
    ];

    /// The array's name in the document.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Accessors => "accessors",
            Self::BufferViews => "bufferViews",
            Self::Buffers => "buffers",
            Self::Cameras => "cameras",
            Self::Images => "images",
            Self::Lights => "lights",
            Self::Materials => "materials",
            Self::Meshes => "meshes",
            Self::Nodes => "nodes",
            Self::Samplers => "samplers",
            Self::Scenes => "scenes",
            Self::Skins => "skins",
            Self::Textures => "textures",
        }
    }

    /// Number of entries in the document.
    pub(crate) fn len(self, root: &Object) -> usize {
        match self {
            Self::Lights => root["extensions"]["KHR_lights_punctual"]["lights"].list().len(),
            _ => root.list(self.name()).len(),
        }
    }
}
