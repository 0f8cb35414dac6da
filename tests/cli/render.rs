//! `lodc render`: pictures judged by what they show and where. One is compared with all its bytes
//! in `lodc-measure`.

use crate::support::{Folder, Run, grid, scene};
use lodc_formats::images::{decode, png};
use lodc_scene::Image;
use std::ffi::OsStr;

/// Runs the program, which draws.
#[track_caller]
fn render<S: AsRef<OsStr>>(f: &Folder, args: impl IntoIterator<Item = S>) -> Run {
    f.lodc(args).ends(0)
}

fn picture(f: &Folder, name: &str) -> Image {
    decode(&f.read(name)).expect("a picture")
}

fn at(picture: &Image, x: u32, y: u32) -> [u8; 4] {
    let start = 4 * (y * picture.width + x) as usize;
    std::array::from_fn(|c| picture.bytes[start + c])
}

/// Share of pixels that are not the white background.
fn covered(picture: &Image) -> f64 {
    let pixels = picture.bytes.as_chunks::<4>().0;
    pixels.iter().filter(|p| **p != [255; 4]).count() as f64 / pixels.len() as f64
}

/// A JPEG of 16 × 16 pixels whose quarters are red, green, blue and grey.
const QUARTERS: &[u8] = include_bytes!("quarters.jpg");

/// An upright square with a texture whose quarters are red, green, blue and grey.
fn textured(f: &Folder) {
    let quarters = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [90, 90, 90, 255]];
    let pixel = |i: usize| quarters[i / 8 / 4 * 2 + i % 8 / 4];
    let texture = Image { width: 8, height: 8, bytes: (0..64).flat_map(pixel).collect() };
    f.file("t.png", png(&texture));
    f.file("s.mtl", "newmtl m\nKd 1 1 1\nmap_Kd t.png\n");
    f.file(
        "s.obj",
        "mtllib s.mtl\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\n\
         vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3 4/4\n",
    );
}

#[test]
fn a_texture_is_upright_from_a_mesh_and_from_its_levels() {
    let f = Folder::new();
    textured(&f);
    f.lodc(["build", "s.obj", "-o", "s.lodc", "-q"]).ends(0);
    for input in ["s.obj", "s.lodc"] {
        let args =
            ["render", input, "-o", "s.png", "--view", "front", "--size", "80x80", "--fovy", "5"];
        render(&f, args);
        let p = picture(&f, "s.png");
        assert_eq!((p.width, p.height), (80, 80));
        // Light changes how bright a colour is, not which it is.
        let strongest = |x, y| {
            let [r, g, b, _] = at(&p, x, y);
            let top = r.max(g).max(b);
            (top > 100, [r, g, b].map(|c| c > top / 2 + 20))
        };
        assert_eq!(strongest(24, 24), (true, [true, false, false]), "{input}: upper left");
        assert_eq!(strongest(56, 24), (true, [false, true, false]), "{input}: upper right");
        assert_eq!(strongest(24, 56), (true, [false, false, true]), "{input}: lower left");
        let [r, g, b, _] = at(&p, 56, 56);
        assert!(r.abs_diff(g) < 12 && g.abs_diff(b) < 12, "{input}: lower right");
        assert!((0.8..0.9).contains(&covered(&p)), "{input}: {}", covered(&p));
    }
}

/// The eye is to the right of a wall that faces the front: seen from there its near end is larger.
#[test]
fn an_eye_draws_what_it_sees_and_a_side_what_the_eye_chose() {
    let f = Folder::new();
    f.file("g.obj", grid(24));
    let eye = [
        "render", "g.obj", "-o", "e.png", "--size", "200x200", "--eye", "40,12,12", "--fovy", "90",
        "-q",
    ];
    render(&f, eye);
    let p = picture(&f, "e.png");
    let height = |x: u32| (0..200).filter(|&y| at(&p, x, y) != [255; 4]).count();
    let columns: Vec<u32> = (0..200).filter(|&x| height(x) > 0).collect();
    let third = columns.len() / 3;
    let tallest = |columns: &[u32]| columns.iter().map(|&x| height(x)).max().unwrap_or(0);
    let (far, near) = (tallest(&columns[..third]), tallest(&columns[2 * third..]));
    assert!(near * 5 > far * 6, "{far} {near}");
    let view = ["--criterion", "pixels", "--contact-sheet", "0.5,0.25", "--view", "front"];
    for morph in [&[][..], &["--morph"]] {
        let run = f.lodc(eye.iter().filter(|a| **a != "-q").chain(&view).chain(morph)).ends(0);
        assert!(run.err.contains(", 25") || !morph.is_empty(), "{}", run.err);
        let p = picture(&f, "e.png");
        assert_eq!(p.width, 400);
        assert!(covered(&p) > 0.3, "{}", covered(&p));
    }
    f.lodc(["render", "g.obj", "-o", "e.png", "--criterion", "silhouette"]).fails(2);
    f.lodc(eye.iter().chain(&["--orthographic"])).fails(2);
    f.lodc(eye.iter().chain(&view[..2]).chain(&["--color", "strips"])).fails(2);
}

#[test]
fn a_jpeg_is_a_texture() {
    let f = Folder::new();
    textured(&f);
    f.file("t.jpg", QUARTERS);
    f.file("s.mtl", "newmtl m\nKd 1 1 1\nmap_Kd t.jpg\n");
    f.lodc(["build", "s.obj", "-o", "s.lodc", "-q"]).ends(0);
    for input in ["s.obj", "s.lodc"] {
        let args =
            ["render", input, "-o", "s.png", "--view", "front", "--size", "80x80", "--fovy", "5"];
        let run = render(&f, args);
        assert!(!run.err.contains("texture"), "{}", run.err);
        let p = picture(&f, "s.png");
        let strongest = |x, y| (0..3).max_by_key(|&c| at(&p, x, y)[c]);
        assert_eq!(
            [strongest(24, 24), strongest(56, 24), strongest(24, 56)],
            [Some(0), Some(1), Some(2)],
            "{input}"
        );
        let [r, g, b, _] = at(&p, 56, 56);
        assert!(r.abs_diff(g) < 12 && g.abs_diff(b) < 12 && r < 150, "{input}: lower right");
    }
}

#[test]
fn two_runs_write_the_same_bytes_whatever_the_threads() {
    let f = Folder::new();
    f.file("s.gltf", scene(&[1.0, 2.0], 6));
    let args = |out| {
        [
            "render",
            "s.gltf",
            "-o",
            out,
            "--contact-sheet",
            "1,0.5,0.1",
            "--size",
            "120x90",
            "--wireframe",
        ]
    };
    render(&f, args("a.png").into_iter().chain(["--jobs", "1"]));
    render(&f, args("b.png").into_iter().chain(["--jobs", "7"]));
    assert!(f.read("a.png") == f.read("b.png"));
}

#[test]
fn every_option_makes_a_picture_of_something() {
    let f = Folder::new();
    f.file("g.obj", grid(8));
    f.lodc(["build", "g.obj", "-o", "g.lodc", "-q"]).ends(0);
    let mut seen = Vec::new();
    for options in [
        &["--view", "top"][..],
        &["--view", "back", "--ratio", "0.3"],
        &["--azimuth", "-30", "--elevation", "40", "--shading", "flat"],
        &["--color", "plain", "--wireframe"],
        &["--color", "submesh", "--up", "z"],
        &["--color", "strips", "--triangles", "60"],
        &["--color", "error", "--ratio", "0.2"],
        &["--orthographic", "--zoom", "2", "--background", "#102030"],
        &["--lod", "30", "--back-faces", "mark"],
    ] {
        for input in ["g.obj", "g.lodc"] {
            let common = ["render", input, "-o", "o.png", "--size", "100x80"];
            render(&f, common.iter().chain(options));
            let p = picture(&f, "o.png");
            let background = at(&p, 0, 0);
            let drawn = p.bytes.as_chunks::<4>().0.iter().filter(|p| **p != background).count();
            assert!(drawn > 200, "{input} {options:?}: {drawn} pixels");
            seen.push(p);
        }
    }
    // Without levels of detail both inputs show the same triangles; the order in which they are
    // drawn may show in a few pixels at edges.
    let differ = |a: &Image, b: &Image| {
        a.bytes.iter().zip(&b.bytes).filter(|(a, b)| a.abs_diff(**b) > 2).count()
    };
    assert!(differ(&seen[0], &seen[1]) < seen[0].bytes.len() / 100);
    assert!(differ(&seen[0], &seen[2]) > seen[0].bytes.len() / 20);
}

#[test]
fn a_contact_sheet_has_one_picture_for_each_share_and_labels_below() {
    let f = Folder::new();
    f.file("g.obj", grid(10));
    let args = [
        "render",
        "g.obj",
        "-o",
        "s.png",
        "--contact-sheet",
        "1,0.5,0.2",
        "--size",
        "100x80",
        "--columns",
        "2",
    ];
    render(&f, args);
    let sheet = picture(&f, "s.png");
    assert_eq!(sheet.width, 200);
    let row = sheet.height / 2;
    assert!(row > 80 + 18, "{row} rows hold a picture and its label");
    let dark = |left: u32, top: u32, width: u32, height: u32| {
        let all = (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y)));
        all.filter(|&(x, y)| at(&sheet, x, y) != [255; 4]).count()
    };
    for (left, top) in [(0, 0), (100, 0), (0, row)] {
        assert!(dark(left, top, 100, 80) > 500, "a picture at ({left}, {top})");
        assert!(dark(left, top + 80, 100, row - 80) > 50, "a label at ({left}, {})", top + 80);
    }
    assert_eq!(dark(100, row, 100, row), 0, "the place of a fourth");
}

#[test]
fn nodes_place_objects_as_the_scene_says() {
    let f = Folder::new();
    // Two grids beside each other, the right one three times as large.
    f.file("s.gltf", scene(&[1.0, 3.0], 5));
    let args = [
        "render",
        "s.gltf",
        "-o",
        "s.png",
        "--view",
        "front",
        "--size",
        "200x100",
        "--orthographic",
    ];
    render(&f, args.into_iter().chain(["--back-faces", "show"]));
    let p = picture(&f, "s.png");
    let columns = |from: u32, to: u32| {
        (from..to).filter(|&x| (0..p.height).any(|y| at(&p, x, y) != [255; 4])).count() as f64
    };
    let (left, right) = (columns(0, 80), columns(80, 200));
    assert!(left > 10.0 && (2.5..3.5).contains(&(right / left)), "{left} and {right} columns");
}

#[test]
fn an_empty_mesh_is_an_empty_picture() {
    let f = Folder::new();
    f.file("e.obj", "v 0 0 0\nf 1 1 1\n");
    render(&f, ["render", "e.obj", "-o", "e.png", "--size", "20x20", "--background", "#010203"]);
    assert!(picture(&f, "e.png").bytes.as_chunks::<4>().0.iter().all(|p| *p == [1, 2, 3, 255]));
}

#[test]
fn a_stream_works_both_ways() {
    let f = Folder::new();
    let run = f.lodc_with(
        ["render", "-", "-o", "-", "--size", "32x32", "--background", "transparent"],
        grid(3).as_bytes(),
    );
    let run = run.ends(0);
    let p = decode(&run.out).expect("a picture");
    assert_eq!((p.width, at(&p, 0, 0)), (32, [0; 4]));
    assert!(p.bytes.as_chunks::<4>().0.iter().any(|p| p[3] == 255));
}

#[test]
fn nonsense_and_failures_are_one_line_and_leave_what_was_there() {
    let f = Folder::new();
    f.file("g.obj", grid(2));
    f.file("old.png", "kept");
    for args in [
        &["--size", "0x5"][..],
        &["--view", "inside"],
        &["--view", "top", "--azimuth", "3"],
        &["--ratio", "2"],
        &["--ratio", "0.5", "--contact-sheet", "1"],
        &["--contact-sheet", "1.5"],
        &["--columns", "2"],
        &["--zoom", "0"],
        &["--background", "red"],
        &["--fovy", "5", "--orthographic"],
        &["--color", "error", "--wireframe"],
    ] {
        f.lodc(["render", "g.obj", "-o", "old.png"].iter().chain(args)).ends(2);
    }
    f.lodc(["render", "g.obj", "-o", "g.obj"]).fails(2);
    f.lodc(["render", "g.obj", "-o", "not/there.png"]).fails(4);
    f.lodc(["render", "missing.obj", "-o", "old.png"]).fails(3);
    f.file("broken.lodc", b"\x89LODC and nothing more");
    f.lodc(["render", "broken.lodc", "-o", "old.png"]).fails(3);
    assert_eq!(f.read("old.png"), b"kept");
}

#[test]
fn colours_of_vertices_look_like_the_same_colour_of_a_material() {
    let f = Folder::new();
    let painted = |line: &str| match line.starts_with("v ") {
        true => format!("{line} 0.5 0.25 0.75\n"),
        false => format!("{line}\n"),
    };
    f.file("painted.obj", grid(8).lines().map(painted).collect::<String>());
    f.file("kd.mtl", "newmtl m\nKd 0.5 0.25 0.75\n");
    f.file("kd.obj", format!("mtllib kd.mtl\nusemtl m\n{}", grid(8)));
    f.lodc(["extract", "painted.obj", "--lod", "0", "-o", "painted.glb"]).ends(0);
    f.lodc(["extract", "painted.obj", "--lod", "0", "-o", "painted.ply"]).ends(0);
    f.lodc(["build", "painted.obj", "-o", "painted.lodc"]).ends(0);
    let drawn = |input: &str| {
        let common = ["render", input, "-o", "o.png", "--size", "80x60", "--view", "front"];
        render(&f, common.iter().chain(&["--orthographic"]));
        picture(&f, "o.png").bytes
    };
    let expected = drawn("kd.obj");
    for input in ["painted.obj", "painted.glb", "painted.ply", "painted.lodc"] {
        let found = drawn(input);
        let off = found.iter().zip(&expected).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(off <= Some(2), "{input}: off by {off:?}");
    }
}
