//! Orders points along a space-filling curve, so that groups near each other in space get numbers
//! near each other.

use rayon::prelude::*;

/// Bits for each coordinate: three make 33, which takes three passes of the radix sort. Groups in
/// one of the 2,048³ cells keep the order of the file. Chosen by hand: they are near each other
/// anyway.
const AXIS_BITS: u32 = 11;
/// Bits by which one pass sorts: its 2,048 counters of four bytes fit into a first-level cache.
const DIGIT_BITS: u32 = 11;
/// Keys that one thread computes at a time. Chosen by hand.
const KEYS_PER_TASK: usize = 1 << 14;

/// A cube in space, cut into cells along a Z-order curve: a cell's number has the bits of its three
/// coordinates in turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curve {
    origin: [f64; 3],
    cells_per_unit: f64,
}

impl Curve {
    /// The curve through a bounding box. `shift` is a share of its extent by which the curve's
    /// cells are moved against the box.
    pub(crate) fn new(lo: [f32; 3], hi: [f32; 3], shift: f64) -> Self {
        let (lo, hi) = (lo.map(f64::from), hi.map(f64::from));
        let extent = (0..3).map(|i| hi[i] - lo[i]).fold(0.0, f64::max);
        let extent_with_shift = (1.0 + shift) * extent;
        let cells_per_unit = if extent_with_shift > 0.0 {
            f64::from((1u32 << AXIS_BITS) - 1) / extent_with_shift
        } else {
            0.0
        };
        Self { origin: lo.map(|c| c - shift * extent), cells_per_unit }
    }

    /// Position of a point along the curve.
    fn code(&self, p: [f32; 3]) -> u64 {
        let cell = |i: usize| ((f64::from(p[i]) - self.origin[i]) * self.cells_per_unit) as u64;
        spread(cell(0)) | spread(cell(1)) << 1 | spread(cell(2)) << 2
    }

    /// The numbers of points in the order of the curve; points of one cell by number.
    pub(crate) fn order(&self, len: usize, point: impl Fn(usize) -> [f32; 3] + Sync) -> Vec<u32> {
        let mut keys = vec![0u64; len];
        keys.par_chunks_mut(KEYS_PER_TASK).enumerate().for_each(|(chunk, keys)| {
            for (key, i) in keys.iter_mut().zip(chunk * KEYS_PER_TASK..) {
                *key = self.code(point(i));
            }
        });
        sorted(len, 3 * AXIS_BITS, |i| keys[i as usize])
    }
}

/// The low bits of a number with two zeros between any two.
fn spread(x: u64) -> u64 {
    let mut x = x & ((1 << AXIS_BITS) - 1);
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

/// The numbers below `len` in rising order of keys below `2^bits`, equal keys by number (radix
/// sort).
pub(crate) fn sorted(len: usize, bits: u32, key: impl Fn(u32) -> u64) -> Vec<u32> {
    let mut order: Vec<u32> = (0..len as u32).collect();
    let mut sorted = vec![0u32; len];
    for shift in (0..bits).step_by(DIGIT_BITS as usize) {
        let digit = |i: u32| (key(i) >> shift) as usize & ((1 << DIGIT_BITS) - 1);
        let mut start = vec![0u32; (1 << DIGIT_BITS) + 1];
        for i in 0..len as u32 {
            start[digit(i) + 1] += 1;
        }
        for d in 1..start.len() {
            start[d] += start[d - 1];
        }
        for &i in &order {
            let slot = &mut start[digit(i)];
            sorted[*slot as usize] = i;
            *slot += 1;
        }
        std::mem::swap(&mut order, &mut sorted);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_sorted_and_equal_ones_keep_their_order() {
        let mut random = lodc_fixtures::Rng::new(3);
        let keys: Vec<u64> = (0..5000).map(|_| random.below(1 << 20) as u64 >> 8).collect();
        let mut expected: Vec<u32> = (0..5000).collect();
        expected.sort_by_key(|&i| (keys[i as usize], i));
        assert_eq!(sorted(5000, 33, |i| keys[i as usize]), expected);
    }

    #[test]
    fn the_curve_visits_the_octants_of_a_box_one_after_another() {
        let points: Vec<[f32; 3]> =
            (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2 & 1].map(|c| c as f32)).collect();
        let curve = Curve::new([0.0; 3], [1.0; 3], 0.0);
        let reversed = |i: usize| points[7 - i];
        assert_eq!(curve.order(8, reversed), [7, 6, 5, 4, 3, 2, 1, 0]);
    }
}
