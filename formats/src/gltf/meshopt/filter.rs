//! The filters that turn decoded attributes into what the accessors mean. Rounding as the
//! specification has it.

use super::Filter;

/// Applies a filter to all elements in place; `stride` fits it.
pub(crate) fn apply(filter: Filter, stride: usize, bytes: &mut [u8]) {
    let narrow = stride == 4;
    match filter {
        Filter::None => {}
        Filter::Exponential => bytes.chunks_exact_mut(4).for_each(exponential),
        Filter::Quaternion => {
            bytes.chunks_exact_mut(8).for_each(|b| store16(b, quaternion(load16(b))));
        }
        Filter::Octahedral if narrow => {
            bytes.chunks_exact_mut(4).for_each(|b| store8(b, octahedral(load8(b), 127.0)));
        }
        Filter::Octahedral => {
            bytes.chunks_exact_mut(8).for_each(|b| store16(b, octahedral(load16(b), 32767.0)));
        }
        Filter::Color if narrow => bytes.chunks_exact_mut(4).for_each(|b| {
            let q = color(load8(b).map(|v| v & 255), 8);
            b.copy_from_slice(&q.map(|v| v as u8));
        }),
        Filter::Color => bytes
            .chunks_exact_mut(8)
            .for_each(|b| store16(b, color(load16(b).map(|v| v & 65535), 16))),
    }
}

/// x, y on the octahedron and its size in z become a unit vector times `largest`; w stays. The
/// order of the sum and the rounding are those of the reference decoder where it has vector
/// instructions, in browsers, so that results are the same bit for bit.
fn octahedral([x, y, one, w]: [i32; 4], largest: f32) -> [i32; 4] {
    let (x, y) = (x as f32, y as f32);
    let z = one as f32 - x.abs() - y.abs();
    // The lower half of the octahedron is folded over its corners.
    let fold = z.min(0.0);
    let x = x + if x >= 0.0 { fold } else { -fold };
    let y = y + if y >= 0.0 { fold } else { -fold };
    let scale = largest / (x * x + (y * y + z * z)).sqrt();
    let [x, y, z] = [x, y, z].map(|v| (v * scale).round_ties_even() as i32);
    [x, y, z, w]
}

/// Three components, and in the fourth their scale with the index of the one left out in its two
/// lowest bits.
fn quaternion([x, y, z, w]: [i32; 4]) -> [i32; 4] {
    let scale = std::f32::consts::FRAC_1_SQRT_2 / (w | 3) as f32;
    let (x, y, z) = (x as f32 * scale, y as f32 * scale, z as f32 * scale);
    let rest = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let left_out = (w & 3) as usize;
    let mut out = [0; 4];
    for (i, value) in [rest, x, y, z].into_iter().enumerate() {
        out[(left_out + i) & 3] = nearest(value * 32767.0);
    }
    out
}

/// A signed mantissa of 24 bits and a signed exponent of 8.
fn exponential(b: &mut [u8]) {
    let v = i32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let (exponent, mantissa) = (v >> 24, v << 8 >> 8);
    // Two to a whole power, exact also below the normal numbers.
    let power = if exponent >= -126 {
        f32::from_bits(((exponent + 127) as u32) << 23)
    } else {
        f32::from_bits(1 << (exponent + 149).clamp(0, 22))
    };
    b.copy_from_slice(&(power * mantissa as f32).to_le_bytes());
}

/// Luma, two signed chroma and alpha, whose highest bit says how many bits the values have.
fn color([y, co, cg, a]: [i32; 4], bits: u32) -> [i32; 4] {
    let signed = |v: i32| if v >> (bits - 1) == 1 { v - (1 << bits) } else { v };
    let (co, cg) = (signed(co), signed(cg));
    let top = (a as u32).checked_ilog2().unwrap_or(0);
    let unit = ((1u32 << top << 1) - 1) as f32;
    let largest = ((1u32 << bits) - 1) as f32;
    let scale = largest / unit;
    let alpha = ((a << 1) & ((1 << top << 1) - 1)) | (a & 1);
    let out = |v: i32| nearest((v as f32 * scale).clamp(0.0, largest));
    [out(y + co - cg), out(y + cg), out(y - co - cg), out(alpha)]
}

/// Half away from zero, and 0 for what is not a number: a zero vector has no direction.
fn nearest(v: f32) -> i32 {
    (v + if v >= 0.0 { 0.5 } else { -0.5 }) as i32
}

fn load8(b: &[u8]) -> [i32; 4] {
    std::array::from_fn(|i| i32::from(b[i] as i8))
}
fn store8(b: &mut [u8], v: [i32; 4]) {
    b.copy_from_slice(&v.map(|v| v as u8));
}
fn load16(b: &[u8]) -> [i32; 4] {
    std::array::from_fn(|i| i32::from(i16::from_le_bytes([b[2 * i], b[2 * i + 1]])))
}
fn store16(b: &mut [u8], v: [i32; 4]) {
    for (two, v) in b.chunks_exact_mut(2).zip(v) {
        two.copy_from_slice(&(v as u16).to_le_bytes());
    }
}
