//! `lodc view`: a page without a network, and what a browser shows of it.

use crate::support::browser::Browser;
use crate::support::{Folder, grid, scene};
use lodc_formats::picture::png;
use lodc_scene::Image;

const PART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/machine_part.glb");

/// Triangles that `extract --lod` gives, object by object together, and the LOD that it names.
fn extracted(f: &Folder, lod: &str) -> (String, Option<String>) {
    let args = ["extract", "m.lodc", "--lod", lod, "--per-object", "-o", "l.glb", "--json", "-q"];
    let report = f.lodc(args).ends(0).json();
    (report["triangles"].to_string(), report["lod"].as_u64().map(|k| k.to_string()))
}

#[test]
fn a_browser_shows_the_levels_that_extract_gives() {
    let Some(browser) = Browser::find() else { return };
    let f = Folder::new();
    f.file("grid.obj", grid(12));
    f.file("scene.gltf", scene(&[1.0, 4.0, 0.5], 8));
    for input in [PART, "grid.obj", "scene.gltf"] {
        f.lodc(["build", input, "-o", "m.lodc", "-q"]).ends(0);
        f.lodc(["view", "m.lodc", "-o", "view.html", "-q"]).ends(0);
        for lod in ["0", "77", "999999"] {
            let (triangles, shown) = extracted(&f, lod);
            let page = browser.attributes(&f.join("view.html"), &format!("lod={lod}"));
            let of = |name: &str| page.get(name).map(String::as_str);
            assert_eq!(of("data-ready"), Some("true"), "{input} at {lod}: {page:?}");
            assert_eq!(of("data-triangles"), Some(&*triangles), "{input} at {lod}");
            // Several objects have no LOD in common: the one asked for is stated.
            assert_eq!(of("data-lod"), Some(shown.as_deref().unwrap_or(lod)), "{input} at {lod}");
            assert!(matches!(of("data-backend"), Some("webgl2" | "webgpu")), "{page:?}");
        }
    }
}

#[test]
fn a_browser_finds_levels_by_triangles_and_by_error_as_extract_does() {
    let Some(browser) = Browser::find() else { return };
    let f = Folder::new();
    f.lodc(["build", PART, "-o", "m.lodc", "-q"]).ends(0);
    f.lodc(["view", "m.lodc", "-o", "view.html", "-q"]).ends(0);
    for (option, key, value) in [
        ("--triangles", "triangles", "100"),
        ("--error", "error", "0.5"),
        ("--error", "error", "0"),
    ] {
        let args = ["extract", "m.lodc", option, value, "-o", "l.glb", "--json", "-q"];
        let report = f.lodc(args).ends(0).json();
        let page = browser.attributes(&f.join("view.html"), &format!("{key}={value}"));
        assert_eq!(page["data-triangles"], report["triangles"].to_string(), "{key} {value}");
        assert_eq!(page["data-lod"], report["lod"].to_string(), "{key} {value}");
    }
}

#[test]
fn a_page_is_made_of_a_mesh_and_of_its_lodc_file_alike() {
    let f = Folder::new();
    f.lodc(["build", PART, "-o", "m.lodc", "--models", "interactive", "-q"]).ends(0);
    f.lodc(["view", PART, "-o", "a.html", "--title", "part", "-q"]).ends(0);
    f.lodc(["view", "m.lodc", "-o", "b.html", "--title", "part", "-q"]).ends(0);
    assert_eq!(f.read("a.html"), f.read("b.html"));
    let streamed = f.lodc(["view", PART, "-o", "-", "--title", "part", "-q"]).ends(0);
    assert_eq!(streamed.out, f.read("a.html"));
}

#[test]
fn textures_are_in_the_page_and_missing_ones_are_a_warning() {
    let f = Folder::new();
    f.file("c.mtl", "newmtl m\nmap_Kd there.png\nnewmtl n\nmap_Kd missing.png\n");
    f.file("there.png", png(&Image::filled(1, 1, [255; 4])));
    f.file("c.obj", format!("mtllib c.mtl\nusemtl m\n{}usemtl n\nf 1 2 3\n", grid(4)));
    let run = f.lodc(["view", "c.obj", "-o", "c.html"]).ends(0);
    let warnings: Vec<&str> = run.err.lines().filter(|l| l.contains("texture")).collect();
    assert!(warnings.len() == 1 && warnings[0].contains("missing.png"), "{warnings:?}");
    let Some(browser) = Browser::find() else { return };
    let page = browser.dump(&format!("file://{}", f.join("c.html").display()));
    assert!(page.contains("1 image"), "the texture is not in the page");
}

#[test]
fn wrong_use_of_view_is_refused_in_a_line() {
    let f = Folder::new();
    f.file("g.obj", grid(2));
    f.lodc(["view", "missing.obj", "-o", "v.html"]).ends(3);
    f.lodc(["view", "g.obj", "-o", "-", "--depfile", "d"]).ends(2);
    f.lodc(["view", "g.obj", "-o", "no/such/folder/v.html"]).ends(4);
    f.lodc(["view", "g.obj"]).ends(2);
    assert!(!f.has("v.html"));
}
