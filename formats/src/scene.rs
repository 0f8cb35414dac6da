//! The imported asset: triangle meshes of every object, and a document with everything else
//! (materials, nodes, animations) as the file had it.

use crate::RequestedFiles;
#[cfg(feature = "gltf")]
use crate::known::Known;
use lodc_mesh::{Mesh, PoseKey};

/// The format that a scene came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceFormat {
    /// Wavefront OBJ.
    Obj,
    /// glTF 2.0, JSON with files beside it.
    Gltf,
    /// glTF 2.0, binary.
    Glb,
    /// Stanford PLY.
    Ply,
    /// STL.
    Stl,
}

impl SourceFormat {
    /// The name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Gltf => "gltf",
            Self::Glb => "glb",
            Self::Ply => "ply",
            Self::Stl => "stl",
        }
    }

    /// Returns whether the document of such a scene is a glTF's.
    #[must_use]
    pub const fn is_gltf(self) -> bool {
        matches!(self, Self::Gltf | Self::Glb)
    }
}

/// Origin of a scene; never a path, so that output does not depend on the folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Its format.
    pub format: SourceFormat,
    /// XXH3-128 of the bytes of the main file and then of every buffer file it names, in order.
    pub content_hash: u128,
}

/// An imported asset.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its origin.
    pub source: Source,
    /// Everything that is not a triangle mesh.
    pub document: Document,
    /// One object per glTF mesh with triangles; one of any other file.
    pub objects: Vec<SceneObject>,
    /// Repairs, and what was dropped or left alone: one line each, with counts.
    pub warnings: Vec<String>,
    /// Every file that the import looked for.
    pub files: RequestedFiles,
    /// True if its geometry was compressed by EXT_meshopt_compression or its successor.
    pub compressed: bool,
    /// True if its document says that streams may be short integers (KHR_mesh_quantization).
    pub quantized: bool,
    /// True if it is an export of lodc that quantised values anew.
    pub requantized: bool,
}

/// One object of a scene.
#[derive(Clone, Debug)]
pub struct SceneObject {
    /// Its description.
    pub info: ObjectInfo,
    /// Its triangles.
    pub mesh: Mesh,
    /// For each vertex of the mesh, which of the file's positions it has, from 0. glTF: empty.
    pub source_positions: Vec<u32>,
}

/// Description of an object besides its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectInfo {
    /// Its name in the file, or `mesh0`, `mesh1`, … or the file's stem.
    pub name: String,
    /// One per submesh of the mesh.
    pub submeshes: Vec<SubmeshInfo>,
    /// World units per mesh unit: the largest scale at which a node of the scene shows it, at rest
    /// or at any moment of its animations; 1 where no node does.
    pub world_scale: f64,
    /// glTF: its index in the document's `meshes`. Others: 0.
    pub document_mesh: u32,
    /// The poses that its errors hold in besides the one at rest.
    pub poses: Vec<PoseKey>,
}

/// Description of a submesh besides its triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct SubmeshInfo {
    /// OBJ: the group or object name; STL: the solid's name; others: empty.
    pub name: String,
    /// The material's name. glTF: none (the document's primitive has it).
    pub material: Option<String>,
    /// glTF: its index in the document mesh's `primitives`. Others: the submesh's own index.
    pub document_primitive: u32,
}

/// Everything of an asset that is not a triangle mesh, enough to write the whole scene again.
#[derive(Clone, Debug, PartialEq)]
pub enum Document {
    /// From an OBJ, PLY or STL.
    Obj(ObjDocument),
    /// From a glTF.
    Gltf(GltfDocument),
}

impl Document {
    /// Returns whether it has materials.
    #[must_use]
    pub fn has_materials(&self) -> bool {
        match self {
            Self::Obj(obj) => !obj.materials.is_empty(),
            Self::Gltf(gltf) => gltf.json().contains("\"materials\":"),
        }
    }

    /// Returns whether it names images that materials may show.
    #[must_use]
    pub fn has_textures(&self) -> bool {
        match self {
            Self::Obj(obj) => {
                let mut lines = obj.materials.iter().flat_map(|m| &m.lines);
                lines.any(|line| line.trim_start().starts_with("map_Kd"))
            }
            Self::Gltf(gltf) => gltf.json().contains("\"textures\":"),
        }
    }
}

/// The rest of an OBJ; of a PLY, its textures as materials; of an STL, nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjDocument {
    /// Names of the material libraries, as the OBJ has them.
    pub libraries: Vec<String>,
    /// Materials, in the order of the libraries: name and the lines of their definition as read.
    pub materials: Vec<ObjMaterial>,
    /// Points and lines: statements `v`, `p` and `l` of an OBJ by themselves.
    pub loose: Vec<String>,
    /// Where the object's mesh stands: to be added to its positions. Zeros unless the file's
    /// coordinates are too far from the origin for single precision.
    pub offset: [f64; 3],
}

/// One material of an MTL file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjMaterial {
    /// Its name.
    pub name: String,
    /// The lines of its definition after `newmtl`, as read.
    pub lines: Vec<String>,
}

/// The rest of a glTF: its text and buffer 0. The text is parsed and checked once, when it is first
/// read.
#[derive(Clone, Debug, Default)]
pub struct GltfDocument {
    json: String,
    blob: Vec<u8>,
    /// Its root, parsed and checked, and its accessors.
    #[cfg(feature = "gltf")]
    pub(crate) root: Known,
    #[cfg(feature = "gltf")]
    pub(crate) accessors: Known,
}

impl GltfDocument {
    /// A document of its text and the bytes of buffer 0; nothing is checked yet.
    #[must_use]
    pub fn new(json: String, blob: Vec<u8>) -> Self {
        Self {
            json,
            blob,
            #[cfg(feature = "gltf")]
            root: Known::default(),
            #[cfg(feature = "gltf")]
            accessors: Known::default(),
        }
    }

    /// The JSON document. Primitives that are objects' submeshes have no `indices` and no
    /// `attributes` or `targets` accessors any more; everything else is as it was, its buffer views
    /// pointing into [`Self::blob`] (buffer 0).
    #[must_use]
    pub fn json(&self) -> &str {
        &self.json
    }

    /// The bytes that remaining buffer views refer to.
    #[must_use]
    pub fn blob(&self) -> &[u8] {
        &self.blob
    }
}

impl PartialEq for GltfDocument {
    fn eq(&self, other: &Self) -> bool {
        self.json == other.json && self.blob == other.blob
    }
}

/// What a mesh file holds, as far as can be told without reading it.
#[cfg(feature = "import")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Triangles, those without area included.
    pub triangles: u64,
    /// Vertices that the file stores; corners may make more of them in OBJ, joining makes fewer in
    /// STL.
    pub vertices: u64,
    /// Bytes of the file and of the buffers that it names, decompressed.
    pub bytes: u64,
}
