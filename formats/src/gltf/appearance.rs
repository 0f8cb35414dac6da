//! Base colours of glTF materials (glTF 2.0, 3.9), of the older specular-glossiness ones, and their
//! textures.

use super::pictures::Pictures;
use crate::import::gltf::uri;
use crate::nodes::{as_index, numbers};
use crate::{Assets, FormatError};
use lodc_scene::{AlphaMode, Coordinates, Material, Texture, Wrap};
use serde_json::Value;

/// Reads textures of one document.
pub(super) struct Reader<'a> {
    pub(super) json: &'a Value,
    pub(super) pictures: Pictures,
    pub(super) assets: &'a mut Assets,
    /// The bytes of a buffer view.
    pub(super) view: &'a dyn Fn(usize) -> Result<Vec<u8>, FormatError>,
}

impl Reader<'_> {
    /// A material of the document.
    pub(super) fn material(&mut self, source: &Value) -> Material {
        let glossy = &source["extensions"]["KHR_materials_pbrSpecularGlossiness"];
        let metal = &source["pbrMetallicRoughness"];
        let (colour, texture) = if metal.is_object() || !glossy.is_object() {
            (&metal["baseColorFactor"], &metal["baseColorTexture"])
        } else {
            (&glossy["diffuseFactor"], &glossy["diffuseTexture"])
        };
        let cut_off = source["alphaCutoff"].as_f64().unwrap_or(0.5) as f32;
        let mut colour = numbers(colour, [1.0; 4]).map(|v| (v as f32).clamp(0.0, 1.0));
        let found = self.texture(texture);
        if found.is_none() && texture.is_object() {
            // White stands for the texture that could not be had; grey shows the shape.
            colour[..3].iter_mut().for_each(|c| *c *= 0.6);
        }
        let read = if texture.is_object() { Some(texture) } else { any_texture(source) };
        Material {
            colour,
            texture: found,
            coordinates: read.map_or(Coordinates::PLAIN, coordinates),
            double_sided: source["doubleSided"].as_bool().unwrap_or(false),
            alpha: match source["alphaMode"].as_str() {
                Some("MASK") => AlphaMode::Mask(cut_off),
                Some("BLEND") => AlphaMode::Blend,
                _ => AlphaMode::Opaque,
            },
            unlit: source["extensions"]["KHR_materials_unlit"].is_object(),
        }
    }

    fn texture(&mut self, info: &Value) -> Option<Texture> {
        let texture = &self.json["textures"][as_index(&info["index"])?];
        let image = self.image(as_index(&texture["source"]))?;
        let Coordinates { set, transform } = coordinates(info);
        let sampler =
            as_index(&texture["sampler"]).map_or(&Value::Null, |s| &self.json["samplers"][s]);
        let wrap = |key: &str| match sampler[key].as_u64() {
            Some(33071) => Wrap::Clamp,
            Some(33648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        Some(Texture {
            image,
            set,
            transform,
            wrap: [wrap("wrapS"), wrap("wrapT")],
            nearest: sampler["magFilter"].as_u64() == Some(9728),
        })
    }

    fn image(&mut self, image: Option<usize>) -> Option<usize> {
        let Some(image) = image else {
            let extensions = "in a format that an extension names";
            self.pictures.get("", extensions, || {
                Err(FormatError::new(
                    crate::Fault::Unsupported,
                    "",
                    "a texture without a PNG or JPEG",
                ))
            });
            return None;
        };
        let source = &self.json["images"][image];
        let place = format!("images[{image}]");
        let name = source["name"].as_str().unwrap_or(&place);
        let Self { pictures, assets, view, .. } = self;
        pictures.get(&place, name, || {
            match (source["uri"].as_str(), as_index(&source["bufferView"])) {
                (Some(uri), _) => uri::read(uri, &place, assets),
                (None, Some(index)) => view(index),
                (None, None) => Err(FormatError::new(
                    crate::Fault::Malformed,
                    place.clone(),
                    "has neither uri nor bufferView",
                )),
            }
        })
    }
}

/// The first texture of a material, whatever it is for.
fn any_texture(source: &Value) -> Option<&Value> {
    source.as_object()?.iter().find_map(|(name, value)| {
        let is_texture = name.ends_with("Texture") && as_index(&value["index"]).is_some();
        if is_texture { Some(value) } else { any_texture(value) }
    })
}

/// The texture coordinates that a texture reads.
fn coordinates(info: &Value) -> Coordinates {
    let moved = &info["extensions"]["KHR_texture_transform"];
    let set = as_index(&moved["texCoord"]).or(as_index(&info["texCoord"])).unwrap_or(0);
    Coordinates { set: u32::try_from(set).unwrap_or(u32::MAX), transform: transform(moved) }
}

/// `KHR_texture_transform`: first scaled, then turned, then moved.
fn transform(source: &Value) -> [[f32; 3]; 2] {
    let [x, y] = numbers(&source["offset"], [0.0; 2]);
    let [sx, sy] = numbers(&source["scale"], [1.0; 2]);
    let (sine, cosine) = source["rotation"].as_f64().unwrap_or(0.0).sin_cos();
    [[cosine * sx, sine * sy, x], [-sine * sx, cosine * sy, y]].map(|row| row.map(|v| v as f32))
}
