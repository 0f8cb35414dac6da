//! Weights, locks and paint: what is locked stays, what matters keeps triangles, and a wrong name
//! lists the right ones.

use crate::support::{Folder, grid};
use lodc_formats::images::png;
use lodc_scene::Image;
use std::f32::consts::TAU;
use std::fmt::Write;

/// Two grids side by side, of materials of their own.
fn two_materials() -> String {
    let mut text = format!("mtllib m.mtl\no plate\nusemtl keep\n{}", grid(12));
    let vertices = 13 * 13;
    for line in grid(12).lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["v", x, y, z] => {
                let x: f64 = x.parse().expect("a number");
                writeln!(text, "v {} {y} {z}", x + 100.0).expect("text");
            }
            ["f", ..] => {
                let corner = |c: &&str| c.parse::<u32>().expect("a number") + vertices;
                let corners: Vec<String> =
                    words[1..].iter().map(|c| corner(c).to_string()).collect();
                writeln!(text, "f {}", corners.join(" ")).expect("text");
            }
            _ => {}
        }
        if text.ends_with('\n') && line.starts_with("f ") && !text.contains("usemtl rest") {
            let at = text.rfind("f ").expect("a face");
            text.insert_str(at, "usemtl rest\n");
        }
    }
    text
}

/// Faces of an OBJ by material.
fn faces(f: &Folder, name: &str) -> [usize; 2] {
    let text = String::from_utf8(f.read(name)).expect("text");
    let (mut counts, mut at) = ([0; 2], 0);
    for line in text.lines() {
        match line {
            "usemtl keep" => at = 0,
            "usemtl rest" => at = 1,
            l if l.starts_with("f ") => counts[at] += 1,
            _ => {}
        }
    }
    counts
}

#[test]
fn a_locked_material_stays_and_the_rest_pays() {
    let f = Folder::new();
    f.file("m.mtl", "newmtl keep\nnewmtl rest\n");
    f.file("m.obj", two_materials());
    let quadric = ["--metric", "quadric"];
    let args = ["extract", "m.obj", "-o", "o.obj", "--ratio", "60%", "-q", quadric[0], quadric[1]];
    f.lodc(args).ends(0);
    let free = faces(&f, "o.obj");
    assert!(free[0] < 288, "{free:?}");
    f.lodc(args.iter().chain(&["--lock", "material:keep"])).ends(0);
    let locked = faces(&f, "o.obj");
    assert_eq!(locked[0], 288);
    assert!(locked[1] < free[1] && locked[1] > 0, "{locked:?} {free:?}");
    let part = ["--part", r#"{"materials": ["ke*"], "lock": true}"#];
    f.lodc(args.iter().chain(&part)).ends(0);
    assert_eq!(faces(&f, "o.obj"), locked, "as by name");
    f.file("lodc.toml", "[[override]]\nmaterials = [\"keep\"]\nlock = true\n");
    f.lodc(args).ends(0);
    assert_eq!(faces(&f, "o.obj"), locked, "as by configuration");
    // A file that was built so has it, too.
    let build = ["build", "m.obj", "-o", "m.lodc", "--lock", "material:keep", "-q"];
    f.lodc(build.iter().chain(&quadric)).ends(0);
    f.lodc(["verify", "m.lodc", "--source", "m.obj", "-q"]).ends(0);
    f.lodc(["extract", "m.lodc", "-o", "o.obj", "--ratio", "60%", "-q"]).ends(0);
    assert_eq!(faces(&f, "o.obj"), locked);
    let run = f.lodc(["extract", "m.lodc", "-o", "o.obj", "--ratio", "1", "--lock", "color"]);
    assert!(run.fails(2).err.contains("build"));
}

/// Two flat grids side by side, of materials of their own, whose texture is pulled out of shape in
/// the same way: all that a collapse costs is what the texture shifts.
fn two_textures() -> String {
    const SIDE: u32 = 12;
    let mut text = "mtllib m.mtl\no plate\n".to_owned();
    for plate in 0..2 {
        for (y, x) in (0..=SIDE).flat_map(|y| (0..=SIDE).map(move |x| (y, x))) {
            let pulled = f64::from(x * x % 7 + y * y % 5) / 20.0;
            let (u, v) = (f64::from(x) / 12.0 + pulled, f64::from(y) / 12.0 - pulled);
            writeln!(text, "v {} {y} 0\nvt {u} {v}", x + 100 * plate).expect("text");
        }
    }
    for (plate, material) in [(0, "keep"), (1, "rest")] {
        writeln!(text, "usemtl {material}").expect("text");
        for (y, x) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (y, x))) {
            let corner = |dx: u32, dy: u32| {
                let n = 169 * plate + (SIDE + 1) * (y + dy) + x + dx + 1;
                format!("{n}/{n}")
            };
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").expect("text");
        }
    }
    text
}

#[test]
fn a_material_has_weights_of_its_own() {
    let f = Folder::new();
    f.file("m.mtl", "newmtl keep\nnewmtl rest\n");
    f.file("m.obj", two_textures());
    let with = |more: &[&str]| {
        let args = ["extract", "m.obj", "-o", "o.obj", "--ratio", "55%", "--metric", "quadric"];
        f.lodc(args.iter().chain(&["-q"]).chain(more)).ends(0);
        (faces(&f, "o.obj"), f.read("o.obj"))
    };
    let (even, plain) = with(&[]);
    assert!(even[0].abs_diff(even[1]) < 40, "{even:?}");
    // The whole of the one plate is flat and of no account; nothing of the other has to go.
    let part = r#"{"materials": ["rest"], "weight": "uv=0"}"#;
    let (own, bytes) = with(&["--part", part]);
    assert!(own[0] == 288 && own[1] < 40, "{own:?}");
    // A weight of 1 is what every material has.
    assert_eq!(with(&["--part", r#"{"materials": ["rest"], "weight": "uv=1"}"#]).1, plain);
    // The last part that names a material counts, be it by the object.
    assert_eq!(
        with(&["--part", part, "--part", r#"{"objects": ["*"], "weight": "uv=1"}"#]).1,
        plain
    );
    f.file("lodc.toml", "[[override]]\nmaterials = [\"re*\"]\nweight = \"uv=0\"\n");
    assert_eq!(with(&[]).1, bytes, "as by configuration");
    let shown = f.lodc(["config", "--show", "m.obj"]).ends(0).text();
    let line =
        r#"extract --part '{"weight":"uv=0","materials":["re*"]}' # lodc.toml [[override]] 1"#;
    assert!(shown.contains(line), "{shown}");
    f.file("lodc.toml", "");
    f.lodc(["build", "m.obj", "-o", "m.lodc", "--part", part, "-q"]).ends(0);
    f.lodc(["verify", "m.lodc", "--source", "m.obj", "-q"]).ends(0);
    f.lodc(["extract", "m.lodc", "-o", "o.obj", "--ratio", "55%", "-q"]).ends(0);
    assert_eq!(faces(&f, "o.obj"), own);
    let late = f.lodc(["extract", "m.lodc", "-o", "o.obj", "--ratio", "1", "--part", part]);
    assert!(late.fails(2).err.contains("belong to `lodc build`"));
}

#[test]
fn a_part_that_is_not_there_lists_those_that_are() {
    let f = Folder::new();
    f.file("m.mtl", "newmtl keep\nnewmtl rest\n");
    f.file("m.obj", two_materials());
    let fails =
        |part: &str| f.lodc(["build", "m.obj", "-o", "m.lodc", "--part", part]).fails(2).err;
    let wrong = fails(r#"{"materials": ["kept"], "weight": "uv=0"}"#);
    assert!(wrong.contains("no material is named kept (there are: keep, rest)"), "{wrong}");
    let wrong = fails(r#"{"objects": ["wheel"], "lock": true}"#);
    assert!(wrong.contains("no object is named wheel (there are: "), "{wrong}");
    // A configuration is for many assets: not each has to have the part.
    f.file("lodc.toml", "[[override]]\nmaterials = [\"kept\"]\nweight = \"uv=0\"\n");
    f.lodc(["build", "m.obj", "-o", "m.lodc", "-q"]).ends(0);
}

#[test]
fn a_wrong_name_lists_the_right_ones() {
    let f = Folder::new();
    f.file("m.mtl", "newmtl keep\nnewmtl rest\n");
    f.file("m.obj", two_materials());
    let fails =
        |lock: &str| f.lodc(["build", "m.obj", "-o", "m.lodc", "--lock", lock]).fails(2).err;
    assert!(fails("material:kept").contains("there are: keep, rest"));
    assert!(fails("node:wheel").contains("there are: "));
    assert!(fails("color").contains("red is 1"));
    assert!(!f.has("m.lodc"));
    let run = f.lodc(["build", "m.obj", "--weight", "size=2"]).ends(2);
    assert!(run.err.contains("not one of normal, uv, color, skin, morph"), "{}", run.err);
}

#[test]
fn coloured_vertices_stay() {
    let f = Folder::new();
    let coloured: String = (grid(10).lines())
        .map(|line| match line.strip_prefix("v ") {
            Some(place) => {
                let number = |i| place.split_whitespace().nth(i).and_then(|n: &str| n.parse().ok());
                let near = |i| number(i).is_some_and(|v: f64| (4.0..=6.0).contains(&v));
                format!("v {place} {} 0 0\n", u8::from(near(0) && near(1)))
            }
            None => format!("{line}\n"),
        })
        .collect();
    let red =
        |text: &str| text.lines().filter(|l| l.starts_with("v ") && l.ends_with(" 1 0 0")).count();
    let all = red(&coloured);
    assert!(all >= 4, "{coloured}");
    f.file("g.obj", &coloured);
    let args = ["extract", "g.obj", "-o", "o.obj", "--ratio", "30%", "--weight", "color=0", "-q"];
    f.lodc(args.iter().chain(&["--lock", "color"])).ends(0);
    assert_eq!(red(&String::from_utf8(f.read("o.obj")).expect("text")), all);
}

/// Columns of a ball, and texels of its map.
const COLUMNS: u32 = 32;

/// A ball whose western half is white, and black its eastern; with texture coordinates whose
/// columns are texels.
fn painted_ball() -> String {
    let (mut text, rows) = (String::new(), 16);
    for row in 0..=rows {
        for column in 0..=COLUMNS {
            let (around, down) = (column as f32 / COLUMNS as f32, row as f32 / rows as f32);
            let (radius, angle) = ((down * TAU / 2.0).sin(), around * TAU);
            let [x, y, z] = [radius * angle.cos(), (down * TAU / 2.0).cos(), radius * angle.sin()];
            let grey = paint(column % COLUMNS);
            writeln!(text, "v {x} {y} {z} {grey} {grey} {grey}").expect("text");
            writeln!(text, "vt {} {down}", around + 0.5 / COLUMNS as f32).expect("text");
        }
    }
    for row in 0..rows {
        for column in 0..COLUMNS {
            let a = row * (COLUMNS + 1) + column + 1;
            let (b, c, d) = (a + 1, a + COLUMNS + 1, a + COLUMNS + 2);
            writeln!(text, "f {a}/{a} {b}/{b} {d}/{d}\nf {a}/{a} {d}/{d} {c}/{c}").expect("text");
        }
    }
    text
}

/// The grey of a column.
fn paint(column: u32) -> u32 {
    u32::from((COLUMNS / 4..3 * COLUMNS / 4).contains(&column))
}

/// Faces of an OBJ by the side that they lie on: east (no paint), west.
fn faces_by_side(obj: &[u8]) -> [usize; 2] {
    let text = str::from_utf8(obj).expect("text");
    let numbers = |line: &str| -> Vec<f32> {
        let words = line.split_whitespace().skip(1);
        words.filter_map(|w| w.split('/').next()?.parse().ok()).collect()
    };
    let lines = |start: &'static str| text.lines().filter(move |l| l.starts_with(start));
    let across: Vec<f32> = lines("v ").map(|line| numbers(line)[0]).collect();
    let mut counts = [0; 2];
    for face in lines("f ") {
        let sum: f32 = numbers(face).iter().map(|&v| across[v as usize - 1]).sum();
        counts[usize::from(sum < 0.0)] += 1;
    }
    counts
}

#[test]
fn what_is_painted_keeps_its_triangles() {
    let f = Folder::new();
    f.file("ball.obj", painted_ball());
    let texel = |column| [255 * paint(column) as u8; 3].into_iter().chain([255]);
    let bytes = (0..COLUMNS).flat_map(texel).collect();
    f.file("map.png", png(&Image { width: COLUMNS, height: 1, bytes }));
    let extracted = |more: &[&str]| {
        let args = ["extract", "ball.obj", "-o", "o.obj", "--ratio", "15%", "--no-refit", "-q"];
        f.lodc(args.iter().chain(&["--weight", "color=0"]).chain(more)).ends(0);
        f.read("o.obj")
    };
    let [east, west] = faces_by_side(&extracted(&[]));
    assert!(east * 3 < west * 4 && west * 3 < east * 4, "{east} {west}");
    let painted = extracted(&["--importance", "COLOR_0"]);
    let [east, west] = faces_by_side(&painted);
    assert!(west > 6 * east, "{east} {west}");
    assert!(painted == extracted(&["--importance", "COLOR_0", "--jobs", "3"]));
    assert!(painted == extracted(&["--importance", "map.png"]), "a map says the same");
    for metric in ["hybrid", "viewpoint"] {
        let more = ["--importance", "COLOR_0", "--metric", metric];
        let [east, west] = faces_by_side(&extracted(&more));
        assert!(west > 2 * east, "{metric}: {east} {west}");
    }
    f.file("lodc.toml", "[defaults]\nimportance = \"COLOR_0\"\n");
    assert!(painted == extracted(&[]), "as by configuration");
    // Errors that a file states still hold.
    let build = ["build", "ball.obj", "-o", "b.lodc", "--if-changed", "--models", "none"];
    f.lodc(build.iter().chain(&["--importance", "map.png"])).ends(0);
    f.lodc(["verify", "b.lodc", "--source", "ball.obj", "-q"]).ends(0);
    let again = f.lodc(build.iter().chain(&["--importance", "map.png"])).ends(0).err;
    assert!(!again.contains("KiB in"), "it is up to date: {again}");
    f.file("map.png", png(&Image::filled(1, 1, [9; 4])));
    let other = f.lodc(build.iter().chain(&["--importance", "map.png"])).ends(0).err;
    assert!(other.contains("KiB in"), "the map belongs to the input: {other}");
}

#[test]
fn paint_that_is_not_there_is_refused_in_a_line() {
    let f = Folder::new();
    f.file("ball.obj", painted_ball());
    f.file("plain.obj", grid(4));
    f.file("not.png", "no picture");
    let fails = |status, input: &str, paint: &str| {
        let args = ["build", input, "-o", "o.lodc", "--importance", paint];
        f.lodc(args).fails(status).err
    };
    let wrong = fails(2, "ball.obj", "_FACE");
    assert!(wrong.contains("no object has the attribute _FACE"), "{wrong}");
    assert!(wrong.contains("(there are: COLOR_0)"), "{wrong}");
    let wrong = fails(2, "plain.obj", "COLOR_0");
    assert!(wrong.contains("(there is none)"), "{wrong}");
    let wrong = fails(3, "ball.obj", "missing.png");
    assert!(wrong.contains("missing.png"), "{wrong}");
    let wrong = fails(3, "ball.obj", "not.png");
    assert!(wrong.contains("not.png"), "{wrong}");
    f.file("map.png", png(&Image::filled(1, 1, [255; 4])));
    let wrong = fails(2, "plain.obj", "map.png");
    assert!(wrong.contains("no object has texture coordinates"), "{wrong}");
    f.lodc(["build", "plain.obj", "-o", "p.lodc", "-q"]).ends(0);
    let args = ["extract", "p.lodc", "-o", "o.obj", "--ratio", "1", "--importance", "COLOR_0"];
    assert!(f.lodc(args).fails(2).err.contains("belong to `lodc build`"));
}
