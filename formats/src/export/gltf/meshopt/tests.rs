//! What is encoded is decoded by the decoder of imports, byte for byte.

use super::{index, vertex};
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
