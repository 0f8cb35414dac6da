//! Writes one level of detail in any format; says by how much reading and writing move vertices,
//! and what a format leaves out.

pub use crate::gltf::write::{RoundedObject, rounded};
pub use crate::options::{ExportObject, ExportOptions, Precision};
pub use crate::provenance::{GeomorphFacts, LevelFacts, Provenance, ScreenFacts};

use crate::far::Extent;
use crate::flatten::{FileCoordinates, Placed, placed};
use crate::loose::Loose;
use crate::obj::write::Library;
use crate::{
    Document, FormatError, Limits, ObjDocument, ObjectInfo, OutputFile, gltf, obj, ply,
    scene_graph, stl,
};
use lodc_mesh::{Mesh, Semantic};
use lodc_scene::Coordinates;
use std::path::Path;

/// A format that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// glTF 2.0, binary.
    Glb,
    /// glTF 2.0, JSON and one `.bin` beside it.
    Gltf,
    /// Wavefront OBJ and, where there are materials, an MTL beside it.
    Obj,
    /// Stanford PLY, binary little-endian.
    Ply,
    /// STL, binary.
    Stl,
}

impl ExportFormat {
    /// The extensions of files that can be written, in alphabetical order, with their formats. A
    /// `.vrm` is a GLB under the name of avatars.
    pub const EXTENSIONS: [(&str, Self); 6] = [
        ("glb", Self::Glb),
        ("gltf", Self::Gltf),
        ("obj", Self::Obj),
        ("ply", Self::Ply),
        ("stl", Self::Stl),
        ("vrm", Self::Glb),
    ];
}

/// Makes the files of an export in memory; nothing is written. Image files keep their names.
///
/// # Errors
/// If the format cannot hold the scene.
pub fn export(
    path: &Path,
    format: ExportFormat,
    document: &Document,
    objects: &[ExportObject<'_>],
) -> Result<Vec<OutputFile>, FormatError> {
    export_with(path, format, document, objects, &ExportOptions::default())
}

/// Makes the files of an export in memory, copies of image files included, the file that refers to
/// the others first.
///
/// # Errors
/// As [`export`].
pub fn export_with(
    path: &Path,
    format: ExportFormat,
    document: &Document,
    objects: &[ExportObject<'_>],
    options: &ExportOptions,
) -> Result<Vec<OutputFile>, FormatError> {
    let mut files = match format {
        ExportFormat::Glb | ExportFormat::Gltf => {
            gltf::write::export(path, format == ExportFormat::Glb, document, objects, options)?
        }
        ExportFormat::Obj => {
            let library = library(document, options)?;
            let placed = all_placed(document, objects, format)?;
            let loose = loose(document)?;
            obj::write::export(path, &placed, &library, &loose, options.provenance.as_ref())
        }
        ExportFormat::Ply => {
            let library = library(document, options)?;
            let placed = all_placed(document, objects, format)?;
            let loose = loose(document)?;
            ply::write::export(path, &placed, &library, &loose, options.provenance.as_ref())?
        }
        ExportFormat::Stl => stl::write::export(path, &all_placed(document, objects, format)?)?,
    };
    files.extend(options.textures.copies.iter().cloned());
    Ok(files)
}

/// Returns for each object how far a vertex comes to stand at most from where the scene has it, in
/// mesh units: a format without nodes has coordinates of the scene, rounded to single precision or
/// to the fewest digits that tell vertices of single precision apart.
///
/// # Errors
/// As [`export`].
pub fn flattening_error(
    format: ExportFormat,
    document: &Document,
    objects: &[ExportObject<'_>],
) -> Result<Vec<f64>, FormatError> {
    let mut moved = vec![0.0; objects.len()];
    if matches!(format, ExportFormat::Glb | ExportFormat::Gltf) {
        return Ok(moved);
    }
    for placed in all_placed(document, objects, format)? {
        let vertices = placed.vertices();
        let rounding = match format {
            ExportFormat::Obj => obj::write::rounding(&vertices, placed.object.mesh),
            ExportFormat::Ply if vertices.far.is_some() => 0.0,
            _ => vertices.rounding(),
        };
        let in_mesh = largest_move(rounding) / placed.object.info.world_scale;
        if in_mesh.is_finite() {
            moved[placed.number] = in_mesh.max(moved[placed.number]);
        }
    }
    Ok(moved)
}

/// Returns by how much reading has moved vertices of a mesh at most: those of a file with an
/// offset were rounded to single precision about it. What doubles round does not count.
#[must_use]
pub fn reading_error(document: &Document, mesh: &Mesh) -> f64 {
    let Document::Obj(ObjDocument { offset, .. }) = document else { return 0.0 };
    if *offset == [0.0; 3] {
        return 0.0;
    }
    let local = Extent::of(mesh.positions().iter().map(|p| p.map(f64::from)));
    largest_move(local.map_or(0.0, |extent| extent.rounding()))
}

/// How far a point moves at most if each of its three coordinates is rounded by up to `rounding`.
fn largest_move(rounding: f64) -> f64 {
    3f64.sqrt() * rounding
}

/// Says what of an asset an STL, which has triangles alone, leaves out; none if that is nothing,
/// and for all other formats.
#[must_use]
pub fn left_out(
    format: ExportFormat,
    document: &Document,
    objects: &[ExportObject<'_>],
) -> Option<String> {
    if format != ExportFormat::Stl {
        return None;
    }
    let has = |is_one: fn(&Semantic) -> bool| {
        let mut streams = objects.iter().flat_map(|o| o.mesh.attributes());
        streams.any(|a| a.morph_target.is_none() && is_one(&a.semantic))
    };
    let mut kinds = Vec::new();
    for (kind, there) in [
        ("normals", has(|s| *s == Semantic::Normal)),
        ("texture coordinates", has(|s| matches!(s, Semantic::TexCoord(_)))),
        ("colours", has(|s| matches!(s, Semantic::Color(_)))),
        ("materials", document.has_materials()),
        ("joints", has(|s| matches!(s, Semantic::Joints(_)))),
        ("morph targets", objects.iter().any(|o| is_morphed(o.mesh))),
        ("points and lines", loose(document).is_ok_and(|loose| !loose.is_empty())),
    ] {
        if there {
            kinds.push(kind);
        }
    }
    let kinds = kinds.join(", ");
    (!kinds.is_empty()).then(|| format!("an STL holds triangles only; left out: {kinds}"))
}

fn is_morphed(mesh: &Mesh) -> bool {
    mesh.attributes().iter().any(|a| a.morph_target.is_some())
}

/// The points and lines of a document.
fn loose(document: &Document) -> Result<Loose, FormatError> {
    match document {
        Document::Obj(obj) => Ok(Loose::read(&obj.loose)),
        Document::Gltf(gltf) => gltf::loose(gltf),
    }
}

/// The materials of a document as an OBJ has them.
fn library(document: &Document, options: &ExportOptions) -> Result<Library, FormatError> {
    match document {
        Document::Obj(obj) => Ok(Library::new(obj, &options.textures)),
        Document::Gltf(gltf) => gltf::library(gltf, &options.textures),
    }
}

/// The objects where the document shows them. From OBJ to OBJ materials keep the options that move
/// their textures; else texture coordinates move in their place.
fn all_placed<'a>(
    document: &Document,
    objects: &[ExportObject<'a>],
    format: ExportFormat,
) -> Result<Vec<Placed<'a>>, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| o.info).collect();
    let read = match document {
        Document::Obj(_) if format == ExportFormat::Obj => Vec::new(),
        Document::Obj(obj) => obj::coordinates(obj, &infos),
        Document::Gltf(gltf) => gltf::coordinates(gltf, &infos, &Limits::DEFAULT)?,
    };
    let of_file = |read: &Coordinates| match document {
        // What no option moves stays bit for bit.
        Document::Obj(_) if *read == obj::coordinates::PLAIN => FileCoordinates::default(),
        _ => FileCoordinates::of_image(*read),
    };
    let coordinates: Vec<Vec<FileCoordinates>> =
        read.iter().map(|object| object.iter().map(of_file).collect()).collect();
    placed(&scene_graph(document, &infos, &Limits::DEFAULT)?, objects, &coordinates)
}
