//! Names of files as people have them: found where they can be, a warning where not, and nothing
//! outside the folder.

use crate::support::{Folder, glb_document, grid, scene};
use serde_json::{Value, json};

/// What begins as a PNG; nothing here looks further.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n and so on";

/// The document of a GLB.
fn document(f: &Folder, glb: &str) -> Value {
    glb_document(&f.read(glb)).0
}

/// An OBJ with texture coordinates, `head` before it.
fn textured(head: &str) -> String {
    let mut obj = format!("{head}\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n");
    for line in grid(4).lines() {
        match line.strip_prefix("f ") {
            Some(corners) => {
                let corners = corners.split(' ').zip(1..).map(|(v, t)| format!("{v}/{t}"));
                obj += &format!("f {}\n", corners.collect::<Vec<_>>().join(" "));
            }
            None => obj += &format!("{line}\n"),
        }
    }
    obj
}

/// Extracts as GLB and expects the picture inside.
#[track_caller]
fn embeds(f: &Folder, input: &str, options: &[&str]) -> String {
    let args = ["extract", input, "--lod", "0", "-o", "o.glb"];
    let run = f.lodc(args.iter().chain(options)).ends(0);
    let root = document(f, "o.glb");
    assert!(root["images"][0]["bufferView"].is_u64(), "{input}: {root}\n{}", run.err);
    let texture = &root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    assert_eq!(texture["index"], 0, "{input}: {root}");
    run.err
}

#[test]
fn libraries_and_textures_may_be_in_quotes() {
    let f = Folder::new();
    f.file("my wood.png", PNG);
    f.file("scan model.mtl", "newmtl skin\nKd 1 1 1\nmap_Kd \"my wood.png\"\n");
    f.file("a.obj", textured("mtllib \"scan model.mtl\"\nusemtl skin"));
    f.file("b.obj", textured("mtllib \"no such.mtl\" \"scan model.mtl\"\nusemtl \"skin\""));
    assert!(!embeds(&f, "a.obj", &[]).contains("warning: the material"));
    assert!(embeds(&f, "b.obj", &[]).contains("not read: no such.mtl"));
    f.file("c.mtl", "newmtl skin\nmap_Kd -bm 1 'my wood.png'\n");
    f.file("c.obj", textured("mtllib 'no such.mtl' 'c.mtl'\nusemtl 'skin'"));
    assert!(embeds(&f, "c.obj", &[]).contains("not read: no such.mtl"));
    // The copy of a texture has no quotes either.
    std::fs::create_dir(f.join("out")).expect("a folder");
    f.lodc(["extract", "a.obj", "--lod", "0", "-o", "out/o.obj"]).ends(0);
    assert!(f.has("out/my wood.png"));
}

#[test]
fn of_several_libraries_those_that_are_there_are_read() {
    let f = Folder::new();
    f.file("wood.png", PNG);
    f.file("have.mtl", "newmtl skin\nKd 0 1 0\nmap_Kd wood.png\n");
    f.file("a.obj", textured("mtllib gone.mtl have.mtl\nusemtl skin"));
    assert!(embeds(&f, "a.obj", &[]).contains("gone.mtl"));
}

#[test]
fn an_unknown_option_of_a_texture_takes_one_word() {
    let f = Folder::new();
    f.file("wood.png", PNG);
    f.file("a.obj", textured("mtllib a.mtl\nusemtl skin"));
    for options in ["-colorspace sRGB -s 2 2 1", "-srgb on", "-s 2 2 1 -colorspace linear"] {
        f.file("a.mtl", format!("newmtl skin\nKd 1 1 1\nmap_Kd {options} wood.png\n"));
        assert!(!embeds(&f, "a.obj", &[]).contains("missing"), "{options}");
    }
    let root = document(&f, "o.glb");
    let info = &root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    assert_eq!(info["extensions"]["KHR_texture_transform"]["scale"], json!([2.0, 2.0]));
}

#[test]
fn paths_of_another_machine_are_found_by_their_last_part() {
    for path in ["/home/someone/wood.png", "C:\\Users\\Someone\\wood.png", "D:/x/wood.png"] {
        let f = Folder::new();
        f.file("tex/wood.png", PNG);
        f.file("a.obj", textured("mtllib /home/someone/else/a.mtl\nusemtl skin"));
        f.file("a.mtl", format!("newmtl skin\nKd 1 1 1\nmap_Kd {path}\n"));
        embeds(&f, "a.obj", &["--textures-from", "tex"]);
        let run = f.lodc(["extract", "a.obj", "--lod", "0", "-o", "o.glb"]).ends(0);
        assert!(run.err.contains("a texture is missing"), "{}", run.err);
        assert_eq!(document(&f, "o.glb")["images"][0]["uri"], "wood.png");
        f.file("wood.png", PNG);
        embeds(&f, "a.obj", &[]);
        std::fs::create_dir(f.join("out")).expect("a folder");
        f.lodc(["extract", "a.obj", "--lod", "0", "-o", "out/o.obj"]).ends(0);
        let mtl = String::from_utf8(f.read("out/o.mtl")).expect("text");
        assert!(mtl.contains("map_Kd wood.png"), "{mtl}");
        assert!(f.has("out/wood.png"));
    }
}

#[test]
fn nothing_outside_the_folder_is_opened() {
    let f = Folder::new();
    f.file("secret.png", PNG);
    f.file("in/a.obj", textured("mtllib a.mtl\nusemtl skin"));
    let secret = f.join("secret.png");
    for path in ["../secret.png", secret.to_str().expect("a path")] {
        f.file("in/a.mtl", format!("newmtl skin\nKd 1 1 1\nmap_Kd {path}\n"));
        let run = f.lodc(["extract", "in/a.obj", "--lod", "0", "-o", "o.glb"]).ends(0);
        assert!(run.err.contains("a texture is missing"), "{}", run.err);
    }
}

#[test]
fn without_a_library_the_one_of_the_same_name_is_used_and_said() {
    let f = Folder::new();
    f.file("wood.png", PNG);
    f.file("a.mtl", "newmtl skin\nKd 1 1 1\nmap_Kd wood.png\n");
    f.file("a.obj", textured("usemtl skin"));
    assert!(embeds(&f, "a.obj", &[]).contains("no mtllib statement: materials are from a.mtl"));
    f.file("b.obj", textured(""));
    f.file("b.mtl", "newmtl skin\n");
    let run = f.lodc(["extract", "b.obj", "--lod", "0", "-o", "o.glb"]).ends(0);
    assert!(!run.err.contains("mtllib"), "{}", run.err);
}

#[test]
fn image_uris_with_percent_signs_drives_and_file_are_found_or_named() {
    let f = Folder::new();
    for (name, uri) in [
        ("100%.png", "100%.png"),
        ("50%25.png", "50%25.png"),
        ("wood.png", "C:\\textures\\wood.png"),
        ("wood.png", "file:///C:/textures/wood.png"),
        ("wood.png", "file:///home/someone/wood.png"),
        ("sub/wood.png", "sub\\wood.png"),
        ("a b.png", "a%20b.png"),
        ("wood.png", "wood.png?v=3"),
        ("a b.png", "a%20b.png#top"),
        ("C#.png", "C#.png"),
    ] {
        let f = Folder::new();
        let mut root: Value = serde_json::from_str(&scene(&[1.0], 4)).expect("a scene");
        root["images"] = json!([{"uri": uri}]);
        root["textures"] = json!([{"source": 0}]);
        let texture = json!({"baseColorTexture": {"index": 0}});
        root["materials"] = json!([{"pbrMetallicRoughness": texture}]);
        root["meshes"][0]["primitives"][0]["material"] = json!(0);
        f.file("a.gltf", root.to_string());
        let args = ["extract", "a.gltf", "--lod", "0", "-o", "o.glb"];
        let run = f.lodc(args).ends(0);
        assert!(run.err.contains("a texture is missing"), "{uri}: {}", run.err);
        f.file(name, PNG);
        assert!(!embeds(&f, "a.gltf", &[]).contains("missing"), "{uri}");
    }
    assert!(f.names().is_empty());
}

#[test]
fn a_texture_of_a_library_may_be_percent_encoded() {
    let f = Folder::new();
    f.file("a.mtl", "newmtl skin\nKd 1 1 1\nmap_Kd my%20wood.png\n");
    f.file("a.obj", textured("mtllib a.mtl\nusemtl skin"));
    f.file("my wood.png", PNG);
    assert!(!embeds(&f, "a.obj", &[]).contains("missing"));
    // The name as it is comes first.
    f.file("my%20wood.png", [PNG, b"longer"].concat());
    embeds(&f, "a.obj", &[]);
    let (root, _) = glb_document(&f.read("o.glb"));
    let view = root["images"][0]["bufferView"].as_u64().expect("a view") as usize;
    assert_eq!(root["bufferViews"][view]["byteLength"], PNG.len() + 6);
}

#[test]
fn a_build_says_which_images_are_to_be_copied() {
    let f = Folder::new();
    let mut root: Value = serde_json::from_str(&scene(&[1.0], 4)).expect("a glTF");
    let images = ["images/a.png", "images/b%20c.png", "images/a.png"];
    root["images"] = json!(images.map(|uri| json!({ "uri": uri })));
    f.file("models/a.gltf", root.to_string());
    f.file("models/images/a.png", PNG);
    f.file("models/images/b c.png", PNG);
    f.file("public/index.html", "");
    let build = |args: &[&str]| f.lodc(["build"].iter().chain(args)).ends(0).err;
    let said = build(&["models/a.gltf", "-o", "public/a.lodc"]);
    assert!(said.contains("copy 2 images beside it: images/a.png and 1 more"), "{said}");
    assert!(!build(&["models/a.gltf"]).contains("image"), "they are beside it");
    let said = build(&["models", "-o", "levels"]);
    assert!(said.contains("; copy 2 images beside it\n"), "{said}");
    f.file("public/images/a.png", PNG);
    let said = build(&["models/a.gltf", "-o", "public/a.lodc"]);
    assert!(said.contains("copy 1 image beside it: images/b c.png\n"), "{said}");
}

#[test]
fn a_mesh_where_a_file_is_wanted_is_told_what_to_do() {
    let f = Folder::new();
    f.file("club.obj", grid(4));
    f.lodc(["extract", "club.obj", "--ratio", "1", "-o", "club.glb", "-q"]).ends(0);
    f.lodc(["build", "club.obj", "-o", "there.lodc", "-q"]).ends(0);
    for args in [&["info"][..], &["pack", "-o", "x.lods"]] {
        for name in ["club.obj", "club.glb"] {
            let run = f.lodc(args.iter().chain(&[name])).fails(3);
            let wanted =
                format!("lodc: {name}: a mesh, not a .lodc file; run `lodc build {name}` first");
            assert!(run.err.contains(&wanted), "{args:?}: {}", run.err);
        }
    }
    let run = f.lodc(["verify", "club.obj"]).fails(3);
    assert!(run.err.contains("`lodc build` makes a file of a mesh first"), "{}", run.err);
}

#[test]
fn a_folder_of_results_has_no_name_of_a_file() {
    let f = Folder::new();
    f.file("models/a.obj", grid(4));
    for (command, out) in [("build", "x.lodc"), ("extract", "x.glb"), ("chain", "x.gltf")] {
        let level: &[&str] = if command == "extract" { &["--ratio", "1"] } else { &[] };
        let args = [command, "models", "-o", out];
        let run = f.lodc(args.iter().chain(level)).fails(2);
        assert!(run.err.contains("a file's name, and there are several results"), "{}", run.err);
        assert!(!f.has(out));
        let folder = format!("{out}/");
        let args = [command, "models", "-o", &folder, "-q"];
        f.lodc(args.iter().chain(level)).ends(0);
        f.lodc(args.map(|a| a.trim_end_matches('/')).iter().chain(level)).ends(0);
    }
}
