//! The order in which the objects of a scene lose triangles: by error in world units, and among
//! steps whose errors are nearly the same by loss per triangle removed.
//!
//! The steps of every object are cut into bands of errors, 16 to an octave, the same for all
//! objects. A scene is a prefix of the order, so that scenes of different budgets are nested, and
//! its largest error is at most that of a band above the least that a budget allows: no object
//! keeps triangles that others would err less with. Within a band the lower convex hull of
//! (triangles, loss) over an object's levels is cut into segments; the steps of a segment share its
//! slope, and segments go by slope, so that what is seen least goes first (Shoham and Gersho 1988).

use crate::candidate::Candidate;
use lodc_mesh::Lod;
use std::ops::Range;

/// Bits of an error's float that are dropped: the others number 16 bands in each octave, of which
/// each is 3 to 6 % wide. Chosen by hand: losses decide little that errors do not.
const DROPPED_BITS: u32 = 19;

/// The band of an error in world units; never less for a larger one, and equal on every machine.
fn band(error: f64) -> u32 {
    (error.max(0.0) as f32).to_bits() >> DROPPED_BITS
}

/// A run of steps of one object.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    /// The band of their errors.
    band: u32,
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
pub struct RankedLod {
    /// Its place, from 0 on, among those of all objects.
    pub rank: u32,
    /// The level that the object has after it.
    pub lod: Lod,
}

/// For each object of a scene its ranked LODs, by which a receiver can choose levels for a number
/// of triangles as [`select`](crate::select()) does, without knowing losses: it takes them in the
/// order of their ranks while the scene has too many triangles; where one would remove more than is
/// needed, it takes the object's finest level that fits.
#[must_use]
pub fn ranks(objects: &[Candidate<'_>], losses: &[Vec<f64>]) -> Vec<Vec<RankedLod>> {
    let mut ranks = vec![Vec::new(); objects.len()];
    for (rank, segment) in (0..).zip(order(objects, losses)) {
        let collapses = objects[segment.object].collapses;
        let lod = Lod(collapses.parts().step_ends[segment.end - 1]);
        ranks[segment.object].push(RankedLod { rank, lod });
    }
    ranks
}

/// The segments of all objects in the order in which they are removed.
fn order(objects: &[Candidate<'_>], losses: &[Vec<f64>]) -> Vec<Segment> {
    let mut segments: Vec<Segment> = Vec::new();
    for (number, (object, loss)) in objects.iter().zip(losses).enumerate() {
        put_segments(number, object, loss, &mut segments);
    }
    // Stable: segments of one slope keep the order of the objects.
    segments.sort_by(|a, b| a.band.cmp(&b.band).then(a.slope.total_cmp(&b.slope)));
    segments
}

/// Chooses the finest state of a scene on the order that has at most `budget` triangles; the
/// coarsest one where every object still has a triangle, and what is locked, if there is none.
/// `losses` has for each object the loss after each step, never falling.
pub(crate) fn within_triangles(
    objects: &[Candidate<'_>],
    losses: &[Vec<f64>],
    budget: u64,
) -> Vec<Lod> {
    let mut total: u64 = objects.iter().map(|o| u64::from(o.collapses.parts().triangles)).sum();
    let mut lods = vec![Lod(0); objects.len()];
    for segment in order(objects, losses) {
        if total <= budget {
            break;
        }
        let collapses = objects[segment.object].collapses;
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

/// Appends the segments of an object up to its last level: band by band, in each in the order of
/// rising slopes.
fn put_segments(number: usize, object: &Candidate<'_>, loss: &[f64], segments: &mut Vec<Segment>) {
    let collapses = object.collapses;
    let errors = &collapses.parts().step_errors[..collapses.steps_at(object.last())];
    let band_of = |error: f32| band(f64::from(error) * object.world_scale());
    let mut first = 0;
    while first < errors.len() {
        let band = band_of(errors[first]);
        let end = first + errors[first..].partition_point(|&error| band_of(error) <= band);
        put_hull(number, object, loss, first..end, band, segments);
        first = end;
    }
}

/// Appends the segments of the steps of one band.
fn put_hull(
    object: usize,
    candidate: &Candidate<'_>,
    loss: &[f64],
    steps: Range<usize>,
    band: u32,
    segments: &mut Vec<Segment>,
) {
    let parts = candidate.collapses.parts();
    let triangles_after =
        |end: usize| if end == 0 { parts.triangles } else { parts.step_triangles[end - 1] };
    let loss_at = |end: usize| if end == 0 { 0.0 } else { loss[end - 1] };
    let slope = |from: usize, to: usize| {
        (loss_at(to) - loss_at(from)) / f64::from(triangles_after(from) - triangles_after(to))
    };
    let mut corners = vec![steps.start];
    for end in steps.start + 1..=steps.end {
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
        band,
        slope: slope(w[0], w[1]),
        object,
        end: w[1],
        removed: u64::from(triangles_after(w[0]) - triangles_after(w[1])),
    }));
}
