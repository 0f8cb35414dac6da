//! Makes a scene of faces with any number of corners, as OBJ, PLY and STL have them.

mod assemble;
mod local;
mod triangulate;
mod unique;

pub(crate) use assemble::{Assembled, assemble};
pub(crate) use local::{local, may_be_far};
pub(crate) use lodc_mesh::NONE;
use unique::Unique;
pub(crate) use unique::first_equal;

use crate::far::diagonal;
use crate::options::ImportOptions;
use crate::words::counted;
use crate::{
    Assets, Document, Fault, FormatError, ObjDocument, ObjectInfo, Scene, SceneObject, Source,
    SourceFormat, SubmeshInfo,
};
use lodc_mesh::{Attribute, Component, Mesh, MeshParts, Semantic};
use std::path::Path;

/// Faces and what their corners have. Indices count from 0 and are in range.
#[derive(Debug, Default)]
pub(crate) struct Faces {
    pub(crate) positions: Vec<[f32; 3]>,
    /// Empty, or one per position: sRGB values and opacity, white where the file has none.
    pub(crate) colors: Vec<[f32; 4]>,
    pub(crate) color_has_alpha: bool,
    /// Empty, or for each position which of the file's it is: colours of faces divide some.
    pub(crate) file_positions: Vec<u32>,
    pub(crate) texcoords: Vec<[f32; 2]>,
    /// Empty, or the third components.
    pub(crate) texcoords_w: Vec<f32>,
    pub(crate) normals: Vec<[f32; 3]>,
    /// The index of each corner's position.
    pub(crate) corner_v: Vec<u32>,
    /// The index of each corner's texture coordinates or [`NONE`]; empty if no corner has any.
    pub(crate) corner_t: Vec<u32>,
    /// The index of each corner's normal or [`NONE`]; empty if no corner has any.
    pub(crate) corner_n: Vec<u32>,
    /// For each face the number of corners up to its last.
    pub(crate) face_ends: Vec<u32>,
    /// Runs of faces with the same material and label.
    pub(crate) runs: Vec<Run>,
    /// Names of materials in order of appearance.
    pub(crate) materials: Vec<String>,
    /// Names of the parts that become submeshes (groups and objects of an OBJ, solids of an STL),
    /// in order of appearance.
    pub(crate) labels: Vec<String>,
    /// Names of the objects in the file. If there is only one, its name becomes that of the scene's
    /// object, and submeshes are not named by it.
    pub(crate) objects: Vec<String>,
}

/// Faces from `first_face` up to the next run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) first_face: u32,
    /// Index into the materials, or [`NONE`].
    pub(crate) material: u32,
    /// Index into the labels, or [`NONE`].
    pub(crate) label: u32,
}

impl Faces {
    /// Gives the corners of each face its colour, by number in `palette`; positions that faces of
    /// different colours share are divided. `seed` is any number that the file's maker cannot
    /// choose.
    pub(crate) fn color_by_face(&mut self, numbers: &[u32], palette: &[[f32; 4]], seed: u64) {
        let mut unique = Unique::new(seed);
        let mut keys: Vec<[u32; 3]> = Vec::new();
        let mut start = 0;
        for (&end, &color) in self.face_ends.iter().zip(numbers) {
            for v in &mut self.corner_v[start..end as usize] {
                let key = [*v, color, 0];
                *v = unique.number(key, keys.len() as u32, |id| keys[id as usize]);
                if *v as usize == keys.len() {
                    keys.push(key);
                }
            }
            start = end as usize;
        }
        self.positions = keys.iter().map(|k| self.positions[k[0] as usize]).collect();
        self.colors = keys.iter().map(|k| palette[k[1] as usize]).collect();
        self.file_positions = keys.iter().map(|k| k[0]).collect();
    }

    /// Name of the only object, or the file's.
    pub(crate) fn name(&self, assets: &Assets) -> String {
        match &self.objects[..] {
            [only] => only.clone(),
            _ => assets.stem(),
        }
    }
}

/// What a file that is one object holds, whose submeshes are its materials.
pub(crate) struct FaceFile {
    pub(crate) assembled: Assembled,
    /// The object's name; empty if it has none.
    pub(crate) name: String,
    pub(crate) source: Source,
    pub(crate) document: ObjDocument,
    pub(crate) warnings: Vec<String>,
}

/// Makes the scene of a file.
///
/// # Errors
/// If the mesh is too large.
pub(crate) fn scene(
    file: FaceFile,
    assets: &Assets,
    options: &ImportOptions,
) -> Result<Scene, FormatError> {
    let FaceFile { mut assembled, name, source, document, mut warnings } = file;
    let mut parts = std::mem::take(&mut assembled.parts);
    if assembled.byte_colors {
        warnings.push("colours of vertices are numbers from 0 to 255, read as bytes".to_owned());
    }
    let source_positions =
        clean_numbered(&mut parts, assembled.source_positions, options.weld, &mut warnings);
    let mesh =
        Mesh::try_from(parts).map_err(|e| FormatError::new(Fault::Limit, "", e.to_string()))?;
    let name = if name.is_empty() { "mesh0".to_owned() } else { name };
    let info = ObjectInfo {
        name,
        submeshes: assembled.submeshes,
        world_scale: 1.0,
        document_mesh: 0,
        poses: vec![],
    };
    Ok(Scene {
        source,
        document: Document::Obj(document),
        objects: vec![SceneObject { info, mesh, source_positions }],
        warnings,
        files: assets.files().clone(),
        compressed: false,
        quantized: false,
        requantized: false,
    })
}

/// Makes a scene of a mesh that comes from no file.
///
/// # Errors
/// If its parts do not fit each other, a position is not finite, or it is too large.
pub(crate) fn scene_of_parts(
    parts: MeshParts,
    options: &ImportOptions,
) -> Result<Scene, FormatError> {
    let limits = options.limits;
    let (vertices, triangles) = (parts.positions.len(), parts.triangles.len());
    if vertices as u64 > limits.vertices || triangles as u64 > limits.triangles {
        let problem = format!("{vertices} vertices, {triangles} triangles: more than the limits");
        return Err(FormatError::new(Fault::Limit, "", problem));
    }
    parts.check().map_err(|e| FormatError::new(Fault::Malformed, "", e.to_string()))?;
    let positions = parts.positions.iter().flatten().flat_map(|c| c.to_le_bytes());
    let corners = parts.triangles.iter().flatten().flat_map(|v| v.to_le_bytes());
    let attributes = parts.attributes.iter().flat_map(|a| &a.bytes).copied();
    let bytes: Vec<u8> = positions.chain(corners).chain(attributes).collect();
    let source =
        Source { format: SourceFormat::Ply, content_hash: xxhash_rust::xxh3::xxh3_128(&bytes) };
    let submesh = |i: usize| SubmeshInfo {
        name: String::new(),
        material: None,
        document_primitive: i as u32,
    };
    let submeshes = (0..parts.submeshes.len()).map(submesh).collect();
    let source_positions = (0..vertices as u32).collect();
    let assembled = Assembled { parts, source_positions, submeshes, ..Assembled::default() };
    let (name, document, warnings) = (String::new(), ObjDocument::default(), Vec::new());
    let file = FaceFile { assembled, name, source, document, warnings };
    scene(file, &Assets::new(Path::new("-"), &[], limits), options)
}

/// Says how polygons became triangles, and what corners were given.
pub(crate) fn warn(assembled: &Assembled, warnings: &mut Vec<String>) {
    for (count, one, several) in [
        (assembled.polygons, "polygon was triangulated", "polygons were triangulated"),
        (
            assembled.imperfect_polygons,
            "of these crosses itself or turns back: its triangles may overlap",
            "of these cross themselves or turn back: their triangles may overlap",
        ),
        (
            assembled.filled_texcoords,
            "corner without texture coordinates beside others that have them was given (0, 0)",
            "corners without texture coordinates beside others that have them were given (0, 0)",
        ),
    ] {
        if count > 0 {
            warnings.push(counted(count, one, several));
        }
    }
}

/// Cleans a mesh with a number for each vertex; returns those of the vertices that stay.
fn clean_numbered(
    parts: &mut MeshParts,
    numbers: Vec<u32>,
    weld: f64,
    warnings: &mut Vec<String>,
) -> Vec<u32> {
    // Cleaning moves a stream with its vertices, even one that no submesh has.
    parts.attributes.push(Attribute {
        semantic: Semantic::Custom(String::new()),
        morph_target: None,
        component: Component::U32,
        components: 1,
        normalized: false,
        bytes: numbers.into_iter().flat_map(u32::to_le_bytes).collect(),
    });
    clean(parts, weld, warnings);
    let bytes = parts.attributes.pop().map(|a| a.bytes).unwrap_or_default();
    bytes.as_chunks().0.iter().copied().map(u32::from_le_bytes).collect()
}

/// Welds if asked to, and drops degenerate triangles and unused vertices.
fn clean(parts: &mut MeshParts, weld: f64, warnings: &mut Vec<String>) {
    if weld > 0.0 {
        let moved = lodc_mesh::weld_positions(parts, weld * diagonal(&parts.positions));
        if moved > 0 {
            let vertices = counted(moved, "vertex was", "vertices were");
            warnings.push(format!("{vertices} welded to a neighbour"));
        }
    }
    let cleaning = parts.clean();
    if cleaning.degenerate_triangles > 0 {
        let one = "triangle with two corners at one position was dropped";
        let several = "triangles with two corners at one position were dropped";
        warnings.push(counted(cleaning.degenerate_triangles, one, several));
    }
    if parts.triangles.is_empty() {
        warnings.push("no triangles: nothing to simplify".to_owned());
    }
}
