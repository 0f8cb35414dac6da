//! The filters that turn decoded attributes into what the accessors mean, rounding as the
//! specification has it, and those of floats and of unit vectors the other way.

use super::Filter;

/// Bits of a float's mantissa, without the leading one; also those of the exponential filter's
/// whole number without its sign.
const MANTISSA: u32 = 23;
/// A float's stored exponent minus the power of two of its mantissa's last bit.
const BIAS: i32 = 127 + MANTISSA as i32;

/// Differences of the nearest whole number and of its two neighbours from the nearest.
const NEIGHBOURS: [i32; 3] = [0, -1, 1];

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
    let largest = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let left_out = (w & 3) as usize;
    let mut out = [0; 4];
    for (i, value) in [largest, x, y, z].into_iter().enumerate() {
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

/// Packs elements of floats, `stride` bytes each, with one power of two per component. None unless
/// the decoder will give back every byte.
pub(super) fn packed_floats(stride: usize, bytes: &[u8]) -> Option<Vec<u8>> {
    let mut powers = vec![i32::MAX; stride / 4];
    for element in bytes.chunks_exact(stride) {
        for (power, b) in powers.iter_mut().zip(element.as_chunks::<4>().0) {
            *power = (*power).min(lowest_bit(u32::from_le_bytes(*b)));
        }
    }
    // A component that is 0 everywhere.
    powers.iter_mut().filter(|p| **p == i32::MAX).for_each(|p| *p = 0);
    if powers.iter().any(|power| !(-100..100).contains(power)) {
        return None;
    }
    let mut packed = Vec::with_capacity(bytes.len());
    for element in bytes.chunks_exact(stride) {
        for (power, b) in powers.iter().zip(element.as_chunks::<4>().0) {
            packed.extend(exponential_word(u32::from_le_bytes(*b), *power)?.to_le_bytes());
        }
    }
    let mut again = packed.clone();
    apply(Filter::Exponential, stride, &mut again);
    (again == bytes).then_some(packed)
}

/// The power of two of the lowest bit of a float that is set; the largest number for 0.
fn lowest_bit(float: u32) -> i32 {
    if float & (u32::MAX >> 1) == 0 { i32::MAX } else { exponent(float) - BIAS + zeros(float) }
}

fn exponent(float: u32) -> i32 {
    (float >> MANTISSA & 0xff) as i32
}

fn mantissa(float: u32) -> u32 {
    float & ((1 << MANTISSA) - 1) | 1 << MANTISSA
}

fn zeros(float: u32) -> i32 {
    mantissa(float).trailing_zeros() as i32
}

/// A float as a whole number times a power of two: the power in the highest 8 bits. None if it has
/// too many bits.
fn exponential_word(float: u32, power: i32) -> Option<i32> {
    if float & (u32::MAX >> 1) == 0 {
        return Some(power << 24);
    }
    let shift = u32::try_from(lowest_bit(float) - power).ok()?;
    let odd = mantissa(float) >> zeros(float);
    let fits =
        shift < MANTISSA && odd.checked_shl(shift)? >> shift == odd && odd << shift < 1 << MANTISSA;
    let magnitude = (odd << (shift & 31)) as i32;
    let signed = if float >> 31 == 1 { -magnitude } else { magnitude };
    fits.then_some(power << 24 | signed & 0xff_ffff)
}

/// Bytes of a component of `bits` bits.
const fn size(bits: u8) -> usize {
    if bits <= 8 { 1 } else { 2 }
}

/// A vector on the octahedron: two numbers of `bits` bits (2 to 16), their largest value, and `w`
/// from −1 to 1 in all bits of its bytes. What has no direction becomes the third axis.
pub(crate) fn packed_direction(bits: u8, vector: [f32; 3], w: f32) -> [i32; 4] {
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
pub(crate) fn unpacked_direction(bits: u8, packed: [i32; 4]) -> [i32; 4] {
    let size = size(bits);
    let mut bytes: Vec<u8> =
        packed.iter().flat_map(|v| v.to_le_bytes().into_iter().take(size)).collect();
    apply(Filter::Octahedral, 4 * size, &mut bytes);
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
pub(super) fn packed_directions(bits: u8, stride: usize, bytes: &[u8]) -> Option<Vec<u8>> {
    let size = size(bits);
    if stride != 4 * size || !bytes.len().is_multiple_of(stride) {
        return None;
    }
    let all = ((1 << (8 * size - 1)) - 1) as f32;
    let mut out = Vec::with_capacity(bytes.len());
    for element in bytes.chunks_exact(stride) {
        let values: [i32; 4] = std::array::from_fn(|k| component(&element[k * size..][..size]));
        let [x, y, z, w] = values.map(|v| v as f32 / all);
        let [x, y, one, w] = packed_direction(bits, [x, y, z], w);
        // Rounding to bytes may have moved it to a neighbour.
        let neighbours = (0..9).map(|i| [x + NEIGHBOURS[i % 3], y + NEIGHBOURS[i / 3], one, w]);
        let packed =
            neighbours.into_iter().find(|&packed| unpacked_direction(bits, packed) == values)?;
        out.extend(packed.iter().flat_map(|v| v.to_le_bytes().into_iter().take(size)));
    }
    Some(out)
}
