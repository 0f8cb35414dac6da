//! Cut, damaged, longer, newer, crafted.

use super::*;
use crate::Fault;
use crate::lods::mesh_header;
use crate::testing::Random;
use lodc_fixtures as fixtures;
use std::iter;

fn small() -> (LodFile, Vec<u8>) {
    let mesh = fixtures::coloured_cube();
    let file = obj(vec![object("cube", fixtures::random_collapse(&mesh, 3))]);
    let bytes = stepwise(&file).bytes;
    (file, bytes)
}

#[test]
fn a_stream_cut_anywhere_shows_its_last_whole_step() {
    let (file, bytes) = small();
    for cut in 0..bytes.len() {
        let unpacker = fed(&bytes[..cut]);
        assert!(!unpacker.is_complete(), "{cut} bytes");
        let steps = steps_before(&bytes, cut);
        assert_eq!(unpacker.objects(), usize::from(steps > 0), "{cut} bytes");
        if unpacker.objects() > 0 {
            assert_eq!(unpacker.progress(0).steps[0], steps, "{cut} bytes");
            check(&unpacker, 0, &file.objects[0].simplified, "cut");
            unpacker.mesh(0).expect("a mesh");
        }
    }
    assert!(fed(&bytes).is_complete());
}

#[test]
fn no_bit_can_flip_unnoticed_and_all_before_it_stays() {
    let (file, bytes) = small();
    let mut damaged = bytes.clone();
    // More follows, as it would on a line: a length that grew does not look like a cut.
    let more = vec![0; 1 << 16];
    for bit in 0..8 * bytes.len() {
        damaged[bit / 8] ^= 1 << (bit % 8);
        let mut unpacker = Unpacker::new(Limits::DEFAULT);
        let mut pieces = iter::once(&*damaged).chain(iter::repeat_n(&*more, 32));
        let error = pieces.find_map(|piece| unpacker.feed(piece).err()).expect("a flipped bit");
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(matches!(error.fault, Fault::Malformed | Fault::Unsupported), "bit {bit}: {error}");
        assert_eq!(unpacker.feed(&[]), Err(error), "bit {bit}: it stays refused");
        let steps = steps_before(&bytes, bit / 8);
        assert_eq!(unpacker.objects(), usize::from(steps > 0), "bit {bit}");
        if unpacker.objects() > 0 {
            assert_eq!(unpacker.progress(0).steps[0], steps, "bit {bit}");
            check(&unpacker, 0, &file.objects[0].simplified, "damaged");
        }
    }
}

/// Returns the steps in the whole blocks of the first bytes of a stream with a block for each step.
fn steps_before(bytes: &[u8], cut: usize) -> u32 {
    blocks(bytes).iter().filter(|(end, _)| *end <= cut).map(|(_, block)| block.steps).sum()
}

fn refused(bytes: &[u8], case: &str) {
    let error = Unpacker::new(Limits::DEFAULT).feed(bytes).expect_err("this must be refused");
    assert!(error.to_string().contains(case), "{error}");
}

#[test]
fn other_files_are_refused_by_name() {
    let (_, bytes) = small();
    refused(&[&bytes[..], b"x"].concat(), "follows the end");
    refused(b"v 0 0 0\n", "not a .lods stream");
    refused(&[&bytes[1..], &[0]].concat(), "not a .lods stream");
    let ends = ends(&bytes);
    // A block twice, left out, or in another's place.
    refused(&[&bytes[..ends[3]], &bytes[ends[2]..]].concat(), "checksum");
    refused(&[&bytes[..ends[2]], &bytes[ends[3]..]].concat(), "checksum");
    let mut early = bytes[..ends[4]].to_vec();
    block::put(&mut early, 4, Block { tag: 0, steps: 0, payload: &[] });
    refused(&early, "before everything is complete");
}

#[test]
fn a_flipped_bit_of_the_header_is_damage() {
    let (_, bytes) = small();
    for bit in 0..8 * FILE_HEADER.length {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        refused(&damaged, "header: the header is damaged");
    }
}

#[test]
fn other_versions_and_features_say_what_they_need() {
    let (_, bytes) = small();
    let newer = concat!("written by a newer lodc than ", env!("CARGO_PKG_VERSION"));
    let with = |offset: usize, value: u16| {
        let mut other = bytes.clone();
        other[offset..offset + 2].copy_from_slice(&value.to_le_bytes());
        FILE_HEADER.seal(&mut other);
        other
    };
    refused(&with(8, 0), "there is no version 0");
    for version in [2, 3, 300, u16::MAX] {
        let case = format!("header: version {version}: {newer}; this one reads version 1");
        refused(&with(8, version), &case);
    }
    for bit in 0..8 {
        let case = format!("header: features {:#x}: {newer}; this one knows none", 1 << bit);
        refused(&with(10, 1 << bit), &case);
    }
    for hint in 8..16 {
        assert!(fed(&with(10, 1 << hint)).is_complete(), "bit {hint} is a hint");
    }
}

#[test]
fn more_than_the_limits_allow_is_refused() {
    let (_, bytes) = small();
    let limits = Limits { vertices: 5, ..Limits::DEFAULT };
    let error = Unpacker::new(limits).feed(&bytes).expect_err("too many vertices");
    assert_eq!(error.fault, Fault::Limit);
}

/// The stream with a payload changed and its checksums made right again.
pub(super) fn forged(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut out = bytes[..FILE_HEADER.length].to_vec();
    let mut offset = FILE_HEADER.length;
    for number in 0.. {
        let Parsed::Block(found, length) = block::parse(&bytes[offset..], number) else { break };
        let mut payload = found.payload.to_vec();
        let mut steps = found.steps;
        if random.below(12) == 0 {
            match (random.below(4), payload.len()) {
                (0, _) => steps = steps.wrapping_add(random.below(3) as u32).wrapping_sub(1),
                (1, _) => payload.truncate(random.below(payload.len() + 1)),
                (_, 0) => {}
                (_, n) => payload[random.below(n)] = random.next() as u8,
            }
        }
        block::put(&mut out, number, Block { steps, payload: &payload, ..found });
        offset += length;
    }
    out
}

#[test]
fn forged_blocks_do_no_harm() {
    let mut random = Random(11);
    let mut refused = 0;
    for seed in 0..40 {
        let mesh = fixtures::random(seed);
        let objects = vec![object("random", fixtures::random_collapse(&mesh, seed))];
        let file = if seed % 2 == 0 { obj(objects) } else { gltf(objects) };
        let options = PackOptions {
            block_bytes: Some([0, 60, 4096][seed as usize % 3]),
            ..PackOptions::default()
        };
        let bytes = pack(&file, &options).expect("a sound file").bytes;
        for _ in 0..150 {
            let mut unpacker = Unpacker::new(Limits::DEFAULT);
            refused += usize::from(unpacker.feed(&forged(&bytes, &mut random)).is_err());
            for object in 0..unpacker.objects() {
                // They may show anything, but must not panic.
                let _ = unpacker.mesh(object);
                let _ = unpacker.progress(object);
            }
        }
    }
    assert!(refused > 1000, "only {refused} were noticed");
}

/// The fuzz target `lods`, with seeds.
#[test]
fn bytes_that_change_anywhere_do_no_harm() {
    let mut random = Random(12);
    let mut accepted = 0;
    for seed in 0..20 {
        let file =
            gltf(vec![object("random", fixtures::random_collapse(&fixtures::random(seed), seed))]);
        let bytes = pack(&file, &PackOptions::default()).expect("a sound file").bytes;
        for _ in 0..300 {
            let mut changed = bytes.clone();
            for _ in 0..=random.below(4) {
                let offset = random.below(changed.len());
                match random.below(3) {
                    0 => changed[offset] = random.next() as u8,
                    1 => changed[offset] ^= 1 << random.below(8),
                    _ => drop(changed.drain(offset..(offset + random.below(9)).min(changed.len()))),
                }
            }
            let changed = super::super::with_valid_checksums(&changed);
            let mut unpacker =
                Unpacker::new(Limits { vertices: 1 << 20, triangles: 1 << 20, ..Limits::DEFAULT });
            accepted += usize::from(
                changed.chunks(1 + random.below(500)).all(|piece| unpacker.feed(piece).is_ok()),
            );
            for object in 0..unpacker.objects() {
                let _ = unpacker.mesh(object);
                let state = unpacker.progress(object);
                assert!(state.vertices[0] <= state.vertices[1] && state.vertices[0] <= 1 << 20);
            }
        }
    }
    assert!(accepted < 3000, "{accepted} of 6000 were taken for sound");
}

#[test]
fn a_few_bytes_cannot_ask_for_much() {
    let (_, bytes) = small();
    let ends = ends(&bytes);
    // Zeros go on for ever as the likeliest things; the head announces as much as it can.
    let mut file =
        obj(vec![object("grid", fixtures::random_collapse(&fixtures::coloured_cube(), 1))]);
    file.objects.truncate(1);
    let blocks = blocks(&bytes);
    let first = blocks.iter().position(|(_, block)| block.steps > 0).expect("steps");
    let mut bomb = bytes[..blocks[first].0].to_vec();
    for number in first as u64 + 1..2000 {
        block::put(&mut bomb, number, Block { tag: 1, steps: 1, payload: &[0; 4] });
    }
    let mut unpacker = Unpacker::new(Limits::DEFAULT);
    assert!(unpacker.feed(&bomb).is_err(), "more vertices than its header says");
    assert!(unpacker.progress(0).vertices[0] <= unpacker.progress(0).vertices[1]);
    // A header that announces as much as its numbers can hold.
    let mut header = bytes[..ends[1]].to_vec();
    let plain = [&[0xff, 0xff, 0xff, 0xff, 0x0f].repeat(3)[..], &[0; 3], &[1, 0]].concat();
    let coded = mesh_header::codec().encode(&plain);
    let payload = [&[plain.len() as u8, coded.len() as u8], &coded[..]].concat();
    block::put(&mut header, 1, Block { tag: 1, steps: 1, payload: &payload });
    let error = Unpacker::new(Limits::DEFAULT).feed(&header).expect_err("too much");
    assert_eq!(error.fault, Fault::Limit, "{error}");
}
