//! `lodc view`: a page without a network, and what a browser shows of it.

use crate::support::browser::Browser;
use crate::support::{Folder, grid, scene};
use lodc_formats::images::png;
use lodc_scene::Image;
use serde_json::Value;

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
            assert_eq!(of("data-backend"), Some("webgl2"), "{page:?}");
        }
    }
}

#[test]
fn a_browser_finds_levels_by_triangles_and_by_error_as_extract_does() {
    let Some(browser) = Browser::find() else { return };
    let f = Folder::new();
    // Objects of one shape at several scales: the common error asks for other levels of them than
    // the order over objects does.
    f.file("scene.gltf", scene(&[1.0, 4.0, 0.5], 12));
    for (input, counts) in [(PART, ["100", "9"]), ("scene.gltf", ["400", "97"])] {
        f.lodc(["build", input, "-o", "m.lodc", "-q"]).ends(0);
        f.lodc(["view", "m.lodc", "-o", "view.html", "-q"]).ends(0);
        let counts = counts.map(|count| ("triangles", count));
        for (key, value) in counts.into_iter().chain([("error", "0.5"), ("error", "0")]) {
            let option = format!("--{key}");
            let args = ["extract", "m.lodc", &option, value, "-o", "l.glb", "--json", "-q"];
            let report = f.lodc(args).ends(0).json();
            let page = browser.attributes(&f.join("view.html"), &format!("{key}={value}"));
            let what = format!("{input}: {key} {value}");
            assert_eq!(page["data-triangles"], report["triangles"].to_string(), "{what}");
            let objects = report["objects"].as_array().expect("objects");
            let lods: Vec<String> = objects.iter().map(|o| o["lod"].to_string()).collect();
            assert_eq!(page["data-lods"], lods.join(" "), "{what}");
        }
    }
}

#[test]
fn a_page_is_made_of_a_mesh_and_of_its_lodc_file_alike() {
    let f = Folder::new();
    let args = ["build", PART, "-o", "m.lodc", "--models", "interactive", "-q"];
    f.lodc(args).ends(0);
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

/// Shows levels in every way, and moves: logs what is said and how many pixels are covered.
const SHOWN: &str = r"
{
const pause = (delay) => scheduler.postTask(() => {}, { delay });
const page = document.documentElement.dataset;
setTimeout(() => console.log('done: no end'), 300000);

async function still(viewer) {
  do await pause(30); while (viewer.due);
}

function pixels(canvas) {
  const { width, height } = canvas;
  const copy = Object.assign(document.createElement('canvas'), { width, height });
  const context = copy.getContext('2d');
  context.drawImage(canvas, 0, 0);
  return context.getImageData(0, 0, width, height).data;
}

async function shown(viewer, changes) {
  viewer.set(changes);
  await still(viewer);
  const all = pixels(viewer.canvas);
  let [covered, sum] = [0, 0];
  for (let i = 0; i < all.length; i += 4) {
    if ([0, 1, 2].some((k) => Math.abs(all[i + k] - all[k]) > 24)) covered += 1;
    for (let k = 0; k < 3; k++) sum = (31 * sum + all[i + k]) % 1000003;
  }
  return { lod: page.lod, triangles: page.triangles, covered, sum };
}

async function moved(viewer) {
  viewer.motion.most = 50;
  viewer.orbit.turn(0.1, 0);
  const drawn = [];
  while (viewer.due) {
    await pause(1);
    drawn.push(Number(page.drawn));
  }
  await still(viewer);
  return { triangles: page.triangles, drawn: `${Math.min(...drawn)}`, after: page.drawn };
}

async function run() {
  while (!window.viewer) await pause(30);
  const { viewer } = window;
  const all = [];
  for (const lod of [0, 77, 999999]) all.push(await shown(viewer, { asked: { lod } }));
  for (const colouring of ['plain', 'error', 'strips', 'material']) {
    all.push(await shown(viewer, { asked: { lod: 200 }, colouring }));
  }
  all.push(await shown(viewer, { wire: true, flat: true }));
  all.push(await shown(viewer, { wire: false, asked: null, by: 'pixels', copies: 30 }));
  const moves = await moved(Object.assign(viewer, { copies: 1, by: 'triangles', share: 1 }));
  return JSON.stringify({ all, moves });
}

run().then((text) => console.log(`done: ${text}`), (e) => console.log(`done: ${e.stack}`));
}
";

#[test]
fn a_level_is_shown_in_every_way_and_less_of_it_while_it_moves() {
    let Some(browser) = Browser::find() else { return };
    let f = Folder::new();
    f.lodc(["build", PART, "-o", "m.lodc", "-q"]).ends(0);
    f.lodc(["view", "m.lodc", "-o", "view.html", "-q"]).ends(0);
    let page = String::from_utf8(f.read("view.html")).expect("a page is text");
    let (front, end) = page.rsplit_once("</script>").expect("a script");
    let page = f.file("shown.html", format!("{front}{SHOWN}</script>{end}"));
    let result = browser.result(&page);
    let result: Value = serde_json::from_str(&result).unwrap_or_else(|_| panic!("{result}"));
    let all = result["all"].as_array().expect("states");
    for (lod, shown) in ["0", "77", "999999"].iter().zip(all) {
        let (triangles, lod) = extracted(&f, lod);
        assert_eq!(shown["triangles"], triangles, "{shown}");
        assert_eq!(shown["lod"].as_str().map(str::to_owned), lod, "{shown}");
    }
    for (number, shown) in all.iter().enumerate() {
        let covered = shown["covered"].as_u64().expect("covered");
        assert!(number == 2 || covered > 10_000, "{number}: {shown}");
        // No way looks like another.
        let is_alike = |other: &&Value| other["sum"] == shown["sum"];
        assert_eq!(all.iter().filter(is_alike).count(), 1, "{number}: {result}");
    }
    let moves = &result["moves"];
    let number = |key: &str| moves[key].as_str().and_then(|n| n.parse::<u64>().ok());
    assert_eq!((number("triangles"), number("after")), (Some(480), Some(480)), "{moves}");
    assert!(number("drawn").is_some_and(|drawn| (1..480).contains(&drawn)), "{moves}");
}

/// Shows levels as exported, and at the end of the way to the next: logs what is said and differs.
const MORPHING: &str = r"
{
const pause = (delay) => scheduler.postTask(() => {}, { delay });
setTimeout(() => console.log('done: no end'), 300000);

async function shown(changes) {
  const { viewer } = window;
  viewer.set(changes);
  do await pause(30); while (viewer.due);
  const { width, height } = viewer.canvas;
  const canvas = Object.assign(document.createElement('canvas'), { width, height });
  const webgl = await WebglRenderer.create(canvas, viewer.scene);
  webgl.draw(viewer.shown);
  const copy = Object.assign(document.createElement('canvas'), { width, height });
  const context = copy.getContext('2d');
  context.drawImage(canvas, 0, 0);
  webgl.close();
  const { level, weight, triangles } = document.documentElement.dataset;
  return { level, weight, triangles, pixels: context.getImageData(0, 0, width, height).data };
}

function apart({ pixels: a }, { pixels: b }) {
  let count = 0;
  for (let i = 0; i < a.length; i += 4) {
    if ([0, 1, 2].some((k) => Math.abs(a[i + k] - b[k + i]) > 24)) count += 1;
  }
  return count;
}

async function run() {
  while (!window.viewer) await pause(30);
  const { viewer } = window;
  const { lods } = viewer;
  viewer.lods = () => {
    const chosen = lods.call(viewer);
    if (viewer.atEnd && viewer.morphs) viewer.scene.weight = 1;
    return chosen;
  };
  const levels = [];
  for (let k = 0; k < viewer.scene.chain.length; k++) {
    const begun = await shown({ asked: { lod: k } });
    const end = await shown({ asked: { lod: k + 0.5 }, atEnd: true });
    levels.push({ begun, end });
    viewer.atEnd = false;
  }
  const told = levels.map(({ begun, end }, k) => ({
    ...begun,
    pixels: undefined,
    way: k + 1 < levels.length ? apart(begun, levels[k + 1].begun) : 0,
    left: k + 1 < levels.length ? apart(end, levels[k + 1].begun) : 0,
  }));
  const far = { by: viewer.chain ? 'distance' : 'level', asked: null, share: 0 };
  const { level } = await shown(far);
  return JSON.stringify({ told, farthest: level });
}

run().then((text) => console.log(`done: ${text}`), (e) => console.log(`done: ${e.stack}`));
}
";

#[test]
fn levels_are_shown_as_they_are_shipped() {
    let Some(browser) = Browser::find() else { return };
    let tube = PART.replace("machine_part", "skinned_tube_u8");
    let morphing: &[&str] =
        &["--geomorph=joints", "--compress", "meshopt", "--quantize", "pos=14,normal=8,uv=12"];
    let variants: [(&str, &str, &[&str]); 4] = [
        (PART, "c.glb", &["--geomorph"]),
        (&tube, "c.gltf", morphing),
        (PART, "c.glb", &[]),
        (PART, "c.glb", &["--index-ranges"]),
    ];
    for (input, out, more) in variants {
        let f = Folder::new();
        let args = ["chain", input, "-o", out, "--auto", "4", "--json", "-q"];
        let chain = f.lodc(args.iter().chain(more)).ends(0).json();
        let run = f.lodc(["view", out, "-o", "view.html"]).ends(0);
        assert!(run.err.contains("4 levels as exported"), "{}", run.err);
        let page = String::from_utf8(f.read("view.html")).expect("a page is text");
        let (front, end) = page.rsplit_once("</script>").expect("a script");
        let page = f.file("morphing.html", format!("{front}{MORPHING}</script>{end}"));
        let result = browser.result(&page);
        let result: Value = serde_json::from_str(&result).unwrap_or_else(|_| panic!("{result}"));
        let morphs = more.iter().any(|o| o.starts_with("--geomorph"));
        let mut ways = 0;
        for (k, shown) in result["told"].as_array().expect("levels").iter().enumerate() {
            let what = format!("{input}, {more:?}, {k}: {shown}");
            assert_eq!(shown["level"], k.to_string(), "{what}");
            assert_eq!(shown["triangles"], chain["levels"][k]["triangles"].to_string(), "{what}");
            let [way, left] = ["way", "left"].map(|key| shown[key].as_u64().expect(key));
            // Edges may fall on other samples.
            assert!(!morphs || left <= 40 + way / 20, "{what}");
            ways += way;
        }
        assert!(ways > 50, "levels look different: {result}");
        assert_eq!(result["farthest"], "3", "{input}, {more:?}");
    }
}

#[test]
fn a_file_that_morphs_to_another_one_is_shown_and_a_level_alone_is_a_mesh() {
    let f = Folder::new();
    f.lodc(["chain", PART, "-o", "s.glb", "--auto", "3", "--separate", "--geomorph", "-q"]).ends(0);
    let run = f.lodc(["view", "s_LOD0.glb", "-o", "v.html", "--depfile", "d"]).ends(0);
    assert!(run.err.contains("1 level as exported"), "{}", run.err);
    assert!(String::from_utf8_lossy(&f.read("d")).contains("s_LOD0.glb"));
    f.lodc(["view", "s_LOD2.glb", "-o", "v.html", "-q"]).ends(0);
    f.lodc(["extract", PART, "--ratio", "50%", "-o", "l.obj", "-q"]).ends(0);
    f.lodc(["view", "l.obj", "-o", "v.html", "-q"]).ends(0);
    let Some(browser) = Browser::find() else { return };
    f.lodc(["view", "s_LOD0.glb", "-o", "v.html", "-q"]).ends(0);
    let page = browser.attributes(&f.join("v.html"), "lod=0.5");
    assert_eq!((&*page["data-level"], &*page["data-weight"]), ("0", "0.500"), "{page:?}");
}

#[cfg(all(unix, not(target_os = "macos")))]
#[test]
fn a_page_is_opened_if_that_is_asked_for() {
    use std::os::unix::fs::PermissionsExt;
    let f = Folder::new();
    f.file("grid.obj", grid(4));
    let opener =
        f.file("bin/xdg-open", "#!/bin/sh\necho \"$1\" > opened.part && mv opened.part opened\n");
    std::fs::set_permissions(&opener, PermissionsExt::from_mode(0o755)).expect("it can be run");
    let view = |folders: String| {
        let mut command = std::process::Command::new(crate::support::LODC);
        command.args(["view", "grid.obj", "-o", "page.html", "--open"]).env("PATH", folders);
        crate::support::Run::of(command.current_dir(f.path())).ends(0)
    };
    let path = std::env::var("PATH").unwrap_or_default();
    let run = view(format!("{}:{path}", f.join("bin").display()));
    assert!(run.err.ends_with("; opened in the browser\n"), "{}", run.err);
    let begun = std::time::Instant::now();
    while !f.has("opened") && begun.elapsed().as_secs() < 60 {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let opened = String::from_utf8(f.read("opened")).expect("a path");
    assert_eq!(
        opened.trim(),
        f.join("page.html").canonicalize().expect("it is there").display().to_string()
    );
    let run = view(f.join("none").display().to_string());
    assert!(run.err.contains("no browser was opened (xdg-open: "), "{}", run.err);
    f.lodc(["view", "grid.obj", "-o", "-", "--open"]).fails(2);
}
