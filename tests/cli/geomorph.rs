//! `lodc chain --geomorph`: a morph target takes each level to the next, and `verify` proves it.

use crate::placements::Scene;
use crate::support::browser::{Browser, served};
use crate::support::{Folder, corpus, outside};
use serde_json::{Value, json};

const FIXTURES: [&str; 5] = [
    "machine_part.glb",
    "machine_part.obj",
    "skinned_tube_u8.glb",
    "morphing_sphere.glb",
    "coloured_cube.glb",
];

/// A folder with a fixture and its chain as a glTF and a file of numbers beside it.
fn chained(fixture: &str, more: &[&str]) -> Folder {
    let f = Folder::new();
    let path = format!("{}/../fixtures/{fixture}", env!("CARGO_MANIFEST_DIR"));
    f.file(fixture, std::fs::read(path).expect("a fixture"));
    let args = ["chain", fixture, "-o", "c.gltf", "-q"];
    f.lodc(args.iter().chain(more)).ends(0);
    f
}

fn document(f: &Folder, name: &str) -> Value {
    serde_json::from_slice(&f.read(name)).expect("a document")
}

fn number(value: &Value) -> usize {
    value.as_u64().unwrap_or(0) as usize
}

/// The meshes of the levels of the first node that has some.
fn meshes(d: &Value) -> Vec<usize> {
    let nodes = d["nodes"].as_array().expect("nodes");
    let node = nodes.iter().find(|n| n["extensions"]["MSFT_lod"].is_object()).expect("a chain");
    let ids = node["extensions"]["MSFT_lod"]["ids"].as_array().expect("ids").iter();
    let own = std::iter::once(number(&node["mesh"]));
    own.chain(ids.map(|id| number(&d["nodes"][number(id)]["mesh"]))).collect()
}

/// The targets of a primitive.
fn targets(d: &Value, mesh: usize, primitive: usize) -> usize {
    d["meshes"][mesh]["primitives"][primitive]["targets"].as_array().map_or(0, Vec::len)
}

#[test]
fn levels_become_the_next_ones() {
    let variants: [&[&str]; 6] = [
        &["--geomorph"],
        &["--geomorph", "--auto", "9"],
        &["--geomorph=uv,tangent,color"],
        &["--geomorph=joints"],
        &["--geomorph", "--quantize", "pos=11,normal=8,uv=10"],
        &["--geomorph", "--compress", "meshopt", "--quantize", "pos=11,normal=8,uv=10,color=8"],
    ];
    for fixture in FIXTURES {
        for more in variants {
            let f = chained(fixture, more);
            let run = f.lodc(["verify", "c.gltf", "--json"]).ends(0).json();
            let check = &run["files"][0]["checks"][0];
            assert_eq!(check["check"], "morph into the next level", "{fixture}, {more:?}: {run}");
            assert_eq!((&check["ok"], check["lods"].as_u64() > Some(1)), (&true.into(), true));
            // Nothing else of the file is wrong with a target more.
            // The cube is on a grid already, and put on another one.
            let is_gridded = fixture == "coloured_cube.glb" && more.contains(&"--quantize");
            if fixture == "machine_part.glb" || more == ["--geomorph"] || is_gridded {
                f.lodc(["verify", "c.gltf", "--source", fixture]).ends(0);
            }
        }
    }
}

#[test]
fn files_of_their_own_morph_to_the_next_file() {
    for fixture in FIXTURES {
        for more in [&[][..], &["--refit"], &["--refit", "--compress", "meshopt"]] {
            let f = Folder::new();
            let path = format!("{}/../fixtures/{fixture}", env!("CARGO_MANIFEST_DIR"));
            f.file(fixture, std::fs::read(path).expect("a fixture"));
            let args = ["chain", fixture, "-o", "out.glb", "-q", "--separate", "--geomorph"];
            f.lodc(args.iter().chain(more)).ends(0);
            for k in 0..3 {
                let name = format!("out_LOD{k}.glb");
                let run = f.lodc(["verify", &name, "--json"]).ends(0).json();
                assert_eq!(run["files"][0]["checks"][0]["ok"], true, "{fixture} {more:?}: {run}");
            }
            f.lodc(["verify", "out_LOD1.glb", "--source", fixture]).ends(0);
            // The last one goes nowhere.
            f.lodc(["verify", "out_LOD3.glb"]).ends(2);
        }
    }
}

type Inject = fn(&mut Value, &mut [u8]);

/// The place of the first value of a stream of the target of level 0.
fn first_delta(d: &Value, name: &str) -> usize {
    let mesh = meshes(d)[0];
    let target = d["meshes"][mesh]["primitives"][0]["targets"].as_array().and_then(|t| t.last());
    let accessor = &d["accessors"][number(&target.expect("a target")[name])];
    let values = &accessor["sparse"]["values"];
    let view = &d["bufferViews"][number(&values["bufferView"])];
    number(&view["byteOffset"]) + number(&values["byteOffset"])
}

fn add(numbers: &mut [u8], at: usize, by: f32) {
    let bytes = &mut numbers[at..at + 4];
    let value = f32::from_le_bytes(bytes.try_into().expect("four bytes"));
    bytes.copy_from_slice(&(value + by).to_le_bytes());
}

/// Each a defect.
const DEFECTS: &[(&str, Inject)] = &[
    ("a vertex that goes elsewhere", |d, numbers| {
        (0..40).for_each(|k| add(numbers, first_delta(d, "POSITION") + 12 * k, 0.125));
    }),
    ("a normal that turns elsewhere", |d, numbers| {
        (0..40).for_each(|k| add(numbers, first_delta(d, "NORMAL") + 12 * k, 0.25));
    }),
    ("no way at all", |d, numbers| {
        let at = first_delta(d, "POSITION");
        numbers[at..at + 12 * 40].fill(0);
    }),
    ("the way of another level", |d, _| {
        let all = meshes(d);
        d["meshes"][all[0]]["primitives"][0]["targets"] =
            d["meshes"][all[1]]["primitives"][0]["targets"].clone();
    }),
    ("other vertices that move", |d, _| {
        let mesh = meshes(d)[0];
        let target = d["meshes"][mesh]["primitives"][0]["targets"][0]["POSITION"].clone();
        let indices = &mut d["accessors"][number(&target)]["sparse"]["indices"];
        let before = number(&indices["byteOffset"]);
        indices["byteOffset"] = (before - 2).into();
    }),
];

/// No difference leads to or from what is not finite: such normals stay, and nothing else does.
#[test]
fn normals_that_are_not_finite_stay() {
    let mut scene = Scene::of_rocks(&[12]);
    let vertices = scene.accessors[0]["count"].as_u64().expect("a count") as usize;
    let odd = [f32::NAN, f32::INFINITY, -f32::NAN];
    let normal = |v: usize| match v % 9 {
        4 => [odd[v % 3]; 3],
        _ => [0.0, 0.6, 0.8],
    };
    let normals: Vec<f32> = (0..vertices).flat_map(normal).collect();
    let normals = scene.floats(&normals, "VEC3");
    scene.meshes[0]["primitives"][0]["attributes"]["NORMAL"] = normals.into();
    let f = Folder::new();
    f.file("s.gltf", scene.file(&[0], &json!({ "nodes": [{ "mesh": 0 }] })));
    for more in [&[][..], &["--separate"], &["--separate", "--refit"]] {
        let args = ["chain", "s.gltf", "-o", "c.glb", "--geomorph", "-q"];
        f.lodc(args.iter().chain(more)).ends(0);
        for name in f.names().iter().filter(|name| name.ends_with(".glb")) {
            f.lodc(["verify", name, "--source", "s.gltf"]).ends(0);
            std::fs::remove_file(f.join(name)).expect("it was written");
        }
    }
}

#[test]
fn injected_targets_are_found() {
    let f = chained("machine_part.glb", &["--geomorph"]);
    for (name, inject) in DEFECTS {
        let (mut d, mut numbers) = (document(&f, "c.gltf"), f.read("c.bin"));
        inject(&mut d, &mut numbers);
        d["buffers"][0]["uri"] = "d.bin".into();
        f.file("d.gltf", d.to_string());
        f.file("d.bin", numbers);
        let run = f.lodc(["verify", "d.gltf"]).ends(1);
        assert!(run.text().contains("morph into the next level, cpu: DIFFERENT"), "{name}");
    }
}

#[test]
fn levels_say_where_they_are_shown_and_coverage_agrees() {
    for more in [&["--geomorph"][..], &["--geomorph", "--pixels", "2", "--distances", "5,60,400"]] {
        let f = chained("machine_part.glb", more);
        let d = document(&f, "c.gltf");
        let facts = &d["extras"]["lodc"];
        let pixels = facts["screen"]["pixels"].as_f64().expect("pixels");
        assert_eq!(pixels, if more.len() > 1 { 2.0 } else { 1.0 });
        let levels = facts["levels"].as_array().expect("levels");
        let of = |k: usize, key: &str| levels[k][key].as_f64();
        let tangent = 30f64.to_radians().tan();
        for k in 0..levels.len() {
            let (distance, error) = (of(k, "distance").expect("one"), of(k, "error").expect("one"));
            let least = error * 1080.0 / (pixels * 2.0 * tangent);
            assert!(distance >= least * (1.0 - 1e-9), "{k}: {distance}, {least}");
            let next = levels.get(k + 1).and_then(|next| next["distance"].as_f64());
            let eighth = next.map(|next| distance + 0.125 * (next - distance));
            assert_eq!(of(k, "morph_from"), eighth, "{k}");
        }
        let mut nodes = d["nodes"].as_array().expect("nodes").iter();
        let shares = nodes.find_map(|n| n["extras"]["MSFT_screencoverage"].as_array());
        let mesh = meshes(&d)[0];
        let corners: Vec<f64> = ["min", "max"]
            .into_iter()
            .flat_map(|key| {
                let first = &d["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"];
                let accessor = &d["accessors"][number(first)];
                accessor[key].as_array().expect("bounds").iter().filter_map(Value::as_f64)
            })
            .collect();
        assert_eq!(corners.len(), 6);
        let shares = shares.expect("shares");
        for (k, share) in shares.iter().take(shares.len() - 1).enumerate() {
            let distance = of(k + 1, "distance").expect("one");
            // The box of all primitives is at least that of the first.
            let diagonal =
                (0..3).map(|i| (corners[i + 3] - corners[i]).powi(2)).sum::<f64>().sqrt();
            let least = (diagonal / (2.0 * distance * tangent)).powi(2).min(1.0);
            assert!(share.as_f64() >= Some(least * (1.0 - 1e-5)), "{k}: {share}, {least}");
        }
    }
}

#[test]
fn other_targets_and_their_animations_stay() {
    let f = chained("morphing_sphere.glb", &["--geomorph"]);
    let d = document(&f, "c.gltf");
    let all = meshes(&d);
    f.lodc(["chain", "morphing_sphere.glb", "-o", "plain.gltf", "-q"]).ends(0);
    let plain = document(&f, "plain.gltf");
    let before = targets(&plain, meshes(&plain)[0], 0);
    assert!(before > 0);
    for (k, &mesh) in all.iter().enumerate() {
        let extra = usize::from(k + 1 < all.len());
        assert_eq!(targets(&d, mesh, 0), before + extra, "level {k}");
        let names = d["meshes"][mesh]["extras"]["targetNames"].as_array();
        let last = names.and_then(|names| names.last()).and_then(Value::as_str);
        assert_eq!(last == Some("lodc:next"), extra == 1, "level {k}");
    }
    let node_mesh = |node: &Value| number(&d["nodes"][number(node)]["mesh"]);
    let mut seen = 0;
    for animation in d["animations"].as_array().into_iter().flatten() {
        for channel in animation["channels"].as_array().expect("channels") {
            if channel["target"]["path"] != "weights" {
                continue;
            }
            let sampler = &animation["samplers"][number(&channel["sampler"])];
            let count = |key: &str| number(&d["accessors"][number(&sampler[key])]["count"]);
            let per_key = if sampler["interpolation"] == "CUBICSPLINE" { 3 } else { 1 };
            let mesh = node_mesh(&channel["target"]["node"]);
            assert_eq!(count("output"), count("input") * per_key * targets(&d, mesh, 0));
            seen += 1;
        }
    }
    let is_animated = |a: &Value| {
        let channels = a["channels"].as_array().into_iter().flatten();
        channels.filter(|c| c["target"]["path"] == "weights").count()
    };
    let of_plain: usize =
        plain["animations"].as_array().into_iter().flatten().map(is_animated).sum();
    assert_eq!(seen, of_plain);
}

#[test]
fn what_cannot_morph_is_refused() {
    let f = chained("machine_part.glb", &[]);
    for (args, what) in [
        (
            &["-o", "x.obj", "--separate", "--geomorph"][..],
            "only .glb and .gltf hold morph targets",
        ),
        (&["-o", "x.glb", "--geomorph=joint"], "`joint` is not one of tangent, uv, color, joints"),
        (&["-o", "x.glb", "--geomorph", "--index-ranges"], "cannot be used with"),
    ] {
        let run = f.lodc(["chain", "machine_part.glb"].iter().chain(args)).ends(2);
        assert!(run.err.contains(what), "{args:?}: {}", run.err);
    }
}

/// Bytes of geometry: of what draws read, and what `more` has besides.
fn geometry(f: &Folder, plain: &str, more: &str) -> f64 {
    let d = document(f, plain);
    let views = d["bufferViews"].as_array().expect("views").iter();
    let drawn = views.filter(|v| v["target"].is_u64()).map(|v| number(&v["byteLength"]));
    let drawn: usize = drawn.sum();
    let bytes = |name: &str| f.read(&name.replace(".gltf", ".bin")).len();
    (drawn + bytes(more) - bytes(plain)) as f64 / drawn as f64
}

#[test]
fn real_meshes_morph() {
    let Some(corpus) = corpus() else { return };
    let models = [
        "paper/cow.obj",
        "paper/fandisk.obj",
        "paper/ogrehead.obj",
        "gltf/khronos/Duck.glb",
        "gltf/khronos/CesiumMan.glb",
        "gltf/khronos/CesiumMilkTruck.glb",
        "gltf/khronos/AnimatedMorphCube.glb",
    ];
    let mut ratios = Vec::new();
    for model in models {
        let f = Folder::new();
        let input = corpus.join(model).to_string_lossy().into_owned();
        for (name, more) in [("plain.gltf", &[][..]), ("geomorph.gltf", &["--geomorph"])] {
            let args = ["chain", &input, "-o", name, "-q", "--poses", "2"];
            f.lodc(args.iter().chain(more)).ends(0);
        }
        f.lodc(["verify", "geomorph.gltf"]).ends(0);
        ratios.push((geometry(&f, "plain.gltf", "geomorph.gltf"), model));
    }
    let mean = ratios.iter().map(|r| r.0).sum::<f64>() / ratios.len() as f64;
    assert!(mean <= 1.5, "{ratios:?}");
}

/// A page that looks at a chain from one place, its distance swept from 0 beyond the last level's:
/// the largest changes from one picture to the next, of levels that morph and that switch.
const SWEEP: &str = r#"<!doctype html>
<script type="importmap">
{ "imports": {
  "three": "/node_modules/three/build/three.module.js",
  "three/addons/": "/node_modules/three/examples/jsm/"
} }
</script>
<script type="module">
setTimeout(() => console.log('done: no end'), 120000);
const failed = (e) => console.log(`done: ${e.reason ?? e.message}`);
window.addEventListener('error', failed);
window.addEventListener('unhandledrejection', failed);
const THREE = await import('three');
const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
const { ChainModel, LodcChain } = await import('/chain.js');
const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setSize(128, 128);
const model = await ChainModel.of(await new GLTFLoader().loadAsync('/chain.glb'));
const chain = new LodcChain(model);
for (const { mesh } of chain.meshes) {
  const flatShading = !mesh.geometry.attributes.normal;
  const side = THREE.DoubleSide;
  mesh.material = new THREE.MeshLambertMaterial({ color: '#c0c0c0', side, flatShading });
}
const scene = new THREE.Scene();
scene.background = new THREE.Color('#e0e4e8');
scene.add(new THREE.HemisphereLight('#ffffff', '#404040', 2), chain);
const { center, radius } = chain.sphere;
const camera = new THREE.PerspectiveCamera(40, 1, radius / 10, radius * 10);
camera.position.set(1, 0.7, 1.6).normalize().multiplyScalar(radius * 2.6).add(center);
camera.lookAt(center);
const context = renderer.getContext();
const picture = () => {
  renderer.render(scene, camera);
  const bytes = new Uint8Array(128 * 128 * 4);
  context.readPixels(0, 0, 128, 128, context.RGBA, context.UNSIGNED_BYTE, bytes);
  return bytes;
};
// Every step is the same share farther away: levels may begin at distances of any ratio.
const first = model.levels.levels.find((level) => level.distance > 0).distance / 8;
const end = model.levels.levels.at(-1).distance * 1.05;
const largest = (morphs) => {
  chain.morphs = morphs;
  chain.show(0, 0);
  let [most, before] = [0, picture()];
  for (let i = 1; i <= 300; i++) {
    chain.at(first * (end / first) ** (i / 300));
    const now = picture();
    let sum = 0;
    // Not squared: of what is less than one of 256 levels rounding shows the mean, not the square.
    for (let k = 0; k < now.length; k++) sum += Math.abs(now[k] - before[k]);
    most = Math.max(most, sum / now.length);
    before = now;
  }
  return most;
};
console.log(`done: ${largest(true)} ${largest(false)}`);
</script>
"#;

#[test]
fn levels_that_morph_change_little_from_picture_to_picture() {
    let (Some(browser), Some(web)) = (Browser::find(), outside("LODC_WEB")) else { return };
    let f = Folder::new();
    let input = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/terrain.glb");
    f.lodc(["chain", input, "-o", "chain.glb", "--geomorph", "-q"]).ends(0);
    f.file("sweep.html", SWEEP);
    let address = served(vec![f.path().to_owned(), web]);
    let told = browser.result_at(&format!("{address}/sweep.html"));
    let numbers: Vec<f64> = told.split(' ').filter_map(|n| n.parse().ok()).collect();
    let [geomorph, switch] = numbers[..] else { panic!("{told}") };
    assert!(switch > 0.1, "nothing switches: {told}");
    assert!(geomorph <= 0.25 * switch, "{geomorph} against {switch}");
}

#[test]
fn the_example_shows_a_crowd_of_chains() {
    let (Some(browser), Some(web)) = (Browser::find(), outside("LODC_WEB")) else { return };
    let f = chained("machine_part.glb", &["--geomorph"]);
    let args = ["chain", "machine_part.glb", "-o", "models/chain.glb", "--geomorph", "-q"];
    f.lodc(args).ends(0);
    let address = served(vec![f.path().to_owned(), web]);
    let page = browser.dump(&format!("{address}/example/chain.html?copies=500"));
    let root = page.split_once('>').map_or("", |(_, rest)| rest);
    assert!(
        root.contains("data-ready=\"true\"") && root.contains("data-copies=\"500\""),
        "{page:.400}"
    );
}
