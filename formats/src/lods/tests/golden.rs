//! Streams of every version that ever was stay readable, and are written as they were: `fixtures/golden/lods1/`.
//!
//! They are made of the golden `.lodc` files, with the strips that those hold, by
//! `cargo test -p lodc-formats make_golden_streams -- --ignored`.

use super::*;
use lodc_lod::{AnyModel, StripKind};
use std::path::PathBuf;

const NAMES: [&str; 3] = ["cube_and_part", "skinned_tube", "triangle"];

fn golden(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures/golden").join(name)
}

/// A golden file and the stream of it.
fn packed(name: &str) -> (LodFile, Vec<u8>) {
    let bytes = std::fs::read(golden(&format!("v2/{name}.lodc"))).expect("a golden file");
    let file = crate::lodc::read(&bytes).expect("a golden file");
    let strips: Vec<Option<&StripSet>> = (file.objects.iter())
        .map(|o| o.models.iter().filter_map(AnyModel::strips).find(|s| s.kind == StripKind::Cache).map(|s| &s.set))
        .collect();
    assert!(strips.iter().all(Option::is_some), "{name} has strips");
    let bytes = pack(&file, &strips, &PackOptions::default()).expect("a sound file").bytes;
    (file, bytes)
}

#[test]
fn golden_streams_are_read_and_written_as_ever() {
    for name in NAMES {
        let bytes = std::fs::read(golden(&format!("lods1/{name}.lods"))).expect("a golden stream");
        let (file, again) = packed(name);
        assert!(again == bytes, "{name} is written otherwise than it was");
        let unpacker = fed(&bytes);
        assert!(unpacker.is_whole());
        assert_eq!((unpacker.document(), unpacker.source()), (Some(&file.document), Some(&file.source)), "{name}");
        for (i, o) in file.objects.iter().enumerate() {
            assert_eq!(unpacker.info(i), &o.info, "{name}");
            check(&unpacker, i, &o.simplified, name);
            super::growth::same_mesh(&unpacker, i, o.simplified.mesh(), name);
        }
    }
}

#[test]
fn passing_over_strips_changes_nothing_else() {
    for name in NAMES {
        let (file, bytes) = packed(name);
        let mut plain = Unpacker::new(Limits::DEFAULT).triangles_only();
        plain.feed(&bytes).expect("a sound stream");
        assert!(plain.is_whole());
        let whole = fed(&bytes);
        for i in 0..file.objects.len() {
            assert!(plain.strips(i).is_none() && whole.strips(i).is_some(), "{name}");
            assert_eq!(plain.mesh(i), whole.mesh(i), "{name}");
        }
    }
}

#[test]
#[ignore = "writes the golden streams; only for a new version of the format"]
fn make_golden_streams() {
    std::fs::create_dir_all(golden("lods1")).expect("a folder");
    for name in NAMES {
        std::fs::write(golden(&format!("lods1/{name}.lods")), packed(name).1).expect("a file");
    }
}
