//! Engines read chains: Babylon.js, which knows MSFT_lod, and three.js through its parser.

use crate::support::{self, Folder, bounded, corpus, outside};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Bits that quantised files keep.
const BITS: &str = "pos=14,normal=10,uv=12,color=8,weight=8";

/// The node_modules folder with the engines. None if they are not asked for.
fn modules() -> Option<PathBuf> {
    outside("LODC_ENGINES")
}

/// Runs a script of this folder over a list; returns what it prints.
fn script(folder: &Folder, modules: &Path, name: &str, list: &Value) -> Value {
    folder.file("list.json", list.to_string());
    support::script(name, folder.path(), [modules, Path::new("list.json")])
}

/// The fixture, and models of the corpus where it is there: one mesh each, shown once.
fn inputs() -> Vec<PathBuf> {
    let part = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/machine_part.glb");
    let mut inputs = vec![PathBuf::from(part)];
    if let Some(corpus) = corpus() {
        let names = ["Duck.glb", "CesiumMan.glb", "RiggedSimple.glb", "BoxVertexColors.glb"];
        let paths = names.map(|name| corpus.join("gltf/khronos").join(name));
        inputs.extend(paths.into_iter().filter(|p| p.exists()));
        assert!(inputs.len() > 2, "the corpus lacks all of {names:?}");
    }
    inputs
}

#[test]
fn engines_see_the_levels_that_the_table_states() {
    let Some(modules) = modules() else { return };
    let folder = Folder::new();
    let (mut names, mut expected) = (Vec::new(), Vec::new());
    for (i, input) in inputs().iter().enumerate() {
        for (kind, more) in [("plain", &[][..]), ("quantised", &["--quantize", BITS])] {
            let name = format!("{i}{kind}.glb");
            let input = input.to_string_lossy();
            let args = ["chain", &input, "-o", &name, "--json", "-q"];
            let report = folder.lodc(args.iter().chain(more)).ends(0).json();
            let levels = report["levels"].as_array().expect("levels").iter();
            expected.push(Value::Array(levels.map(|l| l["triangles"].clone()).collect()));
            names.push(name);
        }
    }
    let seen = script(&folder, &modules, "engines.mjs", &names.clone().into());
    for ((name, expected), i) in names.iter().zip(&expected).zip(0..) {
        let input = inputs()[i / 2].display().to_string();
        assert_eq!(&seen[name]["babylon"], expected, "Babylon.js, {input}");
        assert_eq!(seen[name]["three"], Value::Array(vec![expected.clone()]), "three.js, {input}");
    }
}

#[test]
fn engines_play_the_way_to_the_next_level() {
    let Some(modules) = modules() else { return };
    let folder = Folder::new();
    let mut names = Vec::new();
    for (i, input) in inputs().iter().enumerate() {
        let input = input.to_string_lossy();
        let name = format!("{i}.glb");
        folder.lodc(["chain", &input, "-o", &name, "--geomorph", "-q", "--poses", "0"]).ends(0);
        names.push(name);
    }
    let seen = script(&folder, &modules, "weights.mjs", &names.clone().into());
    for (name, input) in names.iter().zip(inputs()) {
        for engine in ["babylon", "three"] {
            let off = seen[name][engine].as_array().expect("differences");
            assert_eq!(off.len(), 3, "{engine}, {}", input.display());
            let same = off.iter().all(|off| off.as_f64() < Some(1e-4));
            assert!(same, "{engine}, {}: {off:?}", input.display());
        }
    }
}

#[test]
fn the_reference_decoder_gives_every_byte_back() {
    let Some(modules) = modules() else { return };
    let folder = Folder::new();
    let (mut pairs, mut names) = (Vec::new(), Vec::new());
    for (i, input) in inputs().iter().enumerate() {
        for more in [&[][..], &["--quantize", BITS]] {
            let [plain, compressed] = ["p", "c"].map(|kind| format!("{kind}{i}{}.glb", more.len()));
            for (name, compress) in [(&plain, "none"), (&compressed, "meshopt")] {
                let input = input.to_string_lossy();
                let args = ["extract", &input, "-o", name, "--ratio", "50%", "--order", "size"];
                let compress = ["--compress", compress, "-q"];
                folder.lodc(args.iter().chain(&compress).chain(more)).ends(0);
            }
            pairs.push(Value::from(vec![compressed.clone(), plain.clone()]));
            names.push([compressed, plain, format!("p{i}0.glb")]);
        }
    }
    let compared = script(&folder, &modules, "meshopt.mjs", &pairs.clone().into());
    let compared = compared.as_object().expect("a table");
    assert_eq!(compared.len(), pairs.len());
    // Small files that compression and quantisation would make larger have neither.
    let mut packed = 0;
    for [own, plain, neither] in &names {
        if compared[own] == 0 {
            assert_ne!(plain, neither, "{own} is not compressed");
            assert_eq!(folder.read(own), folder.read(neither), "{own}");
        } else {
            packed += 1;
        }
    }
    assert!(packed > 1, "hardly anything is packed");
}

/// Models of the corpus without images.
const WITHOUT_IMAGES: [&str; 10] = [
    "paper/cow.obj",
    "paper/fandisk.obj",
    "paper/bunny.obj",
    "paper/ogrehead.obj",
    "paper/cessna.obj",
    "paper/jaiqua.glb",
    "ugly/cgal/elephant-with-holes.obj",
    "gltf/khronos/2CylinderEngine.glb",
    "gltf/bevy/CornellBox.glb",
    "gltf/misc/generic-hand-left.glb",
];

#[test]
fn quantised_files_are_about_as_small_as_those_of_gltfpack() {
    let (Some(modules), Some(corpus)) = (modules(), corpus()) else { return };
    let folder = Folder::new();
    for name in WITHOUT_IMAGES {
        let input = corpus.join(name).to_string_lossy().into_owned();
        let args = ["extract", &input, "--ratio", "1", "--compress", "meshopt", "-o", "own.glb"];
        folder.lodc(args.iter().chain(&["-q", "--quantize", BITS])).ends(0);
        let pack = bounded("node")
            .arg(modules.join("gltfpack/cli.js"))
            .args("-cc -kn -km -ke -kv -vp 14 -vt 12 -vn 10 -o its.glb -i".split(' '))
            .arg(&input)
            .current_dir(folder.path())
            .output()
            .expect("node is there if gltfpack is");
        assert!(pack.status.success(), "{name}: {}", String::from_utf8_lossy(&pack.stderr));
        // Nodes keep the digits that they have; gltfpack rounds them. Where a plain file is smaller
        // than one that is quantised, whose nodes are longer, it is the whole that counts.
        let sizes = |file| {
            let bytes = folder.read(file);
            [bytes.len() - nodes_size(&bytes), bytes.len()]
        };
        let [own, its] = ["own.glb", "its.glb"].map(sizes);
        let is_near = |k: usize| own[k] * 100 <= its[k] * 105;
        assert!(is_near(0) || is_near(1), "{name}: {own:?} bytes, gltfpack takes {its:?}");
    }
}

/// Bytes that the nodes of a GLB take.
fn nodes_size(bytes: &[u8]) -> usize {
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    let root: Value = serde_json::from_slice(&bytes[20..20 + length]).expect("a document");
    root["nodes"].to_string().len()
}
