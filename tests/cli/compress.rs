//! Compressed geometry is read back as it was, and stays compressed.

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
