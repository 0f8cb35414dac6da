//! Points and lines: passed through where there are triangles, refused by name where there are
//! none.

use crate::support::{Folder, glb_document, grid};
use serde_json::Value;

#[test]
fn what_has_no_face_is_refused_by_what_it_is() {
    let f = Folder::new();
    let ply = |properties: &str, rest: &str| {
        format!("ply\nformat ascii 1.0\nelement vertex 3\n{properties}{rest}end_header\n")
    };
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let splat = format!("{xyz}property float f_dc_0\nproperty float rot_0\n");
    let no_faces = "element face 0\nproperty list uchar int vertex_indices\n";
    for (name, text, expected) in [
        ("cloud.ply", ply(xyz, "") + "0 0 0\n1 0 0\n0 1 0\n", "a point cloud, not a mesh: 3 vert"),
        ("empty.ply", ply(xyz, no_faces) + "0 0 0\n1 0 0\n0 1 0\n", "a point cloud"),
        ("splat.ply", ply(&splat, "") + &"0 0 0 1 1\n".repeat(3), "a Gaussian splat, not a mesh"),
        ("cloud.obj", "v 0 0 0\nv 1 0 0\np 1 2\n".to_owned(), "a point cloud, not a mesh: 2 vert"),
        ("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n".to_owned(), "lines, not a mesh: 2 vertices"),
        ("notes.txt", "shopping list\ng milk\nbread\n".to_owned(), "not a mesh"),
        ("notes.obj", "dear reader\no well\nhello\n".to_owned(), "not a mesh"),
    ] {
        f.file(name, text);
        for command in ["build", "extract", "chain"] {
            let level: &[&str] = if command == "extract" { &["--lod", "0"] } else { &[] };
            let out = if command == "build" { "o.lodc" } else { "o.glb" };
            let args = [command, name, "-o", out];
            let run = f.lodc(args.iter().chain(level)).fails(3);
            assert!(run.err.contains(expected) && run.err.contains(name), "{name}: {}", run.err);
        }
    }
}

/// An OBJ with triangles, a line of three vertices and two points.
fn mixed() -> String {
    let extra = "v 100 0 0\nv 101 0.5 0\nv 102 0 0\nv 103 0 7\nl -4 -3 -2\np 84 85\n";
    format!("{}{extra}", grid(8))
}

/// Ends of the lines and points of an OBJ, by position.
fn elements(obj: &str) -> Vec<String> {
    let vertices: Vec<&str> = obj.lines().filter_map(|l| l.strip_prefix("v ")).collect();
    let mut count = 0i64;
    let mut found = Vec::new();
    for line in obj.lines() {
        count += i64::from(line.starts_with("v "));
        let Some((word @ ("l" | "p"), rest)) = line.split_once(' ') else { continue };
        let position = |i: i64| vertices[(if i < 0 { count + i } else { i - 1 }) as usize];
        let ends = rest.split(' ').map(|i| position(i.parse().expect("an index")));
        found.push(format!("{word} {}", ends.collect::<Vec<_>>().join(", ")));
    }
    found
}

#[test]
fn lines_and_points_of_an_obj_pass_into_every_format() {
    let f = Folder::new();
    f.file("a.obj", mixed());
    let run = f.lodc(["extract", "a.obj", "--ratio", "50%", "-o", "o.obj"]).ends(0);
    assert!(run.err.contains("1 line element passes through unchanged"), "{}", run.err);
    let expected = ["p 102 0 0, 103 0 7", "l 100 0 0, 101 0.5 0, 102 0 0"];
    assert_eq!(elements(&String::from_utf8(f.read("o.obj")).expect("text")), expected);
    // Through a .lodc as well.
    f.lodc(["build", "a.obj", "-o", "a.lodc"]).ends(0);
    f.lodc(["extract", "a.lodc", "--ratio", "50%", "-o", "o.obj"]).ends(0);
    assert_eq!(elements(&String::from_utf8(f.read("o.obj")).expect("text")), expected);
    for input in ["a.obj", "a.lodc"] {
        f.lodc(["extract", input, "--ratio", "50%", "-o", "o.glb"]).ends(0);
        let (root, _) = glb_document(&f.read("o.glb"));
        let modes: Vec<&Value> = root["meshes"][1]["primitives"]
            .as_array()
            .map(|all| all.iter().map(|p| &p["mode"]).collect())
            .expect("a mesh of points and lines");
        assert_eq!(modes, [0, 1], "{root}");
        f.lodc(["verify", "o.glb", "--source", "a.obj"]).ends(0);
    }
    // From there back, where lines are pairs.
    f.lodc(["extract", "o.glb", "--lod", "0", "-o", "p.obj"]).ends(0);
    let back = elements(&String::from_utf8(f.read("p.obj")).expect("text"));
    assert_eq!(back, ["p 102 0 0, 103 0 7", "l 100 0 0, 101 0.5 0", "l 101 0.5 0, 102 0 0",]);
    f.lodc(["extract", "a.obj", "--ratio", "50%", "-o", "o.ply"]).ends(0);
    let ply = f.read("o.ply");
    let header = String::from_utf8_lossy(&ply[..600.min(ply.len())]).into_owned();
    assert!(header.contains("element edge 2\nproperty int vertex1"), "{header}");
    let run = f.lodc(["extract", "o.ply", "--lod", "0", "-o", "q.obj"]).ends(0);
    assert!(run.err.contains("2 edges pass through unchanged"), "{}", run.err);
    let back = elements(&String::from_utf8(f.read("q.obj")).expect("text"));
    let points = "p 103 0 7, 102 0 0";
    assert_eq!(back, [points, "l 100 0 0, 101 0.5 0", "l 101 0.5 0, 102 0 0"]);
    let run = f.lodc(["extract", "a.obj", "--ratio", "50%", "-o", "o.stl"]).ends(0);
    assert!(run.err.contains("left out: points and lines"), "{}", run.err);
}

#[test]
fn edges_and_loose_vertices_of_a_ply_pass_into_every_format() {
    let f = Folder::new();
    for far in [0.0, 4_649_776.5] {
        // A grid of 128 triangles, two vertices of an edge, and one of nothing.
        let x = |x: f64| far + x;
        let mut text = String::from(
            "ply\nformat ascii 1.0\nelement vertex 84\nproperty float x\nproperty float y\n\
             property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
             element face 128\nproperty list uchar int vertex_indices\n\
             element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n",
        );
        for i in 0..81 {
            let height = [0.0, 0.3][usize::from(i % 7 == 0)];
            text += &format!("{} {} {height} 255 255 255\n", x(f64::from(i % 9)), i / 9);
        }
        for end in [[9.2, 0.5], [10.3, 4.125], [11.7, 2.0]] {
            text += &format!("{} {} 0 10 20 30\n", x(end[0]), end[1]);
        }
        for i in 0..64 {
            let a = i / 8 * 9 + i % 8;
            text += &format!("3 {a} {} {}\n3 {a} {} {}\n", a + 1, a + 10, a + 10, a + 9);
        }
        f.file("a.ply", text + "81 82\n");
        let color = "0.039215688 0.078431375 0.11764706";
        let expected = [
            format!("p {} 2 0 {color}", x(11.7)),
            format!("l {} 0.5 0 {color}, {} 4.125 0 {color}", x(9.2), x(10.3)),
        ];
        let run = f.lodc(["extract", "a.ply", "--ratio", "50%", "-o", "o.obj"]).ends(0);
        assert!(run.err.contains("1 edge passes through unchanged, as lines"), "{}", run.err);
        let said = "1 vertex that no face uses passes through unchanged, as points";
        assert!(run.err.contains(said), "{}", run.err);
        f.lodc(["build", "a.ply", "-o", "a.lodc"]).ends(0);
        for input in ["a.ply", "a.lodc"] {
            let to = |out: &str| {
                f.lodc(["extract", input, "--ratio", "50%", "-o", out]).ends(0);
            };
            to("o.obj");
            assert_eq!(elements(&String::from_utf8(f.read("o.obj")).expect("text")), expected);
            to("o.ply");
            to("o.glb");
            for again in ["o.obj", "o.ply", "o.glb"] {
                f.lodc(["extract", again, "--lod", "0", "-o", "again.obj"]).ends(0);
                let back = elements(&String::from_utf8(f.read("again.obj")).expect("text"));
                let numbers = |all: &[String]| -> Vec<f64> {
                    let words = all.iter().flat_map(|line| line.split([' ', ',']));
                    words.filter_map(|word| word.parse().ok()).collect()
                };
                let words: Vec<usize> = back.iter().map(|line| line.split(' ').count()).collect();
                assert_eq!(words, [7, 13], "{input} by {again}: {back:?}");
                for (found, wanted) in numbers(&back).iter().zip(numbers(&expected)) {
                    assert!((found - wanted).abs() < 1e-6, "{input} by {again}: {back:?}");
                }
            }
        }
    }
}
