//! Files that were written are read; files that are damaged, cut, longer, newer or crafted is
//! refused.

use super::*;
use crate::testing::{LodFile, LodObject, read, stored, write};
use crate::{ObjDocument, ObjMaterial, SourceFormat, SubmeshInfo};
use lodc_fixtures as fixtures;
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::{Attribute, Component, Mesh, MeshParts, PoseKey, Semantic, Submesh};
use lodc_strip::{StripOptions, StripPool};

fn object(name: &str, mesh: &Mesh) -> LodObject {
    object_with(name, fixtures::random_collapse(mesh, 1), &[ModelKind::Interactive])
}

fn object_with(name: &str, simplified: Simplified, kinds: &[ModelKind]) -> LodObject {
    let simplified = Arc::new(simplified);
    let mesh = simplified.mesh();
    let submesh = |i| SubmeshInfo {
        name: format!("part{i}"),
        material: (i > 0).then(|| format!("material{i}")),
        document_primitive: i,
    };
    let info = ObjectInfo {
        name: name.to_owned(),
        submeshes: (0..mesh.submeshes().len() as u32).map(submesh).collect(),
        world_scale: 2.5,
        document_mesh: 3,
        poses: vec![],
    };
    let mut strips = StripPool::new(&simplified, StripOptions::default());
    let model = |&kind| AnyModel::build(kind, &mut strips).expect("triangles are in order");
    let models = kinds.iter().map(model).collect();
    LodObject { info, simplified, models }
}

pub(super) fn obj_file(name: &str) -> LodFile {
    let materials =
        vec![ObjMaterial { name: "red".to_owned(), lines: vec!["Kd 1 0 0".to_owned()] }];
    LodFile {
        source: Source { format: SourceFormat::Obj, content_hash: 0x0123_4567_89ab_cdef },
        document: Document::Obj(ObjDocument {
            libraries: vec!["shapes.mtl".to_owned()],
            materials,
            ..ObjDocument::default()
        }),
        objects: vec![object(name, &fixtures::named(name).expect("a shape"))],
        made_from: None,
        layout: Layout::Packed,
        left_out: vec![],
    }
}

pub(super) fn gltf_file(names: &[&str]) -> LodFile {
    let json = r#"{"asset":{"version":"2.0"}}"#.to_owned();
    LodFile {
        source: Source { format: SourceFormat::Glb, content_hash: u128::MAX },
        document: Document::Gltf(GltfDocument::new(json, (0..37).collect())),
        objects: names
            .iter()
            .map(|name| object(name, &fixtures::named(name).expect("a shape")))
            .collect(),
        made_from: None,
        layout: Layout::Packed,
        left_out: vec![],
    }
}

/// The same file in the layout for devices.
pub(super) fn wide(file: &LodFile) -> LodFile {
    let objects = file.objects.iter().map(|o| LodObject {
        info: o.info.clone(),
        simplified: Arc::clone(&o.simplified),
        models: o.models.clone(),
    });
    LodFile {
        source: file.source.clone(),
        document: file.document.clone(),
        objects: objects.collect(),
        layout: Layout::Gpu,
        made_from: None,
        left_out: vec![],
    }
}

/// A file with a mesh of several submeshes, a seam and borders, and all models of it.
pub(super) fn all_models_file() -> LodFile {
    let mesh = fixtures::named("machine_part").expect("a shape");
    let simplified = fixtures::random_collapse(&mesh, 1);
    let objects = vec![object_with("machine_part", simplified, &ModelKind::ALL)];
    LodFile { objects, ..gltf_file(&[]) }
}

/// A square of a submesh with texture coordinates and a triangle of one without, in all models.
pub(super) fn two_parts_file() -> LodFile {
    let uv = [0.0f32, 0.0, 1.0, 0.0, 1.0, 0.5, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let parts = MeshParts {
        positions: vec![
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [2.0, 1.0, 0.0],
            [1.0, 2.0, 0.0],
        ],
        vertex_submesh: vec![0, 0, 0, 0, 1, 1, 1],
        attributes: vec![Attribute {
            semantic: Semantic::TexCoord(0),
            morph_target: None,
            component: Component::F32,
            components: 2,
            normalized: false,
            bytes: uv.iter().flat_map(|c| c.to_le_bytes()).collect(),
        }],
        submeshes: vec![
            Submesh { first_triangle: 0, triangle_count: 2, attributes: vec![0] },
            Submesh { first_triangle: 2, triangle_count: 1, attributes: vec![] },
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6]],
    };
    let mesh = Mesh::try_from(parts).expect("a sound mesh");
    let simplified = lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {});
    let objects = vec![object_with("two_parts", simplified, &ModelKind::ALL)];
    LodFile { objects, ..obj_file("triangle") }
}

/// A file of one object whose errors are measured.
pub(super) fn measured_file(name: &str) -> LodFile {
    let simplified = fixtures::random_collapse(&fixtures::named(name).expect("a shape"), 1);
    let parts = simplified.collapses().parts().clone();
    let or_infinite = |left: u32, distance: f32| if left > 0 { distance } else { f32::INFINITY };
    let (largest, rms) = (1..)
        .zip(&parts.step_triangles)
        .map(|(step, &left)| {
            let distance = step as f32 * 0.01;
            (or_infinite(left, distance), or_infinite(left, distance / 4.0))
        })
        .unzip();
    let simplified = simplified.with_distances(largest, rms).expect("they do not fall");
    LodFile {
        objects: vec![object_with(name, simplified, &[ModelKind::Interactive])],
        ..obj_file(name)
    }
}

#[test]
fn poses_that_errors_hold_in_come_back() {
    let mut file = gltf_file(&["cube", "morphing_sphere"]);
    file.objects[1].info.poses =
        vec![PoseKey::Moment { animation: 1, seconds: 0.5 }, PoseKey::Target(0)];
    let again = read(&write(&file)).expect("what was written");
    same(&file, &again);
    assert!(again.left_out.is_empty());
}

#[test]
fn measured_errors_come_back_and_files_without_them_say_so() {
    let file = measured_file("cube");
    let again = read(&write(&file)).expect("what was written");
    assert_eq!(again.objects[0].simplified, file.objects[0].simplified);
    assert!(again.objects[0].simplified.collapses().is_measured());
    let estimate = read(&write(&obj_file("cube"))).expect("what was written");
    assert!(!estimate.objects[0].simplified.collapses().is_measured());
}

pub(super) fn same(a: &LodFile, b: &LodFile) {
    assert_eq!((&a.source, &a.document), (&b.source, &b.document));
    assert_eq!(a.objects.len(), b.objects.len());
    for (a, b) in a.objects.iter().zip(&b.objects) {
        assert_eq!(a.info, b.info);
        assert!(a.simplified == b.simplified, "{}", a.info.name);
        let kinds = |o: &LodObject| o.models.iter().map(AnyModel::kind).collect::<Vec<_>>();
        assert_eq!(kinds(a), kinds(b));
    }
}

#[test]
fn what_is_written_is_read_and_writes_the_same_again() {
    let small = |mesh: &Mesh| mesh.triangles().len() <= 400;
    let mut files: Vec<LodFile> = (fixtures::ALL.iter())
        .filter(|(_, make)| small(&make()))
        .flat_map(|(name, _)| [obj_file(name), gltf_file(&[name, "cube", name])])
        .collect();
    files.push(gltf_file(&[]));
    files.push(all_models_file());
    for file in files.into_iter().flat_map(|file| [wide(&file), file]) {
        let file = &file;
        let bytes = write(file);
        let again = read(&bytes).expect("a whole file");
        same(file, &again);
        assert!(again.left_out.is_empty());
        assert_eq!(bytes, write(&again));
        assert!(again.layout == file.layout || file.objects.is_empty());
    }
}

#[test]
fn sections_are_aligned_and_geometry_takes_no_more_than_is_needed() {
    let file = obj_file("icosphere");
    let bytes = write(&file);
    let v = file.objects[0].simplified.mesh().vertex_count() as u64;
    let object = &file.objects[0];
    let stored = geometry_bytes(&object.simplified, Layout::Packed)
        + stored(&object.models[0], Layout::Packed).bytes();
    // Ten words, and five bytes and a bit for the step: error, triangles lost, last of its step or
    // not.
    assert!(stored <= 45 * v + v / 8 + 1, "{stored} bytes for {v} vertices");
    assert!((bytes.len() as u64) < stored + 1500, "{} bytes", bytes.len());
    for entry in bytes[table::HEADER_BYTES..].chunks(40).take(bytes[12].into()) {
        assert_eq!(entry[16] % 16, 0);
    }
}

/// The words of a section of an object.
fn words(bytes: &[u8], tag: &[u8; 4], index: u32) -> Vec<u32> {
    let all = sections(bytes).expect("a whole file");
    let key = (*tag, Some(0), index);
    let found = all.iter().find(|s| (s.tag, s.object, s.index) == key).expect("the section");
    assert!(found.wide);
    assert_eq!((found.bytes.as_ptr() as usize - bytes.as_ptr() as usize) % 16, 0);
    found.bytes.chunks(4).map(|b| u32::from_le_bytes(b.try_into().expect("a word"))).collect()
}

#[test]
fn sections_of_the_gpu_layout_are_what_a_device_is_given() {
    let file = wide(&all_models_file());
    let bytes = write(&file);
    let object = &file.objects[0];
    let mesh = object.simplified.mesh();
    assert_eq!(words(&bytes, b"TRIS", 0), mesh.triangles().as_flattened());
    assert_eq!(words(&bytes, b"TARG", 0), object.simplified.collapses().targets());
    for (index, model) in [(0, &object.models[0]), (2, &object.models[1])] {
        let strips = model.strips().expect("a strip model");
        let stored = words(&bytes, b"MODA", index);
        let front = 1 + mesh.submeshes().len() + strips.iter().count();
        assert_eq!(stored[0], strips.kind as u32);
        assert_eq!(&stored[front..], strips.indices());
    }
    // Attributes have bytes for every vertex, whichever submesh it is of.
    for section in sections(&bytes).expect("a whole file").iter().filter(|s| s.tag == *b"ATTR") {
        assert_eq!(section.bytes, mesh.attributes()[section.index as usize].bytes);
    }
    let model = |layout| stored(&object.models[0], layout).bytes();
    let stored = |layout| geometry_bytes(&object.simplified, layout) + model(layout);
    assert!(stored(Layout::Packed) < stored(Layout::Gpu));
    let more = bytes.len() - write(&all_models_file()).len();
    assert!(stored(Layout::Gpu) - stored(Layout::Packed) < more as u64);
}

#[test]
fn streams_are_stored_only_for_submeshes_that_have_them() {
    let mut parts = fixtures::machine_part().into_parts();
    let vertices = parts.positions.len();
    for i in 0..parts.submeshes.len() {
        let stream = Attribute {
            semantic: Semantic::Custom(format!("_ONLY{i}")),
            morph_target: None,
            component: Component::F32,
            components: 4,
            normalized: false,
            bytes: (0..vertices)
                .flat_map(|v| {
                    [if parts.vertex_submesh[v] as usize == i { v as u8 | 1 } else { 0 }; 16]
                })
                .collect(),
        };
        let number = parts.attributes.len() as u32;
        parts.attributes.push(stream);
        parts.submeshes[i].attributes.push(number);
    }
    let submeshes = parts.submeshes.len();
    assert!(submeshes > 1);
    let mesh = Mesh::try_from(parts).expect("a mesh");
    let mut file = obj_file("machine_part");
    let before = write(&file).len();
    file.objects = vec![object("machine_part", &mesh)];
    let bytes = write(&file);
    same(&file, &read(&bytes).expect("a whole file"));
    let all = file.objects[0].simplified.mesh().vertex_count() * 16;
    assert!(bytes.len() < before + all + all / 4, "{} more for {all}", bytes.len() - before);
}

#[test]
fn the_key_depends_on_every_byte() {
    let mut bytes = write(&obj_file("cube"));
    let before = key(&bytes);
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    assert_ne!(before, key(&bytes));
}
