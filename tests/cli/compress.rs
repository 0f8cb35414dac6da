//! `--compress` (meshopt): compressed geometry is decoded to equal bytes by every command, and
//! outputs stay compressed.

use crate::support::Folder;

fn part(f: &Folder) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/machine_part.glb");
    f.file("part.glb", std::fs::read(path).expect("a fixture"));
}

fn is_compressed(f: &Folder, name: &str) -> bool {
    String::from_utf8_lossy(&f.read(name)).contains("EXT_meshopt_compression")
}

#[test]
fn compression_loses_nothing_and_lasts() {
    let f = Folder::new();
    part(&f);
    let args = ["extract", "part.glb", "--ratio", "1", "--compress", "meshopt", "-q", "-o"];
    for name in ["c.glb", "c.gltf"] {
        f.lodc(args.iter().chain(&[name])).ends(0);
        assert!(is_compressed(&f, name));
        f.lodc(["build", name, "-o", "c.lodc", "-q"]).ends(0);
        f.lodc(["verify", "c.lodc", "--source", "part.glb", "-q"]).ends(0);
    }
    f.lodc(["extract", "part.glb", "--ratio", "1", "-o", "plain.glb", "-q"]).ends(0);
    assert!(f.read("c.glb").len() < f.read("plain.glb").len());
    f.lodc(["extract", "c.glb", "--ratio", "0.5", "-o", "half.glb", "-q"]).ends(0);
    assert!(is_compressed(&f, "half.glb"), "as the input");
    let none = ["--compress", "none", "-q"];
    let half = ["extract", "c.glb", "--ratio", "0.5", "-o", "half.glb"];
    f.lodc(half.iter().chain(&none)).ends(0);
    assert!(!is_compressed(&f, "half.glb"));
    let run = f.lodc(["extract", "c.glb", "--ratio", "1", "-o", "o.obj", "--compress", "meshopt"]);
    assert!(run.fails(2).err.contains("only .glb and .gltf"));
    f.lodc(["extract", "c.glb", "--ratio", "1", "-o", "o.obj", "-q"]).ends(0);
}

#[test]
fn a_chain_is_compressed_too() {
    let f = Folder::new();
    part(&f);
    let chain = |shape: &[&str], name: &str| {
        let args = ["chain", "part.glb", "--compress", "meshopt", "-q", "-o", name];
        f.lodc(args.iter().chain(shape)).ends(0);
        assert!(is_compressed(&f, name));
        f.lodc(["build", name, "-o", "c.lodc", "-q"]).ends(0);
    };
    chain(&[], "c.glb");
    chain(&["--index-ranges"], "r.glb");
}

#[test]
fn quantised_geometry_is_close_and_small() {
    let f = Folder::new();
    part(&f);
    let extract = ["extract", "part.glb", "--ratio", "1", "-q", "-o"];
    let bits = ["--quantize", "pos=14,normal=10,uv=12,color=8,weight=8"];
    f.lodc(extract.iter().chain(&["plain.glb"])).ends(0);
    f.lodc(extract.iter().chain(&["q.glb"]).chain(&bits)).ends(0);
    f.lodc(extract.iter().chain(&["qc.glb", "--compress", "meshopt"]).chain(&bits)).ends(0);
    for name in ["q.glb", "qc.glb"] {
        // Half a step of 2^-14 of the longest side in each direction.
        let limits = ["--max-hausdorff", "0.006%", "--max-image-rmse", "2", "-q"];
        f.lodc(["compare", "plain.glb", name].iter().chain(&limits)).ends(0);
    }
    let size = |name: &str| f.read(name).len();
    assert!(size("q.glb") < size("plain.glb") && size("qc.glb") < size("q.glb"));
    f.lodc(["extract", "part.glb", "--ratio", "1", "-q", "-o", "c.glb", "--compress", "meshopt"])
        .ends(0);
    assert!(size("qc.glb") < size("c.glb"));
    f.lodc(["chain", "part.glb", "-o", "chain.glb", "-q"].iter().chain(&bits)).ends(0);
    f.lodc(["build", "chain.glb", "-o", "chain.lodc", "-q"]).ends(0);
}

#[test]
fn bits_that_make_no_sense_are_refused() {
    let f = Folder::new();
    part(&f);
    let refused = [
        ("o.glb", "pos=20", "from 2 to 16"),
        ("o.glb", "colour=8", "not one of pos, normal, uv, color, weight"),
        ("o.obj", "pos=14", "only .glb and .gltf can be quantised"),
    ];
    for (output, bits, word) in refused {
        let args = ["extract", "part.glb", "--ratio", "1", "-o", output, "--quantize", bits];
        let run = f.lodc(args).ends(2);
        assert!(run.err.contains(word), "{bits}: {}", run.err);
    }
}

/// An OBJ of curved, triangulated sheets of `n` by `n` vertices, each a corner and a side.
fn sheets(n: usize, sheets: &[([f64; 3], f64)]) -> String {
    let mut obj = String::new();
    for (number, &([x, y, z], side)) in sheets.iter().enumerate() {
        for v in 0..n * n {
            let [a, b] = [v % n, v / n].map(|i| i as f64 / (n - 1) as f64);
            let height = z + 0.05 * side * (9.0 * a).sin() * (7.0 * b).cos();
            obj += &format!("v {} {} {height}\n", x + side * a, y + side * b);
        }
        let first = number * n * n + 1;
        for v in (0..n * (n - 1)).filter(|v| v % n < n - 1).map(|v| first + v) {
            obj += &format!("f {v} {} {}\nf {v} {} {}\n", v + 1, v + n + 1, v + n + 1, v + n);
        }
    }
    obj
}

#[test]
fn an_error_that_is_asked_for_is_that_of_what_is_written() {
    let f = Folder::new();
    f.file("sheet.obj", sheets(30, &[([0.0; 3], 10.0)]));
    f.lodc(["build", "sheet.obj", "-o", "sheet.lodc", "-q"]).ends(0);
    for input in ["sheet.obj", "sheet.lodc"] {
        let extract = ["extract", input, "-o", "l.glb", "--json", "--quantize", "pos=10"];
        for (asked, distance, most) in [
            (&["--error", "0.02"][..], "error", 0.02),
            (&["--error", "0.2%", "--no-refit"], "error", 0.0284),
            (&["--rms", "0.01"], "rms", 0.01),
            // A pixel of 1,080 at 60° and a distance of 20.
            (&["--pixels", "1", "--distance", "20"], "error", 0.0214),
            (&["--ratio", "5%", "--max-error", "0.02"], "error", 0.02),
        ] {
            let report = f.lodc(extract.iter().chain(asked)).ends(0).json();
            assert!(report[distance].as_f64() <= Some(most), "{asked:?}: {report}");
            assert!(report["lod"].as_u64() > Some(0), "{asked:?}: coarser than the input");
            assert!(!report["warnings"].to_string().contains("not kept"), "{asked:?}: {report}");
            f.lodc(["verify", "l.glb", "--source", "sheet.obj", "-q"]).ends(0);
        }
    }
    let chain = ["chain", "sheet.obj", "-o", "c.glb", "--errors", "0.02,0.1", "--json"];
    for how in [&[][..], &["--separate", "--refit"]] {
        let quantize = ["--quantize", "pos=10"];
        let levels = f.lodc(chain.iter().chain(&quantize).chain(how)).ends(0).json();
        for (level, most) in [(0, 0.02), (1, 0.1)] {
            assert!(levels["levels"][level]["error"].as_f64() <= Some(most), "{levels}");
        }
    }
}

#[test]
fn a_grid_that_is_coarser_than_the_error_leaves_the_finest_level() {
    let f = Folder::new();
    f.file("sheet.obj", sheets(30, &[([0.0; 3], 10.0)]));
    let line = |option: &str| format!("{option} is not kept: --quantize adds up to ");
    for (asked, option) in [
        (["--error", "0.01"], "--error"),
        (["--rms", "0.001"], "--rms"),
        (["--max-error", "0.01"], "--max-error"),
    ] {
        let ratio = ["--ratio", "10%"].into_iter().filter(|_| option == "--max-error");
        let args = ["extract", "sheet.obj", "-o", "l.glb", "--json", "--quantize", "pos=5"];
        let report = f.lodc(args.into_iter().chain(asked).chain(ratio)).ends(0).json();
        assert_eq!(report["lod"], 0, "{report}");
        assert!(report["warnings"][0].as_str().is_some_and(|w| w.starts_with(&line(option))));
    }
    let args = ["chain", "sheet.obj", "-o", "c.glb", "--errors", "0.01,2", "--quantize", "pos=5"];
    let run = f.lodc(args).ends(0);
    assert!(run.err.contains(&format!("level 0: {}", line("--errors"))), "{}", run.err);
    assert!(!run.err.contains("level 1:"), "{}", run.err);
}

#[test]
fn parts_smaller_than_a_cell_count_as_gone() {
    let f = Folder::new();
    f.file("two.obj", sheets(13, &[([0.0; 3], 100.0), ([300.0, 0.0, 0.0], 0.001)]));
    for (command, level) in [("extract", ["--ratio", "1"]), ("chain", ["--levels", "100%"])] {
        let args = [command, "two.obj", "-o", "l.glb", "--json", "--quantize", "pos=12"];
        let run = f.lodc(args.iter().chain(&level)).ends(0);
        let report = run.json();
        let error =
            if command == "chain" { &report["levels"][0]["error"] } else { &report["error"] };
        assert!(error.as_f64() > Some(199.0) && error.as_f64() < Some(210.0), "{report}");
        let lost = "288 triangles have no area after quantising";
        assert!(report["warnings"].to_string().contains(lost), "{report}");
        f.lodc(["verify", "l.glb", "--source", "two.obj", "-q"]).ends(0);
    }
}

#[test]
fn what_is_flat_is_hardly_farther_for_being_quantised() {
    let f = Folder::new();
    let flat: String = sheets(9, &[([0.0; 3], 1000.0)])
        .lines()
        .map(|line| match line.starts_with('v') {
            true => format!("{} 3\n", line.rsplit_once(' ').expect("three numbers").0),
            false => format!("{line}\n"),
        })
        .collect();
    f.file("flat.obj", flat);
    let args = ["extract", "flat.obj", "--ratio", "1", "-o", "l.glb", "--json"];
    let report = f.lodc(args.iter().chain(&["--quantize", "pos=8"])).ends(0).json();
    // Half the diagonal of a cell is 3.4.
    assert!(report["error"].as_f64() < Some(2.1), "{report}");
    f.lodc(["verify", "l.glb", "--source", "flat.obj", "-q"]).ends(0);
}
