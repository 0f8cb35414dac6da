//! The committed fixture files are what the generator writes; good ones import, and `x_` ones are
//! refused as they should.

use lodc_fixtures::files::{self, MALFORMED};
use lodc_formats::import::{ImportOptions, import};
use std::path::PathBuf;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures")
}

#[test]
fn committed_files_are_what_the_generator_writes() {
    let mut different = Vec::new();
    for (name, bytes) in files::all() {
        if std::fs::read(folder().join(&name)).ok().as_ref() != Some(&bytes) {
            different.push(name);
        }
    }
    assert!(different.is_empty(), "not as committed (`just fixtures` writes them): {different:?}");
}

#[test]
fn every_committed_asset_comes_from_the_generator_and_is_small() {
    let known = files::all();
    let mut total = 0;
    for entry in std::fs::read_dir(folder()).expect("the folder can be listed") {
        let path = entry.expect("entries can be read").path();
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        if ["obj", "mtl", "gltf", "glb", "bin"].contains(&extension) {
            let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
            let size = path.metadata().expect("files have a size").len();
            assert!(known.iter().any(|(n, _)| n == name), "{name} is nobody's");
            assert!(size < 100 << 10, "{name} has {size} bytes");
            total += size;
        }
    }
    assert!((50 << 10..600 << 10).contains(&total), "{total} bytes in all");
}

#[test]
fn good_files_import_with_every_triangle_of_their_shape() {
    let mut imported = 0;
    for (name, _) in files::all() {
        let (stem, extension) = name.split_once('.').expect("names have an extension");
        if name.starts_with("x_") || !["obj", "gltf", "glb"].contains(&extension) {
            continue;
        }
        let shape = lodc_fixtures::named(stem).expect("files are called like their shapes");
        let scene = import(&folder().join(&name), &ImportOptions::default())
            .unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.objects.len(), 1, "{name}");
        let mesh = &scene.objects[0].mesh;
        assert_eq!(mesh.triangles().len(), shape.triangles().len(), "{name}");
        assert_eq!(mesh.submeshes().len(), shape.submeshes().len(), "{name}");
        assert_eq!(mesh.bounds(), shape.bounds(), "{name}");
        if extension != "obj" {
            let semantics = |m: &lodc_mesh::Mesh| {
                let mut s: Vec<_> = m
                    .attributes()
                    .iter()
                    .map(|a| (a.semantic.clone(), a.morph_target, a.component.size()))
                    .collect();
                s.sort();
                s
            };
            assert_eq!(semantics(mesh), semantics(&shape), "{name}");
            assert_eq!(mesh.vertex_count(), shape.vertex_count(), "{name}");
        }
        imported += 1;
    }
    assert!(imported >= 20, "{imported}");
}

#[test]
fn malformed_files_are_refused_for_their_own_reason() {
    let mut wrong = Vec::new();
    for malformed in MALFORMED {
        assert!(malformed.name.starts_with("x_"), "{}", malformed.name);
        match import(&folder().join(malformed.name), &ImportOptions::default()) {
            Ok(_) => wrong.push(format!("{}: was read", malformed.name)),
            Err(e) => {
                let (fault, message) = (format!("{:?}", e.fault), e.to_string());
                let said = message.to_lowercase().contains(malformed.message);
                if !malformed.faults.contains(&fault.as_str())
                    || !said
                    || message.lines().count() != 1
                {
                    wrong.push(format!("{}: {fault}: {message}", malformed.name));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), MALFORMED.len(), wrong.join("\n"));
}
