//! What is encoded is decoded by the decoder of imports, byte for byte.

use super::{exponential, index, octahedral, vertex};
use crate::import::gltf::meshopt::unfiltered;
use crate::import::gltf::meshopt::{Filter, Layout, Mode, decode};
use lodc_mesh::{Mesh, SplitMix64};

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
            let out = octahedral::unpacked(bits, octahedral::packed(bits, vector, -1.0));
            let all = ((1 << (8 * size - 1)) - 1) as f32;
            for (a, b) in vector.iter().zip(out) {
                // A step of the octahedron, and one of the bytes.
                let limit = 5.0 / (1 << bits) as f32 + 1.0 / all;
                assert!((a / length - b as f32 / all).abs() < limit, "{bits}: {vector:?} {out:?}");
            }
            assert_eq!(out[3], -all as i32);
            bytes.extend(out.iter().flat_map(|v| v.to_le_bytes().into_iter().take(size)));
        }
        let mut packed = octahedral::encode(bits, 4 * size, &bytes).expect("they are rounded");
        unfiltered(Filter::Octahedral, 4 * size, &mut packed);
        assert_eq!(packed, bytes, "{bits}");
    }
    assert_eq!(octahedral::encode(10, 8, &[1; 8]), None, "no unit vector");
    let z = octahedral::unpacked(10, octahedral::packed(10, [0.0, f32::NAN, 0.0], 0.0));
    assert_eq!(z, [0, 0, 32767, 0], "what has no direction");
}

#[test]
fn multiples_of_a_power_of_two_come_back() {
    let bytes = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let mut random = SplitMix64::new(17);
    for (bits, power) in [(1, -20), (12, -12), (22, 3), (22, -60)] {
        let number = || ((random.bits() % (1 << bits)) as f32 - 1.0) * 2f32.powi(power);
        let plain = bytes(&std::iter::repeat_with(number).take(400).collect::<Vec<_>>());
        let mut packed = exponential::encode(8, &plain).expect("they have few bits");
        unfiltered(Filter::Exponential, 8, &mut packed);
        assert_eq!(packed, plain);
    }
    for unfit in [[0.1, 1e9], [-0.0, 1.0], [f32::NAN, 0.0], [f32::INFINITY, 0.0], [1e-44, 0.0]] {
        // One component: 0.1 and 1e9 have no power of two in common.
        assert_eq!(exponential::encode(4, &bytes(&unfit)), None, "{unfit:?}");
    }
}
