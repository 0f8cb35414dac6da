//! glTF 2.0 and GLB: the document as it was, its triangles at one level of detail.

mod chain;
mod fresh;
mod images;
mod levels;
mod meshopt;
mod missing;
mod prune;
mod quantize;
mod samples;
mod writer;

use super::{Additions, ExportObject};
use crate::import::gltf::json::{self, Object};
use crate::import::gltf::{schema, uri};
use crate::{Document, Fault, FormatError, Limits, ObjectInfo, OutputFile, SubmeshInfo};
use lodc_mesh::Mesh;
use quantize::{Quantizer, Subject};
use serde_json::Value;
use std::borrow::Cow;
use std::path::Path;
use writer::Writer;

pub use chain::{ChainObject, ChainShape, export_chain};
pub use levels::{LevelsObject, export_levels};
pub(crate) use missing::gltf_without_missing;

const MAGIC: u32 = 0x4654_6c67;
const JSON: u32 = 0x4e4f_534a;
const BIN: u32 = 0x004e_4942;

/// Makes one `.glb`, or a `.gltf` and the `.bin` beside it. Primitives without triangles are left
/// out, and meshes without primitives with them: their nodes stay.
pub(super) fn export<'a>(
    path: &Path,
    binary: bool,
    document: &Document,
    objects: &[ExportObject<'a>],
    additions: &Additions,
) -> Result<Vec<OutputFile>, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| o.info).collect();
    let (mut root, mut blob) = source_document(document, &infos, additions)?;
    let subject = |(i, o): (usize, &ExportObject<'a>)| subject(document, i, o.info, o.mesh);
    let subjects = objects.iter().enumerate().map(subject).collect::<Result<Vec<_>, _>>()?;
    let quantizer = Quantizer::new(additions.precision, document, &subjects, &mut root, &mut blob)?;
    let mut writer = Writer::new(&root, additions);
    let mut empty = Vec::new();
    for (i, subject) in subjects.iter().enumerate() {
        let geometry = quantizer.geometry(i, subject);
        let mut numbering = writer.numbering(&geometry);
        for (s, &number) in subject.primitives.iter().enumerate() {
            if !numbering.primitive(s, submesh_primitive(&mut root, subject.mesh, number)?)? {
                empty.push((subject.mesh, number));
            }
        }
    }
    prune::without(&mut root, &empty);
    writer.finish(&mut root, &mut blob);
    if binary { glb(path, &root, &blob).map(|file| vec![file]) } else { Ok(gltf(path, root, blob)) }
}

/// The document that geometry goes into, additions included, and the bytes that it refers to
/// already.
fn source_document(
    document: &Document,
    objects: &[&ObjectInfo],
    additions: &Additions,
) -> Result<(Object, Vec<u8>), FormatError> {
    let (mut root, mut blob) = match document {
        Document::Gltf(gltf) => {
            (json::parse(gltf.json.as_bytes(), &Limits::DEFAULT)?, gltf.blob.clone())
        }
        Document::Obj(obj) => (fresh::document(obj, objects), Vec::new()),
    };
    // The document may come from a file that someone made up.
    schema::check(&mut root)?;
    images::put(&mut root, &mut blob, &additions.textures);
    if let Some(provenance) = &additions.provenance {
        provenance.put(&mut root);
    }
    Ok((root, blob))
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

/// An object and its places in the document.
fn subject<'a>(
    document: &Document,
    object: usize,
    info: &'a ObjectInfo,
    mesh: &'a Mesh,
) -> Result<Subject<'a>, FormatError> {
    if info.submeshes.len() != mesh.submeshes().len() {
        return Err(json::malformed(&*info.name, "has other submeshes than its description"));
    }
    let primitive = |(s, submesh)| document_primitive(document, submesh, s);
    Ok(Subject {
        info,
        mesh: document_mesh(document, info, object),
        primitives: info.submeshes.iter().enumerate().map(primitive).collect(),
        geometry: adapted(document, mesh),
    })
}

fn submesh_primitive(
    root: &mut Object,
    mesh: usize,
    primitive: usize,
) -> Result<&mut Object, FormatError> {
    find_primitive(root, mesh, primitive).ok_or_else(|| {
        json::malformed(format!("meshes[{mesh}].primitives[{primitive}]"), "is not in the document")
    })
}

fn find_primitive(root: &mut Object, mesh: usize, primitive: usize) -> Option<&mut Object> {
    let mesh = root.get_mut("meshes")?.as_array_mut()?.get_mut(mesh)?;
    mesh.get_mut("primitives")?.as_array_mut()?.get_mut(primitive)?.as_object_mut()
}

fn glb(path: &Path, root: &Object, blob: &[u8]) -> Result<OutputFile, FormatError> {
    let mut text = to_json(root, false);
    text.resize(text.len().next_multiple_of(4), b' ');
    let padded = blob.len().next_multiple_of(4);
    let chunk = if blob.is_empty() { 0 } else { 8 + padded };
    let length = 12 + 8 + text.len() + chunk;
    let word = |n: usize| {
        let too_large = || {
            FormatError::new(
                Fault::Limit,
                "",
                "larger than the 4 GiB of a GLB: write .gltf instead",
            )
        };
        u32::try_from(n).map_err(|_| too_large())
    };
    let mut bytes = Vec::with_capacity(length);
    for n in [MAGIC, 2, word(length)?, word(text.len())?, JSON] {
        bytes.extend(n.to_le_bytes());
    }
    bytes.extend(text);
    if !blob.is_empty() {
        bytes.extend(word(padded)?.to_le_bytes());
        bytes.extend(BIN.to_le_bytes());
        bytes.extend_from_slice(blob);
        bytes.resize(length, 0);
    }
    Ok(OutputFile { path: path.to_owned(), bytes })
}

fn gltf(path: &Path, mut root: Object, blob: Vec<u8>) -> Vec<OutputFile> {
    let beside = path.with_extension("bin");
    if !blob.is_empty() {
        let name = beside
            .file_name()
            .map(|n| uri::percent_encoded(&n.to_string_lossy()))
            .unwrap_or_default();
        if let Some(buffer) =
            root.get_mut("buffers").and_then(|b| b.get_mut(0)).and_then(Value::as_object_mut)
        {
            buffer.insert("uri".to_owned(), name.into());
        }
    }
    let mut files = vec![OutputFile { path: path.to_owned(), bytes: to_json(&root, true) }];
    if !blob.is_empty() {
        files.push(OutputFile { path: beside, bytes: blob });
    }
    files
}

/// Names an extension in one of the lists of the document.
fn add_extension(root: &mut Object, list: &str, name: &str) {
    let names = root.entry(list).or_insert_with(|| Value::Array(Vec::new()));
    if let Value::Array(names) = names
        && !names.iter().any(|n| n == name)
    {
        names.push(name.into());
    }
}

fn to_json(root: &Object, pretty: bool) -> Vec<u8> {
    let text = if pretty { serde_json::to_vec_pretty(root) } else { serde_json::to_vec(root) };
    text.expect("values from JSON can be written as JSON")
}

#[cfg(test)]
mod tests;
