//! Reads glTF 2.0 and GLB files into a scene: meshes of triangles, and a document with the rest.
//!
//! `open` reads a document, checks and repairs it and decodes Draco; `Opened::scene` makes objects
//! of its meshes (`object`) and stores what is left (`remainder`).

mod blob;
mod count;
mod draco;
mod exported;
mod feature_ids;
mod forest;
mod geomorph;
mod levels_inside;
mod object;
#[cfg(feature = "export")]
mod plain;
mod primitive;
mod remainder;
mod repair;

use super::accessor::Accessor;
use super::budget::Budget;
use super::extensions::QUANTIZATION;
use super::json::{self, Json, Object};
use super::views::{self, Buffers, Views};
use super::{document, extensions, glb, schema, uri};
use crate::options::ImportOptions;
use crate::words;
use crate::{
    Assets, Document, FormatError, ObjectInfo, Scene, SceneObject, Source, SourceFormat,
    SubmeshInfo,
};
pub(crate) use count::counted;
pub(crate) use exported::{exported, states_levels};
use lodc_mesh::Mesh;
use object::Reading;
#[cfg(feature = "export")]
pub(crate) use plain::plain;
use primitive::{Primitive, Read};

/// Reads a glTF or GLB; `bytes` is the main file.
///
/// # Errors
/// See [`crate::import::import`].
#[expect(
    clippy::needless_pass_by_value,
    reason = "importers have one signature, and others consume their bytes"
)]
pub(crate) fn import(
    bytes: Vec<u8>,
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<Scene, FormatError> {
    let (mut root, mut opened) = open(&bytes, assets, options)?;
    levels_inside::keep_finest(&mut root, &mut opened.warnings)?;
    opened.scene(root, assets, options)
}

/// What a file has besides its document.
struct Opened<'a> {
    source: Source,
    buffers: Buffers<'a>,
    /// Bytes of the file and of all buffers, also of those that Draco streams were decoded to.
    bytes: u64,
    warnings: Vec<String>,
}

/// Reads the document, checked, and the buffers.
fn open<'a>(
    bytes: &'a [u8],
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<(Object, Opened<'a>), FormatError> {
    let mut warnings = Vec::new();
    let (format, text, chunk) = if glb::is_glb(bytes) {
        let chunks = glb::split(bytes)?;
        warnings.extend(chunks.warnings);
        (SourceFormat::Glb, &bytes[chunks.json], chunks.bin.map(|bin| &bytes[bin]))
    } else {
        let text = bytes.strip_prefix(words::BYTE_ORDER_MARK);
        if text.is_some() {
            warnings.push("the byte order mark before the JSON is ignored".to_owned());
        }
        (SourceFormat::Gltf, text.unwrap_or(bytes), None)
    };
    let mut root = json::parse(text, &options.limits)?;
    extensions::check(&root)?;
    schema::check(&mut root)?;

    repair::addresses(&mut root, &mut warnings);
    let mut buffers = views::read_buffers(&root, chunk, assets)?;
    let mut hasher = xxhash_rust::xxh3::Xxh3::new();
    hasher.update(bytes);
    let files = root.entries("buffers").zip(&buffers).filter(|(buffer, _)| names_file(buffer));
    files.filter_map(|(_, b)| b.as_deref()).for_each(|b| hasher.update(b));
    let input = (bytes.len() + buffers.iter().flatten().map(|b| b.len()).sum::<usize>()) as u64;
    let source = Source { format, content_hash: hasher.digest128() };
    let bytes = input + draco::unpack(&mut root, &mut buffers, &options.limits, input)?;
    repair::accessors(&mut root, &mut warnings);
    let bytes = bytes + feature_ids::make_explicit(&mut root, &mut buffers, &mut warnings);
    Ok((root, Opened { source, buffers, bytes, warnings }))
}

impl Opened<'_> {
    /// The scene of the file's document, or of one with other references into the same buffers.
    fn scene(
        &self,
        root: Object,
        assets: &Assets,
        options: &ImportOptions,
    ) -> Result<Scene, FormatError> {
        let mut warnings = self.warnings.clone();
        let budget = Budget::new(self.bytes);
        let views = Views::new(&root, &self.buffers, &budget)?;
        let accessors = Accessor::all(&root, &views)?;

        forest::check(&root)?;
        let compressed = extensions::is_compressed(&root);
        let quantized = extensions::uses(&root, QUANTIZATION);
        let requantized = extensions::is_requantized(&root);
        let mut reading = Reading::new(&accessors, &views, options.limits, options.weld);
        let mut objects = read_objects(&root, &mut reading, &mut warnings)?;
        let numbers = |accessor| document::numbers(&accessors, &views, accessor);
        forest::set_world_scales(&root, &mut objects, &numbers, &mut warnings)?;
        warnings.extend(extensions::kept_extras(&root));
        let primitives = |o: &SceneObject| -> Vec<(usize, usize)> {
            let mesh = o.info.document_mesh as usize;
            o.info.submeshes.iter().map(|s| (mesh, s.document_primitive as usize)).collect()
        };
        let stripped: Vec<(usize, usize)> = objects.iter().flat_map(primitives).collect();
        let document = remainder::remainder(root, &stripped, &views, &mut warnings)?;
        Ok(Scene {
            source: self.source.clone(),
            document: Document::Gltf(document),
            objects,
            warnings,
            files: assets.files().clone(),
            compressed,
            quantized,
            requantized,
        })
    }
}

fn names_file(buffer: &Object) -> bool {
    buffer["uri"].as_str().is_some_and(|uri| !uri::is_data(uri))
}

/// Every mesh with triangles.
fn read_objects(
    root: &Object,
    reading: &mut Reading<'_>,
    warnings: &mut Vec<String>,
) -> Result<Vec<SceneObject>, FormatError> {
    let mut objects = Vec::new();
    let (mut points_or_lines, mut without_positions) = (0, 0);
    for (m, mesh) in root.entries("meshes").enumerate() {
        let (mut primitives, mut numbers): (Vec<Primitive>, Vec<u32>) = (Vec::new(), Vec::new());
        for (p, object) in mesh.list("primitives").iter().filter_map(Json::as_object).enumerate() {
            match primitive::read(
                object,
                format!("meshes[{m}].primitives[{p}]"),
                reading.accessors,
            )? {
                Read::Triangles(primitive) => {
                    primitives.push(primitive);
                    numbers.push(p as u32);
                }
                Read::PointsOrLines => points_or_lines += 1,
                Read::NoPosition => without_positions += 1,
            }
        }
        let Some((triangles, submeshes)) = reading.object(&primitives)? else { continue };
        let name = mesh["name"].as_str().map_or_else(|| format!("mesh{m}"), str::to_owned);
        objects.push(scene_object(name, m, triangles, submeshes.iter().map(|&s| numbers[s])));
    }
    let counts = &reading.counts;
    for (count, one, several) in [
        (
            counts.degenerate,
            "triangle with two corners at one position was dropped",
            "triangles with two corners at one position were dropped",
        ),
        (
            reading.unused_vertices() + counts.lonely_vertices,
            "vertex that no triangle uses was dropped",
            "vertices that no triangle uses were dropped",
        ),
        (counts.welded, "vertex was welded to a neighbour", "vertices were welded to a neighbour"),
        (
            counts.leftover_corners,
            "corner after the last whole triangle of its primitive was dropped",
            "corners after the last whole triangle of their primitives were dropped",
        ),
        (
            counts.third_coordinates,
            "attribute has a third texture coordinate, which is dropped",
            "attributes have a third texture coordinate, which is dropped",
        ),
        (
            counts.not_finite,
            "value of an attribute is not a finite number and stays as it is",
            "values of attributes are not finite numbers and stay as they are",
        ),
        (
            points_or_lines,
            "primitive of points or lines passes through unchanged",
            "primitives of points or lines pass through unchanged",
        ),
        (
            without_positions,
            "primitive without positions passes through unchanged",
            "primitives without positions pass through unchanged",
        ),
        (
            counts.only_degenerate,
            "primitive whose triangles have no area passes through unchanged",
            "primitives whose triangles have no area pass through unchanged",
        ),
    ] {
        if count > 0 {
            warnings.push(words::counted(count, one, several));
        }
    }
    Ok(objects)
}

fn scene_object(
    name: String,
    document_mesh: usize,
    mesh: Mesh,
    primitives: impl Iterator<Item = u32>,
) -> SceneObject {
    let submesh = |document_primitive| SubmeshInfo {
        name: String::new(),
        material: None,
        document_primitive,
    };
    let submeshes = primitives.map(submesh).collect();
    let document_mesh = document_mesh as u32;
    let info = ObjectInfo { name, submeshes, world_scale: 1.0, document_mesh, poses: vec![] };
    SceneObject { info, mesh, source_positions: Vec::new() }
}

#[cfg(test)]
pub(crate) mod tests;
