use super::{LevelsObject, export_levels};
use crate::images::Textures;
use crate::{Document, ObjDocument, ObjectInfo, SubmeshInfo};
use lodc_mesh::{Lod, Simplified};
use lodc_simplify::{Options, simplify};
use serde_json::Value;
use std::path::Path;

/// A GLB that has been taken apart.
struct Glb {
    json: Value,
    binary: Vec<u8>,
}

impl Glb {
    fn new(bytes: &[u8]) -> Self {
        let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
        let json = serde_json::from_slice(&bytes[20..20 + length]).expect("a JSON chunk");
        Self { json, binary: bytes[28 + length..].to_vec() }
    }

    /// The elements of an accessor, each `size` bytes wide.
    fn elements(&self, accessor: &Value, size: usize) -> Vec<&[u8]> {
        let accessor = &self.json["accessors"][accessor.as_u64().expect("a number") as usize];
        let number = |value: &Value| value.as_u64().unwrap_or(0) as usize;
        let view = &self.json["bufferViews"][number(&accessor["bufferView"])];
        let start = number(&view["byteOffset"]) + number(&accessor["byteOffset"]);
        let stride = number(&view["byteStride"]).max(size);
        let at = |i: usize| &self.binary[start + i * stride..][..size];
        (0..number(&accessor["count"])).map(at).collect()
    }

    fn words(&self, accessor: &Value) -> Vec<u32> {
        let kind = &self.json["accessors"][accessor.as_u64().expect("a number") as usize];
        let size = if kind["componentType"] == 5123 { 2 } else { 4 };
        let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |w, &b| w << 8 | u32::from(b));
        self.elements(accessor, size).into_iter().map(word).collect()
    }

    /// Triangles of a primitive at a LOD as a host decodes them: corners by their positions' bits.
    fn triangles(&self, primitive: &Value, lod: u32) -> Vec<[Vec<u8>; 3]> {
        let lodc = &primitive["extras"]["lodc"];
        let (source, numbers) = (self.words(&primitive["indices"]), self.words(&lodc["numbers"]));
        let (targets, removals) = (self.words(&lodc["targets"]), self.words(&lodc["removals"]));
        let live = numbers.partition_point(|&number| number >= lod);
        let count = removals.partition_point(|&removal| removal > lod);
        if live == 0 {
            assert_eq!(count, 0, "triangles need vertices");
            return Vec::new();
        }
        let mut shown: Vec<u32> = (0..live as u32).collect();
        for &target in &targets[live..] {
            shown.push(shown[target as usize]);
        }
        let positions = self.elements(&primitive["attributes"]["POSITION"], 12);
        let corner = |&i: &u32| positions[shown[i as usize] as usize].to_vec();
        let triangle = |t: &[u32]| [corner(&t[0]), corner(&t[1]), corner(&t[2])];
        source.chunks(3).take(count).map(triangle).collect()
    }
}

fn info(simplified: &Simplified) -> ObjectInfo {
    let submesh = |i| SubmeshInfo { name: String::new(), material: None, document_primitive: i };
    ObjectInfo {
        name: "mesh".to_owned(),
        submeshes: (0..simplified.mesh().submeshes().len() as u32).map(submesh).collect(),
        world_scale: 1.0,
        document_mesh: 0,
        poses: vec![],
    }
}

fn exported(simplified: &Simplified) -> Glb {
    let info = info(simplified);
    let triangles = simplified.mesh().triangles().len() as u32;
    let strips: Vec<u32> = (0..triangles).collect();
    let object = LevelsObject { info: &info, simplified, strips: Some(&strips), ranks: &[] };
    let document = Document::Obj(ObjDocument::default());
    let (file, warnings) =
        export_levels(Path::new("l.glb"), &document, &[object], Textures::default())
            .expect("it can be written");
    assert!(warnings.is_empty(), "{warnings:?}");
    Glb::new(&file.bytes)
}

/// Compares every level with the reference, submesh by submesh.
fn check(name: &str, simplified: &Simplified) {
    let glb = exported(simplified);
    let mesh = simplified.mesh();
    let primitives = glb.json["meshes"][0]["primitives"].as_array().expect("primitives");
    let bits = |v: u32| mesh.positions()[v as usize].iter().flat_map(|c| c.to_le_bytes()).collect();
    let steps = simplified.collapses().parts().step_ends.clone();
    for lod in std::iter::once(0).chain(steps) {
        let reference = simplified.triangles_at(Lod(lod));
        for (s, primitive) in (0..).zip(primitives) {
            let of_submesh = reference.iter().filter(|t| t.submesh == s);
            let mut wanted: Vec<[Vec<u8>; 3]> = of_submesh.map(|t| t.corners.map(bits)).collect();
            let mut shown = glb.triangles(primitive, lod);
            for t in wanted.iter_mut().chain(&mut shown) {
                let first = (0..3).min_by_key(|&k| &t[k]).expect("three corners");
                t.rotate_left(first);
            }
            wanted.sort();
            shown.sort();
            assert!(shown == wanted, "{name}: submesh {s} differs at LOD {lod}");
        }
    }
}

#[test]
fn every_level_of_a_glb_is_that_of_the_reference() {
    let shapes = ["machine_part", "striped_sphere", "several_components", "torus"];
    for name in shapes {
        let mesh = lodc_fixtures::named(name).expect("a named shape");
        check(name, &simplify(&mesh, &Options::DEFAULT, &|_, _| {}));
        check(name, &lodc_fixtures::random_collapse(&mesh, 7));
    }
}

#[test]
fn the_sequence_of_a_glb_has_steps_counts_and_errors() {
    let mesh = lodc_fixtures::named("machine_part").expect("a named shape");
    let simplified = simplify(&mesh, &Options::DEFAULT, &|_, _| {});
    let glb = exported(&simplified);
    let lodc = &glb.json["meshes"][0]["extras"]["lodc"];
    let parts = simplified.collapses().parts();
    assert_eq!(lodc["records"], parts.targets.len());
    assert_eq!(glb.words(&lodc["ends"]), parts.step_ends);
    assert_eq!(glb.words(&lodc["triangles"]), parts.step_triangles);
    let errors = glb.words(&lodc["errors"]).into_iter().map(f32::from_bits);
    let (mut last, mut infinite) = (0.0, 0);
    for (stored, &error) in errors.zip(&parts.step_errors) {
        infinite += u32::from(error.is_infinite());
        assert_eq!(stored, if error.is_finite() { error } else { last });
        last = stored;
    }
    assert!(infinite < 3, "only the end has no triangle");
}
