//! The errors that a sequence states, against distances that are measured here at a few levels.

use crate::distance::{Sampling, farther_than};
use crate::surface::Surface;
use lodc_mesh::{CollapseSequence, Lod, PositionIds, Simplified, SplitMix64, is_degenerate};
use lodc_nearest::TriangleTree;
use rayon::prelude::*;

/// Levels that are measured, spread over the triangle counts.
const LEVELS: u32 = 8;

/// Chooses the levels.
const SEED: u64 = 0x6572_726f_7273;

/// Fewer samples than [`Sampling::DEFAULT`]: a stored error that is half of the true one is found
/// all the same.
const SAMPLING: Sampling = Sampling { samples: 20_000, lattice: 30_000, seed: 0x5eed };

/// Measured distances may be so much larger than the stored ones, which know samples only.
const TOLERANCE: f64 = 1.05;

/// Compares the errors of a sequence with measured ones: returns how many levels were measured, and
/// what is wrong with the first whose error does not hold. `shape` is the surface that the scene
/// shows, a place for each vertex.
#[must_use]
pub fn check_errors(simplified: &Simplified, shape: &[[f32; 3]]) -> (usize, Option<String>) {
    let lods = levels(simplified.collapses());
    (lods.len(), first_difference(simplified, shape, &lods))
}

/// Returns levels with triangles, one by chance from each of some ranges of triangle counts.
fn levels(collapses: &CollapseSequence) -> Vec<Lod> {
    let mut random = SplitMix64::new(SEED);
    let mut above = f64::from(collapses.parts().triangles);
    let ratio = above.powf(1.0 / f64::from(LEVELS));
    let mut lods = Vec::new();
    for _ in 0..LEVELS {
        let below = above / ratio;
        let wanted = below + (above - below) * f64::from(random.unit());
        lods.push(collapses.lod_for_triangles(wanted as u32).min(collapses.last_visible()));
        above = below;
    }
    lods.dedup();
    lods.retain(|&lod| lod > Lod(0));
    lods
}

/// Returns what is wrong with the first level whose error does not hold.
fn first_difference(simplified: &Simplified, shape: &[[f32; 3]], lods: &[Lod]) -> Option<String> {
    let positions = PositionIds::new(simplified.mesh().positions());
    let input = surface(shape, simplified.mesh().triangles().to_vec());
    let tree = input.tree();
    // Rounding errors of coordinates are no differences.
    let slack = 1e-9 * input.diagonal();
    let check = |&lod: &Lod| {
        let stored = simplified.collapses().error_at(lod);
        let bound = TOLERANCE * f64::from(stored) + slack;
        let measured = measure(simplified, shape, &positions, &tree, lod, bound)?;
        Some(format!("LOD {}: the error is {stored}, measured are {measured}", lod.0))
    };
    lods.par_iter().with_max_len(1).find_map_first(check)
}

fn surface(shape: &[[f32; 3]], triangles: Vec<[u32; 3]>) -> Surface {
    let positions = shape.iter().map(|&p| p.into()).collect();
    Surface { positions, triangles, ..Surface::default() }
}

/// Returns the distance of a level from the input, the larger of both ways, if it is more than
/// `bound`. Triangles that both have are nowhere apart, so samples lie on the others.
fn measure(
    simplified: &Simplified,
    shape: &[[f32; 3]],
    positions: &PositionIds,
    input: &TriangleTree,
    lod: Lod,
    bound: f64,
) -> Option<f64> {
    let is_changed = |t: &[u32; 3]| t.iter().any(|&v| v < lod.0);
    let map = simplified.collapses().resolve_all(lod);
    let resolved = |t: [u32; 3]| t.map(|v| map[v as usize]);
    let is_live = |t: &[u32; 3]| !is_degenerate(t.map(|v| positions.of_vertex[v as usize]));
    let all = simplified.mesh().triangles();
    let changed: Vec<[u32; 3]> = all.iter().copied().filter(is_changed).collect();
    let result = changed.iter().copied().map(resolved).filter(is_live).collect();
    let back = || farther_than(&surface(shape, result), input, bound, &SAMPLING);
    let there = || {
        let shown = simplified.triangles_at_with(lod, positions);
        let shown = shown.iter().map(|t| t.corners).collect();
        let tree = surface(shape, shown).tree();
        farther_than(&surface(shape, changed), &tree, bound, &SAMPLING)
    };
    let (there, back) = rayon::join(there, back);
    there.into_iter().chain(back).max_by(f64::total_cmp)
}
