//! Makes the glTF document of a scene from another format: one mesh and node per object, one
//! material per OBJ material.

use crate::gltf::accessor::component_number;
use crate::gltf::json::{Json, Object, object};
use crate::gltf::materials::six_decimals;
use crate::gltf::texture_transform::{CLAMP, TRANSFORM};
use crate::gltf::uri;
use crate::gltf::views::put as put_bytes;
use crate::loose::Loose;
use crate::obj::mtl::{Meaning, TextureMap, numbers};
use crate::{ObjDocument, ObjMaterial, ObjectInfo};
use indexmap::IndexSet;
use lodc_mesh::{Attribute, Component, Mesh, Semantic};
use lodc_scene::{AlphaMode, to_linear};

/// A document whose primitives of triangles have no geometry yet, and the bytes of points and
/// lines.
pub(super) fn document(obj: &ObjDocument, objects: &[&ObjectInfo]) -> (Object, Vec<u8>) {
    let mut textures = Textures::default();
    let materials: Vec<Json> = obj.materials.iter().map(|m| material(m, &mut textures)).collect();
    let numbers = numbers(&obj.materials);
    let mesh = |object: &&ObjectInfo| {
        let primitive = |name: Option<&String>| match name.and_then(|n| numbers.get(&**n)) {
            Some(&material) => object! { "material" => material },
            None => object! {},
        };
        let primitives: Vec<Json> =
            object.submeshes.iter().map(|s| primitive(s.material.as_ref())).collect();
        object! { "name" => &*object.name, "primitives" => primitives }
    };
    let placed = |name: &str, mesh: usize| {
        let mut node = object! { "name" => name, "mesh" => mesh };
        if obj.offset != [0.0; 3] {
            node["translation"] = obj.offset.into();
        }
        node
    };
    let mut root = Object::default();
    let (mut meshes, mut blob): (Vec<Json>, _) = (objects.iter().map(mesh).collect(), Vec::new());
    let mut nodes: Vec<Json> = (0..objects.len()).map(|i| placed(&objects[i].name, i)).collect();
    let loose = Loose::read(&obj.loose);
    if !loose.is_empty() {
        nodes.push(placed(LOOSE, meshes.len()));
        meshes.push(loose_mesh(&loose, obj.offset, &mut root, &mut blob));
        root["buffers"] = vec![object! { "byteLength" => blob.len() }].into();
    }
    let roots: Vec<usize> = (0..nodes.len()).collect();
    put(&mut root, "meshes", meshes);
    put(&mut root, "nodes", nodes);
    put(&mut root, "materials", materials);
    textures.write(&mut root);
    if !roots.is_empty() {
        put(&mut root, "scenes", vec![object! { "nodes" => roots }]);
        root["scene"] = 0u32.into();
    }
    root["asset"] = object! { "version" => "2.0", "generator" => "lodc" };
    (root, blob)
}

/// The name of the mesh with points and lines.
const LOOSE: &str = "points and lines";

/// The mesh with points and lines about an offset, its bytes at the end of `blob`.
fn loose_mesh(loose: &Loose, offset: [f64; 3], root: &mut Object, blob: &mut Vec<u8>) -> Json {
    let mut accessor = |kind: &str, component: Component, count: usize, bytes: &[u8]| {
        let view = root.list("bufferViews").len();
        root.append("bufferViews", vec![put_bytes(blob, bytes)]);
        root.append(
            "accessors",
            vec![object! {
                "bufferView" => view, "componentType" => component_number(component),
                "count" => count, "type" => kind,
            }],
        );
        root.list("accessors").len() - 1
    };
    let floats = |values: &[[f32; 3]]| -> Vec<u8> {
        values.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect()
    };
    let indices =
        |values: &[u32]| -> Vec<u8> { values.iter().flat_map(|i| i.to_le_bytes()).collect() };
    let count = loose.positions.len();
    #[expect(clippy::cast_possible_truncation, reason = "glTF has single precision")]
    let near = |p: &[f64; 3]| std::array::from_fn(|k| (p[k] - offset[k]) as f32);
    let positions: Vec<[f32; 3]> = loose.positions.iter().map(near).collect();
    let position = accessor("VEC3", Component::F32, count, &floats(&positions));
    let mut attributes = object! { "POSITION" => position };
    if !loose.colors.is_empty() {
        let light: Vec<[f32; 3]> = loose.colors.iter().map(|c| c.map(to_linear)).collect();
        attributes["COLOR_0"] = accessor("VEC3", Component::F32, count, &floats(&light)).into();
    }
    let mut primitives = Vec::new();
    let lines: Vec<[u32; 2]> = loose.segments().collect();
    // 0 points, 1 lines.
    for (mode, all) in [(0u32, &loose.points[..]), (1, lines.as_flattened())] {
        if !all.is_empty() {
            let mut primitive = object! { "attributes" => attributes.clone(), "mode" => mode };
            if !all.iter().copied().eq(0..count as u32) {
                let bytes = indices(all);
                primitive["indices"] = accessor("SCALAR", Component::U32, all.len(), &bytes).into();
            }
            primitives.push(primitive);
        }
    }
    let (lo, hi) = bounds(&positions);
    if let Some(entry) = root.object_mut("accessors", position) {
        entry["min"] = lo.map(f64::from).into();
        entry["max"] = hi.map(f64::from).into();
    }
    object! { "name" => LOOSE, "primitives" => primitives }
}

fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let start = ([f32::MAX; 3], [f32::MIN; 3]);
    positions.iter().fold(start, |(lo, hi), p| {
        (std::array::from_fn(|i| lo[i].min(p[i])), std::array::from_fn(|i| hi[i].max(p[i])))
    })
}

/// Sets a list, unless it is empty.
fn put(root: &mut Object, key: &str, values: Vec<Json>) {
    if !values.is_empty() {
        root[key] = values.into();
    }
}

/// The materials' textures: one per image, or two if it is both repeated and clamped.
#[derive(Default)]
struct Textures {
    /// URIs.
    images: IndexSet<String>,
    /// The image, and whether it is clamped.
    textures: IndexSet<(usize, bool)>,
    /// True if texture coordinates are moved.
    transformed: bool,
}

impl Textures {
    /// The reference of a material to a texture; none for a name that no file can have.
    fn info(&mut self, map: &TextureMap<'_>) -> Option<Json> {
        let path = map.file.replace('\\', "/");
        if path.contains('\0') {
            return None;
        }
        let image = self.images.insert_full(uri::of_path(&path)).0;
        let index = self.textures.insert_full((image, map.clamped)).0;
        let mut info = object! { "index" => index };
        let ([su, sv], [u, v]) = (map.scale.map(f64::from), map.offset.map(f64::from));
        if (map.scale, map.offset) != ([1.0; 2], [0.0; 2]) {
            // Coordinates of an OBJ begin at the bottom of the picture, those of a glTF at the top.
            let transform = object! { "offset" => [u, 1.0 - sv - v], "scale" => [su, sv] };
            info["extensions"] = object! { TRANSFORM => transform };
            self.transformed = true;
        }
        Some(info)
    }

    fn write(&self, root: &mut Object) {
        let clamped = self.textures.iter().any(|&(_, clamped)| clamped);
        let texture = |&(image, clamped): &(usize, bool)| {
            let mut texture = object! { "source" => image };
            if clamped {
                texture["sampler"] = 0u32.into();
            }
            texture
        };
        put(root, "textures", self.textures.iter().map(texture).collect());
        put(root, "images", self.images.iter().map(|i| object! { "uri" => &**i }).collect());
        if clamped {
            root["samplers"] = vec![object! { "wrapS" => CLAMP, "wrapT" => CLAMP }].into();
        }
        if self.transformed {
            root["extensionsUsed"] = [TRANSFORM].into();
        }
    }
}

fn material(material: &ObjMaterial, textures: &mut Textures) -> Json {
    let meaning = Meaning::of(material);
    let texture = meaning.map().and_then(|map| textures.info(&map));
    let color = meaning.base_colour(texture.is_some()).map(|c| six_decimals(c.into()));
    let mut pbr = object! { "baseColorFactor" => color, "metallicFactor" => 0.0 };
    if let Some(texture) = texture {
        pbr["baseColorTexture"] = texture;
    }
    let mut out = object! { "name" => &*material.name, "pbrMetallicRoughness" => pbr };
    let emissive = meaning.emissive.unwrap_or_default().map(|c| c.clamp(0.0, 1.0));
    if emissive != [0.0; 3] {
        out["emissiveFactor"] = emissive.into();
    }
    match meaning.alpha_mode() {
        AlphaMode::Opaque => {}
        AlphaMode::Mask(_) => out["alphaMode"] = "MASK".into(),
        AlphaMode::Blend => out["alphaMode"] = "BLEND".into(),
    }
    out
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

/// Gives texture coordinates the two numbers that glTF has: an OBJ may have one or three.
fn two_components(a: &mut Attribute) {
    if a.components != 2 {
        let first_two = |vertex: &[u8]| {
            let mut bytes = [0; 8];
            bytes.iter_mut().zip(vertex).for_each(|(to, &from)| *to = from);
            bytes
        };
        a.bytes = a.bytes.chunks_exact(a.stride()).flat_map(first_two).collect();
        a.components = 2;
    }
}

fn unit(n: &mut [f32]) {
    let square: f64 = n.iter().map(|&c| f64::from(c).powi(2)).sum();
    if square.is_finite() && square > 0.0 {
        let length = square.sqrt();
        // Unit vectors stay bit for bit. The tolerance is chosen by hand: it has to be above the
        // rounding of single precision and of the six digits that many OBJ files have.
        if (length - 1.0).abs() > 1e-5 {
            n.iter_mut().for_each(|c| *c = (f64::from(*c) / length) as f32);
        }
    } else {
        n.copy_from_slice(&[0.0, 0.0, 1.0]);
    }
}

/// Changes the values of each vertex, which are floats.
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
