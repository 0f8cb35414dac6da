//! The golden streams, `fixtures/golden/v1/*.lods`, are read and written as ever.
//!
//! They are made, most of them of golden `.lodc` files, by
//! `cargo test -p lodc-formats make_golden_streams -- --ignored`.

use super::*;
use lodc_fixtures as fixtures;
use std::path::PathBuf;

/// Those that are made of the golden file of this name.
const NAMES: [&str; 4] = ["cube_and_part", "skinned_tube", "triangle", "two_parts"];

fn golden(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures/golden/v1").join(name)
}

fn stream(name: &str) -> Vec<u8> {
    std::fs::read(golden(&format!("{name}.lods"))).expect("a golden stream")
}

/// What the golden streams are made from, and how: also meshes of high-valence vertices, of which a
/// vertex repeats the target of another one (the book), or a star is named (flaps).
fn sources() -> Vec<(&'static str, LodFile, PackOptions)> {
    let file = |name| {
        let bytes = std::fs::read(golden(&format!("{name}.lodc"))).expect("a golden file");
        (name, crate::testing::read(&bytes).expect("a golden file"), PackOptions::default())
    };
    let center = |name, mesh, block_bytes| {
        let file = obj(vec![object(name, fixtures::random_collapse(&mesh, 1))]);
        (name, file, PackOptions { block_bytes, exact: true, ..PackOptions::default() })
    };
    let centers =
        [center("book", fixtures::book(400), Some(0)), center("flaps", fixtures::flaps(600), None)];
    NAMES.into_iter().map(file).chain(centers).collect()
}

fn packed(file: &LodFile, options: &PackOptions) -> Vec<u8> {
    pack(file, options).expect("a sound file").bytes
}

#[test]
fn golden_streams_are_read_and_written_as_ever() {
    for (name, file, options) in sources() {
        let bytes = stream(name);
        let unpacker = fed(&bytes);
        assert!(unpacker.is_complete());
        assert_eq!(
            (unpacker.document(), unpacker.source()),
            (Some(&file.document), Some(&file.source)),
            "{name}"
        );
        let ordered = if options.exact { file } else { in_stream_order(&file) };
        for (i, o) in ordered.objects.iter().enumerate() {
            assert_eq!(unpacker.info(i), &o.info, "{name}");
            check(&unpacker, i, &o.simplified, name);
            every_step::same_mesh(&unpacker, i, o.simplified.mesh(), name);
        }
        assert!(packed(&ordered, &options) == bytes, "{name} is written otherwise");
    }
}

#[test]
#[ignore = "writes the golden streams; only when the format changes"]
fn make_golden_streams() {
    for (name, file, options) in sources() {
        let bytes = packed(&file, &options);
        std::fs::write(golden(&format!("{name}.lods")), bytes).expect("a file");
    }
}
