//! The library and the program are one way: the same options give the same bytes.

use crate::support::Folder;
use lodc::formats::export::{ExportFormat, ExportObject, ExportOptions, Precision, export};
use lodc::formats::import::{ImportOptions, import};
use lodc::formats::lods::{PackOptions, Unpacker, pack};
use lodc::formats::{Limits, write_all};
use lodc::level_mesh::Order;
use lodc::pipeline::{DEFAULT_POSES, Growth, Importance, refitted_meshes};
use lodc::{Asset, Error, Errors, Select, Simplify, scene_levels, single};
use lodc_simplify::Options;
use std::path::Path;

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

/// A level of a mesh file, its vertices moved to where the level errs least, on a grid.
fn refitted(input: &Path, output: &Path) -> Result<(), Error> {
    let import_options = ImportOptions::default();
    let scene = import(input, &import_options)?;
    let options = vec![Options::DEFAULT; scene.objects.len()];
    let importance = Importance::default();
    let how = Simplify { options: &options, importance: &importance, poses: DEFAULT_POSES };
    let asset = Asset::simplified(input, scene, &import_options, &how, Errors::OfResult, &())?;
    let (objects, document, limits) = (&asset.objects, &asset.document, &Limits::DEFAULT);
    let chosen = scene_levels(objects, document, limits)?.select(Select::Ratio(0.2));
    let lods = chosen.expect("a ratio can be met").lods;
    let how = (Order::Cache, Growth::from(Errors::OfResult));
    let meshes = refitted_meshes(objects, document, &lods, how, limits, &|| ())?;
    let precision = Precision { position: Some(14), ..Precision::default() };
    let mut options = ExportOptions { precision, ..ExportOptions::default() };
    let level = asset.level_of(single(&lods));
    let made = level.files(&meshes, output, ExportFormat::Glb, &mut options)?;
    Ok(write_all(&made.files)?)
}

#[test]
fn a_level_of_a_mesh_is_refitted_and_quantised_as_the_program_does() {
    for name in ONE_OBJECT {
        let f = Folder::new();
        let how = ["--ratio", "0.2", "--quantize", "pos=14", "-q", "-o", "a.glb"];
        f.lodc([&["extract", &fixture(name)][..], &how].concat()).ends(0);
        refitted(fixture(name).as_ref(), &f.join("b.glb")).expect("a sound mesh");
        assert!(f.read("a.glb") == f.read("b.glb"), "{name}");
    }
}

#[test]
fn a_stream_is_packed_and_its_prefix_unpacked_as_the_program_does() {
    for name in ONE_OBJECT {
        let f = Folder::new();
        f.lodc(["build", &fixture(name), "-o", "a.lodc", "-q", "--models", "none"]).ends(0);
        f.lodc(["pack", "a.lodc", "-o", "a.lods", "-q"]).ends(0);
        let file = lodc::open(f.join("a.lodc")).expect("the program's file");
        let packed = pack(file.content(), &PackOptions::default()).expect("a sound file").bytes;
        assert!(packed == f.read("a.lods"), "{name}");

        let prefix = &packed[..packed.len() / 2];
        f.file("half.lods", prefix);
        f.lodc(["unpack", "half.lods", "-o", "a.glb"]).ends(0);
        let mut unpacker = Unpacker::new(Limits::DEFAULT);
        unpacker.feed(prefix).expect("a sound stream");
        let arrived = unpacker.arrived().expect("a sound document").expect("more than a head");
        let mesh = unpacker.mesh(0).expect("a mesh").0;
        let objects = [ExportObject { info: &arrived.infos[0], mesh: &mesh }];
        let path = f.join("b.glb");
        let files = export(&path, ExportFormat::Glb, &arrived.document, &objects);
        write_all(&files.expect("a mesh")).expect("a folder");
        assert!(f.read("a.glb") == f.read("b.glb"), "{name}");
    }
}
