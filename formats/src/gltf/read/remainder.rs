//! The rest of a document when its triangles are gone: everything else, its buffer views
//! compacted into one blob.

use super::blob::compact;
use super::primitive;
use crate::gltf::extensions::{self, DRACO, MESHOPT};
use crate::gltf::json::{self, Object, integer};
use crate::gltf::schema::{Pool, references, retain};
use crate::gltf::views::Views;
use crate::{FormatError, GltfDocument};
use serde_json::Value;

/// Takes the given primitives' geometry (mesh, primitive) out of a document and compacts the rest.
/// Nothing is renumbered while an unknown extension might point to it; then old geometry stays
/// behind.
pub(super) fn remainder(
    mut root: Object,
    stripped: &[(usize, usize)],
    views: &Views<'_>,
    warnings: &mut Vec<String>,
) -> Result<GltfDocument, FormatError> {
    let before = Used::of(&mut root);
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
    let mut kept: Vec<usize> = (0..before.views.len()).collect();
    if let Some(name) = extensions::opaque(&root) {
        warnings.push(format!(
            "the extension {name} is unknown and may refer to old data, which stays in the file"
        ));
    } else {
        let after = Used::of(&mut root);
        // What nothing pointed to from the start may be meant for someone else.
        let keep = |before: &[bool], after: &[bool]| -> Vec<bool> {
            before.iter().zip(after).map(|(b, a)| *a || !*b).collect()
        };
        let keep_views = keep(&before.views, &after.views);
        retain(&mut root, Pool::Accessors, &keep(&before.accessors, &after.accessors));
        retain(&mut root, Pool::BufferViews, &keep_views);
        kept.retain(|&v| keep_views[v]);
    }
    let blob = compact(&mut root, &kept, views)?;
    for name in MESHOPT {
        extensions::forget(&mut root, name);
    }
    Ok(GltfDocument { json: Value::Object(root).to_string(), blob })
}

fn primitive_mut(root: &mut Object, mesh: usize, primitive: usize) -> Option<&mut Object> {
    let mesh = root.get_mut("meshes")?.as_array_mut()?.get_mut(mesh)?;
    mesh.get_mut("primitives")?.as_array_mut()?.get_mut(primitive)?.as_object_mut()
}

/// Compressed primitives have been refused, so wherever the extension is left the uncompressed data
/// is there too.
fn drop_draco(root: &mut Object) {
    for mesh in root.get_mut("meshes").and_then(Value::as_array_mut).into_iter().flatten() {
        for primitive in
            mesh.get_mut("primitives").and_then(Value::as_array_mut).into_iter().flatten()
        {
            if let Some(primitive) = primitive.as_object_mut() {
                json::remove_extension(primitive, DRACO);
            }
        }
    }
    extensions::forget(root, DRACO);
}

/// Accessors and buffer views that something refers to; what an unused accessor refers to does not
/// count.
struct Used {
    accessors: Vec<bool>,
    views: Vec<bool>,
}

impl Used {
    fn of(root: &mut Object) -> Self {
        let mut accessors = vec![false; Pool::Accessors.len(root)];
        let mut views = vec![false; Pool::BufferViews.len(root)];
        let index = |v: &Value| integer(v).map_or(usize::MAX, |i| i as usize);
        references(root, Pool::Accessors, &mut |v, _| accessors[index(v)] = true);
        references(root, Pool::BufferViews, &mut |v, place| {
            let accessor = place
                .strip_prefix("accessors[")
                .and_then(|p| p.split_once(']')?.0.parse::<usize>().ok());
            if accessor.is_none_or(|a| accessors[a]) {
                views[index(v)] = true;
            }
        });
        Self { accessors, views }
    }
}
