//! Pinned streams of every codec and version, damaged in every simple way; and what is encoded is
//! decoded, byte for byte.

use super::filter::{packed_direction, packed_directions, packed_floats, unpacked_direction};
use super::{Filter, Layout, Mode, decode, filter, index, vertex};
use crate::testing::Random;
use lodc_mesh::{Mesh, SplitMix64};

const V0: &str = "a01f0002060a0e12161a1e22262a2e32363a3e42464a4e52565a5e62666a6e72767affff00007e82\
    868a8e92969a1f00040c141c242c343c444c545c646c747c848c949ca4acb4bcc4ccd4dce4ecf4ffff0000fcfbf3eb\
    e3dbd3cb1f0006121e2a36424e5a66727e8a96a2aebac6d2deeaf6fdf1e5d9cdc1b5a99d91ffff000085796d615549\
    3d311f0008182838485868788898a8b8c8d8e8f8f7e7d7c7b7a7978777675747372717ffff00000708182838485868\
    1f000a1e32465a6e8296aabed2e6faf1ddc9b5a18d7965513d29150112263a4e62ffff0000768a9eb2c6daeefd1f00\
    0c243c546c849cb4cce4fcebd3bba38b735b432b13041c344c647c94acc4dcffff0000f4f3dbc3ab937b631f000e2a\
    46627e9ab6d2eef5d9bda185694d311506223e5a7692aecae6fde1c5a9ffdf00008d7155391d1a361f001030507090\
    b0d0f0efcfaf8f6f4f2f0f1030507090b0d0f0efcfaf8f6f4f2fffff00000f1030507090b0d0000000000000000000\
    0000000000000000000000000000000011223344556677";
const V1: &str = "a1979a00585858585858585858585858585858585858585858585858585858585858585858585858\
    585858152aaaaaaaaaaaaaaaaaaa00002a0ddddddddddddddddddddddddddddddddddddddd000000002a0444444444\
    4444444444444444444444444444440000000000000000000000000000000000000000ffff0000803f0100";
const TRIANGLES: &str = "e1f010001000100010001000100010001000100010ffffffe807e107ae013f89011b00768\
    7566778a9866589689801690000";
const INDICES: &str = "d10004040002080204040002080204040002080204040002080204040002080204040002080\
    20404000208020404000208020404000208020404000208d10f46e70c48e90c3600000000";

fn bytes(hex: &str) -> Vec<u8> {
    let digit = |b: u8| char::from(b).to_digit(16).expect("a hexadecimal digit") as u8;
    hex.as_bytes().chunks_exact(2).map(|c| digit(c[0]) << 4 | digit(c[1])).collect()
}

/// A strip, then two triangles far from everything.
fn indices() -> Vec<u32> {
    let strip =
        (0..20).flat_map(|i| if i % 2 == 1 { [i + 1, i, i + 2] } else { [i, i + 1, i + 2] });
    strip.chain([500, 3, 90, 21, 500, 7]).collect()
}

/// Each stream, how it is laid out, and what is in it.
fn pinned() -> Vec<(Vec<u8>, Layout, Vec<u8>)> {
    let layout = |mode, count, stride| Layout { mode, filter: Filter::None, count, stride };
    let squares =
        (0..40u32).flat_map(|i| (0..8u32).map(move |k| (i * i * (k + 1) + k * 17) as u8)).collect();
    let rows = (0..40u16).flat_map(|i| {
        let float = (1.0 + f32::from(i) / 64.0).to_le_bytes();
        [&(i * 300).to_le_bytes()[..], &(65535 - i * 7).to_le_bytes(), &float].concat()
    });
    let wide: Vec<u8> = indices().iter().flat_map(|i| i.to_le_bytes()).collect();
    vec![
        (bytes(V0), layout(Mode::Attributes, 40, 8), squares),
        (bytes(V1), layout(Mode::Attributes, 40, 8), rows.collect()),
        (bytes(TRIANGLES), layout(Mode::Triangles, 66, 4), rotated(&wide)),
        (bytes(INDICES), layout(Mode::Indices, 66, 4), wide),
    ]
}

/// Triangles with their smallest index first: the codec may turn them.
fn rotated(wide: &[u8]) -> Vec<u8> {
    let number = |b: &[u8]| u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let mut out = Vec::new();
    for t in wide.chunks_exact(12) {
        let mut t = [number(&t[..4]), number(&t[4..8]), number(&t[8..])];
        let first = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
        t.rotate_left(first);
        out.extend(t.iter().flat_map(|i| i.to_le_bytes()));
    }
    out
}

#[test]
fn pinned_streams_decode_to_what_was_encoded() {
    for (stream, layout, expected) in pinned() {
        let out = decode(&layout, &stream).expect("a sound stream");
        let out = if layout.mode == Mode::Triangles { rotated(&out) } else { out };
        assert_eq!(out, expected, "{layout:?}");
    }
}

#[test]
fn prefixes_extra_bytes_and_next_versions_are_refused() {
    for (stream, layout, _) in pinned() {
        for end in 0..stream.len() {
            // The table of a triangle stream stands at its end, so that a prefix can happen to be
            // another stream.
            let other = layout.mode == Mode::Triangles && end > 40;
            assert!(other || decode(&layout, &stream[..end]).is_err(), "{layout:?} {end}");
        }
        let mut longer = stream.clone();
        longer.insert(1, 0);
        assert!(decode(&layout, &longer).is_err(), "{layout:?}");
        let mut newer = stream.clone();
        newer[0] = newer[0] & 0xf0 | 2;
        assert!(decode(&layout, &newer).is_err(), "{layout:?}");
    }
}

#[test]
fn wrong_counts_are_refused_or_decode_to_their_size() {
    for (stream, layout, _) in pinned() {
        for count in (0..200).chain([1 << 20, 3 << 40, usize::MAX / 3 * 3]) {
            let layout = Layout { count, ..layout };
            if layout.check().is_ok()
                && let Ok(out) = decode(&layout, &stream)
            {
                assert_eq!(out.len(), count * layout.stride);
            }
        }
    }
}

#[test]
fn damaged_streams_never_panic() {
    for case in 0..20_000 {
        let mut random = Random(case);
        let (mut stream, layout, _) = pinned().swap_remove((case % 4) as usize);
        for _ in 0..=random.below(4) {
            let offset = 1 + random.below(stream.len() - 1);
            stream[offset] = random.next() as u8;
        }
        if let Ok(out) = decode(&layout, &stream) {
            assert_eq!(out.len(), layout.count * layout.stride);
        }
    }
}

#[test]
fn layouts_that_the_extension_forbids_are_refused() {
    let layout = |mode, filter, count, stride| Layout { mode, filter, count, stride };
    for bad in [
        layout(Mode::Attributes, Filter::None, 4, 3),
        layout(Mode::Attributes, Filter::None, 4, 0),
        layout(Mode::Attributes, Filter::None, 4, 260),
        layout(Mode::Attributes, Filter::Octahedral, 4, 12),
        layout(Mode::Attributes, Filter::Quaternion, 4, 4),
        layout(Mode::Triangles, Filter::None, 4, 4),
        layout(Mode::Triangles, Filter::None, 3, 1),
        layout(Mode::Indices, Filter::Exponential, 3, 4),
    ] {
        assert!(bad.check().is_err(), "{bad:?}");
    }
}

fn filtered(kind: Filter, stride: usize, values: &[u8]) -> Vec<u8> {
    let mut out = values.to_vec();
    filter::apply(kind, stride, &mut out);
    out
}

fn wide(values: [i16; 4]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

#[test]
fn octahedra_unfold_to_unit_vectors() {
    assert_eq!(filtered(Filter::Octahedral, 4, &[0, 0, 127, 9]), [0, 0, 127, 9]);
    assert_eq!(filtered(Filter::Octahedral, 4, &[127, 0, 127, 9]), [127, 0, 0, 9]);
    assert_eq!(filtered(Filter::Octahedral, 4, &[127, 127, 127, 9]), [0, 0, 129, 9]);
    assert_eq!(filtered(Filter::Octahedral, 8, &wide([0, -511, 511, 1])), wide([0, -32767, 0, 1]));
    // No direction at all, which no encoder writes.
    assert_eq!(filtered(Filter::Octahedral, 4, &[0, 0, 0, 0]), [0; 4]);
}

#[test]
fn quaternions_get_their_largest_component_back() {
    for largest in 0..4 {
        let mut expected = [0; 4];
        expected[largest] = 32767;
        assert_eq!(
            filtered(Filter::Quaternion, 8, &wide([0, 0, 0, 32764 | largest as i16])),
            wide(expected)
        );
    }
    let halves = filtered(Filter::Quaternion, 8, &wide([23170, 0, 0, 32767]));
    assert_eq!(halves, wide([16384, 0, 0, 28377]));
}

#[test]
fn exponents_reach_from_subnormal_numbers_to_infinity() {
    let one = |exponent: i32, mantissa: i32| {
        let packed = (exponent << 24 | mantissa & 0xff_ffff).to_le_bytes();
        let out = filtered(Filter::Exponential, 4, &packed);
        f32::from_le_bytes([out[0], out[1], out[2], out[3]])
    };
    assert_eq!(one(0, 5), 5.0);
    assert_eq!(one(-1, -3), -1.5);
    assert_eq!(one(-128, 1), f32::from_bits(1 << 21));
    assert_eq!(one(-127, 4), f32::MIN_POSITIVE * 2.0);
    assert_eq!(one(127, 1), 2f32.powi(127));
    assert_eq!(one(127, 2), f32::INFINITY);
}

#[test]
fn colours_come_back_from_luma_and_chroma() {
    // 8 bits: full alpha in 7 bits below the mark; a grey of half brightness has no chroma.
    assert_eq!(filtered(Filter::Color, 4, &[128, 0, 0, 255]), [128, 128, 128, 255]);
    assert_eq!(filtered(Filter::Color, 4, &[100, 20, 246, 128]), [130, 90, 90, 0]);
}

fn decoded(mode: Mode, count: usize, stride: usize, bytes: &[u8]) -> Result<Vec<u8>, &'static str> {
    let layout = Layout { mode, filter: Filter::None, count, stride };
    layout.check()?;
    decode(&layout, bytes)
}

/// Triangles turned so that their numbers are smallest in order, also where two corners are equal.
fn turned(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let turn = |&[a, b, c]: &[u32; 3]| [a, b, c].min([b, c, a]).min([c, a, b]);
    triangles.iter().map(turn).collect()
}

fn check_triangles(triangles: &[[u32; 3]]) {
    let bytes = index::encode(triangles);
    let decoded = decoded(Mode::Triangles, 3 * triangles.len(), 4, &bytes).expect("decodes");
    let indices: Vec<u32> =
        decoded.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    assert_eq!(turned(indices.as_chunks().0), turned(triangles));
}

#[test]
fn triangles_come_back_turned_at_most() {
    for (name, make) in lodc_fixtures::ALL {
        let mesh: Mesh = make();
        check_triangles(mesh.triangles());
        // Two primitives, one behind the other, with numbers of their own.
        check_triangles(&[mesh.triangles(), mesh.triangles()].concat());
        let arranged = mesh.arranged(|m| m.triangles().to_vec());
        check_triangles(arranged.triangles());
        assert!(!name.is_empty());
    }
    let mut random = SplitMix64::new(7);
    for range in [3, 20, 1000, u32::MAX - 1] {
        let mut index = || (random.bits() % u64::from(range)) as u32;
        let triangles: Vec<[u32; 3]> = (0..500).map(|_| [index(), index(), index()]).collect();
        check_triangles(&triangles);
    }
}

#[test]
fn attributes_come_back_byte_for_byte() {
    let mut random = SplitMix64::new(11);
    for stride in [4, 8, 12, 16, 32, 48, 256] {
        for count in [1, 15, 16, 17, 255, 256, 257, 1000] {
            for spread in [1u64, 3, 7, 40, 256] {
                let mut value = 0u8;
                let bytes: Vec<u8> = (0..count * stride)
                    .map(|_| {
                        value = value.wrapping_add((random.bits() % spread) as u8);
                        value
                    })
                    .collect();
                let encoded = vertex::encode(stride, &bytes);
                let decoded = decoded(Mode::Attributes, count, stride, &encoded);
                assert_eq!(decoded.as_deref(), Ok(&bytes[..]), "{count} of {stride}");
            }
        }
    }
}

#[test]
fn directions_come_back_once_they_are_rounded() {
    let mut random = SplitMix64::new(13);
    let mut unit = || (random.bits() >> 40) as f32 / (1u32 << 23) as f32 - 1.0;
    for bits in 2..=16 {
        let size = if bits <= 8 { 1 } else { 2 };
        let mut bytes = Vec::new();
        for _ in 0..1000 {
            let vector = [unit(), unit(), unit()];
            let length = vector.iter().map(|c| c * c).sum::<f32>().sqrt();
            let out = unpacked_direction(bits, packed_direction(bits, vector, -1.0));
            let all = ((1 << (8 * size - 1)) - 1) as f32;
            for (a, b) in vector.iter().zip(out) {
                // A step of the octahedron, and one of the bytes.
                let limit = 5.0 / (1 << bits) as f32 + 1.0 / all;
                assert!((a / length - b as f32 / all).abs() < limit, "{bits}: {vector:?} {out:?}");
            }
            assert_eq!(out[3], -all as i32);
            bytes.extend(out.iter().flat_map(|v| v.to_le_bytes().into_iter().take(size)));
        }
        let mut packed = packed_directions(bits, 4 * size, &bytes).expect("they are rounded");
        filter::apply(Filter::Octahedral, 4 * size, &mut packed);
        assert_eq!(packed, bytes, "{bits}");
    }
    assert_eq!(packed_directions(10, 8, &[1; 8]), None, "no unit vector");
    let z = unpacked_direction(10, packed_direction(10, [0.0, f32::NAN, 0.0], 0.0));
    assert_eq!(z, [0, 0, 32767, 0], "what has no direction");
}

#[test]
fn multiples_of_a_power_of_two_come_back() {
    let bytes = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let mut random = SplitMix64::new(17);
    for (bits, power) in [(1, -20), (12, -12), (22, 3), (22, -60)] {
        let number = || ((random.bits() % (1 << bits)) as f32 - 1.0) * 2f32.powi(power);
        let plain = bytes(&std::iter::repeat_with(number).take(400).collect::<Vec<_>>());
        let mut packed = packed_floats(8, &plain).expect("they have few bits");
        filter::apply(Filter::Exponential, 8, &mut packed);
        assert_eq!(packed, plain);
    }
    for unfit in [[0.1, 1e9], [-0.0, 1.0], [f32::NAN, 0.0], [f32::INFINITY, 0.0], [1e-44, 0.0]] {
        // One component: 0.1 and 1e9 have no power of two in common.
        assert_eq!(packed_floats(4, &bytes(&unfit)), None, "{unfit:?}");
    }
}
