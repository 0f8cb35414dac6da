//! Exported levels read back (files of `extract` and `chain`): each as a scene, with the metadata
//! and the geomorph targets that the file states.

use crate::Scene;
use crate::provenance::Provenance;

/// What is wrong with a file that states no level.
pub(crate) const NOT_EXPORTED: &str = "not written by `lodc extract` or `lodc chain`: nothing to \
    verify; `lodc build` makes a file of a mesh first";

/// A file of one level or of several, as `extract` and `chain` write them.
#[derive(Clone, Debug)]
pub struct ExportedLevels {
    /// The metadata that the file states.
    pub stated: Provenance,
    /// Each stated level as a scene of its own.
    pub levels: Vec<Scene>,
    /// The first thing that the levels of one file should share and do not, with its location.
    pub difference: Option<String>,
    /// How levels morph to the next ones.
    pub morphs: Vec<Geomorph>,
}

/// How one level of a mesh moves to the next, as its morph target says it.
#[derive(Clone, Debug)]
pub struct Geomorph {
    /// The level that moves: its index in [`ExportedLevels::levels`].
    pub level: usize,
    /// The location of its mesh in the document, as messages name it: `meshes[3]`.
    pub location: String,
    /// The primitives of its mesh.
    pub from: Vec<GeomorphPart>,
    /// The primitives of the next level's mesh.
    pub to: Vec<GeomorphPart>,
}

/// A primitive that morphs, or that another one morphs to.
#[derive(Clone, Debug, Default)]
pub struct GeomorphPart {
    /// Its material and the names of the attributes that move: parts of one kind can morph into
    /// each other.
    pub kind: String,
    /// How many values each vertex has; the first three are its position.
    pub width: usize,
    /// The values of all vertices, vertex by vertex.
    pub values: Vec<f32>,
    /// The values of all vertices when they have moved.
    pub moved: Vec<f32>,
    /// Its triangles.
    pub triangles: Vec<[u32; 3]>,
}
