//! Options of imports and exports.

#[cfg(feature = "import")]
use crate::Limits;
#[cfg(feature = "export")]
use crate::{ObjectInfo, images::PlacedTextures, provenance::Provenance};
#[cfg(feature = "export")]
use lodc_mesh::Mesh;
#[cfg(feature = "import")]
use std::path::PathBuf;

/// Options of an import.
#[cfg(feature = "import")]
#[derive(Clone, Debug, Default)]
pub struct ImportOptions {
    /// Limits on the size of inputs.
    pub limits: Limits,
    /// Folders besides the asset's own that may be read.
    pub allowed: Vec<PathBuf>,
    /// Weld positions closer than this share of the bounding box's diagonal; 0 joins identical
    /// positions only.
    pub weld: f64,
}

/// One object at one level of detail.
#[cfg(feature = "export")]
#[derive(Clone, Copy, Debug)]
pub struct ExportObject<'a> {
    /// Its description.
    pub info: &'a ObjectInfo,
    /// Its triangles, with exactly the submeshes of `info` (some may be empty).
    pub mesh: &'a Mesh,
}

/// Contents of an export besides the document and its objects. The default adds nothing.
#[cfg(feature = "export")]
#[derive(Clone, Debug, Default)]
pub struct ExportOptions {
    /// Image files in or beside the export.
    pub textures: PlacedTextures,
    /// True to compress geometry by EXT_meshopt_compression.
    pub compress: bool,
    /// Bits that numbers keep (KHR_mesh_quantization); the default keeps all.
    pub precision: Precision,
    /// The metadata to state: source, levels and errors.
    pub provenance: Option<Provenance>,
}

/// Bits per number, 2 to 16, of each kind of stream; `None` keeps the numbers as they are.
#[cfg(feature = "export")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Precision {
    /// Positions: the longest side of the scene has 2^n − 2 steps.
    pub position: Option<u8>,
    /// Normals and tangents: on an octahedron, whose sides have this number of bits.
    pub normal: Option<u8>,
    /// Texture coordinates: the longest side of their range in a material has 2^n − 1 steps.
    pub uv: Option<u8>,
    /// Colours, from 0 to 1.
    pub color: Option<u8>,
    /// Weights of joints, from 0 to 1; their sum stays 1.
    pub weight: Option<u8>,
}
