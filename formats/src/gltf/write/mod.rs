//! Writes glTF 2.0 and GLB: the source's document as it was, its triangles at one level of detail;
//! or a chain of levels, or all of them.

mod avatars;
mod buffers;
mod chain;
mod compressed;
mod differences;
mod fresh;
mod geomorph;
mod images;
mod levels;
mod samples;
mod writer;

use super::extensions;
use super::json::{self, Json, Object, object};
use super::quantize::{self, Quantizer, WrittenObject};
use super::{glb, prune, schema};
use crate::options::{ExportObject, ExportOptions, Precision};
use crate::percent::percent_encoded;
use crate::provenance::{LevelFacts, Provenance};
use crate::{Document, FormatError, GENERATOR, Limits, ObjectInfo, OutputFile, SubmeshInfo};
use buffers::{Drawn, VertexBuffers};
pub use images::embed_images;
use lodc_mesh::{Mesh, PoseKey, Submesh};
use std::borrow::Cow;
use std::path::Path;
use writer::Writer;

pub use super::quantize::RoundedObject;
pub use chain::{ChainObject, ChainShape, export_chain};
pub use differences::MovedStreams;
pub use geomorph::Geomorph;
pub use levels::{LevelsObject, export_levels};

/// Makes one `.glb`, or a `.gltf` and the `.bin` beside it. Primitives without triangles are left
/// out, and meshes without primitives with them: their nodes stay.
pub(crate) fn export<'a>(
    path: &Path,
    binary: bool,
    document: &Document,
    objects: &[ExportObject<'a>],
    options: &ExportOptions,
) -> Result<Vec<OutputFile>, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| o.info).collect();
    let (mut root, mut blob) = source_document(document, &infos, options)?;
    let written_object =
        |(i, o): (usize, &ExportObject<'a>)| written_object(document, i, o.info, o.mesh);
    let written_objects =
        objects.iter().enumerate().map(written_object).collect::<Result<Vec<_>, _>>()?;
    let quantizer =
        Quantizer::new(options.precision, document, &written_objects, &mut root, &mut blob)?;
    let mut writer = Writer::new(&root, options);
    let mut empty = Vec::new();
    for (i, written_object) in written_objects.iter().enumerate() {
        let geometry = quantizer.geometry(i, written_object);
        let buffers = VertexBuffers::new(&geometry, drawn(&geometry), |_| 0);
        let mut mesh_writer = writer.mesh_writer(&geometry, buffers);
        for (s, &number) in written_object.primitives.iter().enumerate() {
            if !mesh_writer
                .primitive(s, submesh_primitive(&mut root, written_object.mesh, number)?)?
            {
                empty.push((written_object.mesh, number));
            }
        }
    }
    prune::without(&mut root, &empty);
    writer.finish(&mut root, &mut blob);
    if binary { glb(path, &root, &blob).map(|file| vec![file]) } else { Ok(gltf(path, root, blob)) }
}

/// The vertices of each submesh in the order in which its triangles first use them.
fn drawn(mesh: &Mesh) -> Vec<Drawn> {
    let mut is_drawn = vec![false; mesh.vertex_count()];
    let of_submesh = |submesh: &Submesh| {
        let corners = mesh.triangles()[submesh.triangles()].as_flattened();
        let first_use = |&&v: &&u32| !std::mem::replace(&mut is_drawn[v as usize], true);
        Drawn {
            vertices: corners.iter().filter(first_use).copied().collect(),
            indices: corners.len(),
        }
    };
    mesh.submeshes().iter().map(of_submesh).collect()
}

/// Returns what quantising does to each object; none if it moves no vertex.
///
/// # Errors
/// If the document is damaged.
pub fn rounded<'a>(
    document: &Document,
    objects: &[ExportObject<'a>],
    precision: Precision,
) -> Result<Option<Vec<RoundedObject>>, FormatError> {
    if precision.position.is_none() && precision.weight.is_none() {
        return Ok(None);
    }
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| o.info).collect();
    let (root, _) = source_document(document, &infos, &ExportOptions::default())?;
    let written_object =
        |(i, o): (usize, &ExportObject<'a>)| written_object(document, i, o.info, o.mesh);
    let written_objects =
        objects.iter().enumerate().map(written_object).collect::<Result<Vec<_>, _>>()?;
    quantize::rounded(precision, document, &root, &written_objects).map(Some)
}

/// The document that geometry goes into, provenance and images included, and the bytes that it
/// refers to already.
fn source_document(
    document: &Document,
    objects: &[&ObjectInfo],
    options: &ExportOptions,
) -> Result<(Object, Vec<u8>), FormatError> {
    let (mut root, mut blob) = match document {
        Document::Gltf(gltf) => (gltf.root(&Limits::DEFAULT)?.clone(), gltf.blob().to_vec()),
        Document::Obj(obj) => fresh::document(obj, objects),
    };
    images::put(&mut root, &mut blob, &options.textures);
    if let Some(provenance) = &options.provenance {
        put_provenance(&mut root, provenance, options.precision != Precision::default());
    }
    Ok((root, blob))
}

/// Puts `asset.generator` and `extras.lodc` into a document.
fn put_provenance(root: &mut Object, provenance: &Provenance, requantizes: bool) {
    if let Some(asset) = root.get_mut("asset") {
        asset["generator"] = GENERATOR.into();
    }
    let finite = |x: f64| x.is_finite().then_some(x);
    let level = |l: &LevelFacts| {
        let mut facts = object! { "lod" => l.lod, "error" => finite(l.error), "rms" => l.rms };
        if let Some(geomorph) = &l.geomorph {
            facts["distance"] = geomorph.distance.and_then(finite).into();
            facts["morph_from"] = geomorph.morph_from.and_then(finite).into();
            if let Some(error) = geomorph.pose_error {
                facts["geomorph_pose_error"] = finite(error).into();
            }
            if geomorph.staying > 0 {
                facts["geomorph_staying"] = geomorph.staying.into();
            }
        }
        facts
    };
    let mut all = match &provenance.levels[..] {
        [one] => level(one),
        several => object! { "levels" => several.iter().map(level).collect::<Json>() },
    };
    if let Some(screen) = &provenance.screen {
        all["screen"] = object! {
            "pixels" => screen.pixels, "height" => screen.height, "fovy" => screen.fovy,
        };
    }
    if let Some(next) = &provenance.next {
        all["next"] = percent_encoded(next).into();
    }
    all["refitted"] = provenance.refitted.into();
    if requantizes {
        all["quantized"] = true.into();
    }
    all["source"] = format!("{:032x}", provenance.source).into();
    if let Some(poses) = &provenance.poses {
        let max_count = poses.iter().map(Vec::len).max().unwrap_or(0);
        all["errors_over"] = object! { "rest" => true, "poses" => max_count };
        if max_count > 0 {
            let object_poses = |poses: &Vec<PoseKey>| poses.iter().map(pose_key).collect::<Json>();
            all["poses"] = poses.iter().map(object_poses).collect::<Json>();
        }
    }
    extensions::put_extra(root, "lodc", all);
}

fn pose_key(pose: &PoseKey) -> Json {
    match *pose {
        PoseKey::Moment { animation, seconds } => {
            object! { "animation" => animation, "seconds" => seconds }
        }
        PoseKey::Target(target) => object! { "target" => target },
    }
}

/// The number of an object's mesh in the document.
fn document_mesh(document: &Document, info: &ObjectInfo, object: usize) -> usize {
    match document {
        Document::Gltf(_) => info.document_mesh as usize,
        Document::Obj(_) => object,
    }
}

/// The number of a submesh's primitive in its mesh.
fn document_primitive(document: &Document, info: &SubmeshInfo, submesh: usize) -> usize {
    match document {
        Document::Gltf(_) => info.document_primitive as usize,
        Document::Obj(_) => submesh,
    }
}

/// The mesh as glTF wants it.
fn adapted<'a>(document: &Document, mesh: &'a Mesh) -> Cow<'a, Mesh> {
    match document {
        Document::Obj(_) => Cow::Owned(fresh::adapted(mesh)),
        Document::Gltf(_) => Cow::Borrowed(mesh),
    }
}

/// An object, and which mesh and primitives of the document it is.
fn written_object<'a>(
    document: &Document,
    object: usize,
    info: &'a ObjectInfo,
    mesh: &'a Mesh,
) -> Result<WrittenObject<'a>, FormatError> {
    if info.submeshes.len() != mesh.submeshes().len() {
        return Err(json::malformed(&*info.name, "has other submeshes than its description"));
    }
    let primitive = |(s, submesh)| document_primitive(document, submesh, s);
    Ok(WrittenObject {
        info,
        mesh: document_mesh(document, info, object),
        primitives: info.submeshes.iter().enumerate().map(primitive).collect(),
        geometry: adapted(document, mesh),
        geomorph_target: None,
    })
}

fn submesh_primitive(
    root: &mut Object,
    mesh: usize,
    primitive: usize,
) -> Result<&mut Object, FormatError> {
    schema::primitive_mut(root, mesh, primitive).ok_or_else(|| {
        json::malformed(format!("meshes[{mesh}].primitives[{primitive}]"), "is not in the document")
    })
}

fn glb(path: &Path, root: &Object, blob: &[u8]) -> Result<OutputFile, FormatError> {
    Ok(OutputFile {
        path: path.to_owned(),
        bytes: glb::joined(root.to_string().into_bytes(), blob)?,
    })
}

fn gltf(path: &Path, mut root: Object, blob: Vec<u8>) -> Vec<OutputFile> {
    let buffer_path = path.with_extension("bin");
    if !blob.is_empty() {
        let name = buffer_path.file_name().map(|n| percent_encoded(&n.to_string_lossy()));
        if let Some(buffer) = root.objects_mut("buffers").next() {
            buffer["uri"] = name.unwrap_or_default().into();
        }
    }
    let mut files =
        vec![OutputFile { path: path.to_owned(), bytes: format!("{root:#}").into_bytes() }];
    if !blob.is_empty() {
        files.push(OutputFile { path: buffer_path, bytes: blob });
    }
    files
}

#[cfg(test)]
mod tests;
