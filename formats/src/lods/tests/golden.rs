//! Streams of every version that ever was stay readable: `fixtures/golden/lods1/`, `lods2/`,
//! `lods4/`, `lods7/`, and `lods8/` and `lods11/` (`hubs.rs`). Those from version 7 on are written
//! as they were.
//!
//! They are made of the golden `.lodc` files by
//! `cargo test -p lodc-formats make_golden_streams -- --ignored`.

use super::super::VERSION;
use super::*;
use std::path::PathBuf;

/// The golden files of which there are streams, with the version that they are of.
const NAMES: [(&str, u32); 4] =
    [("cube_and_part", 2), ("skinned_tube", 2), ("triangle", 2), ("two_parts", 3)];
/// Versions of streams, each with how many of these it has.
const VERSIONS: [(u32, usize); 4] = [(1, 3), (2, 4), (4, 4), (7, 4)];

fn golden(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures/golden").join(name)
}

fn source((name, version): (&str, u32)) -> LodFile {
    let bytes = std::fs::read(golden(&format!("v{version}/{name}.lodc"))).expect("a golden file");
    crate::testing::read(&bytes).expect("a golden file")
}

fn stream(version: u32, name: &str) -> Vec<u8> {
    std::fs::read(golden(&format!("lods{version}/{name}.lods"))).expect("a golden stream")
}

fn packed(file: &LodFile, strips: &[StripSet]) -> Vec<u8> {
    let strips: Vec<_> = strips.iter().map(Some).collect();
    pack(file, &strips, &PackOptions::default()).expect("a sound file").bytes
}

/// The strips of an object with its vertices in collapse order, as a writer needs them.
fn strips(unpacker: &Unpacker, object: usize) -> StripSet {
    let coded = unpacker.strips(object).expect("strips are coded");
    let last = unpacker.progress(object).vertices[1] - 1;
    let (mut indices, mut ends) = (Vec::new(), Vec::new());
    for strip in coded.iter() {
        indices.extend(strip.iter().map(|&v| last - v));
        ends.push(indices.len() as u32);
    }
    let submesh_ends = (0..coded.submesh_count()).map(|s| coded.submesh(s).end as u32).collect();
    StripSet::from_parts(indices, ends, submesh_ends).expect("strips as they were")
}

#[test]
fn golden_streams_are_read_and_written_as_ever() {
    let all = VERSIONS.iter().flat_map(|&(v, count)| NAMES[..count].iter().map(move |n| (v, *n)));
    for (version, golden) in all {
        let (name, (file, bytes)) = (golden.0, (source(golden), stream(version, golden.0)));
        let unpacker = fed(&bytes);
        assert!(unpacker.is_complete());
        assert_eq!(unpacker.version(), version);
        assert_eq!(
            (unpacker.document(), unpacker.source()),
            (Some(&file.document), Some(&file.source)),
            "{name}"
        );
        for (i, o) in file.objects.iter().enumerate() {
            assert_eq!(unpacker.info(i), &o.info, "{name}");
            check(&unpacker, i, &o.simplified, name);
            every_step::same_mesh(&unpacker, i, o.simplified.mesh(), name);
        }
        let strips: Vec<_> = (0..file.objects.len()).map(|i| strips(&unpacker, i)).collect();
        let packed = packed(&file, &strips);
        // The same strips are made of a stream of any version, and so is the same stream.
        assert!(packed == stream(VERSION, name), "{name} is written otherwise than it was");
    }
}

#[test]
fn passing_over_strips_changes_nothing_else() {
    for (name, _) in NAMES {
        let bytes = stream(VERSION, name);
        let mut plain = Unpacker::new(Limits::DEFAULT).triangles_only();
        plain.feed(&bytes).expect("a sound stream");
        let whole = fed(&bytes);
        assert!(plain.is_complete() && whole.is_complete());
        for i in 0..whole.objects() {
            assert_eq!(
                (plain.strips(i).is_some(), whole.strips(i).is_some()),
                (false, true),
                "{name}"
            );
            assert_eq!(plain.mesh(i), whole.mesh(i), "{name}");
        }
    }
}

#[test]
#[ignore = "writes the golden streams; only for a new version of the format"]
fn make_golden_streams() {
    hubs::make_golden();
    std::fs::create_dir_all(golden(&format!("lods{VERSION}"))).expect("a folder");
    for (name, version) in NAMES {
        let file = source((name, version));
        let strips = strips_of(&file);
        std::fs::write(golden(&format!("lods{VERSION}/{name}.lods")), packed(&file, &strips))
            .expect("a file");
    }
}
