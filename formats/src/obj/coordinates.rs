//! Which texture coordinates the materials of an OBJ read, and how they move them.

use super::mtl::{Meaning, TextureMap, numbers};
use crate::{ObjDocument, ObjectInfo, SubmeshInfo};
use lodc_scene::Coordinates;

/// Texture coordinates begin at the bottom of an image, its rows at the top.
pub(crate) const PLAIN: Coordinates =
    Coordinates { set: 0, transform: [[1.0, 0.0, 0.0], [0.0, -1.0, 1.0]] };

/// The texture coordinates that the textures of submeshes read, by object.
pub(crate) fn coordinates(obj: &ObjDocument, objects: &[&ObjectInfo]) -> Vec<Vec<Coordinates>> {
    let material_coordinates: Vec<Coordinates> =
        obj.materials.iter().map(|m| read_by(Meaning::of(m).map().as_ref())).collect();
    let numbers = numbers(&obj.materials);
    let submesh_coordinates = |s: &SubmeshInfo| {
        let number = s.material.as_deref().and_then(|name| numbers.get(name));
        number.map_or(PLAIN, |&number| material_coordinates[number])
    };
    objects.iter().map(|o| o.submeshes.iter().map(submesh_coordinates).collect()).collect()
}

/// The texture coordinates that a texture reads, whether its picture can be read or not.
pub(super) fn read_by(map: Option<&TextureMap<'_>>) -> Coordinates {
    let Some(&TextureMap { scale: [su, sv], offset: [u, v], .. }) = map else {
        return PLAIN;
    };
    // The picture's first row is the top, the texture coordinate 0 is the bottom.
    Coordinates { set: 0, transform: [[su, 0.0, u], [0.0, -sv, 1.0 - v]] }
}
