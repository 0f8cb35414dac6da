//! What an import stores of a glTF besides its meshes: the document without the primitives'
//! geometry, its remaining buffer views copied into one buffer.

use super::blob::compact;
use super::primitive;
use crate::gltf::extensions::{self, DRACO, MESHOPT};
use crate::gltf::json::Object;
use crate::gltf::schema::{Pool, primitive_mut, referenced, retain};
use crate::gltf::views::Views;
use crate::{FormatError, GltfDocument};

/// Takes the given primitives' geometry (mesh, primitive) out of a document and compacts the rest.
/// Nothing is renumbered while an unknown extension might point to it; then old geometry stays
/// behind.
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
        warnings.push(format!(
            "outlines or n-gons of {outlines} primitives dropped: they name the old triangles"
        ));
    }
    drop_draco(&mut root);
    let mut kept_views: Vec<usize> = (0..Pool::BufferViews.len(&root)).collect();
    if let Some(name) = extensions::opaque(&root) {
        warnings.push(format!(
            "the extension {name} is unknown and may refer to old data, which stays in the file"
        ));
    } else {
        for (pool, referenced_before) in pools.into_iter().zip(referenced_before) {
            // What nothing referred to from the start may be meant for other programs.
            let referenced_after = referenced(&mut root, pool).into_iter();
            let keep: Vec<bool> = referenced_after
                .zip(referenced_before)
                .map(|(is_used, was_used)| is_used || !was_used)
                .collect();
            retain(&mut root, pool, &keep);
            if pool == Pool::BufferViews {
                kept_views.retain(|&v| keep[v]);
            }
        }
    }
    let blob = compact(&mut root, &kept_views, views)?;
    for name in MESHOPT {
        extensions::forget(&mut root, name);
    }
    Ok(GltfDocument { json: root.to_string(), blob })
}

/// Drops the Draco extension: the data is there uncompressed, from the start or since it was
/// decoded.
fn drop_draco(root: &mut Object) {
    for mesh in root.objects_mut("meshes") {
        mesh.objects_mut("primitives").for_each(|primitive| primitive.remove_extension(DRACO));
    }
    extensions::forget(root, DRACO);
}
