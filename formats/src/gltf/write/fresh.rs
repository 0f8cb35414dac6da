//! A glTF document for what did not come from glTF: one mesh and node per object, one material per
//! OBJ material.

use crate::gltf::json::{Json, Object, object};
use crate::gltf::uri;
use crate::obj::mtl::{Meaning, options_and_file};
use crate::{ObjDocument, ObjMaterial, ObjectInfo};
use lodc_mesh::{Attribute, Component, Mesh, Semantic};

/// A document whose primitives have no geometry yet.
pub(super) fn document(obj: &ObjDocument, objects: &[&ObjectInfo]) -> Object {
    let mut images: Vec<String> = Vec::new();
    let materials: Vec<Json> = obj.materials.iter().map(|m| material(m, &mut images)).collect();
    let number = |name: &str| obj.materials.iter().position(|m| m.name == name);
    let mesh = |object: &&ObjectInfo| {
        let primitive = |name: Option<&String>| match name.and_then(|n| number(n)) {
            Some(material) => object! { "material" => material },
            None => object! {},
        };
        let primitives: Vec<Json> =
            object.submeshes.iter().map(|s| primitive(s.material.as_ref())).collect();
        object! { "name" => &*object.name, "primitives" => primitives }
    };
    let node = |i: usize| object! { "name" => &*objects[i].name, "mesh" => i };
    let mut root = Object::default();
    let mut put = |key: &str, values: Vec<Json>| {
        if !values.is_empty() {
            root[key] = values.into();
        }
    };
    put("meshes", objects.iter().map(mesh).collect());
    put("nodes", (0..objects.len()).map(node).collect());
    put("materials", materials);
    put("textures", (0..images.len()).map(|i| object! { "source" => i }).collect());
    put("images", images.iter().map(|uri| object! { "uri" => &**uri }).collect());
    let roots: Vec<usize> = (0..objects.len()).collect();
    if !roots.is_empty() {
        put("scenes", vec![object! { "nodes" => roots }]);
        root["scene"] = 0u32.into();
    }
    root["asset"] = object! { "version" => "2.0", "generator" => "lodc" };
    root
}

fn material(material: &ObjMaterial, images: &mut Vec<String>) -> Json {
    let meaning = Meaning::of(material);
    let unit = |c: f64| c.clamp(0.0, 1.0);
    let [r, g, b] = meaning.diffuse.unwrap_or([1.0; 3]).map(unit);
    let mut color = [r, g, b, meaning.dissolve.map_or(1.0, unit)];
    let emissive = meaning.emissive.unwrap_or_default().map(unit);
    let mut pbr = object! { "baseColorFactor" => color, "metallicFactor" => 0.0 };
    if let Some(uri) = meaning.texture.as_deref().and_then(file_name) {
        let index = images.iter().position(|i| *i == uri).unwrap_or_else(|| {
            images.push(uri);
            images.len() - 1
        });
        // A factor of black would hide the texture; OBJ files with a texture often have it.
        if color[..3] == [0.0; 3] {
            color[..3].fill(1.0);
            pbr["baseColorFactor"] = color.into();
        }
        pbr["baseColorTexture"] = object! { "index" => index };
    }
    let mut out = object! { "name" => &*material.name, "pbrMetallicRoughness" => pbr };
    if emissive != [0.0; 3] {
        out["emissiveFactor"] = emissive.into();
    }
    if color[3] < 1.0 {
        out["alphaMode"] = "BLEND".into();
    }
    out
}

/// The file of a `map_` statement as a URI. None for paths that no relative URI can name.
fn file_name(rest: &str) -> Option<String> {
    let path = options_and_file(rest)?.1.replace('\\', "/");
    let relative = !path.starts_with('/') && !path.contains(':') && !path.contains('\0');
    relative.then(|| uri::of_path(&path))
}

/// A mesh as glTF wants it: texture coordinates from the top down, normals of unit length, colours
/// from 0 to 1.
pub(super) fn adapted(mesh: &Mesh) -> Mesh {
    let mut parts = mesh.clone().into_parts();
    for a in parts.attributes.iter_mut().filter(|a| a.component == Component::F32) {
        match (&a.semantic, a.components) {
            (Semantic::TexCoord(_), _) => {
                two_components(a);
                each(a, |uv| uv[1] = 1.0 - uv[1]);
            }
            (Semantic::Normal, 3) => each(a, unit),
            (Semantic::Color(_), _) => each(a, |c| {
                c.iter_mut().for_each(|v| *v = if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) });
            }),
            _ => {}
        }
    }
    Mesh::try_from(parts).expect("only values of attributes have changed")
}

/// Leaves texture coordinates the two numbers that glTF has: of OBJ there may be one or three.
fn two_components(a: &mut Attribute) {
    if a.components != 2 {
        let of_vertex = |all: &[u8]| {
            let mut two = [0; 8];
            two.iter_mut().zip(all).for_each(|(byte, &own)| *byte = own);
            two
        };
        a.bytes = a.bytes.chunks_exact(a.stride()).flat_map(of_vertex).collect();
        a.components = 2;
    }
}

fn unit(n: &mut [f32]) {
    let square: f64 = n.iter().map(|&c| f64::from(c).powi(2)).sum();
    if square.is_finite() && square > 0.0 {
        let length = square.sqrt();
        // What is a unit vector already stays bit for bit.
        if (length - 1.0).abs() > 1e-5 {
            n.iter_mut().for_each(|c| *c = (f64::from(*c) / length) as f32);
        }
    } else {
        n.copy_from_slice(&[0.0, 0.0, 1.0]);
    }
}

fn each(a: &mut Attribute, change: impl Fn(&mut [f32])) {
    let mut values = vec![0.0; usize::from(a.components)];
    for element in a.bytes.chunks_exact_mut(4 * usize::from(a.components)) {
        for (value, b) in values.iter_mut().zip(element.chunks_exact(4)) {
            *value = f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        }
        change(&mut values);
        for (value, b) in values.iter().zip(element.chunks_exact_mut(4)) {
            b.copy_from_slice(&value.to_le_bytes());
        }
    }
}
