//! `lodc strips`: text that draws the file's own triangles, by the numbers of its own vertices.

use crate::support::{Folder, grid};

/// The oriented triangles of the output, smallest corner first, sorted; and what kinds of lines
/// there were.
fn drawn(text: &str) -> (Vec<[u32; 3]>, String) {
    let mut triangles = Vec::new();
    let mut kinds = String::new();
    for line in text.lines() {
        let (kind, numbers) = line.split_once(' ').expect("a kind and numbers");
        let v: Vec<u32> = numbers.split(' ').map(|n| n.parse().expect("a number")).collect();
        kinds += kind;
        if kind == "s" {
            for (k, w) in v.windows(3).enumerate() {
                triangles.push(if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] });
            }
        } else {
            triangles.extend(v.chunks(3).map(|t| [t[0], t[1], t[2]]));
        }
    }
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    let first =
        |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().expect("three");
    let mut triangles: Vec<_> = triangles.into_iter().map(first).collect();
    triangles.sort_unstable();
    (triangles, kinds)
}

#[test]
fn every_generator_draws_the_triangles_by_the_numbers_of_the_file() {
    // Vertex 0 is used by nobody, and the first face uses the last vertices.
    let f = Folder::new();
    let mut obj = "v 9 9 9\n".to_owned();
    for i in 0..12 {
        obj += &format!("v {} {} 0\n", i / 2, i % 2);
    }
    let mut wanted = Vec::new();
    for i in (1..11).rev() {
        let [a, b, c] = if i % 2 == 1 { [i, i + 2, i + 1] } else { [i, i + 1, i + 2] };
        obj += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
        wanted.push([a, b, c]);
    }
    wanted.sort_unstable();
    f.file("a.obj", obj);
    for (strips, kinds) in [("stripe", "s"), ("cache", "s"), ("list", "l")] {
        for effort in ["fast", "default", "thorough"] {
            let run = f
                .lodc(["strips", "a.obj", "-o", "-", "--strips", strips, "--effort", effort])
                .ends(0);
            let (triangles, lines) = drawn(&run.text());
            assert_eq!(triangles, wanted, "{strips} {effort}");
            // The search for long strips and the list need one line; how many strips suit a cache
            // is not promised.
            let one = strips != "cache";
            assert!(
                lines.replace(kinds, "").is_empty() && (lines.len() == 1 || !one),
                "{strips} {effort}: {lines}"
            );
        }
    }
}

#[test]
fn the_text_does_not_depend_on_threads() {
    let f = Folder::new();
    f.file("g.obj", grid(90));
    for strips in ["stripe", "cache", "list"] {
        let with = |jobs| {
            f.lodc(["strips", "g.obj", "-o", "-", "--strips", strips, "--jobs", jobs, "-q"])
                .ends(0)
                .out
        };
        assert!(with("1") == with("3"), "{strips}");
    }
}

#[test]
fn strips_refuse_what_makes_no_sense_and_keep_what_was_there() {
    let f = Folder::new();
    f.file("a.obj", grid(2));
    f.file("old.strips", "kept");
    for args in [["--cache-size", "3"], ["--strips", "best"]] {
        f.lodc(["strips", "a.obj", "-o", "old.strips"].into_iter().chain(args)).ends(2);
    }
    f.file("broken.obj", "v 1 2\n");
    f.lodc(["strips", "broken.obj", "-o", "old.strips"]).fails(3);
    f.lodc(["strips", "a.obj", "-o", "a.obj"]).fails(2);
    f.lodc(["strips", "a.obj", "-o", "not/there.strips"]).fails(4);
    assert_eq!(f.read("old.strips"), b"kept");
}
