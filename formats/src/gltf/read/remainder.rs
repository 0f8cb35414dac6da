//! What an import stores of a glTF besides its meshes: the document without the primitives'
//! geometry, its remaining buffer views copied into one buffer.

use super::blob::compact;
use super::primitive;
use crate::gltf::extension_table::DROPPED_FROM_MESHES;
use crate::gltf::extensions::{self, DRACO, MESHOPT, Unknown};
use crate::gltf::json::Object;
use crate::gltf::schema::{self, Pool, primitive_mut, referenced, retain};
use crate::gltf::views::Views;
use crate::words::counted;
use crate::{FormatError, GltfDocument};
use std::collections::BTreeSet;

/// Takes the given primitives' geometry (mesh, primitive) and what nothing names out of a document
/// and compacts the rest. What an unknown extension might point to keeps its number; where it was
/// old geometry, or the extension does not have its number, it is empty.
pub(super) fn remainder(
    mut root: Object,
    stripped: &[(usize, usize)],
    views: &Views<'_>,
    warnings: &mut Vec<String>,
) -> Result<GltfDocument, FormatError> {
    let pools = [Pool::Accessors, Pool::BufferViews];
    let referenced_before = pools.map(|pool| referenced(&mut root, pool));
    let mut outlines = 0;
    for &(mesh, p) in stripped {
        let primitive = primitive_mut(&mut root, mesh, p).expect("it has been read");
        outlines += usize::from(primitive::strip(primitive));
    }
    if outlines > 0 {
        let primitives = counted(outlines, "primitive", "primitives");
        warnings.push(format!(
            "left out the outlines or n-gons of {primitives}: they number triangles of the input"
        ));
    }
    let simplified: BTreeSet<usize> = stripped.iter().map(|(mesh, _)| *mesh).collect();
    for &mesh in &simplified {
        let mesh = root.object_mut("meshes", mesh).expect("it has been read");
        DROPPED_FROM_MESHES.iter().for_each(|name| mesh.remove_extension(name));
    }
    drop_draco(&mut root);
    let unknown = extensions::unknown(&root);
    if let Some(Unknown { name, .. }) = &unknown {
        warnings.push(format!(
            "the extension {name} is unknown: accessors and buffer views that its numbers may mean \
             keep their numbers; those of simplified triangles are empty"
        ));
    }
    let mut kept_views: Vec<usize> = (0..Pool::BufferViews.len(&root)).collect();
    let mut emptied = vec![false; kept_views.len()];
    for (pool, referenced_before) in pools.into_iter().zip(referenced_before) {
        // An unknown extension has a number of what it names, and keeps all up to its largest.
        let has_number = |i: usize| unknown.as_ref().is_some_and(|u| u.numbers.contains(&i));
        let may_be_named = |i: usize| unknown.as_ref().is_some_and(|u| u.may_name(i));
        let used: Vec<bool> = referenced(&mut root, pool)
            .into_iter()
            .zip(referenced_before)
            .enumerate()
            .map(|(i, (is_used, was_used))| is_used || !was_used && has_number(i))
            .collect();
        let keep: Vec<bool> =
            used.iter().enumerate().map(|(i, used)| *used || may_be_named(i)).collect();
        if pool == Pool::Accessors {
            let unused = root.objects_mut("accessors").zip(&used).filter(|(_, used)| !**used);
            unused.for_each(|(accessor, _)| empty(accessor));
        } else {
            kept_views.retain(|&v| keep[v]);
            emptied = kept_views.iter().map(|&v| !used[v]).collect();
        }
        retain(&mut root, pool, &keep);
    }
    let blob = compact(&mut root, &kept_views, &emptied, views)?;
    for name in MESHOPT {
        extensions::forget(&mut root, name);
    }
    schema::check(&mut root)?;
    Ok(GltfDocument::of_root(root, blob))
}

/// Takes the bytes off an accessor that has to keep its number: what is left is one zero.
fn empty(accessor: &mut Object) {
    for key in ["bufferView", "byteOffset", "sparse", "min", "max"] {
        accessor.shift_remove(key);
    }
    accessor["count"] = 1u32.into();
}

/// Drops the Draco extension: the data is there uncompressed, from the start or since it was
/// decoded.
fn drop_draco(root: &mut Object) {
    for mesh in root.objects_mut("meshes") {
        mesh.objects_mut("primitives").for_each(|primitive| primitive.remove_extension(DRACO));
    }
    extensions::forget(root, DRACO);
}
