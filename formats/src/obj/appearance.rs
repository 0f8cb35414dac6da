//! Materials of an OBJ: `Kd`, `d`, `Tr` and `map_Kd`; `map_d` means that the texture's own opacity
//! cuts.

use super::mtl::{Meaning, TextureMap, UNSAID};
use crate::images::Pictures;
use crate::{Assets, FormatError, ObjDocument, ObjMaterial, ObjectInfo};
use lodc_scene::{AlphaMode, Appearance, Coordinates, Material, Texture, Wrap};
use std::collections::{BTreeMap, BTreeSet};

/// Without a `.mtl`: a light grey, seen from both sides. The texture coordinate 0 is an image's
/// bottom, its first row is the top.
const PLAIN: Material = Material {
    colour: [UNSAID, UNSAID, UNSAID, 1.0],
    texture: None,
    coordinates: Coordinates { set: 0, transform: [[1.0, 0.0, 0.0], [0.0, -1.0, 1.0]] },
    double_sided: true,
    alpha: AlphaMode::Opaque,
    unlit: false,
};

/// The looks of an OBJ.
///
/// # Errors
/// If its pictures are beyond the limits.
pub(crate) fn appearance(
    obj: &ObjDocument,
    objects: &[&ObjectInfo],
    assets: &mut Assets,
) -> Result<Appearance, FormatError> {
    let mut pictures = Pictures::new(assets.limits());
    let shown = objects.iter().flat_map(|o| &o.submeshes).filter_map(|s| s.material.as_deref());
    let used: BTreeSet<&str> = shown.collect();
    let mut materials = vec![PLAIN];
    // What nothing uses need not have its pictures read.
    for m in &obj.materials {
        let used = used.contains(m.name.as_str());
        materials.push(if used { material(m, &mut pictures, assets)? } else { PLAIN });
    }
    // Of several with one name the first counts.
    let mut numbers: BTreeMap<&str, usize> = BTreeMap::new();
    for (number, m) in (1..).zip(&obj.materials) {
        numbers.entry(&m.name).or_insert(number);
    }
    let number = |name: &Option<String>| numbers.get(name.as_deref()?).copied();
    let of =
        |o: &&ObjectInfo| o.submeshes.iter().map(|s| number(&s.material).unwrap_or(0)).collect();
    Ok(Appearance {
        materials,
        of_submesh: objects.iter().map(of).collect(),
        images: pictures.list,
        warnings: pictures.warnings,
    })
}

/// The texture coordinates that submeshes of an OBJ show.
pub(crate) fn coordinates(objects: &[&ObjectInfo]) -> Vec<Vec<Coordinates>> {
    objects.iter().map(|o| vec![PLAIN.coordinates; o.submeshes.len()]).collect()
}

fn material(
    source: &ObjMaterial,
    pictures: &mut Pictures,
    assets: &mut Assets,
) -> Result<Material, FormatError> {
    let meaning = Meaning::of(source);
    let mut material = PLAIN;
    if let Some(map) = &meaning.texture {
        material.texture = texture(map, pictures, assets)?;
    }
    let textured = material.texture.is_some();
    material.colour = meaning.base_colour(textured);
    material.alpha = meaning.alpha_mode();
    Ok(material)
}

/// The texture of `map_Kd [-option value...]... FILE`.
fn texture(
    rest: &str,
    pictures: &mut Pictures,
    assets: &mut Assets,
) -> Result<Option<Texture>, FormatError> {
    let Some(map) = TextureMap::of(rest) else { return Ok(None) };
    let turned = map.file.replace('\\', "/");
    let image = pictures.get(&turned, map.file, || assets.read_reference(&turned))?;
    let Some(image) = image else { return Ok(None) };
    // The picture's first row is the top, the texture coordinate 0 is the bottom.
    let ([su, sv], [u, v]) = (map.scale, map.offset);
    let transform = [[su, 0.0, u], [0.0, -sv, 1.0 - v]];
    let wrap = if map.clamped { Wrap::Clamp } else { Wrap::Repeat };
    Ok(Some(Texture { image, set: 0, transform, wrap: [wrap; 2], nearest: false }))
}
