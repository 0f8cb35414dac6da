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
