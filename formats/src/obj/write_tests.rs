use super::*;
use crate::export::{ExportFormat, ExportObject};
use crate::flatten::tests::{gltf, info, triangle};
use crate::import::{ImportOptions, import};
use crate::testing::{Random, Scratch, corpus};
use crate::{Document, ObjMaterial, Scene, write_all};
use lodc_mesh::Mesh;

fn export(path: &Path, document: &Document, objects: &[ExportObject<'_>]) -> Vec<OutputFile> {
    crate::export::export(path, ExportFormat::Obj, document, objects).expect("exported")
}

/// Per material: the triangles as bytes of all corners, rotated and sorted so that equal multisets
/// are equal lists.
fn triangles(scene: &Scene) -> BTreeMap<Option<String>, Vec<[Vec<u8>; 3]>> {
    let mut out: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for object in &scene.objects {
        let mesh: &Mesh = &object.mesh;
        for (submesh, info) in mesh.submeshes().iter().zip(&object.info.submeshes) {
            let corner = |v: u32| {
                let mut bytes: Vec<u8> =
                    mesh.positions()[v as usize].iter().flat_map(|c| c.to_le_bytes()).collect();
                for &a in &submesh.attributes {
                    bytes.extend_from_slice(mesh.attributes()[a as usize].at(v));
                }
                bytes
            };
            let list = out.entry(info.material.clone()).or_default();
            for &t in &mesh.triangles()[submesh.triangles()] {
                let mut t = t.map(corner);
                let smallest = (0..3).min_by_key(|&i| &t[i]).expect("three");
                t.rotate_left(smallest);
                list.push(t);
            }
            list.sort();
        }
    }
    out
}

fn written(scene: &Scene, path: &Path) -> Vec<OutputFile> {
    let objects: Vec<_> =
        scene.objects.iter().map(|o| ExportObject { info: &o.info, mesh: &o.mesh }).collect();
    export(path, &scene.document, &objects)
}

fn round_trip(scene: &Scene, scratch: &Scratch) -> Scene {
    let path = scratch.path("out.obj");
    // Materials of a file with the same name are read where a file names none that is there.
    drop(std::fs::remove_file(path.with_extension("mtl")));
    write_all(&written(scene, &path)).expect("written");
    import(&path, &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn same(before: &Scene, after: &Scene, case: &str) {
    assert!(triangles(before) == triangles(after), "{case}: triangles differ");
    let names = |s: &Scene| -> Vec<_> {
        let object = &s.objects[0];
        // Written beside points and lines, what has no name has that of the object.
        let name = |n: &str| if n.is_empty() { object.info.name.clone() } else { n.to_owned() };
        let visible = object.info.submeshes.iter().zip(object.mesh.submeshes());
        visible
            .filter(|(_, m)| m.triangle_count > 0)
            .map(|(i, _)| (name(&i.name), i.material.clone()))
            .collect()
    };
    assert_eq!(names(before), names(after), "{case}");
    match (&before.document, &after.document) {
        (Document::Obj(a), Document::Obj(b)) => assert_eq!(a.materials, b.materials, "{case}"),
        _ => panic!("{case}: not an OBJ"),
    }
}

#[test]
fn every_real_obj_comes_back_exactly() {
    let Some(folder) = corpus() else { return };
    let scratch = Scratch::new("obj-round-trip");
    let mut files = 0;
    for group in ["paper", "ugly", "ugly/assimp", "ugly/cgal", "ugly/trimesh"] {
        for entry in std::fs::read_dir(folder.join(group)).expect(group) {
            let path = entry.expect("an entry").path();
            if path.extension().is_none_or(|e| e != "obj") {
                continue;
            }
            files += 1;
            let scene = match import(&path, &ImportOptions::default()) {
                Err(e) if e.problem.contains("not a mesh") => continue,
                read => read.unwrap_or_else(|e| panic!("{e}")),
            };
            same(&scene, &round_trip(&scene, &scratch), &path.display().to_string());
        }
    }
    assert!(files >= 45, "only {files} files");
}

/// Their extent is such that a decimal of single precision may be further from the number than
/// single precision may round an object's coordinates.
#[test]
fn positions_half_as_far_as_single_precision_allows_come_back() {
    let scratch = Scratch::new("obj-far");
    let mut source = String::new();
    for i in 0..300 {
        let at = |k: u32| 10.0 + 6.4 * f64::from(i * k % 1009) / 1009.0;
        source += &format!("v {:.6} {:.6} {}\n", at(7919), at(104_729), f64::from(i % 5) * 0.125);
    }
    for i in 1..=100 {
        source += &format!("f {} {} {}\n", 3 * i - 2, 3 * i - 1, 3 * i);
    }
    scratch.write("in.obj", source.as_bytes());
    let scene = import(&scratch.path("in.obj"), &ImportOptions::default()).expect("read");
    same(&scene, &round_trip(&scene, &scratch), "far");
}

#[test]
fn every_bit_of_strange_values_comes_back() {
    let scratch = Scratch::new("obj-strange");
    let mut random = Random(17);
    let mut source = String::from(
        "o only\nv -0 0 1e-45 1 0.5 1e-9\nv 3.4028235e38 1e-38 -1 0 0 0\nvn inf -inf -0\n\
            vt nan 1e-7 3\n",
    );
    for _ in 0..500 {
        let mut value = || {
            let x = f32::from_bits((random.next() >> 32) as u32);
            if x.is_finite() { x } else { 0.5 }
        };
        source += &format!(
            "v {:e} {:e} {:e} {:e} {:e} {:e}\n",
            value(),
            value(),
            value(),
            (value().abs() % 1.0),
            (value().abs() % 1.0),
            (value().abs() % 1.0)
        );
        source += &format!(
            "vt {:e} {:e} {:e}\nvn {:e} {:e} {:e}\n",
            value(),
            value(),
            value(),
            value(),
            value(),
            value()
        );
    }
    source += "usemtl a # b\nf 1/1/1 2/1/1 3/2/2\nusemtl\ng loose\nf 1 2 3\nusemtl c#d\ng x y\n";
    for i in 3..490 {
        source += &format!("f {i}/{i}/{i} {}/{}/{i} {}/{i}/{}\n", i + 1, i + 2, i + 3, i + 4);
    }
    scratch.write("in.obj", source.as_bytes());
    let scene = import(&scratch.path("in.obj"), &ImportOptions::default()).expect("valid");
    assert_eq!(scene.objects[0].mesh.submeshes().len(), 3);
    same(&scene, &round_trip(&scene, &scratch), "strange");
}

#[test]
fn the_library_is_written_beside_the_file_and_never_to_standard_output() {
    let (mesh, info) = (triangle(), info(0));
    let objects = [ExportObject { info: &info, mesh: &mesh }];
    let materials =
        vec![ObjMaterial { name: "red".to_owned(), lines: vec!["Kd 1 0 0".to_owned()] }];
    let document = Document::Obj(ObjDocument { materials, ..ObjDocument::default() });
    let files = export(Path::new("some/out file.obj"), &document, &objects);
    assert_eq!(files[1].path, Path::new("some/out file.mtl"));
    assert_eq!(files[1].bytes, b"newmtl red\nKd 1 0 0\n");
    assert!(files[0].bytes.starts_with(b"# lodc\nmtllib out file.mtl\no mesh0\n"));
    let files = export(Path::new("-"), &document, &objects);
    assert!(files.len() == 1 && !files[0].bytes.windows(6).any(|w| w == b"mtllib"));
    let bare = export(Path::new("x.obj"), &Document::Obj(ObjDocument::default()), &objects);
    assert_eq!(bare.len(), 1);
}

#[test]
fn gltf_scenes_become_objects_with_simple_materials() {
    let (mesh, info) = (triangle(), info(0));
    let document = gltf(
        r#"{"nodes":[{"mesh":0,"name":"a\nb"},{"mesh":0,"scale":[-1,1,1]}],
        "materials":[{"name":"m"},{"name":"m","alphaMode":"BLEND","pbrMetallicRoughness":
            {"baseColorFactor":[0.5,0.25,1,0.75],"baseColorTexture":{"index":0}}}],
        "textures":[{"source":0}],"images":[{"uri":"a%20b.png"}],
        "meshes":[{"primitives":[{"material":1}]}]}"#,
    );
    let objects = [ExportObject { info: &info, mesh: &mesh }];
    let files = export(Path::new("x.obj"), &document, &objects);
    let text = |i: usize| String::from_utf8(files[i].bytes.clone()).expect("text");
    assert_eq!(
        text(1),
        "newmtl m\nKd 1 1 1\nnewmtl m_material1\nKd 0.735357 0.537099 1\nd 0.75\nmap_Kd a b.png\n"
    );
    let expected = "# lodc\nmtllib x.mtl\no a_b\nv 0 0 0\nvt 0.25 0.75\nvn 0 0 1\nv 1 0 0\n\
        vt 1 1\nv 0 1 0\nvt 0 0\n\
        usemtl m_material1\nf 1/1/1 2/2/1 3/3/1\no mesh0\nv -1 0 0\nf 1/1/1 3/3/1 4/2/1\n";
    assert_eq!(text(0), expected);
}

#[test]
fn names_read_back_as_themselves() {
    for (name, expected) in [
        ("plain", "plain"),
        (" a\tb ", "a_b"),
        ("x # y # z", "x _ y _ z"),
        ("#", "_"),
        ("end #", "end _"),
        ("c#d #e", "c#d #e"),
        ("path\\", "path\\_"),
        ("new\nline", "new_line"),
    ] {
        assert_eq!(clean(name), expected, "{name:?}");
        assert_eq!(clean(expected), expected);
    }
}
