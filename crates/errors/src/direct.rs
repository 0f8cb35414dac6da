//! Levels measured one by one: for the steps that are left where following all of them would take
//! too long, as in ribbons of slivers, whose samples go from face to face without end.
//!
//! Some levels are measured as two surfaces that know nothing of each other. All steps between two
//! of them are stated as the coarser one; where it is far more than the finer one, one between them
//! is measured, too.

use crate::floor::MARGIN;
use crate::input::Input;
use crate::step_errors::StepErrors;
use glam::DVec3;
use lodc_mesh::{NONE, Simplified};
use lodc_nearest::{Search, TriangleTree, area, point_at};
use rayon::prelude::*;

/// Shares of the triangles, in percent, whose levels are measured in any case: those that people
/// ask for.
const SHARES: [u64; 6] = [50, 25, 10, 5, 2, 1];

/// A level between two is measured if the coarser one's error is more than this times the finer
/// one's.
const LEAP: f64 = 2.0;

/// Most levels that are measured.
const MOST: usize = 40;

/// Boxes that may be opened for each triangle of the input, and besides: then the last level is
/// stated for all that are left.
const BOXES: [u64; 2] = [3_000, 10_000_000];

/// Boxes that the search for one of the points below may open.
const PATIENCE: u32 = 64;

/// Points on either surface that the mean is of.
const POINTS: f64 = 30_000.0;

/// States errors for all steps after those that have them.
pub(crate) fn complete(errors: &mut StepErrors, input: &Input, simplified: &Simplified) {
    let sequence = simplified.collapses();
    let first = errors.error.len();
    let left = |step: usize| sequence.step(step).triangles;
    let last = sequence.steps_at(sequence.last_visible());
    if first < last {
        let direct = Direct::new(input, simplified);
        let mut ends: Vec<usize> = (0..u32::BITS)
            .map(|halving| u64::from(left(first)) >> halving)
            .chain(SHARES.map(|share| u64::from(sequence.parts().triangles) * share / 100))
            .map(|wanted| sequence.steps_at(sequence.lod_for_triangles(wanted as u32)))
            .filter(|&end| (first + 1..=last).contains(&end))
            .chain([last])
            .collect();
        ends.sort_unstable();
        ends.dedup();
        let before = errors.error.last().map_or(0.0, |&e| f64::from(e));
        for (end, [error, rms]) in direct.measure(first, before, &ends) {
            while errors.error.len() < end {
                errors.push(error * MARGIN, rms.min(error * MARGIN));
            }
        }
    }
    for step in errors.error.len()..sequence.steps() {
        debug_assert_eq!(left(step), 0, "all steps with triangles are measured");
        errors.push(f64::INFINITY, f64::INFINITY);
    }
}

/// LOD 0, ready for levels to be measured from it.
struct Direct<'a> {
    input: &'a Input,
    simplified: &'a Simplified,
    triangles: Vec<[DVec3; 3]>,
    tree: TriangleTree,
    search: Search,
}

impl<'a> Direct<'a> {
    fn new(input: &'a Input, simplified: &'a Simplified) -> Self {
        let triangles: Vec<_> = input.triangles.iter().map(|&t| input.at(t)).collect();
        let tree = TriangleTree::new(&triangles);
        Self {
            input,
            simplified,
            triangles,
            tree,
            search: Search { boxes: [200, 1_000_000], ..Search::within(input.diagonal) },
        }
    }

    /// Measures the levels after so many steps, and others between them. Returns them in order,
    /// with error and root mean square distance in mesh units.
    fn measure(&self, first: usize, before: f64, ends: &[usize]) -> Vec<(usize, [f64; 2])> {
        let Some((&last, others)) = ends.split_last() else { return Vec::new() };
        let most = BOXES[0] * self.triangles.len() as u64 + BOXES[1];
        let (coarsest, mut opened) = self.level(last);
        let mut measured = Vec::new();
        for &end in others {
            if opened < most {
                let (level, more) = self.level(end);
                measured.push((end, level));
                opened += more;
            }
        }
        measured.push((last, coarsest));
        let tiny = 1e-6 * self.input.diagonal * self.input.unit;
        let mut finest = (first, before);
        let mut i = 0;
        while i < measured.len() {
            let (end, [error, _]) = measured[i];
            let leaps = error > LEAP * finest.1.max(tiny) && end > finest.0 + 1;
            if leaps && measured.len() < MOST && opened < most {
                let middle = finest.0 + (end - finest.0) / 2;
                let (level, more) = self.level(middle);
                measured.insert(i, (middle, level));
                opened += more;
            } else {
                finest = (end, error.max(finest.1));
                i += 1;
            }
        }
        measured
    }

    /// Measures the level after so many steps. Returns the boxes that were opened for it, too.
    fn level(&self, steps: usize) -> ([f64; 2], u64) {
        let Self { input, simplified, .. } = self;
        let map = simplified.collapses().resolve_all(simplified.collapses().step(steps - 1).lod);
        let level: Vec<_> = simplified
            .mesh()
            .triangles()
            .iter()
            .map(|t| t.map(|v| input.point_of[map[v as usize] as usize]))
            .filter(|t| {
                let [a, b, c] = t.map(|p| input.positions[p as usize]);
                a != b && b != c && c != a
            })
            .map(|t| input.at(t))
            .collect();
        let tree = TriangleTree::new(&level);
        let one_way = |from: &[[DVec3; 3]], to: &TriangleTree| {
            (self.search.farthest(from, to), mean(from, to))
        };
        let (there, back) =
            rayon::join(|| one_way(&self.triangles, &tree), || one_way(&level, &self.tree));
        let error = there.0.most.max(back.0.most).min(input.diagonal);
        let rms = there.1.max(back.1).min(error);
        ([error, rms].map(|distance| distance * input.unit), there.0.opened + back.0.opened)
    }
}

/// The root mean square distance over the area of some triangles.
fn mean(triangles: &[[DVec3; 3]], to: &TriangleTree) -> f64 {
    let all: f64 = triangles.iter().map(|&t| area(t)).sum();
    if all == 0.0 {
        return 0.0;
    }
    let of_triangle = |&t: &[DVec3; 3]| {
        // Middles of equal parts: the triangle divided `n` times each way.
        let share = area(t) / all;
        let n = (share * POINTS).sqrt().ceil().clamp(1.0, 200.0);
        let count = n as u32;
        let at = |i: u32, j: u32, third: f64| {
            let [u, v] = [i, j].map(|k| (f64::from(k) + third) / n);
            let p = point_at(t, [u, v, 1.0 - u - v]);
            to.distance_at_most(p, NONE, &mut { PATIENCE }).0
        };
        let upright = (0..count).flat_map(|i| (0..count - i).map(move |j| at(i, j, 1.0 / 3.0)));
        let turned =
            (0..count).flat_map(|i| (0..(count - 1 - i)).map(move |j| at(i, j, 2.0 / 3.0)));
        upright.chain(turned).sum::<f64>() / (n * n) * share
    };
    triangles.par_iter().map(of_triangle).collect::<Vec<f64>>().iter().sum::<f64>().sqrt()
}
