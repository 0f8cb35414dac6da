//! Base colours and textures of a stored glTF's materials: metallic-roughness (glTF 2.0, 3.9) and
//! the older KHR_materials_pbrSpecularGlossiness.

use super::coordinates::{base_colour, material_coordinates, materials};
use super::document::Stored;
use super::json::{Json, Object};
use super::texture_transform::texture_coordinates;
use super::uri;
use crate::images::Pictures;
use crate::obj::mtl::DEFAULT_GREY;
use crate::{Assets, Fault, FormatError, GltfDocument, ObjectInfo};
use lodc_scene::{AlphaMode, Appearance, Coordinates, Material, Texture, Wrap};
use std::collections::BTreeSet;

/// Linear colour of a mesh without a material. glTF says white, on which highlights cannot be seen.
const PLAIN: [f32; 4] = [DEFAULT_GREY, DEFAULT_GREY, DEFAULT_GREY, 1.0];

/// Reads the materials, textures and pictures of a document.
///
/// # Errors
/// If it is damaged.
pub(crate) fn appearance(
    document: &GltfDocument,
    objects: &[&ObjectInfo],
    assets: &mut Assets,
) -> Result<Appearance, FormatError> {
    let limits = *assets.limits();
    Stored::read(document, &limits, |stored, root| {
        let submesh_materials = materials(root, objects);
        let view = |index| stored.view(index);
        let mut reader = Reader { root, pictures: Pictures::new(&limits), assets, view: &view };
        let mut materials = vec![Material { colour: PLAIN, ..Material::default() }];
        // Pictures of materials that nothing uses are not read.
        let used: BTreeSet<usize> = submesh_materials.iter().flatten().copied().collect();
        for (number, source) in (1..).zip(root.list("materials")) {
            let is_used = used.contains(&number);
            materials.push(if is_used { reader.material(source)? } else { Material::default() });
        }
        let Pictures { list: images, warnings, .. } = reader.pictures;
        let painted = Some(materials.len());
        materials.push(Material::default());
        Ok(Appearance { materials, painted, of_submesh: submesh_materials, images, warnings })
    })
}

/// Reads the materials of one document.
struct Reader<'a> {
    root: &'a Object,
    pictures: Pictures,
    assets: &'a mut Assets,
    /// The bytes of a buffer view.
    view: &'a dyn Fn(usize) -> Result<Vec<u8>, FormatError>,
}

impl Reader<'_> {
    /// A material of the document.
    ///
    /// # Errors
    /// If its picture is beyond the limits.
    fn material(&mut self, source: &Json) -> Result<Material, FormatError> {
        let (colour, texture) = base_colour(source);
        let cut_off = source["alphaCutoff"].as_f64().unwrap_or(0.5) as f32;
        let mut colour = colour.numbers([1.0; 4]).map(|v| (v as f32).clamp(0.0, 1.0));
        let image = self.texture(texture)?;
        if image.is_none() && texture.is_object() {
            // The factor is meant for the missing texture and is often white, on which highlights
            // cannot be seen.
            colour[..3].iter_mut().for_each(|c| *c *= DEFAULT_GREY);
        }
        Ok(Material {
            colour,
            texture: image,
            coordinates: material_coordinates(source),
            double_sided: source["doubleSided"].as_bool().unwrap_or(false),
            alpha: match source["alphaMode"].as_str() {
                Some("MASK") => AlphaMode::Mask(cut_off),
                Some("BLEND") => AlphaMode::Blend,
                _ => AlphaMode::Opaque,
            },
            unlit: source["extensions"]["KHR_materials_unlit"].is_object(),
        })
    }

    fn texture(&mut self, info: &Json) -> Result<Option<Texture>, FormatError> {
        let Some(index) = info["index"].as_index() else { return Ok(None) };
        let texture = &self.root["textures"][index];
        let Some(image) = self.image(texture["source"].as_index())? else { return Ok(None) };
        let Coordinates { set, transform } = texture_coordinates(info);
        let sampler =
            texture["sampler"].as_index().map_or(&Json::Null, |s| &self.root["samplers"][s]);
        let wrap = |key: &str| match sampler[key].as_u64() {
            Some(33071) => Wrap::Clamp,
            Some(33648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        Ok(Some(Texture {
            image,
            set,
            transform,
            wrap: [wrap("wrapS"), wrap("wrapT")],
            nearest: sampler["magFilter"].as_u64() == Some(9728),
        }))
    }

    fn image(&mut self, image: Option<usize>) -> Result<Option<usize>, FormatError> {
        let Some(image) = image else {
            let name = "in a format that an extension names";
            return self.pictures.get("", name, || {
                Err(FormatError::new(Fault::Unsupported, "", "a texture without a PNG or JPEG"))
            });
        };
        let source = &self.root["images"][image];
        let location = format!("images[{image}]");
        let name = source["name"].as_str().unwrap_or(&location);
        let Self { pictures, assets, view, .. } = self;
        pictures.get(&location, name, || {
            match (source["uri"].as_str(), source["bufferView"].as_index()) {
                (Some(uri), _) => uri::read(uri, &location, assets),
                (None, Some(index)) => view(index),
                (None, None) => Err(FormatError::new(
                    Fault::Malformed,
                    location.clone(),
                    "has neither uri nor bufferView",
                )),
            }
        })
    }
}
