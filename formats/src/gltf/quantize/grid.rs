//! Uniform quantisation grids: a value is stored as a whole number of 16 bits, of which
//! `offset + step * number` gives it back to half a step.

/// The largest number of a grid: that of an unsigned integer of 16 bits.
const MAX_NUMBER: f64 = 65_535.0;

/// A grid: a value is `offset + step * number`, numbers being whole, from 0 to 65,535.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid<const N: usize> {
    pub(super) offset: [f64; N],
    pub(super) step: f64,
}

impl<const N: usize> Grid<N> {
    /// The grid over some values whose offset is a multiple of its step, so that two grids of one
    /// step have their numbers at the same places. The values span fewer than 65,535 steps.
    pub(super) fn aligned(bounds: &Bounds<N>, step: f64) -> Self {
        Self { offset: bounds.lo.map(|lo| (lo / step).floor() * step), step }
    }

    /// The grid over some values whose longest side has 2^bits − 1 steps.
    pub(super) fn spanning(bounds: &Bounds<N>, bits: u8) -> Self {
        let longest = bounds.longest();
        let step =
            if longest > 0.0 { rounded_to_seven_digits(longest / last_number(bits)) } else { 1.0 };
        Self { offset: bounds.lo, step }
    }

    /// The numbers that are nearest to a value.
    pub(super) fn numbers(&self, value: [f32; N]) -> [u16; N] {
        std::array::from_fn(|k| {
            let number = (f64::from(value[k]) - self.offset[k]) / self.step;
            number.round().clamp(0.0, MAX_NUMBER) as u16
        })
    }

    /// The value on the grid that is nearest to one.
    pub(super) fn rounded(&self, value: [f32; N]) -> [f32; N] {
        let numbers = self.numbers(value);
        std::array::from_fn(|k| (self.offset[k] + self.step * f64::from(numbers[k])) as f32)
    }
}

/// The largest number of `bits` bits.
pub(super) fn last_number(bits: u8) -> f64 {
    f64::from((1u32 << bits) - 1)
}

/// A value rounded to seven digits: documents state it in short, and steps that differ by rounding
/// alone become the same.
pub(super) fn rounded_to_seven_digits(value: f64) -> f64 {
    format!("{value:.6e}").parse().expect("a number was written")
}

/// The box of some values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds<const N: usize> {
    lo: [f64; N],
    hi: [f64; N],
}

impl<const N: usize> Bounds<N> {
    /// The box of no value.
    pub(super) const EMPTY: Self = Self { lo: [f64::INFINITY; N], hi: [f64::NEG_INFINITY; N] };

    pub(super) fn add(&mut self, value: [f64; N]) {
        self.join(&Self { lo: value, hi: value });
    }

    pub(super) fn join(&mut self, other: &Self) {
        for k in 0..N {
            self.lo[k] = self.lo[k].min(other.lo[k]);
            self.hi[k] = self.hi[k].max(other.hi[k]);
        }
    }

    /// The length of the longest side; negative without a value.
    pub(super) fn longest(&self) -> f64 {
        (0..N).map(|k| self.hi[k] - self.lo[k]).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The power of two that is nearest to a step of which the longest side has 2^bits − 1.
    pub(super) fn binary_step(&self, bits: u8) -> f64 {
        let wanted = self.longest() / last_number(bits);
        let normal = f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX);
        let mut step = 1.0;
        while normal.contains(&wanted) && step > wanted * std::f64::consts::SQRT_2 {
            step /= 2.0;
        }
        while normal.contains(&wanted) && step * std::f64::consts::SQRT_2 < wanted {
            step *= 2.0;
        }
        step
    }

    /// The corners of the box.
    pub(super) fn corners(&self) -> impl Iterator<Item = [f64; N]> + '_ {
        let side =
            |corner: usize, k: usize| if corner >> k & 1 == 0 { self.lo[k] } else { self.hi[k] };
        (0..1 << N).map(move |corner| std::array::from_fn(|k| side(corner, k)))
    }
}
