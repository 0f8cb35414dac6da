//! The library and the program are one way: the same options give the same bytes.

use crate::support::Folder;
use lodc::Select;

/// Fixtures of one object: with seams, joints and quantised texture coordinates; an OBJ.
const ONE_OBJECT: [&str; 4] =
    ["machine_part.glb", "skinned_tube_u8.glb", "quantised_torus.glb", "terrain.obj"];

fn fixture(name: &str) -> String {
    format!("{}/../fixtures/{name}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn a_file_is_built_as_the_program_builds_it() {
    for name in ONE_OBJECT {
        let f = Folder::new();
        f.lodc(["build", &fixture(name), "-o", "a.lodc", "-q"]).ends(0);
        let made = lodc::build(fixture(name)).models(&lodc::models::ModelKind::ALL).run();
        let mut file = lodc::read(&f.read("a.lodc")).expect("the program's file");
        // Of what it was made, only the program takes down: `--if-changed` compares that.
        file.made_from = None;
        assert!(made.expect("a sound mesh").to_bytes() == lodc::write(&file), "{name}");
    }
}

#[test]
fn a_level_is_written_as_the_program_writes_it() {
    for name in ONE_OBJECT {
        let f = Folder::new();
        f.lodc(["build", &fixture(name), "-o", "a.lodc", "-q", "--models", "none"]).ends(0);
        let file = lodc::open(f.join("a.lodc")).expect("the program's file");
        let fifth = file.level(Select::Ratio(0.2)).expect("a level");
        let lod = fifth.objects().next().expect("an object").lod();
        let level = file.level(Select::Lod(lod)).expect("the same level");
        for format in ["glb", "gltf", "obj", "ply", "stl"] {
            let (own, other) = (format!("library/x.{format}"), format!("program/x.{format}"));
            for folder in ["library", "program"] {
                std::fs::create_dir_all(f.join(folder)).expect("a folder");
            }
            level.write(f.join(&own)).expect("a file");
            let lod = lod.to_string();
            f.lodc(["extract", "a.lodc", "--lod", &lod, "-o", &other, "-q"]).ends(0);
            assert!(f.read(&own) == f.read(&other), "{name} as {format}");
        }
    }
}
