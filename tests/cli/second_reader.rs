//! A second reader, written in Python from docs/FORMAT.md and docs/STREAM.md, agrees with this
//! program: on levels of every structure and on every step of the golden streams.

use crate::support::{Folder, bounded, outside};
use lodc::{LodFile, LodObject};
use lodc_fixtures::{Rng, named, random_collapse};
use lodc_formats::lodc::Layout;
use lodc_formats::lods::{PackOptions, StepOrder, Unpacker, in_batches, pack};
use lodc_formats::{Document, Limits, ObjDocument, ObjectInfo, Source, SourceFormat, SubmeshInfo};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use lodc_strip::{StripOptions, StripPool};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Shapes with several submeshes, attributes, seams, fakes, points and no triangles at all.
const SHAPES: [&str; 20] = [
    "coloured_cube",
    "cube",
    "duplicate_faces",
    "empty",
    "faceted_sphere",
    "icosphere",
    "machine_part",
    "mobius_strip",
    "morphing_sphere",
    "needles",
    "open_box",
    "quantised_torus",
    "several_components",
    "signed_zero_ring",
    "skinned_tube_u8",
    "striped_sphere",
    "terrain",
    "torus",
    "triangle_soup",
    "uv_sphere",
];
/// Levels of each shape, and those of them that `lodc extract` takes out, too.
const LEVELS: usize = 100;
const EXTRACTED: usize = 3;

/// Runs the script with a Python that has NumPy; its standard output. None if it is not asked for.
fn python(arguments: &[&Path]) -> Option<String> {
    let program = outside("LODC_PYTHON")?;
    let script = root().join("tests/second_reader.py");
    let output = bounded(&program).arg(script).args(arguments).output();
    let output = output.expect("Python starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{errors}", String::from_utf8_lossy(&output.stdout));
    Some(String::from_utf8(output.stdout).expect("the script prints text"))
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn golden() -> PathBuf {
    root().join("fixtures/golden/v1")
}

fn put(out: &mut Vec<u8>, numbers: impl IntoIterator<Item = u32>) {
    numbers.into_iter().for_each(|n| out.extend(n.to_le_bytes()));
}

fn put_triangles(out: &mut Vec<u8>, triangles: &[OrientedTriangle]) {
    put(out, [triangles.len() as u32]);
    for t in triangles {
        put(out, [t.submesh, t.corners[0], t.corners[1], t.corners[2]]);
    }
}

/// A file with every structure of a shape.
fn file(name: &str, simplified: Simplified, layout: Layout) -> LodFile {
    let simplified = Arc::new(simplified);
    let submesh =
        |i| SubmeshInfo { name: format!("part{i}"), material: None, document_primitive: i };
    let info = ObjectInfo {
        name: name.to_owned(),
        submeshes: (0..simplified.mesh().submeshes().len() as u32).map(submesh).collect(),
        world_scale: 1.0,
        document_mesh: 0,
        poses: vec![],
    };
    let mut strips = StripPool::new(&simplified, StripOptions::default());
    let model = |&kind| AnyModel::build(kind, &mut strips).expect("triangles are in order");
    let models = ModelKind::ALL.iter().map(model).collect();
    LodFile {
        source: Source { format: SourceFormat::Obj, content_hash: 1 },
        document: Document::Obj(ObjDocument::default()),
        objects: vec![LodObject { info, simplified, models }],
        made_from: None,
        layout,
        left_out: Vec::new(),
    }
}

/// Random LODs of a shape, with the reference's triangles: `NAME.levels`. Some of them as
/// `NAME@LOD.glb` besides.
fn write_levels(folder: &Folder, name: &str, simplified: &Simplified, seed: u64) {
    let (mut out, mut random) = (Vec::new(), Rng::new(seed));
    let last = simplified.collapses().last().0;
    for i in 0..LEVELS {
        let lod = simplified.collapses().floor(Lod(random.below(last as usize + 1) as u32));
        let mut triangles = simplified.triangles_at(lod);
        triangles.sort_unstable();
        put(&mut out, [lod.0]);
        put_triangles(&mut out, &triangles);
        // The document of an OBJ has no morph targets to export.
        if i < EXTRACTED && !triangles.is_empty() && name != "morphing_sphere" {
            let (input, output) = (format!("{name}.lodc"), format!("{name}@{}.glb", lod.0));
            let lod = lod.0.to_string();
            folder.lodc(["extract", &input, "--lod", &lod, "-o", &output, "-q"]).ends(0);
        }
    }
    folder.file(&format!("{name}.levels"), out);
}

#[test]
fn levels_of_every_structure_are_those_of_the_reference_and_of_extract() {
    if outside("LODC_PYTHON").is_none() {
        return;
    }
    let folder = Folder::new();
    for (seed, name) in (0..).zip(SHAPES) {
        let mesh = named(name).expect("a shape");
        let simplified = if seed % 2 == 0 {
            lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {})
        } else {
            random_collapse(&mesh, seed)
        };
        let file = file(name, simplified, Layout::ALL[seed as usize / 2 % 2]);
        folder.file(&format!("{name}.lodc"), lodc::write(&file));
        write_levels(&folder, name, &file.objects[0].simplified, seed);
    }
    let Some(said) = python(&[Path::new("levels"), folder.path()]) else { return };
    let shapes = SHAPES.len();
    assert!(said.starts_with(&format!("{shapes} files, {} levels", shapes * LEVELS)), "{said}");
}

/// The meshes that the unpacker shows after each block of a stream: `NAME.states`.
fn states(stream: &[u8]) -> Vec<u8> {
    let (mut unpacker, mut out, mut used) = (Unpacker::new(Limits::DEFAULT), Vec::new(), 0);
    for byte in stream {
        unpacker.feed(std::slice::from_ref(byte)).expect("a sound stream");
        if unpacker.bytes() == used {
            continue;
        }
        used = unpacker.bytes();
        put(&mut out, [used as u32, unpacker.objects() as u32]);
        for object in 0..unpacker.objects() {
            let decoder = unpacker.decoder(object);
            let submesh = |t: [u32; 3]| decoder.vertex_submesh()[t[0] as usize];
            let triangle = |t| OrientedTriangle::new(submesh(t), t);
            let rms = decoder.rms().unwrap_or(f32::NAN);
            put(&mut out, [decoder.vertex_count(), decoder.error().to_bits(), rms.to_bits()]);
            put_triangles(&mut out, &decoder.triangles().map(triangle).collect::<Vec<_>>());
        }
    }
    assert!(unpacker.is_complete());
    out
}

#[test]
fn golden_streams_are_read_alike_step_by_step() {
    let folder = Folder::new();
    for name in ["cube_and_part", "skinned_tube", "triangle", "two_parts"] {
        let (stream, file) = (format!("{name}.lods"), format!("{name}.lodc"));
        let bytes = std::fs::read(golden().join(&stream)).expect("a golden stream");
        folder.file(&format!("{name}.states"), states(&bytes));
        folder.file(&stream, bytes);
        // The levels of a stream that is not exact are those of the file that it is unpacked to.
        folder.lodc(["unpack", &stream, "-o", &file, "--models", "none", "-q"]).ends(0);
    }
    let folder = folder.path();
    let Some(said) = python(&[Path::new("streams"), folder, folder]) else { return };
    assert!(said.starts_with("4 streams"), "{said}");
}

/// Pieces, wedges of many kinds, points that no triangle uses; vertices of hundreds of triangles.
#[test]
fn streams_with_many_points_are_read_alike_step_by_step() {
    if outside("LODC_PYTHON").is_none() {
        return;
    }
    let (states_of, made) = (Folder::new(), Folder::new());
    let shapes = ["several_components", "triangle_soup", "faceted_sphere", "machine_part", "cube"];
    for (seed, shape) in (0..).zip(shapes.iter().cycle().take(10).chain(&["book", "flaps"])) {
        let mesh = match *shape {
            "book" => lodc_fixtures::book(400),
            "flaps" => lodc_fixtures::flaps(600),
            _ => named(shape).expect("a shape"),
        };
        let simplified = if seed < shapes.len() as u64 || !shapes.contains(shape) {
            lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {})
        } else {
            random_collapse(&mesh, seed)
        };
        let name = format!("{shape}{seed}");
        // Half of them keep the order of all steps; of the others the file has that of a stream.
        let exact = seed % 2 == 0;
        let ordered = if exact { None } else { in_batches(&simplified, StepOrder::Batches) };
        let file = file(&name, ordered.unwrap_or(simplified), Layout::Packed);
        let options = PackOptions { block_bytes: Some(100), exact, ..PackOptions::default() };
        let stream = pack(&file, &options).expect("a sound file").bytes;
        states_of.file(&format!("{name}.states"), states(&stream));
        made.file(&format!("{name}.lodc"), lodc::write(&file));
        made.file(&format!("{name}.lods"), stream);
    }
    let arguments = [Path::new("streams"), states_of.path(), made.path()];
    let Some(said) = python(&arguments) else { return };
    assert!(said.starts_with("12 streams"), "{said}");
}

#[test]
fn golden_files_give_their_facts() {
    let Some(said) = python(&[Path::new("facts"), &golden()]) else { return };
    assert_eq!(said, std::fs::read_to_string(golden().join("facts.txt")).expect("the facts"));
}

#[test]
fn damage_is_found_with_its_place() {
    let Some(said) = python(&[Path::new("damage"), &golden()]) else { return };
    assert!(said.starts_with("all "), "{said}");
}
