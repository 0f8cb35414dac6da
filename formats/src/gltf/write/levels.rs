//! Writes all levels into one GLB: LOD 0 as any reader of glTF shows it, and the collapse sequence
//! in `extras`.
//!
//! Vertices of a primitive are in reverse order of their disappearance, so those of a level are
//! the first ones; triangles that disappear last come first.

use super::buffers::{Drawn, VertexBuffers};
use super::writer::Writer;
use super::{adapted, document_mesh, document_primitive, glb, source_document, submesh_primitive};
use crate::gltf::extensions::put_extra;
use crate::gltf::json::{Json, Object, object};
use crate::gltf::{prune, uri};
use crate::images::{TextureMode, Textures};
use crate::options::ExportOptions;
use crate::{Document, FormatError, ObjectInfo, OutputFile};
use lodc_mesh::{Attribute, Component, Mesh, SequenceParts, Simplified, Submesh, removal_lods};
use std::path::Path;

/// An object with all of its levels.
#[derive(Clone, Copy, Debug)]
pub struct LevelsObject<'a> {
    /// Its description.
    pub info: &'a ObjectInfo,
    /// Its mesh and collapse sequence.
    pub simplified: &'a Simplified,
    /// The strip of each triangle of the mesh, if strips are known.
    pub strips: Option<&'a [u32]>,
    /// When it loses triangles: indices into the order over the objects of the scene, rising, each
    /// with the LOD after it. Empty for the only object.
    pub ranks: &'a [(u32, u32)],
}

/// Makes one GLB of a scene with every level, its textures embedded, and a warning for each texture
/// that is missing.
///
/// Each primitive has `extras.lodc` with the accessors `numbers` (of each vertex in the collapse
/// order: it is there at LOD k if its number is at least k), `targets` (the earlier vertex of the
/// primitive that it becomes), `removals` (LOD at which each triangle goes) and, if known,
/// `strips`. Each mesh has `extras.lodc` with `records`, `scale` (world units per unit),
/// `diagonal`, and the accessors `ends`, `triangles` and `errors` by step (steps that leave no
/// triangle have the last finite error); of several objects also `ranks` and `rank_lods`, the ranks
/// at which the object loses triangles in the order over all objects, and its LOD after each.
///
/// # Errors
/// If glTF cannot hold the scene.
pub fn export_levels(
    path: &Path,
    document: &Document,
    objects: &[LevelsObject<'_>],
    textures: Textures,
) -> Result<(OutputFile, Vec<String>), FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| o.info).collect();
    let mut warnings = textures.warnings.clone();
    let textures = textures.placed(TextureMode::Embed, path);
    warnings.extend_from_slice(&textures.warnings);
    let options = ExportOptions { textures, ..ExportOptions::default() };
    let (mut root, mut blob) = source_document(document, &infos, &options)?;
    forget_missing(&mut root);
    let mut writer = Writer::new(&root, &options);
    let mut empty = Vec::new();
    for (i, object) in objects.iter().enumerate() {
        let mesh = document_mesh(document, object.info, i);
        let finest = object.simplified.mesh();
        let adapted = adapted(document, finest);
        let levels = WrittenLevels::new(object, &adapted);
        let mut mesh_writer = writer.mesh_writer(&adapted, levels.buffers());
        let numbers = || {
            let infos = object.info.submeshes.iter().enumerate();
            infos.map(|(s, info)| (s, document_primitive(document, info, s)))
        };
        for (s, number) in numbers() {
            if !mesh_writer.primitive(s, submesh_primitive(&mut root, mesh, number)?)? {
                empty.push((mesh, number));
            }
        }
        for (s, number) in numbers() {
            levels.collapses(&mut writer, s, submesh_primitive(&mut root, mesh, number)?)?;
        }
        let extras = levels.sequence(&mut writer)?;
        if let Some(mesh) = root.object_mut("meshes", mesh) {
            put_extra(mesh, "lodc", extras);
        }
    }
    prune::without(&mut root, &empty);
    writer.finish(&mut root, &mut blob);
    Ok((glb(path, &root, &blob)?, warnings))
}

/// Makes images of files that could not be read into images without a file: one page holds
/// everything, so there is nowhere to look for them.
fn forget_missing(root: &mut Object) {
    for image in root.objects_mut("images") {
        let named = image["uri"].as_str();
        if named.is_some_and(|uri| !uri::is_data(uri)) {
            image.shift_remove("uri");
        }
    }
}

/// The levels of one object.
struct WrittenLevels<'a> {
    object: &'a LevelsObject<'a>,
    mesh: &'a Mesh,
    /// The LOD at which each triangle becomes degenerate.
    removals: Vec<u32>,
    /// Vertices of each submesh, the last to disappear first.
    vertices: Vec<Vec<u32>>,
    /// Number of each vertex among those of its submesh.
    local: Vec<u32>,
}

impl<'a> WrittenLevels<'a> {
    fn new(object: &'a LevelsObject<'a>, mesh: &'a Mesh) -> Self {
        let positions = mesh.position_ids();
        let mut vertices = vec![Vec::new(); mesh.submeshes().len()];
        let mut local = vec![0; mesh.vertex_count()];
        for (v, &s) in mesh.vertex_submesh().iter().enumerate().rev() {
            let submesh_vertices: &mut Vec<u32> = &mut vertices[s as usize];
            local[v] = submesh_vertices.len() as u32;
            submesh_vertices.push(v as u32);
        }
        let removals = removal_lods(object.simplified, &positions);
        Self { object, mesh, removals, vertices, local }
    }

    /// Buffers that have the last vertices to disappear first.
    fn buffers(&self) -> VertexBuffers {
        let drawn = |vertices: &Vec<u32>| Drawn { vertices: vertices.clone(), indices: 0 };
        VertexBuffers::apart(self.mesh, self.vertices.iter().map(drawn).collect())
    }

    /// Writes what a submesh's vertices and triangles become.
    fn collapses(
        &self,
        writer: &mut Writer,
        s: usize,
        primitive: &mut Object,
    ) -> Result<(), FormatError> {
        let submesh: &Submesh = &self.mesh.submeshes()[s];
        if submesh.triangle_count == 0 {
            return Ok(());
        }
        let range = submesh.triangles();
        let vertices = &self.vertices[s];
        let targets: Vec<u32> = vertices.iter().map(|&v| self.target(v, s)).collect();
        let mut extras = object! {
            "numbers" => words(writer, vertices)?,
            "targets" => words(writer, &targets)?,
            "removals" => words(writer, &self.removals[range.clone()])?,
        };
        if let Some(strips) = self.object.strips {
            extras["strips"] = words(writer, &strips[range])?;
        }
        put_extra(primitive, "lodc", extras);
        Ok(())
    }

    /// The vertex of submesh `s` that `v` becomes; itself if it is the last one there. A vertex
    /// only leaves its submesh when no triangle needs it any more.
    fn target(&self, v: u32, s: usize) -> u32 {
        let local = self.local[v as usize];
        match self.object.simplified.collapses().targets().get(v as usize) {
            Some(&t) if self.mesh.vertex_submesh()[t as usize] as usize == s => {
                self.local[t as usize]
            }
            _ => local.saturating_sub(1),
        }
    }

    /// The steps of the sequence.
    fn sequence(&self, writer: &mut Writer) -> Result<Json, FormatError> {
        let parts: &SequenceParts = self.object.simplified.collapses().parts();
        let finite = parts.step_errors.iter().copied().filter(|e| e.is_finite());
        let largest_finite = finite.fold(0.0, f32::max);
        let errors: Vec<u8> =
            parts.step_errors.iter().flat_map(|e| e.min(largest_finite).to_le_bytes()).collect();
        let steps = parts.step_ends.len();
        let mut extras = object! {
            "records" => parts.targets.len(),
            "scale" => self.object.info.world_scale,
            "diagonal" => self.mesh.diagonal(),
        };
        if steps > 0 {
            extras["ends"] = words(writer, &parts.step_ends)?;
            extras["triangles"] = words(writer, &parts.step_triangles)?;
            extras["errors"] = scalars(writer, Component::F32, errors)?;
        }
        if !self.object.ranks.is_empty() {
            let (indices, lods): (Vec<u32>, Vec<u32>) = self.object.ranks.iter().copied().unzip();
            extras["ranks"] = words(writer, &indices)?;
            extras["rank_lods"] = words(writer, &lods)?;
        }
        Ok(extras)
    }
}

fn words(writer: &mut Writer, values: &[u32]) -> Result<Json, FormatError> {
    let bytes = values.iter().flat_map(|w| w.to_le_bytes()).collect();
    scalars(writer, Component::U32, bytes)
}

/// An accessor of single numbers of four bytes each.
fn scalars(writer: &mut Writer, component: Component, bytes: Vec<u8>) -> Result<Json, FormatError> {
    let count = (bytes.len() / 4) as u32;
    let semantic = lodc_mesh::Semantic::Custom(String::new());
    let (components, normalized, morph_target) = (1, false, None);
    let a = Attribute { semantic, morph_target, component, components, normalized, bytes };
    writer.stream(&a, &(0..count).collect::<Vec<u32>>())
}

#[cfg(test)]
#[path = "levels_tests.rs"]
mod tests;
