//! The order in which the objects of a scene lose triangles: by loss per triangle removed.
//!
//! For each object the lower convex hull of (triangles, loss) over its levels is cut into segments;
//! the steps of a segment share its slope. All segments together, sorted by slope, are the order; a
//! scene is a prefix of it, so that scenes of different budgets are nested, and one of a hull's
//! corners is the best for its number of triangles (Shoham and Gersho 1988).

use crate::loss::losses;
use lodc_mesh::{CollapseSequence, Lod, Simplified};
use lodc_scene::Arrangement;

/// The last triangles of every object are removed after all others, so that none vanishes while
/// others have many. Four are the fewest that enclose a volume.
const LAST_TRIANGLES: u32 = 4;

/// A run of steps of one object.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    /// True if it leaves fewer than [`LAST_TRIANGLES`].
    is_last: bool,
    /// Loss per triangle removed.
    slope: f64,
    object: usize,
    /// Number of steps that are complete at its end.
    end: usize,
    /// Number of triangles that it removes.
    removed: u64,
}

/// A segment in the order of a scene, as a receiver of its levels needs it: when one of its objects
/// loses triangles, and down to which level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turn {
    /// Its rank, from 0 on, among the turns of all objects.
    pub rank: u32,
    /// The level that the object has after it.
    pub lod: Lod,
}

/// For each object of a scene its turns, by which a receiver can choose levels for a number of
/// triangles as [`select`](crate::select()) does, without knowing losses: it takes turns in the
/// order of their ranks while the scene has too many triangles; where one would remove more
/// than is needed, it takes the object's finest level that fits.
#[must_use]
pub fn turns(objects: &[&Simplified], scene: &Arrangement) -> Vec<Vec<Turn>> {
    let collapses: Vec<&CollapseSequence> = objects.iter().map(|o| o.collapses()).collect();
    let mut turns = vec![Vec::new(); objects.len()];
    for (rank, segment) in (0..).zip(order(&collapses, &losses(objects, scene))) {
        let lod = Lod(collapses[segment.object].parts().step_ends[segment.end - 1]);
        turns[segment.object].push(Turn { rank, lod });
    }
    turns
}

/// The segments of all hulls in the order in which they are removed.
fn order(objects: &[&CollapseSequence], losses: &[Vec<f64>]) -> Vec<Segment> {
    let mut segments: Vec<Segment> = Vec::new();
    for (number, (collapses, loss)) in objects.iter().zip(losses).enumerate() {
        segments.extend(hull(number, collapses, loss));
    }
    // Stable: segments of one slope keep the order of the objects.
    segments.sort_by(|a, b| a.is_last.cmp(&b.is_last).then(a.slope.total_cmp(&b.slope)));
    segments
}

/// Chooses the finest state of a scene on the order that has at most `budget` triangles; the
/// coarsest one where every object still has a triangle if there is none. `losses` has for each
/// object the loss after each step, never falling.
pub(crate) fn within_triangles(
    objects: &[&CollapseSequence],
    losses: &[Vec<f64>],
    budget: u64,
) -> Vec<Lod> {
    let mut total: u64 = objects.iter().map(|c| u64::from(c.parts().triangles)).sum();
    let mut lods = vec![Lod(0); objects.len()];
    for segment in order(objects, losses) {
        if total <= budget {
            break;
        }
        let collapses = objects[segment.object];
        let lod = &mut lods[segment.object];
        if total - segment.removed >= budget {
            *lod = Lod(collapses.parts().step_ends[segment.end - 1]);
            total -= segment.removed;
            continue;
        }
        // Steps within a segment are taken one by one.
        let triangles = u64::from(collapses.triangles_at(*lod));
        let wanted = u32::try_from(triangles - (total - budget)).unwrap_or(u32::MAX);
        *lod = collapses.lod_for_triangles(wanted);
        break;
    }
    lods
}

/// The segments of an object's hull up to its last level that has a triangle, in the order of
/// rising slopes. Those that leave [`LAST_TRIANGLES`] and those that leave fewer have hulls of
/// their own.
fn hull(object: usize, collapses: &CollapseSequence, loss: &[f64]) -> Vec<Segment> {
    let parts = collapses.parts();
    let steps = collapses.steps_at(collapses.last_visible());
    let triangles_after =
        |end: usize| if end == 0 { parts.triangles } else { parts.step_triangles[end - 1] };
    let loss_at = |end: usize| if end == 0 { 0.0 } else { loss[end - 1] };
    let slope = |from: usize, to: usize| {
        (loss_at(to) - loss_at(from)) / f64::from(triangles_after(from) - triangles_after(to))
    };
    // The first step that leaves too few.
    let split = parts.step_triangles[..steps].partition_point(|&n| n >= LAST_TRIANGLES);
    let mut segments = Vec::new();
    for (range, is_last) in [(0..split, false), (split..steps, true)] {
        let mut corners = vec![range.start];
        for end in range.start + 1..=range.end {
            let newest = *corners.last().expect("never empty");
            if triangles_after(end) == triangles_after(newest) {
                // No triangle is removed: the slope would be infinite.
                continue;
            }
            while let [.., a, b] = corners[..]
                && slope(a, b) >= slope(b, end)
            {
                corners.pop();
            }
            corners.push(end);
        }
        segments.extend(corners.windows(2).map(|w| Segment {
            is_last,
            slope: slope(w[0], w[1]),
            object,
            end: w[1],
            removed: u64::from(triangles_after(w[0]) - triangles_after(w[1])),
        }));
    }
    segments
}
