//! Sorts triangles along a Morton (Z-order) curve, so that neighbours in the order are near in
//! space.

use crate::bounds::Bounds;

/// Sorts triangles along a Morton curve through their centroids, 10 bits an axis.
#[must_use]
pub fn morton_order(
    triangles: impl Iterator<Item = u32> + Clone,
    corners: impl Fn(u32) -> [[f32; 3]; 3],
) -> Vec<u32> {
    let mut bounds = Bounds::EMPTY;
    for p in triangles.clone().flat_map(&corners) {
        bounds.include(p);
    }
    let (low, extent) = (bounds.low(), bounds.extent());
    let cells_per_unit = if extent > 0.0 { 1023.0 / extent } else { 0.0 };
    let code = |t: u32| {
        let [a, b, c] = corners(t);
        (0..3).fold(0, |code, i| {
            let middle = ((a[i] - low[i]) + (b[i] - low[i]) + (c[i] - low[i])) * (1.0 / 3.0);
            code | spread((middle * cells_per_unit) as u32) << i
        })
    };
    // A radix sort, ten bits at a time; stable, so ties are broken by the order of `triangles`.
    let mut keyed: Vec<(u32, u32)> = triangles.map(|t| (code(t), t)).collect();
    let mut sorted = vec![(0, 0); keyed.len()];
    for shift in [0, 10, 20] {
        let digit = |code: u32| (code >> shift) as usize & 1023;
        let mut starts = [0u32; 1025];
        for &(code, _) in &keyed {
            starts[digit(code) + 1] += 1;
        }
        for i in 0..1024 {
            starts[i + 1] += starts[i];
        }
        for &entry in &keyed {
            let slot = &mut starts[digit(entry.0)];
            sorted[*slot as usize] = entry;
            *slot += 1;
        }
        std::mem::swap(&mut keyed, &mut sorted);
    }
    keyed.into_iter().map(|(_, t)| t).collect()
}

/// Puts two zeros between the bits of a number of 10 bits.
fn spread(x: u32) -> u32 {
    let x = x.min(1023);
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}
