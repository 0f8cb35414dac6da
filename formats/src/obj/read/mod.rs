//! Reading OBJ files and their material libraries.
//!
//! One file is one object. Its submeshes are its materials, in order of first use; the faces
//! without a material are a submesh of their own.

mod assemble;
mod chunk;
mod libraries;
mod lines;
mod notes;
mod number;
mod parse;
mod parsed;
#[cfg(test)]
mod tests;
mod triangulate;
mod unique;

use crate::options::ImportOptions;
use crate::{
    Assets, Document, Fault, FormatError, ObjDocument, ObjectInfo, Scene, SceneObject, Source,
    SourceFormat,
};
use lodc_mesh::{Attribute, Component, Mesh, MeshParts, Semantic};
use xxhash_rust::xxh3::xxh3_128;

/// Reads an OBJ; `bytes` is the main file.
///
/// # Errors
/// See [`crate::import::import`].
pub(crate) fn import(
    bytes: Vec<u8>,
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<Scene, FormatError> {
    if bytes.is_empty() {
        return Err(FormatError::new(Fault::Malformed, "", "the file is empty"));
    }
    let content_hash = xxh3_128(&bytes);
    let mut parsed = parse::parse(&bytes, assets.limits())?;
    // The text is the largest thing in memory and has said what it had to say.
    drop(bytes);
    let libraries = std::mem::take(&mut parsed.libraries);
    let materials = libraries::Materials::read(&libraries, assets)?;

    let mut warnings = materials.warnings;
    let mut assembled = assemble::assemble(&parsed, content_hash as u64);
    notes::warn(&parsed, &assembled, &mut warnings);
    notes::warn_undefined(&assembled, &materials.list, &mut warnings);
    let name = match &parsed.objects[..] {
        [only] => only.clone(),
        _ => assets.stem(),
    };
    drop(parsed);

    let mut parts = std::mem::take(&mut assembled.parts);
    let source_positions =
        tidy_numbered(&mut parts, assembled.source_positions, options.weld, &mut warnings);
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
        source: Source { format: SourceFormat::Obj, content_hash },
        document: Document::Obj(ObjDocument { libraries, materials: materials.list }),
        objects: vec![SceneObject { info, mesh, source_positions }],
        warnings,
        files: assets.files().clone(),
        compressed: false,
        quantized: false,
    })
}

/// [`tidy`], with a number for each vertex; returns those of the vertices that stay.
fn tidy_numbered(
    parts: &mut MeshParts,
    numbers: Vec<u32>,
    weld: f64,
    warnings: &mut Vec<String>,
) -> Vec<u32> {
    // As a stream of no submesh, the numbers go wherever their vertices go.
    parts.attributes.push(Attribute {
        semantic: Semantic::Custom(String::new()),
        morph_target: None,
        component: Component::U32,
        components: 1,
        normalized: false,
        bytes: numbers.into_iter().flat_map(u32::to_le_bytes).collect(),
    });
    tidy(parts, weld, warnings);
    let bytes = parts.attributes.pop().map(|a| a.bytes).unwrap_or_default();
    bytes.as_chunks().0.iter().copied().map(u32::from_le_bytes).collect()
}

/// Welds if asked to, and drops what takes no part.
fn tidy(parts: &mut MeshParts, weld: f64, warnings: &mut Vec<String>) {
    if weld > 0.0 {
        let moved = lodc_mesh::weld_positions(parts, weld * diagonal(&parts.positions));
        if moved > 0 {
            warnings.push(format!("{moved} vertices were welded to a neighbour"));
        }
    }
    let cleaning = parts.clean();
    if cleaning.degenerate_triangles > 0 {
        warnings.push(format!(
            "{} triangles with two corners at one position were dropped",
            cleaning.degenerate_triangles
        ));
    }
    if parts.triangles.is_empty() {
        warnings.push("there is no triangle: nothing to simplify".to_owned());
    }
}

fn diagonal(positions: &[[f32; 3]]) -> f64 {
    let extent = |i: usize| {
        let values = positions.iter().map(|p| f64::from(p[i]));
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
        if high > low { high - low } else { 0.0 }
    };
    (0..3).map(|i| extent(i).powi(2)).sum::<f64>().sqrt()
}
