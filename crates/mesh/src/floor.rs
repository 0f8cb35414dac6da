//! Rounding down, fast on processors that have no instruction for it.

/// Returns the largest whole number that is not above `x`. On processors without such an
/// instruction the standard library calls a function for it, which is noticeably slower where
/// millions of texels are read.
#[inline]
#[must_use]
pub fn floor(x: f32) -> f32 {
    // Floats from 2^23 on are whole numbers.
    const ALWAYS_WHOLE_FROM: f32 = 8_388_608.0;
    if x.abs() >= ALWAYS_WHOLE_FROM {
        return x;
    }
    let towards_zero = x as i32 as f32;
    if towards_zero > x { towards_zero - 1.0 } else { towards_zero }
}

#[cfg(test)]
mod tests {
    use super::floor;

    #[test]
    fn floors_are_those_of_the_standard_library() {
        let neighbours = |x: f32| [x.next_down(), x, x.next_up(), x + 0.5, -x, -x - 0.25];
        let numbers = [0.0, 1.0, 2.5, 1e-30, 255.0, 8_388_607.5, 8_388_608.0, 3e9, 1e30];
        for x in numbers.into_iter().flat_map(neighbours) {
            assert_eq!(floor(x), x.floor(), "{x}");
        }
    }
}
