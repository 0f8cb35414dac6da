//! Materials of an OBJ: `Kd`, `d`, `Tr` and `map_Kd`; `map_d` means that the texture's own opacity
//! cuts.

use super::mtl::{self, Meaning};
use crate::images::Pictures;
use crate::{Assets, FormatError, ObjDocument, ObjMaterial, ObjectInfo};
use lodc_scene::{AlphaMode, Appearance, Coordinates, Material, Texture, Wrap, to_linear};
use std::collections::{BTreeMap, BTreeSet};

/// Without a `.mtl`: a light grey, seen from both sides. The texture coordinate 0 is an image's
/// bottom, its first row is the top.
const PLAIN: Material = Material {
    colour: [0.6, 0.6, 0.6, 1.0],
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
    // `Kd` has no colour space of its own; programs show it as they show texels.
    let linear = |v: f64| to_linear((v as f32).clamp(0.0, 1.0));
    let mut material = PLAIN;
    let meaning = Meaning::of(source);
    if let Some(diffuse) = meaning.diffuse {
        material.colour[..3].copy_from_slice(&diffuse.map(linear));
    }
    if let Some(dissolve) = meaning.dissolve {
        material.colour[3] = (dissolve as f32).clamp(0.0, 1.0);
    }
    if let Some(map) = &meaning.texture {
        material.texture = texture(map, pictures, assets)?;
    }
    let black = material.colour[..3].iter().all(|&c| c == 0.0);
    if material.texture.is_some() && (black || meaning.diffuse.is_none()) {
        // Many writers leave `Kd` black or out where a texture says the colour.
        material.colour[..3].copy_from_slice(&[1.0; 3]);
    }
    material.alpha = match material.colour[3] {
        // Exporters that mean nothing by it write 0, and a thing that cannot be seen is no
        // material.
        0.0 => {
            material.colour[3] = 1.0;
            AlphaMode::Opaque
        }
        d if d < 1.0 => AlphaMode::Blend,
        _ if meaning.cut => AlphaMode::Mask(0.5),
        _ => AlphaMode::Opaque,
    };
    Ok(material)
}

/// The texture of `map_Kd [-option value...]... FILE`.
fn texture(
    rest: &str,
    pictures: &mut Pictures,
    assets: &mut Assets,
) -> Result<Option<Texture>, FormatError> {
    let Some((options, name)) = mtl::options_and_file(rest) else { return Ok(None) };
    let (mut scale, mut offset, mut wrap) = ([1.0f32; 2], [0.0f32; 2], Wrap::Repeat);
    for (option, values) in options {
        let number =
            |i: usize, default: f32| values.get(i).and_then(|v| v.parse().ok()).unwrap_or(default);
        match option {
            "-s" => scale = [number(0, 1.0), number(1, 1.0)],
            "-o" => offset = [number(0, 0.0), number(1, 0.0)],
            "-clamp" if values == ["on"] => wrap = Wrap::Clamp,
            _ => {}
        }
    }
    let turned = name.replace('\\', "/");
    let image = pictures.get(&turned, name, || assets.read_reference(&turned))?;
    let Some(image) = image else { return Ok(None) };
    // The picture's first row is the top, the texture coordinate 0 is the bottom.
    let transform = [[scale[0], 0.0, offset[0]], [0.0, -scale[1], 1.0 - offset[1]]];
    Ok(Some(Texture { image, set: 0, transform, wrap: [wrap; 2], nearest: false }))
}
