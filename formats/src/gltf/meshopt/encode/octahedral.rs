//! The octahedral filter: unit vectors as two numbers on an octahedron.

use crate::import::gltf::meshopt::{Filter, unfiltered};

/// The nearest whole number and its neighbours, as differences.
const NEAR: [i32; 3] = [0, -1, 1];

/// Bytes of a component of so many bits.
const fn size(bits: u8) -> usize {
    if bits <= 8 { 1 } else { 2 }
}

/// A vector on the octahedron: two numbers of `bits` bits (2 to 16), their largest value, and `w`
/// from −1 to 1 in all bits of its bytes. What has no direction becomes the third axis.
pub(in super::super) fn packed(bits: u8, vector: [f32; 3], w: f32) -> [i32; 4] {
    let [x, y, z] = vector.map(f64::from);
    let sum = x.abs() + y.abs() + z.abs();
    let (x, y) = if sum > 0.0 && sum.is_finite() { (x / sum, y / sum) } else { (0.0, 0.0) };
    // The lower half is folded over the corners of the upper one.
    let fold = |a: f64, b: f64| if a >= 0.0 { 1.0 - b.abs() } else { b.abs() - 1.0 };
    let (x, y) = if z < 0.0 { (fold(x, y), fold(y, x)) } else { (x, y) };
    let one = (1 << (bits - 1)) - 1;
    let number = |v: f64| (v * f64::from(one)).round() as i32;
    let all = (1 << (8 * size(bits) - 1)) - 1;
    [number(x), number(y), one, (f64::from(w) * f64::from(all)).round() as i32]
}

/// The components of a packed vector as the decoder gives them: fractions of all bits of their
/// bytes.
pub(in super::super) fn unpacked(bits: u8, packed: [i32; 4]) -> [i32; 4] {
    let size = size(bits);
    let mut bytes: Vec<u8> =
        packed.iter().flat_map(|v| v.to_le_bytes().into_iter().take(size)).collect();
    unfiltered(Filter::Octahedral, 4 * size, &mut bytes);
    std::array::from_fn(|k| component(&bytes[k * size..][..size]))
}

fn component(bytes: &[u8]) -> i32 {
    match *bytes {
        [low, high] => i16::from_le_bytes([low, high]).into(),
        _ => i32::from(bytes[0] as i8),
    }
}

/// Packs vectors of three or four components, at `stride` bytes from each other. None unless the
/// decoder will give back every byte.
pub(super) fn encode(bits: u8, stride: usize, bytes: &[u8]) -> Option<Vec<u8>> {
    let size = size(bits);
    if stride != 4 * size || !bytes.len().is_multiple_of(stride) {
        return None;
    }
    let all = ((1 << (8 * size - 1)) - 1) as f32;
    let mut out = Vec::with_capacity(bytes.len());
    for element in bytes.chunks_exact(stride) {
        let values: [i32; 4] = std::array::from_fn(|k| component(&element[k * size..][..size]));
        let [x, y, z, w] = values.map(|v| v as f32 / all);
        let near = packed(bits, [x, y, z], w);
        // Rounding to bytes may have moved it to a neighbour.
        let neighbours =
            (0..9).map(|i| [near[0] + NEAR[i % 3], near[1] + NEAR[i / 3], near[2], near[3]]);
        let packed = neighbours.into_iter().find(|&packed| unpacked(bits, packed) == values)?;
        out.extend(packed.iter().flat_map(|v| v.to_le_bytes().into_iter().take(size)));
    }
    Some(out)
}
