//! Exported levels read back (files of `extract` and `chain`): each as a scene, with the metadata
//! and the glide targets that the file states.

use crate::Scene;
use crate::provenance::Provenance;

/// A file of one level or of several, as `extract` and `chain` write them.
#[derive(Clone, Debug)]
pub struct ShippedLevels {
    /// What it says of itself.
    pub stated: Provenance,
    /// Each level as a scene of its own, as many as are stated.
    pub levels: Vec<Scene>,
    /// What the levels of one file do not share although they should, and where.
    pub difference: Option<String>,
    /// The way from levels to the next ones, where they glide.
    pub glides: Vec<Glide>,
}

/// The way from one level of a mesh to the next, as its morph target says it.
#[derive(Clone, Debug)]
pub struct Glide {
    /// The level that moves.
    pub level: usize,
    /// The mesh.
    pub location: String,
    /// Its primitives.
    pub from: Vec<GlidePart>,
    /// Those of the next level.
    pub to: Vec<GlidePart>,
}

/// A primitive that glides, or that another one glides to.
#[derive(Clone, Debug, Default)]
pub struct GlidePart {
    /// Its material, and the names of what moves.
    pub kind: String,
    /// Numbers of a vertex, of which the first three are its position.
    pub width: usize,
    /// The numbers of all vertices.
    pub values: Vec<f32>,
    /// The same at the end of the way.
    pub moved: Vec<f32>,
    /// Its triangles.
    pub triangles: Vec<[u32; 3]>,
}
