//! Base colours and textures of an OBJ's materials: `Kd`, `d`, `Tr` and `map_Kd`; with `map_d`, the
//! texture's own opacity is used as a cutout.

use super::coordinates::{PLAIN as PLAIN_COORDINATES, read_by};
use super::mtl::{DEFAULT_GREY, Meaning, TextureMap, numbers};
use crate::images::Pictures;
use crate::{Assets, FormatError, ObjDocument, ObjMaterial, ObjectInfo, SubmeshInfo};
use lodc_scene::{AlphaMode, Appearance, Coordinates, Material, Texture, Wrap};
use std::collections::BTreeSet;

/// The material of an OBJ without a `.mtl`: a light grey, seen from both sides.
const PLAIN: Material = Material {
    colour: [DEFAULT_GREY, DEFAULT_GREY, DEFAULT_GREY, 1.0],
    texture: None,
    coordinates: PLAIN_COORDINATES,
    double_sided: true,
    alpha: AlphaMode::Opaque,
    unlit: false,
};

/// Reads the materials of an OBJ and their pictures.
///
/// # Errors
/// If its pictures are beyond the limits.
pub(crate) fn appearance(
    obj: &ObjDocument,
    objects: &[&ObjectInfo],
    assets: &mut Assets,
) -> Result<Appearance, FormatError> {
    let mut pictures = Pictures::new(assets.limits());
    let submeshes = objects.iter().flat_map(|o| &o.submeshes);
    let used: BTreeSet<&str> = submeshes.filter_map(|s| s.material.as_deref()).collect();
    let mut materials = vec![PLAIN];
    // Pictures of materials that nothing uses are not read.
    for m in &obj.materials {
        let is_used = used.contains(m.name.as_str());
        materials.push(if is_used { material(m, &mut pictures, assets)? } else { PLAIN });
    }
    materials.push(Material { colour: [1.0; 4], ..PLAIN });
    let numbers = numbers(&obj.materials);
    let number = |name: &str| numbers.get(name).map_or(0, |number| 1 + number);
    let material_of = |s: &SubmeshInfo| s.material.as_deref().map_or(0, number);
    Ok(Appearance {
        painted: Some(materials.len() - 1),
        materials,
        of_submesh: objects.iter().map(|o| o.submeshes.iter().map(material_of).collect()).collect(),
        images: pictures.list,
        warnings: pictures.warnings,
    })
}

fn material(
    source: &ObjMaterial,
    pictures: &mut Pictures,
    assets: &mut Assets,
) -> Result<Material, FormatError> {
    let meaning = Meaning::of(source);
    let map = meaning.map();
    let coordinates = read_by(map.as_ref());
    let texture = match &map {
        Some(map) => texture(map, coordinates, pictures, assets)?,
        None => None,
    };
    let (colour, alpha) = (meaning.base_colour(texture.is_some()), meaning.alpha_mode());
    Ok(Material { colour, alpha, texture, coordinates, ..PLAIN })
}

/// The picture of a texture; none if it cannot be read.
fn texture(
    map: &TextureMap<'_>,
    Coordinates { set, transform }: Coordinates,
    pictures: &mut Pictures,
    assets: &mut Assets,
) -> Result<Option<Texture>, FormatError> {
    let path = map.file.replace('\\', "/");
    let image = pictures.get(&path, map.file, || assets.read_name(&path))?;
    let wrap = [if map.clamped { Wrap::Clamp } else { Wrap::Repeat }; 2];
    Ok(image.map(|image| Texture { image, set, transform, wrap, nearest: false }))
}
