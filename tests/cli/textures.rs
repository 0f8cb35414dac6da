//! Image files are embedded or copied with the model, vertices are in an order for caches, and
//! exports state their source.

use crate::support::{Folder, grid};
use serde_json::Value;

/// A PNG of one pixel.
const PNG: &[u8] = &[
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0, 0, 0, 0x0d, 0x49, 0x48, 0x44, 0x52, 0, 0, 0,
    1, 0, 0, 0, 1, 8, 2, 0, 0, 0, 0x90, 0x77, 0x53, 0xde, 0, 0, 0, 0x0c, 0x49, 0x44, 0x41, 0x54,
    0x08, 0xd7, 0x63, 0xf8, 0xcf, 0xc0, 0, 0, 3, 1, 1, 0, 0x18, 0xdd, 0x8d, 0xb0, 0, 0, 0, 0, 0x49,
    0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82,
];

/// An OBJ with a texture in a folder of its own and one that is missing.
fn textured(f: &Folder) {
    f.file("in/wood/a b.png", PNG);
    f.file("in/m.mtl", "newmtl w\nKd 1 1 1\nmap_Kd -s 1 1 1 wood\\a b.png\nbump gone.png\n");
    f.file("in/m.obj", format!("mtllib m.mtl\nusemtl w\n{}", grid(6)));
}

fn json(f: &Folder, name: &str) -> Value {
    serde_json::from_slice(&f.read(name)).expect("JSON")
}

/// The JSON and the binary chunk of a GLB.
fn glb(f: &Folder, name: &str) -> (Value, Vec<u8>) {
    let bytes = f.read(name);
    let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    let json = serde_json::from_slice(&bytes[20..20 + length]).expect("a JSON chunk");
    (json, bytes[28 + length..].to_vec())
}

/// Bytes of the only image of a GLB.
fn embedded(f: &Folder, name: &str) -> Vec<u8> {
    let (json, bin) = glb(f, name);
    let image = &json["images"][0];
    assert_eq!((&image["mimeType"], image.get("uri")), (&"image/png".into(), None), "{image}");
    let view = &json["bufferViews"][image["bufferView"].as_u64().expect("a view") as usize];
    let at = |key: &str| view[key].as_u64().expect("a number") as usize;
    bin[at("byteOffset")..at("byteOffset") + at("byteLength")].to_vec()
}

#[test]
fn images_are_embedded_copied_or_kept() {
    let f = Folder::new();
    textured(&f);
    let extract = |more: &[&str]| {
        f.lodc(["extract", "in/m.obj", "--ratio", "0.5"].iter().chain(more)).ends(0)
    };
    let run = extract(&["-o", "m.glb", "--depfile", "d"]);
    assert!(run.err.contains("warning: a texture is missing: gone.png"), "{}", run.err);
    assert_eq!(embedded(&f, "m.glb"), PNG);
    let rules = String::from_utf8(f.read("d")).expect("text");
    assert!(rules.contains("in/wood/a\\ b.png") && rules.contains("in/m.mtl"), "{rules}");

    extract(&["-o", "out/", "--format", "gltf"]);
    assert_eq!(f.read("out/wood/a b.png"), PNG);
    assert_eq!(json(&f, "out/m.obj.gltf")["images"][0]["uri"], "wood/a%20b.png");
    extract(&["-o", "obj/", "--format", "obj"]);
    assert_eq!(f.read("obj/wood/a b.png"), PNG);
    let library = String::from_utf8(f.read("obj/m.obj.mtl")).expect("text");
    assert!(library.contains("map_Kd -s 1 1 1 wood\\a b.png\n"), "{library}");

    extract(&["-o", "keep/", "--format", "gltf", "--textures", "keep"]);
    assert!(!f.has("keep/wood"));
    let run = f.lodc(["extract", "in/m.obj", "--ratio", "1", "-o", "o.obj", "--textures", "embed"]);
    assert!(run.fails(2).err.contains("--textures copy"));
}

#[test]
fn a_copy_never_replaces_another_file() {
    let f = Folder::new();
    textured(&f);
    f.file("out/wood/a b.png", b"somebody's work");
    let args = ["extract", "in/m.obj", "--ratio", "1", "-o", "out/m.obj"];
    let run = f.lodc(args).ends(0);
    assert!(run.err.contains("another file has this name"), "{}", run.err);
    assert_eq!(f.read("out/wood/a b.png"), b"somebody's work");
    let library = String::from_utf8(f.read("out/m.mtl")).expect("text");
    let line = library.lines().find(|l| l.starts_with("map_Kd")).expect("a texture");
    let name = line.strip_prefix("map_Kd -s 1 1 1 ").expect("the options stay");
    assert!(name.starts_with("wood/a b-"), "{name}");
    assert_eq!(f.read(&format!("out/{name}")), PNG);
    let before = f.read("out/m.mtl");
    f.lodc(args).ends(0);
    assert!(f.read("out/m.mtl") == before, "the same again");
}

#[test]
fn images_inside_a_glb_become_files_of_an_obj_and_a_lodc_file_finds_its_own() {
    let f = Folder::new();
    textured(&f);
    f.lodc(["extract", "in/m.obj", "--ratio", "1", "-o", "m.glb", "-q"]).ends(0);
    f.lodc(["extract", "m.glb", "--ratio", "0.5", "-o", "o.obj", "-q"]).ends(0);
    let library = String::from_utf8(f.read("o.mtl")).expect("text");
    assert!(library.contains("map_Kd o_image0.png"), "{library}");
    assert_eq!(f.read("o_image0.png"), PNG);

    f.lodc(["build", "in/m.obj", "-o", "m.lodc", "-q"]).ends(0);
    let args = ["extract", "m.lodc", "--ratio", "1", "-o", "l.glb"];
    assert!(f.lodc(args).ends(0).err.contains("a texture is missing: wood/a b.png"));
    f.lodc(args.iter().chain(&["--textures-from", "in"])).ends(0);
    assert_eq!(embedded(&f, "l.glb"), PNG);
}

#[test]
fn a_lodc_file_holds_the_images_of_a_gltf_if_asked() {
    let f = Folder::new();
    textured(&f);
    f.lodc(["extract", "in/m.obj", "--lod", "0", "--format", "gltf", "-o", "m/", "-q"]).ends(0);
    let build = ["build", "m/m.obj.gltf", "-o", "out/m.lodc", "--if-changed"];
    let copy = "copy 1 image beside it: wood/a b.png";
    assert!(f.lodc(["build", "m/m.obj.gltf", "-o", "m.lodc"]).ends(0).err.contains(copy));
    std::fs::create_dir(f.join("out")).expect("a folder");
    let run = f.lodc(build.iter().chain(&["--embed"])).ends(0);
    assert!(!run.err.contains("image"), "{}", run.err);
    f.lodc(["verify", "out/m.lodc", "--source", "m/m.obj.gltf", "-q"]).ends(0);
    f.lodc(["extract", "out/m.lodc", "--ratio", "0.5", "-o", "half.glb", "-q"]).ends(0);
    assert_eq!(embedded(&f, "half.glb"), PNG);
    // Only the option makes the difference.
    assert_eq!(
        f.lodc(build.iter().chain(&["--report", "json"])).ends(0).json()["summary"]["built"],
        1
    );
    let run = f.lodc(["build", "in/m.obj", "-o", "obj.lodc", "--embed"]).ends(0);
    assert!(run.err.contains("warning: images are not embedded"), "{}", run.err);
}

#[test]
fn a_chain_has_its_images_once() {
    let f = Folder::new();
    textured(&f);
    f.lodc(["chain", "in/m.obj", "-o", "c.glb", "-q"]).ends(0);
    assert_eq!(embedded(&f, "c.glb"), PNG);
    let args = ["chain", "in/m.obj", "--separate", "--levels", "1,0.5"];
    f.lodc(args.iter().chain(&["-o", "s/c.gltf", "-q"])).ends(0);
    assert_eq!(f.read("s/wood/a b.png"), PNG);
    for name in ["s/c_LOD0.gltf", "s/c_LOD1.gltf"] {
        assert_eq!(json(&f, name)["images"][0]["uri"], "wood/a%20b.png");
    }
    f.lodc(args.iter().chain(&["-o", "c.glb", "-q"])).ends(0);
    assert!(embedded(&f, "c_LOD0.glb") == PNG && embedded(&f, "c_LOD1.glb") == PNG);
}

#[test]
fn a_file_says_where_it_comes_from() {
    let f = Folder::new();
    f.file("g.obj", grid(8));
    f.lodc(["build", "g.obj", "-o", "g.lodc", "-q"]).ends(0);
    let hash =
        f.lodc(["info", "g.lodc", "--json"]).ends(0).json()["source"]["content_hash"].clone();
    let args = ["extract", "g.lodc", "--triangles", "40", "--json", "-q", "-o"];
    let report = f.lodc(args.iter().chain(&["o.glb"])).ends(0).json();
    let (json, _) = glb(&f, "o.glb");
    let version = format!("lodc {}", env!("CARGO_PKG_VERSION"));
    assert_eq!(json["asset"]["generator"], version.as_str());
    let origin = &json["extras"]["lodc"];
    for key in ["lod", "error", "rms", "refitted"] {
        assert_eq!(origin[key], report[key], "{key}");
    }
    assert_eq!(origin["source"], hash);
    for name in ["o.obj", "o.ply"] {
        f.lodc(args.iter().chain(&[name])).ends(0);
        let bytes = f.read(name);
        let text = String::from_utf8_lossy(&bytes[..200]);
        let line = text.lines().find(|l| l.contains(&version)).expect("a comment");
        assert!(line.contains(&format!("LOD {}", report["lod"])), "{line}");
        assert!(line.contains(hash.as_str().expect("a hash")), "{line}");
    }
    f.lodc(["chain", "g.obj", "-o", "c.glb", "-q"]).ends(0);
    let origin = &glb(&f, "c.glb").0["extras"]["lodc"];
    assert_eq!(origin["levels"].as_array().map(Vec::len), Some(4));
    assert_eq!(origin["source"], hash);
}

#[test]
fn a_refitted_level_states_what_was_measured() {
    let f = Folder::new();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/machine_part.glb");
    f.file("part.glb", std::fs::read(path).expect("a fixture"));
    let args = ["extract", "part.glb", "--ratio", "20%", "--json", "-q", "-o"];
    let plain = f.lodc(args.iter().chain(&["a.glb", "--no-refit"])).ends(0).json();
    let refitted = f.lodc(args.iter().chain(&["b.glb"])).ends(0).json();
    assert_eq!((&plain["refitted"], &refitted["refitted"]), (&false.into(), &true.into()));
    assert_eq!(plain["triangles"], refitted["triangles"]);
    assert!(refitted["rms"].as_f64() < plain["rms"].as_f64(), "{refitted} {plain}");
    let found = f.lodc(["compare", "part.glb", "b.glb", "--views", "0", "--json"]).ends(0).json();
    let [found, stated] = [&found["rms"]["max"], &refitted["rms"]].map(|v| v.as_f64());
    let (found, stated) = (found.expect("a number"), stated.expect("a number"));
    assert!((found - stated).abs() < 0.02 * found, "{stated} is stated, {found} is measured");
    let chain = ["chain", "part.glb", "--separate", "--refit", "--levels", "20%", "-o", "c.glb"];
    let chain = f.lodc(chain.iter().chain(&["--json", "-q"])).ends(0).json();
    assert_eq!(chain["levels"][0]["rms"], refitted["rms"]);
}

#[test]
fn a_refitted_level_is_the_same_from_a_mesh_and_from_its_file() {
    let f = Folder::new();
    let fixture = |name: &str| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/");
        std::fs::read(format!("{folder}{name}")).expect("a fixture")
    };
    f.file("in/part.glb", fixture("machine_part.glb"));
    f.file("in/quarters.jpg", include_bytes!("quarters.jpg"));
    f.file("in/m.mtl", "newmtl w\nKd 1 1 1\nmap_Kd quarters.jpg\n");
    let sphere = String::from_utf8(fixture("uv_sphere.obj")).expect("text");
    f.file("in/beside.obj", format!("mtllib m.mtl\nusemtl w\n{sphere}"));
    f.lodc(["extract", "in/beside.obj", "--ratio", "1", "-o", "in/embedded.glb", "-q"]).ends(0);
    for name in ["in/part.glb", "in/beside.obj", "in/embedded.glb"] {
        f.lodc(["build", name, "-o", "m.lodc", "-q"]).ends(0);
        let refitted = |from: &[&str]| {
            let args = ["extract", "--ratio", "20%", "-o", "r.ply", "-q"];
            f.lodc(args.iter().chain(from)).ends(0);
            f.read("r.ply")
        };
        let of_mesh = refitted(&[name]);
        assert_eq!(of_mesh, refitted(&["m.lodc"]), "{name}");
        let words = ["extract", "m.lodc", "--ratio", "20%", "--no-refit", "-o", "p.ply", "-q"];
        f.lodc(words).ends(0);
        assert_ne!(of_mesh, f.read("p.ply"), "{name}");
    }
}

/// Fetched vertices per triangle with a cache of 16, first in, first out.
fn acmr(triangles: &[Vec<u32>]) -> f64 {
    let (mut cache, mut misses) = (Vec::new(), 0);
    for &v in triangles.iter().flatten() {
        if !cache.contains(&v) {
            misses += 1;
            cache.insert(0, v);
            cache.truncate(16);
        }
    }
    f64::from(misses) / triangles.len() as f64
}

/// The numbers behind a word that begins lines.
fn lists(f: &Folder, name: &str, word: &str) -> Vec<Vec<u32>> {
    let text = String::from_utf8(f.read(name)).expect("text");
    let numbers = |l: &str| l.split_whitespace().map(|n| n.parse().expect("a number")).collect();
    text.lines().filter_map(|l| l.strip_prefix(word)).map(numbers).collect()
}

#[test]
fn triangles_stand_in_an_order_for_caches_unless_that_of_the_file_is_wanted() {
    let f = Folder::new();
    f.file("g.obj", grid(40));
    let args = ["extract", "g.obj", "--ratio", "50%", "-q", "-o"];
    f.lodc(args.iter().chain(&["cache.obj"])).ends(0);
    f.lodc(args.iter().chain(&["file.obj", "--order", "file"])).ends(0);
    f.lodc(["strips", "file.obj", "-o", "list", "--strips", "list", "-q"]).ends(0);
    let best: Vec<Vec<u32>> =
        lists(&f, "list", "l ").concat().chunks(3).map(<[u32]>::to_vec).collect();
    let [cache, file] = ["cache.obj", "file.obj"].map(|name| acmr(&lists(&f, name, "f ")));
    let best = acmr(&best);
    assert!(cache < 1.03 * best, "{cache} against {best}");
    assert!(file > 1.1 * best, "{file} against {best}");
    // Vertices stand by first use.
    let used = lists(&f, "cache.obj", "f ").concat();
    let mut next = 1;
    for v in used {
        assert!(v <= next, "vertex {v} before {next}");
        next += u32::from(v == next);
    }
}
