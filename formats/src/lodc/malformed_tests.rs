//! Damaged, crafted and later files: each is refused by name, or what is unknown is passed over.

use super::tests::{all_models_file, gltf_file, obj_file, same, two_parts_file, wide};
use super::*;
use crate::testing::{LodFile, read, stored, write};
use lodc_fixtures as fixtures;
use lodc_model::Model;
use table::HEADER_BYTES;

fn fails(bytes: &[u8], fault: Fault, problem: &str) {
    let error = read(bytes).expect_err("this must be refused");
    assert_eq!(error.fault, fault, "{error}");
    assert!(error.to_string().contains(problem), "{error}");
}

#[test]
fn flags_that_are_hints_are_passed_over() {
    let flagged = crafted(|b| set(b, SECOND + 4, 0x0004_0001u32.to_le_bytes()));
    assert!(read(&flagged).is_ok());
}

#[test]
fn every_single_bit_flip_is_detected() {
    let names = [
        "machine_part",
        "skinned_tube_u8",
        "machine_part",
        "quantised_torus",
        "morphing_sphere",
        "uv_sphere",
    ];
    let bytes = write(&gltf_file(&names));
    assert!((48 << 10..160 << 10).contains(&bytes.len()), "{} bytes", bytes.len());
    let table =
        HEADER_BYTES + 40 * u32::from_le_bytes(std::array::from_fn(|i| bytes[12 + i])) as usize;
    let mut flipped = bytes.clone();
    for bit in 0..8 * bytes.len() {
        flipped[bit / 8] ^= 1 << (bit % 8);
        // Nothing is read before the container is: what it refuses, `read` refuses. That is tried
        // for some.
        assert!(Container::read(&flipped).is_err(), "bit {bit}");
        if bit < 8 * HEADER_BYTES {
            fails(&flipped, Fault::Malformed, "header: the header is damaged");
        } else if bit < 8 * table || bit % 97 == 0 {
            assert!(read(&flipped).is_err(), "bit {bit}");
        }
        flipped[bit / 8] ^= 1 << (bit % 8);
    }
    same(&read(&flipped).expect("all bits flipped back"), &gltf_file(&names));
}

#[test]
fn damage_to_the_gpu_layout_is_found_as_in_the_packed_one() {
    let bytes = write(&wide(&two_parts_file()));
    let mut flipped = bytes.clone();
    for bit in 0..8 * bytes.len() {
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(read(&flipped).is_err(), "bit {bit}");
        flipped[bit / 8] ^= 1 << (bit % 8);
    }
    for length in 0..bytes.len() {
        assert!(read(&bytes[..length]).is_err(), "{length} bytes");
    }
    fails(&bytes[..bytes.len() - 1], Fault::Malformed, "cut off");
}

/// Sets or clears bits of the flags of a section.
fn flagged(file: &LodFile, tag: &[u8; 4], index: u32, bits: u32) -> Vec<u8> {
    let mut bytes = write(file);
    let at = (HEADER_BYTES..).step_by(40).find(|&e| {
        bytes[e..].starts_with(tag) && bytes[e + 12..].starts_with(&index.to_le_bytes())
    });
    let at = at.expect("the section's entry");
    bytes[at + 4] ^= bits as u8;
    with_valid_checksums(&laid_out(&bytes))
}

/// A file with its sections where their flags want them.
fn laid_out(bytes: &[u8]) -> Vec<u8> {
    let u64_at =
        |bytes: &[u8], at: usize| u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]));
    let sections = u32::from_le_bytes(std::array::from_fn(|i| bytes[12 + i])) as usize;
    let mut out = bytes[..HEADER_BYTES + 40 * sections].to_vec();
    for entry in (HEADER_BYTES..).step_by(40).take(sections) {
        let [start, length] = [16, 24].map(|at| u64_at(bytes, entry + at) as usize);
        let content = bytes[start..start + length].to_vec();
        out.resize(table::section_start(out.len(), bytes[entry + 4] & 2 != 0), 0);
        let start = out.len() as u64;
        set(&mut out, entry + 16, start.to_le_bytes());
        out.extend(content);
    }
    let length = out.len() as u64;
    set(&mut out, 16, length.to_le_bytes());
    out
}

#[test]
fn the_flag_of_wide_numbers_stands_where_they_are() {
    let (packed, gpu) = (two_parts_file(), wide(&two_parts_file()));
    let tris = "section TRIS of object 0: 9 bytes are not a whole number of entries of 12";
    fails(&flagged(&packed, b"TRIS", 0, 2), Fault::Malformed, tris);
    fails(&flagged(&packed, b"TARG", 0, 2), Fault::Malformed, "not a whole number of entries");
    fails(&flagged(&gpu, b"TARG", 0, 2), Fault::Malformed, "object 0: ");
    let strips = "the array \"strips\"";
    fails(&flagged(&packed, b"MODA", 0, 2), Fault::Malformed, strips);
    fails(&flagged(&gpu, b"MODA", 0, 2), Fault::Malformed, strips);
    let removals = "the array \"removals\" is never written wide";
    fails(&flagged(&packed, b"MODA", 1, 2), Fault::Malformed, removals);
    // Elsewhere it is a flag that is not known.
    for tag in [b"JOIN", b"SERR", b"STRI", b"VSUB"] {
        let flagged = flagged(&packed, tag, 0, 2);
        fails(&flagged, Fault::Unsupported, "has unknown flags 0x3");
    }
}

#[test]
fn every_truncation_and_every_longer_file_is_refused() {
    let bytes = write(&gltf_file(&["machine_part", "cube"]));
    for length in 0..bytes.len() {
        assert!(read(&bytes[..length]).is_err(), "{length} bytes");
    }
    fails(&bytes[..bytes.len() - 1], Fault::Malformed, "cut off");
    let mut longer = bytes;
    longer.push(0);
    fails(&longer, Fault::Malformed, "1 bytes follow the end");
    // Even if the header agrees.
    let length = longer.len() as u64;
    longer[16..24].copy_from_slice(&length.to_le_bytes());
    let longer = with_valid_checksums(&longer);
    fails(&longer, Fault::Malformed, "follow the last section");
}

/// A file with something changed and the checksums made right again.
fn crafted(change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut bytes = write(&gltf_file(&["cube"]));
    change(&mut bytes);
    with_valid_checksums(&bytes)
}

fn set<const N: usize>(bytes: &mut [u8], at: usize, value: [u8; N]) {
    bytes[at..at + N].copy_from_slice(&value);
}

#[test]
fn other_files_and_other_versions_are_refused_by_name() {
    fails(b"glTF\x02\0\0\0", Fault::Malformed, "not a .lodc file");
    fails(b"", Fault::Malformed, "the file ends after 0 bytes, within its header");
    let newer = concat!("written by a newer lodc than ", env!("CARGO_PKG_VERSION"));
    let version = format!("header: version 2: {newer}; this one reads version 1");
    fails(&crafted(|b| set(b, 8, 2u16.to_le_bytes())), Fault::Unsupported, &version);
    fails(&crafted(|b| set(b, 8, 0u16.to_le_bytes())), Fault::Malformed, "no version 0");
    let feature = format!("header: features 0x4: {newer}; this one knows none");
    fails(&crafted(|b| set(b, 10, 4u16.to_le_bytes())), Fault::Unsupported, &feature);
    assert!(read(&crafted(|b| set(b, 10, 0x400u16.to_le_bytes()))).is_ok(), "a hint");
}

const FIRST: usize = HEADER_BYTES;
// The table of levels comes between.
const SECOND: usize = FIRST + 80;

#[test]
fn sections_that_are_unknown_are_skipped_or_refused_as_they_ask() {
    // DBLB becomes something else: its place in the manifest is then empty, if it could be skipped
    // at all.
    let third = SECOND + 40;
    fails(&crafted(|b| set(b, third, *b"ZZZZ")), Fault::Unsupported, "section ZZZZ: is required");
    let skipped = crafted(|b| {
        set(b, third, *b"ZZZZ");
        set(b, third + 4, 0u32.to_le_bytes());
    });
    fails(&skipped, Fault::Malformed, "section DBLB: is missing");
    fails(
        &crafted(|b| set(b, third + 4, 3u32.to_le_bytes())),
        Fault::Unsupported,
        "unknown flags 0x3",
    );

    // A whole file with one unknown section more.
    let file = gltf_file(&["cube"]);
    let plan = streams::plan(
        file.objects[0].simplified.mesh(),
        Layout::Packed,
        &mut OmittedZeros::default(),
    );
    let object = &file.objects[0];
    let models: Vec<_> = object.models.iter().map(|m| stored(m, Layout::Packed)).collect();
    let manifest = Manifest::of(&file, std::slice::from_ref(&models), std::slice::from_ref(&plan));
    let manifest = manifest.encode();
    let mut writer = Writer::default();
    writer.required(tag::MANIFEST, SCENE, 0, |out| out.extend_from_slice(&manifest));
    writer.optional(*b"ZZZZ", SCENE, 0, |out| out.extend_from_slice(b"from the future"));
    writer.required(tag::DOCUMENT_JSON, SCENE, 0, |out| {
        out.extend_from_slice(br#"{"asset":{"version":"2.0"}}"#);
    });
    writer.required(tag::DOCUMENT_BLOB, SCENE, 0, |out| out.extend(0..37));
    object::write(&mut writer, 0, &object.simplified, models, &plan, Layout::Packed);
    writer.optional(tag::MODEL_ARRAY, 0, 5, |out| out.push(7));
    let read = read(&writer.finish()).expect("optional sections are skipped");
    same(&read, &file);
    let left_out = [
        "section ZZZZ is not known to this version and was left out",
        "section MODA 5 of object 0 belongs to nothing that the manifest names and was left out",
    ];
    assert_eq!(read.left_out, left_out);
}

#[test]
fn models_of_later_versions_are_left_out_and_their_sections_skipped() {
    let mut bytes = write(&obj_file("cube"));
    let at = bytes.windows(11).position(|w| w == b"interactive").expect("the model's name");
    set(&mut bytes, at, *b"imaginative");
    let file = read(&with_valid_checksums(&bytes)).expect("unknown models are no error");
    assert!(file.objects[0].models.is_empty());
    assert_eq!(
        file.left_out,
        ["object 0: the model \"imaginative\" is not in this version and was left out"]
    );
}

#[test]
fn what_is_left_out_is_reported_in_bounded_space() {
    let mut left_out = SkippedParts::default();
    for i in 0..1000 {
        left_out.add(|| i.to_string());
    }
    let lines = left_out.into_lines();
    assert_eq!(
        (lines.len(), lines[19].as_str(), lines[20].as_str()),
        (21, "19", "980 more unknown parts were left out")
    );
    assert_eq!(skipped::shortened(&"é\n".repeat(10_000)), format!("{}…", "é\\n".repeat(30)));
}

#[test]
fn scales_that_are_no_positive_number_are_refused() {
    let bytes = write(&obj_file("cube"));
    let scale = 2.5f64.to_le_bytes();
    let at = bytes.windows(8).position(|w| w == scale).expect("the object's scale");
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, -0.0] {
        let mut bytes = bytes.clone();
        set(&mut bytes, at, wrong.to_le_bytes());
        let bytes = with_valid_checksums(&bytes);
        fails(&bytes, Fault::Malformed, "object 0: is shown at a scale of");
    }
}

#[test]
fn an_overview_that_is_not_that_of_the_object_is_refused() {
    let file = obj_file("cube");
    let bytes = write(&file);
    let bounds = Bounds::of(file.objects[0].simplified.mesh().positions());
    let words = [bounds.low, bounds.high, bounds.center].concat();
    let stored: Vec<u8> = words.iter().flat_map(|x| x.to_le_bytes()).collect();
    let at = bytes.windows(stored.len()).position(|w| w == stored).expect("the bounds");
    for word in 0..10 {
        let mut bytes = bytes.clone();
        bytes[at + 4 * word + 2] ^= 1;
        fails(&with_valid_checksums(&bytes), Fault::Malformed, "other bounds than its vertices");
    }
    let table = table_of_levels(&file.objects[0].simplified);
    assert!(table.len() > 2 && table[0].triangles == 12, "{table:?}");
    let start = u64::from_le_bytes(std::array::from_fn(|i| bytes[FIRST + 40 + 16 + i])) as usize;
    for (word, problem) in [
        (5, "has a level that the object has not, or not in order"),
        (6, "has other numbers"),
        (7, "has other numbers"),
        (8, "has other numbers"),
        (9, "has other numbers"),
    ] {
        let mut bytes = bytes.clone();
        bytes[start + 4 * word] ^= 0x40;
        fails(&with_valid_checksums(&bytes), Fault::Malformed, problem);
    }
}

#[test]
fn sections_of_the_gpu_layout_can_be_bound_where_they_lie() {
    let bytes = write(&wide(&gltf_file(&["quantised_torus", "skinned_tube_u8"])));
    let mut narrow = 0;
    for section in sections(&bytes).expect("a sound file").into_iter().filter(|s| s.wide) {
        let at = section.bytes.as_ptr() as usize - bytes.as_ptr() as usize;
        assert!(at.is_multiple_of(256) && section.bytes.len().is_multiple_of(4), "{section:?}");
    }
    let file = read(&bytes).expect("a sound file");
    for (number, object) in (0..).zip(&file.objects) {
        let mesh = object.simplified.mesh();
        for (index, attribute) in (0..).zip(mesh.attributes()) {
            let find =
                |s: &Section<'_>| s.tag == *b"ATTR" && s.object == Some(number) && s.index == index;
            let sections = sections(&bytes).expect("a sound file");
            let section = sections.into_iter().find(find).expect("an attribute");
            let stride = attribute.stride().next_multiple_of(4);
            narrow += usize::from(stride != attribute.stride());
            assert_eq!(section.bytes.len(), stride * mesh.vertex_count());
        }
    }
    assert!(narrow > 0, "no stride was padded");
}

#[test]
fn a_sequence_that_ends_with_triangles_left_is_refused() {
    let mut bytes = write(&obj_file("cube"));
    let entry = (HEADER_BYTES..)
        .step_by(40)
        .find(|&e| bytes[e..].starts_with(b"STRI"))
        .expect("the section's entry");
    let u64_at = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i])) as usize;
    let (start, length) = (u64_at(entry + 16), u64_at(entry + 24));
    let killer = (start..start + length).rfind(|&i| bytes[i] > 0).expect("a step that kills");
    bytes[killer] -= 1;
    let bytes = with_valid_checksums(&bytes);
    fails(&bytes, Fault::Malformed, "section STRI of object 0: the last step leaves 1 triangles");
}

#[test]
fn crafted_tables_are_refused_by_name() {
    let offset_of = |entry: usize, bytes: &[u8]| {
        u64::from_le_bytes(std::array::from_fn(|i| bytes[entry + 16 + i]))
    };
    let overlap = crafted(|b| {
        let offset = offset_of(SECOND, b) - 16;
        set(b, SECOND + 16, offset.to_le_bytes());
    });
    fails(&overlap, Fault::Malformed, "overlaps");
    let gap = crafted(|b| {
        let offset = offset_of(SECOND, b) + 16;
        set(b, SECOND + 16, offset.to_le_bytes());
    });
    fails(&gap, Fault::Malformed, "leaves a gap");
    for huge in [1u64 << 40, u64::MAX, u64::MAX - 15] {
        fails(
            &crafted(|b| set(b, SECOND + 24, huge.to_le_bytes())),
            Fault::Malformed,
            "do not fit into the file",
        );
        fails(&crafted(|b| set(b, SECOND + 16, huge.to_le_bytes())), Fault::Malformed, "starts at");
        fails(&crafted(|b| set(b, 16, huge.to_le_bytes())), Fault::Malformed, "cut off");
    }
    fails(&crafted(|b| set(b, 12, u32::MAX.to_le_bytes())), Fault::Malformed, "does not fit into");
    fails(&crafted(|b| set(b, SECOND, *b"MANI")), Fault::Malformed, "occurs twice");
}

#[test]
fn counts_in_the_manifest_that_are_too_large_are_refused_without_allocating() {
    // Format, content hash and the kind of document come before the count of objects, the length
    // of the first and the length of its name.
    let bytes = write(&gltf_file(&["cube"]));
    let start = u64::from_le_bytes(std::array::from_fn(|i| bytes[FIRST + 16 + i])) as usize;
    let objects = start + 1 + 16 + 4;
    let record = objects + 8;
    let name = record + 8;
    for at in [objects, record, name] {
        for count in [1u64 << 40, u64::MAX, u64::MAX / 2] {
            fails(&crafted(|b| set(b, at, count.to_le_bytes())), Fault::Malformed, "section MANI");
        }
    }
}

#[test]
fn streams_that_leave_out_too_many_zeros_are_refused() {
    let mut small = OmittedZeros::of_file(1000);
    assert!(small.take((32 << 20) + 2000));
    assert!(!small.take(1));
    let mut none = OmittedZeros::of_file(usize::MAX);
    assert!(none.take(u64::MAX));
}

#[test]
fn mutations_that_pass_the_checksums_never_panic() {
    let originals = [
        write(&gltf_file(&["machine_part", "cube"])),
        write(&obj_file("skinned_tube_u8")),
        write(&wide(&all_models_file())),
    ];
    let mut rng = fixtures::Rng::new(2024);
    let mut read_whole = 0;
    for round in 0..20_000 {
        let mut bytes = originals[round % 3].clone();
        let sections = u32::from_le_bytes(std::array::from_fn(|i| bytes[12 + i])) as usize;
        for _ in 0..=rng.below(3) {
            // Half of the changes hit the table and the manifest, which are small.
            let front = HEADER_BYTES + 40 * sections + 600;
            let range = if rng.one_in(2) { front.min(bytes.len()) } else { bytes.len() };
            let at = rng.below(range);
            match rng.below(4) {
                0 => bytes[at] ^= 1 << rng.below(8),
                1 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][rng.below(5)],
                2 => bytes[at] = rng.bits() as u8,
                _ => {
                    let value = [0, 1, u32::MAX, 1 << 31, rng.bits() as u32][rng.below(5)];
                    let at = (at & !3).min(bytes.len() - 4);
                    set(&mut bytes, at, value.to_le_bytes());
                }
            }
        }
        if rng.one_in(10) {
            bytes.truncate(rng.below(bytes.len()));
            let length = bytes.len() as u64;
            if length >= HEADER_BYTES as u64 {
                set(&mut bytes, 16, length.to_le_bytes());
            }
        }
        if let Ok(file) = read(&with_valid_checksums(&bytes)) {
            read_whole += 1;
            for o in &file.objects {
                // What can be read can be used.
                for model in &o.models {
                    let mut cursor = model.cursor();
                    for lod in
                        [o.simplified.collapses().last(), lodc_mesh::Lod(7), lodc_mesh::Lod(0)]
                    {
                        model.seek(&mut cursor, lod, &mut ());
                        let _ = o.simplified.mesh().extract(&model.triangles(&cursor));
                    }
                }
            }
        }
    }
    assert!(
        read_whole > 1000,
        "only {read_whole} mutations got past the reader: the test reaches nothing"
    );
}
