use super::*;
use crate::Document;
use crate::Fault;
use crate::testing::{Random, Scratch, corpus};
use lodc_mesh::Semantic;
use std::path::Path;

fn import_text(name: &str, source: &[u8]) -> Result<Scene, FormatError> {
    let mut assets = Assets::new(Path::new(name), &[], crate::Limits::DEFAULT);
    import(source.to_vec(), &mut assets, &ImportOptions::default())
}

fn warned(scene: &Scene, what: &str) -> bool {
    scene.warnings.iter().any(|w| w.contains(what))
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn one_file_is_one_object_named_after_its_only_object_or_the_file() {
    let name = |source: &str| {
        import_text("dir/stem.obj", source.as_bytes()).expect(source).objects[0].info.name.clone()
    };
    assert_eq!(name(TRIANGLE), "stem");
    assert_eq!(name(&format!("o cube\n{TRIANGLE}")), "cube");
    assert_eq!(name(&format!("o a\n{TRIANGLE}o b\nf 1 2 3\n")), "stem");
    let scene = import_text("-", TRIANGLE.as_bytes()).expect("standard input");
    assert_eq!((scene.objects.len(), scene.objects[0].info.name.as_str()), (1, "mesh0"));
    assert_eq!(
        scene.source,
        Source { format: SourceFormat::Obj, content_hash: xxh3_128(TRIANGLE.as_bytes()) }
    );
}

#[test]
fn the_only_objects_name_is_not_a_groups_name() {
    let scene = import_text("x.obj", format!("o whole\n{TRIANGLE}").as_bytes()).expect("valid");
    assert_eq!(scene.objects[0].info.submeshes[0].name, "");
    let scene = import_text("x.obj", format!("o a\n{TRIANGLE}o b\nusemtl m\nf 1 2 3\n").as_bytes())
        .expect("valid");
    let names: Vec<_> = scene.objects[0].info.submeshes.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["a", "b"]);
}

#[test]
fn files_without_faces_are_refused_and_those_without_area_say_so() {
    for (source, what) in [
        ("# nothing\n", "no vertex and no face"),
        ("v 0 0 0\nv 1 1 1\n", "a point cloud, not a mesh: 2 vertices"),
        ("v 0 0 0\nv 1 0 0\np 1\nl 1 2\n", "lines, not a mesh: 2 vertices"),
    ] {
        let error = import_text("x.obj", source.as_bytes()).expect_err(source);
        assert!(error.problem.contains(what), "{source}: {error}");
    }
    let scene = import_text("x.obj", b"v 0 0 0\nf 1 1 1\n").expect("a face without area");
    assert_eq!(scene.objects[0].mesh.triangles().len(), 0);
    assert!(warned(&scene, "nothing to simplify"));
}

#[test]
fn degenerate_faces_are_dropped_and_duplicate_ones_stay() {
    let source = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -0 1 0\nf 1 2 3\nf 1 2 3\nf 1 3 4\nf 1 1 2\n";
    let scene = import_text("x.obj", source.as_bytes()).expect("valid");
    assert_eq!(scene.objects[0].mesh.triangles(), [[0, 1, 2], [0, 1, 2]]);
    assert!(warned(&scene, "2 triangles with two corners at one position"), "{:?}", scene.warnings);
}

#[test]
fn welding_is_relative_to_the_size() {
    let source = "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0.01 0 0\nv 100 100 0\nf 1 2 3\nf 4 5 3\n";
    let weld = |weld: f64| {
        let mut assets = Assets::new(Path::new("x.obj"), &[], crate::Limits::DEFAULT);
        let options = ImportOptions { weld, ..ImportOptions::default() };
        import(source.as_bytes().to_vec(), &mut assets, &options).expect("valid")
    };
    assert!(!warned(&weld(0.0), "welded") && !warned(&weld(1e-6), "welded"));
    let scene = weld(1e-3);
    assert!(warned(&scene, "1 vertex was welded"), "{:?}", scene.warnings);
    assert_eq!(lodc_mesh::PositionIds::new(scene.objects[0].mesh.positions()).len(), 4);
}

#[test]
fn libraries_are_read_from_the_own_folder_only() {
    let scratch = Scratch::new("obj-libraries");
    scratch.write("asset/sub/a b.mtl", b"newmtl red\nKd 1 0 0\nmap_Kd /etc/passwd\n");
    scratch.write("asset/c.mtl", b"newmtl blue\n");
    scratch.write("secret.mtl", b"newmtl secret\n");
    let read = |libraries: &str| {
        let source = format!("{libraries}usemtl red\n{TRIANGLE}");
        scratch.write("asset/main.obj", source.as_bytes());
        crate::import::import(&scratch.path("asset/main.obj"), &ImportOptions::default())
            .expect(libraries)
    };
    let names = |scene: &Scene| match &scene.document {
        Document::Obj(d) => d.materials.iter().map(|m| m.name.clone()).collect::<Vec<_>>(),
        Document::Gltf(_) => Vec::new(),
    };
    for found in
        ["mtllib sub/a b.mtl\n", "mtllib sub\\a b.mtl\n", "mtllib ./sub/../sub/a b.mtl # it\n"]
    {
        let scene = read(found);
        assert_eq!(names(&scene), ["red"], "{found}: {:?}", scene.warnings);
        assert_eq!(scene.files.read_files().len(), 2, "{found}");
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
    let absolute = format!("mtllib {}\n", scratch.path("secret.mtl").display());
    for lost in [
        "mtllib ../secret.mtl\n",
        "mtllib sub/../../secret.mtl\n",
        "mtllib ..\\secret.mtl\n",
        "mtllib c.mtl ../secret.mtl\n",
        "mtllib /etc/passwd\n",
        "mtllib /dev/zero\n",
        "mtllib file:///etc/passwd\n",
        "mtllib http://127.0.0.1:9/x.mtl\n",
        "mtllib C:\\x.mtl\n",
        "mtllib %2e%2e/secret.mtl\n",
        "mtllib %FF\n",
        "mtllib x\0.mtl\n",
        "mtllib sub\n",
        "mtllib missing.mtl\n",
        absolute.as_str(),
    ] {
        let scene = read(lost);
        assert!(!names(&scene).contains(&"secret".to_owned()), "{lost}");
        assert!(warned(&scene, "material library not read"), "{lost}: {:?}", scene.warnings);
        assert!(warned(&scene, "1 material is used but not defined: `red`"), "{lost}");
        assert!(
            scene.files.read_files().iter().all(|f| f.starts_with(scratch.path("asset"))),
            "{:?}",
            scene.files.read_files()
        );
    }
    assert_eq!(names(&read("mtllib c.mtl\nmtllib sub/a b.mtl\n")), ["blue", "red"]);
    scratch.write("asset/d.mtl", b"newmtl red\n");
    assert_eq!(names(&read("mtllib c.mtl d.mtl\n")), ["blue", "red"]);
}

/// Entry of the corpus's manifest for a file.
fn expected(manifest: &serde_json::Value, file: &str, key: &str) -> u64 {
    manifest[file][key].as_u64().unwrap_or_else(|| panic!("{file} has no {key}"))
}

#[test]
fn real_files_have_the_counts_that_others_found() {
    let Some(folder) = corpus() else { return };
    let text = std::fs::read_to_string(folder.join("manifest.json")).expect("the manifest");
    let manifest: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let mut files = 0;
    for file in manifest.as_object().expect("an object").keys().filter(|f| f.ends_with(".obj")) {
        let path = folder.join(file);
        let scene = crate::import::import(&path, &ImportOptions::default());
        if file.contains("invalid") {
            let error = scene.expect_err(file);
            assert!(error.location.starts_with("line "), "{error}");
            continue;
        }
        files += 1;
        let scene = match scene {
            Err(e) if e.problem.contains("not a mesh") => {
                assert_eq!(expected(&manifest, file, "polygons"), 0, "{file}: {e}");
                continue;
            }
            read => read.unwrap_or_else(|e| panic!("{e}")),
        };
        let parsed =
            parse::parse(&std::fs::read(&path).expect(file), &crate::Limits::DEFAULT).expect(file);
        let assembled = faces::assemble(&parsed.faces, 0);
        let check = |key: &str, found: usize| {
            assert_eq!(expected(&manifest, file, key), found as u64, "{file}: {key}");
        };
        check("vertices", parsed.faces.positions.len());
        check("normals", parsed.faces.normals.len());
        check("texcoords", parsed.faces.texcoords.len());
        check("polygons", parsed.faces.face_ends.len());
        // The manifest's own parser does not know the continued lines of this file: three corners
        // of each are missing.
        if file.ends_with("wallhole.obj") {
            assert_eq!((parsed.faces.corner_v.len(), assembled.parts.triangles.len()), (92, 66));
            continue;
        }
        check("triangles", assembled.parts.triangles.len());
        let mut used = vec![false; parsed.faces.positions.len()];
        parsed.faces.corner_v.iter().for_each(|&v| used[v as usize] = true);
        check("referenced", used.iter().filter(|&&u| u).count());
        let mesh = &scene.objects[0].mesh;
        assert!(mesh.triangles().len() <= assembled.parts.triangles.len(), "{file}");
        assert_eq!(scene.objects[0].info.submeshes.len(), mesh.submeshes().len(), "{file}");
    }
    assert!(files >= 50, "only {files} files");
}

#[test]
fn render_vertices_of_the_thesis_models_are_as_published() {
    let Some(folder) = corpus() else { return };
    for (file, vertices, submeshes) in
        [("cow", 2904, 1), ("bunny", 34834, 1), ("cessna", 9531, 5), ("spot", 3225, 1)]
    {
        let path = folder.join(format!("paper/{file}.obj"));
        let scene = crate::import::import(&path, &ImportOptions::default()).expect(file);
        let mesh = &scene.objects[0].mesh;
        assert_eq!((mesh.vertex_count(), mesh.submeshes().len()), (vertices, submeshes), "{file}");
    }
}

#[test]
fn colours_with_nan_are_kept() {
    let source = "v 0 0 0 nan 1 0\nv 1 0 0 1 1 1\nv 0 1 0 0 0 0\nf 1 2 3\n";
    let scene = import_text("x.obj", source.as_bytes()).expect("valid");
    let color = &scene.objects[0].mesh.attributes()[0];
    assert!(color.semantic == Semantic::Color(0) && color.value(0, 0).is_nan());
}

const SEED_OBJ: &str = "# seed\nmtllib a.mtl\no box\nv 0 0 0\nv 1 0 0 1\nv 1 1 0 .5 .5 .5\n\
    v 0 1 0 1 0 0 .5\nvt 0 0\nvt 1 0 .5\nvt 1\n\
    vn 0 0 1\nvn nan 0 1e-3\nusemtl red\ng one two\ns off\nf 1 2 3\n\
    f 1/1 2/2 3/3 4/1\nf -4//-1 -3//-2 -2//-1\nf 1/1/1 2/2/2 \\\n 3/3/1\n\
    usemtl blue\nl 1 2\np 1\nf 4 3 2 1 2 3 4\n";
pub(super) const SEED_MTL: &str =
    "newmtl red\nKd 1 0 0\nmap_Kd -s 1 1 x.png\nnewmtl blue \\\n one\n\nd 0.5\n";

/// Words that mean something in an OBJ or MTL, and numbers at the limits.
#[rustfmt::skip]
const WORDS: [&str; 28] = [
    "v", "vt", "vn", "f", "g", "o", "usemtl", "mtllib", "l", "p", "nan", "inf",
    "-0", "1e39", "1e-50", "0", "-1", "4294967295", "4294967296", "-9223372036854775808",
    "1//", "/", "//1", "1/1/1/1", "\\", "#", "\u{0}", "newmtl",
];

/// Changes a text the way damaged and malformed files are: by words, numbers, lines and bytes.
pub(super) fn mutated(source: &str, random: &mut Random) -> Vec<u8> {
    let mut lines: Vec<Vec<u8>> = source.split('\n').map(|l| l.as_bytes().to_vec()).collect();
    for _ in 0..1 + random.below(4) {
        let (i, j) = (random.below(lines.len()), random.below(lines.len()));
        match random.below(9) {
            0 => drop(lines.remove(i)),
            1 => lines.swap(i, j),
            2 => {
                let copy = lines[i].clone();
                lines.insert(j, copy);
            }
            3..=5 => {
                let mut words: Vec<Vec<u8>> =
                    lines[i].split(|&b| b == b' ').map(<[u8]>::to_vec).collect();
                let at = random.below(words.len());
                words[at] = WORDS[random.below(WORDS.len())].as_bytes().to_vec();
                lines[i] = words.join(&b' ');
            }
            6 => {
                if let Some(last) = lines[i].len().checked_sub(1) {
                    let at = random.below(last + 1);
                    lines[i][at] = random.next() as u8;
                }
            }
            7 => lines[i].extend_from_slice(&b" 1 2 3"[..random.below(7)]),
            _ => {
                let cut = random.below(lines[i].len() + 1);
                lines[i].truncate(cut);
            }
        }
        if lines.is_empty() {
            lines.push(Vec::new());
        }
    }
    lines.join(&b'\n')
}

#[test]
fn damaged_files_end_in_a_scene_or_an_error() {
    let scratch = Scratch::new("obj-mutations");
    let path = scratch.path("a.obj").display().to_string();
    let seed = 2024;
    let mut random = Random(seed);
    let (mut good, mut bad) = (0, 0);
    for round in 0..20_000 {
        // The library is damaged too; by itself, and more often, in `mtl_tests.rs`.
        if round % 100 == 0 {
            scratch.write("a.mtl", &mutated(SEED_MTL, &mut random));
        }
        match import_text(&path, &mutated(SEED_OBJ, &mut random)) {
            Ok(_) => good += 1,
            Err(e) => {
                let known = matches!(e.fault, Fault::Malformed | Fault::Unsupported | Fault::Limit);
                assert!(known, "seed {seed}, round {round}: {e}");
                bad += 1;
            }
        }
    }
    assert!(good > 500 && bad > 500, "one-sided: {good} scenes, {bad} errors");
}

#[test]
fn every_prefix_ends_in_a_scene_or_an_error() {
    for end in 1..SEED_OBJ.len() {
        let _ = import_text("x.obj", &SEED_OBJ.as_bytes()[..end]);
    }
}
