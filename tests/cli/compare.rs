//! `lodc compare`: numbers for scripts, limits for pipelines, pictures for people.

use crate::support::{Folder, grid};
use lodc_formats::images::png;
use lodc_scene::Image;

/// The grid, lifted.
fn lifted(n: usize, by: &str) -> String {
    let lift = |line: &str| match line.strip_prefix("v ") {
        Some(rest) => {
            let mut numbers: Vec<&str> = rest.split(' ').collect();
            numbers[2] = by;
            format!("v {}\n", numbers.join(" "))
        }
        None => format!("{line}\n"),
    };
    grid(n).lines().map(lift).collect()
}

#[test]
fn numbers_and_exit_statuses_are_those_of_the_distance() {
    let f = Folder::new();
    f.file("a.obj", lifted(4, "0"));
    f.file("b.obj", lifted(4, "0.125"));
    let json = f
        .lodc(["compare", "a.obj", "b.obj", "--json", "--views", "6", "--size", "64"])
        .ends(0)
        .json();
    for (kind, key) in
        [("rms", "a_to_b"), ("rms", "b_to_a"), ("hausdorff", "max"), ("hausdorff", "mean")]
    {
        let found = json[kind][key].as_f64().expect("a number");
        assert!((found - 0.125).abs() < 1e-9, "{kind} {key}: {found}");
    }
    assert_eq!(json["image"]["views"], 6);
    assert!(json["image"]["silhouette"].as_f64().is_some_and(|s| s > 0.0 && s < 1.0));
    for (limit, status) in [("0.13", 0), ("0.12", 1)] {
        f.lodc(["compare", "a.obj", "b.obj", "--views", "0", "--max-rms", limit]).ends(status);
        f.lodc(["compare", "a.obj", "b.obj", "--views", "0", "--max-hausdorff", limit])
            .ends(status);
    }
    f.lodc([
        "compare",
        "a.obj",
        "a.obj",
        "--max-image-rmse",
        "0",
        "--max-rms",
        "0%",
        "--size",
        "64",
    ])
    .ends(0);
    f.lodc(["compare", "a.obj", "b.obj", "--max-image-rmse", "0.001", "--size", "64"]).ends(1);
}

#[test]
fn what_was_built_and_taken_out_again_is_the_same_and_coarser_is_worse() {
    let f = Folder::new();
    f.file("a.obj", grid(12));
    f.lodc(["build", "a.obj", "-o", "a.lodc", "--models", "interactive", "--metric", "hybrid"])
        .ends(0);
    f.lodc(["extract", "a.lodc", "--lod", "0", "-o", "same.glb"]).ends(0);
    f.lodc([
        "compare",
        "a.obj",
        "same.glb",
        "--max-hausdorff",
        "1e-6%",
        "--views",
        "2",
        "--size",
        "64",
    ])
    .ends(0);
}

#[test]
fn the_heatmap_is_a_png_and_the_rest_is_refused_in_one_line() {
    let f = Folder::new();
    f.file("a.obj", grid(3));
    f.file("points.obj", "v 0 0 0\n");
    f.lodc(["compare", "a.obj", "a.obj", "--heatmap", "h.png", "--views", "0"]).ends(0);
    assert!(f.read("h.png").starts_with(b"\x89PNG\r\n\x1a\n"));
    f.lodc(["compare", "a.obj", "points.obj"]).fails(3);
    f.lodc(["compare", "a.obj", "b.obj"]).fails(3);
    for wrong in
        [["--max-rms", "-1"], ["--max-rms", "nan"], ["--heatmap", "a.obj"], ["--size", "4"]]
    {
        f.lodc(["compare", "a.obj", "a.obj"].into_iter().chain(wrong)).ends(2);
    }
    f.lodc(["compare", "-", "-"]).fails(2);
}

#[test]
fn limits_are_those_of_either_folder_and_need_what_they_judge() {
    let f = Folder::new();
    f.file("models/a.obj", grid(12));
    f.lodc(["build", "models", "-o", "levels", "-q"]).ends(0);
    let compare = ["compare", "models", "levels", "--levels", "10%", "--views", "0"];
    f.lodc(compare).ends(0);
    for folder in ["models", "levels"] {
        let config = format!("{folder}/lodc.toml");
        f.file(&config, "[defaults.compare]\nmax-rms = \"0.0001%\"\n");
        f.lodc(compare).ends(1);
        std::fs::remove_file(f.join(&config)).expect("it is there");
    }
    let judged = ["--max-image-rmse", "1"];
    f.lodc(compare.iter().chain(&judged)).fails(2);
    f.lodc(["compare", "models", "levels", "--max-image-rmse", "300"]).fails(2);
}

/// A square of two triangles, each with a colour of its own by its vertices or by its material.
fn two_colours(vertices: [&str; 2], materials: [&str; 2]) -> String {
    let corners = |colour: &str| format!("v 0 0 0 {colour}\nv 4 4 0 {colour}\n");
    let [first, second] = vertices.map(corners);
    let [one, two] = materials;
    format!(
        "mtllib k.mtl\n{first}v 4 0 0 {}\n{second}v 0 4 0 {}\n{one}\nf 1 3 2\n{two}\nf 4 5 6\n",
        vertices[0], vertices[1]
    )
}

#[test]
fn colours_of_vertices_and_of_materials_are_compared() {
    let f = Folder::new();
    let grey = "0.5 0.5 0.5";
    f.file("k.mtl", "newmtl grey\nKd 0.5 0.5 0.5\nnewmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n");
    let (red, blue) = ("1 0 0", "0 0 1");
    f.file("red_blue.obj", two_colours([red, blue], [""; 2]));
    f.file("blue_red.obj", two_colours([blue, red], [""; 2]));
    f.file("kd_red_blue.obj", two_colours([""; 2], ["usemtl red", "usemtl blue"]));
    f.file("kd_blue_red.obj", two_colours([""; 2], ["usemtl blue", "usemtl red"]));
    f.file("kd_blue.obj", two_colours([""; 2], ["usemtl blue"; 2]));
    f.file("plain.obj", two_colours([""; 2], [""; 2]));
    f.file("grey.obj", two_colours([grey; 2], [""; 2]));
    let image = |a: &str, b: &str| {
        let all = ["compare", a, b, "--json", "--views", "6", "--size", "64", "--samples", "100"];
        f.lodc(all).ends(0).json()["image"].clone()
    };
    let rmse = |a: &str, b: &str| image(a, b)["rmse"].as_f64().expect("a number");
    for [a, b] in [["red_blue.obj", "blue_red.obj"], ["kd_red_blue.obj", "kd_blue_red.obj"]] {
        assert_eq!(rmse(a, a), 0.0);
        assert!(rmse(a, b) > 60.0, "{a} {b}: {}", rmse(a, b));
    }
    assert_eq!(image("red_blue.obj", "grey.obj")["vertex_colors"], true);
    // One material is left of two: it has been seen to change.
    assert!(rmse("kd_red_blue.obj", "kd_blue.obj") > 40.0);
    // What only one of two has is left out.
    for a in ["red_blue.obj", "kd_red_blue.obj"] {
        assert_eq!(rmse(a, "plain.obj"), 0.0, "{a}");
    }
    // Every format shows the same.
    for name in ["same.glb", "same.ply"] {
        f.lodc(["extract", "red_blue.obj", "--lod", "0", "-o", name]).ends(0);
        assert!(rmse("red_blue.obj", name) < 0.5, "{name}");
    }
}

/// A square whose texture is striped red and green, which are equally bright, moved by a share of
/// its width.
fn striped(f: &Folder, name: &str, shift: f64) {
    f.file(&format!("{name}.mtl"), "newmtl m\nKd 1 1 1\nmap_Kd t.png\n");
    let [left, right] = [shift, 1.0 + shift];
    let text = format!(
        "mtllib {name}.mtl\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\n\
         vt {left} 0\nvt {right} 0\nvt {right} 1\nvt {left} 1\nusemtl m\nf 1/1 2/2 3/3 4/4\n"
    );
    f.file(&format!("{name}.obj"), text);
}

#[test]
fn a_texture_that_has_moved_is_seen() {
    let f = Folder::new();
    let stripe = |i: usize| {
        if (i % 16 / 4).is_multiple_of(2) { [200, 30, 30, 255] } else { [30, 200, 30, 255] }
    };
    f.file(
        "t.png",
        png(&Image { width: 16, height: 16, bytes: (0..256).flat_map(stripe).collect() }),
    );
    for (name, shift) in [("a", 0.0), ("moved", 0.25), ("period", 0.5)] {
        striped(&f, name, shift);
    }
    f.file("plain.obj", "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nf 1 2 3 4\n");
    let image = |b: &str, more: &[&str]| {
        let all =
            ["compare", "a.obj", b, "--json", "--views", "6", "--size", "64", "--samples", "100"];
        f.lodc(all.into_iter().chain(more.iter().copied())).ends(0).json()["image"].clone()
    };
    let rmse = |image: &serde_json::Value| image["rmse"].as_f64().expect("a number");
    assert_eq!(image("moved.obj", &[])["textures"], true);
    // All stripes have changed places: two of three channels differ by up to 170.
    assert!(rmse(&image("moved.obj", &[])) > 40.0);
    assert!(rmse(&image("period.obj", &[])) < 0.5);
    assert_eq!(rmse(&image("a.obj", &[])), 0.0);
    assert_eq!(rmse(&image("moved.obj", &["--no-attributes"])), 0.0);
    let plain = image("plain.obj", &[]);
    assert_eq!(
        (rmse(&plain), &plain["textures"], &plain["texture"]),
        (0.0, &false.into(), &false.into())
    );
    f.lodc([
        "compare",
        "a.obj",
        "moved.obj",
        "--max-image-rmse",
        "40",
        "--size",
        "64",
        "--heatmap",
        "h.png",
    ])
    .ends(1);
    // Without the picture there is a checkerboard again.
    std::fs::remove_file(f.path().join("t.png")).expect("it is there");
    let board = image("moved.obj", &[]);
    assert_eq!((&board["textures"], &board["texture"]), (&false.into(), &true.into()));
}

#[test]
fn the_checkerboard_is_the_same_in_every_format() {
    let f = Folder::new();
    f.file("t.png", png(&Image { width: 1, height: 1, bytes: vec![255; 4] }));
    striped(&f, "a", 0.3);
    let written: [(&str, &[&str]); 3] =
        [("a.glb", &[]), ("grid.glb", &["--quantize", "uv=12"]), ("again.obj", &[])];
    for (name, more) in written {
        let all = ["extract", "a.obj", "--ratio", "1", "--textures", "keep", "-o", name];
        f.lodc(all.into_iter().chain(more.iter().copied())).ends(0);
    }
    // The image is lost, what it read the coordinates by is not.
    std::fs::remove_file(f.path().join("t.png")).expect("it is there");
    for (name, _) in written {
        let image = f
            .lodc(["compare", "a.obj", name, "--json", "--views", "6", "--size", "64"])
            .ends(0)
            .json()["image"]
            .clone();
        assert_eq!(image["texture"], true, "{name}");
        assert!(image["rmse"].as_f64().expect("a number") < 5.0, "{name}: {image}");
    }
}
