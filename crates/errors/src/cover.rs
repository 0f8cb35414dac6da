//! How far a face is from the triangles of the input above and below it, where these cover it.
//!
//! Project some triangles of the input along the face's normal. As long as none of their border
//! lies over the face, they wind around each of its points equally often: if around one, then
//! around all, so over each point of the face is one of theirs (the degree of the projection; folds
//! do no harm). No point of the face is then farther from the input than the highest of their
//! corners.

use crate::input::Input;
use glam::DVec3;
use lodc_nearest::longest_edge_squared;

/// Most triangles that are looked at; where more lie over a face, a search by branch and bound
/// takes less. Chosen by hand.
const MAX_TRIANGLES: usize = 48;
/// Most triangles around a point: more are a high-valence vertex, around which every edge would be
/// looked for.
const MAX_AROUND: usize = 32;

/// How much of each altitude of the face is left out at its edge, so that what lies along an edge,
/// as the border of the input does, is not over the face: this share of the bound that is asked
/// for, in the face's own size, within limits. Chosen by hand.
const MARGIN_OF_LIMIT: f64 = 1e-3;
const MARGINS: [f64; 2] = [1e-8, 0.01];
/// Areas below this, in units of the face's, count as none: rounding errors are below.
const ROUNDING: f64 = 1e-12;

/// A point seen from a face.
#[derive(Clone, Copy)]
struct Seen {
    /// Barycentric coordinates of its projection.
    at: [f64; 3],
    height: f64,
}

impl Seen {
    /// A point on the way to another one.
    fn between(self, other: Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        Self {
            at: std::array::from_fn(|k| mix(self.at[k], other.at[k])),
            height: mix(self.height, other.height),
        }
    }
}

/// A face whose plane others are projected on.
struct Base {
    corner: DVec3,
    /// Gradients of the barycentric coordinates of the second and third corner.
    gradients: [DVec3; 2],
    normal: DVec3,
    /// Barycentric coordinates of what is left of the face are at least this.
    margin: f64,
    /// No point of the face is farther from what is left of it.
    margin_width: f64,
}

impl Base {
    /// `None` for a face of nearly no area, a thousandth as wide as long, or one that is too large
    /// for the margin that a bound of `limit` allows.
    fn new([a, b, c]: [DVec3; 3], limit: f64) -> Option<Self> {
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let longest_squared = longest_edge_squared([a, b, c]);
        let double_area_squared = normal.length_squared();
        if double_area_squared <= 1e-6 * longest_squared * longest_squared {
            return None;
        }
        let longest = longest_squared.sqrt();
        let margin = (MARGIN_OF_LIMIT * limit / longest).min(MARGINS[1]);
        (margin >= MARGINS[0]).then(|| Self {
            corner: a,
            gradients: [ac.cross(normal), normal.cross(ab)].map(|g| g / double_area_squared),
            normal: normal / double_area_squared.sqrt(),
            margin,
            margin_width: 2.0 * margin * longest,
        })
    }

    fn see(&self, p: DVec3) -> Seen {
        let p = p - self.corner;
        let [v, w] = self.gradients.map(|gradient| gradient.dot(p));
        Seen { at: [1.0 - v - w, v, w], height: self.normal.dot(p) }
    }

    /// Returns whether all of some points are beyond one edge of what is left of the face.
    fn are_beside<const N: usize>(&self, points: [Seen; N]) -> bool {
        (0..3).any(|k| points.iter().all(|p| p.at[k] < self.margin))
    }

    /// Returns whether an edge may be over what is left of the face.
    fn may_cross(&self, [p, q]: [Seen; 2]) -> bool {
        if self.are_beside([p, q]) {
            return false;
        }
        // Else it passes by only if all corners are on one side of it.
        let (high, low) = (1.0 - 2.0 * self.margin, self.margin);
        let direction = [1, 2].map(|k| q.at[k] - p.at[k]);
        let side = |k: usize| {
            let corner = [1, 2].map(|i| if i == k { high } else { low });
            let to_corner = [corner[0] - p.at[1], corner[1] - p.at[2]];
            direction[0] * to_corner[1] - direction[1] * to_corner[0]
        };
        let sides = [0, 1, 2].map(side);
        let extent = direction[0].abs() + direction[1].abs() + p.at[1].abs() + p.at[2].abs() + 1.0;
        let rounding = ROUNDING * extent * extent;
        !(sides.iter().all(|&s| s > rounding) || sides.iter().all(|&s| s < -rounding))
    }
}

/// Returns how often an edge winds around the centroid of the face: counted where it passes a line
/// from there. The same edge the other way around counts the opposite, exactly.
fn winding([p, q]: [Seen; 2]) -> i32 {
    const CENTER: f64 = 1.0 / 3.0;
    let is_up = p.at[2] <= CENTER;
    if is_up == (q.at[2] <= CENTER) {
        return 0;
    }
    let (low, high) = if is_up { (p, q) } else { (q, p) };
    let side = (high.at[1] - low.at[1]) * (CENTER - low.at[2])
        - (CENTER - low.at[1]) * (high.at[2] - low.at[2]);
    match side > 0.0 {
        true => 0,
        false if is_up => 1,
        false => -1,
    }
}

/// Returns the largest height of some points, above or below.
fn height(points: &[Seen]) -> f64 {
    points.iter().fold(0.0, |height, p| height.max(p.height.abs()))
}

/// Returns the largest height of the part of a triangle that is over the face.
fn height_over_face(triangle: [Seen; 3]) -> f64 {
    // Each edge of the face adds a corner; rounding may add more.
    const MAX_CORNERS: usize = 8;
    let mut polygon = [triangle[0]; MAX_CORNERS];
    polygon[..3].copy_from_slice(&triangle);
    let mut count = 3;
    for edge in 0..3 {
        let (mut kept, mut kept_count) = (polygon, 0);
        for i in 0..count {
            let (p, q) = (polygon[i], polygon[(i + 1) % count]);
            let is_over = |p: Seen| p.at[edge] >= 0.0;
            let crossing = (is_over(p) != is_over(q))
                .then(|| p.between(q, p.at[edge] / (p.at[edge] - q.at[edge])));
            for corner in is_over(p).then_some(p).into_iter().chain(crossing) {
                if kept_count == MAX_CORNERS {
                    return height(&triangle);
                }
                kept[kept_count] = corner;
                kept_count += 1;
            }
        }
        (polygon, count) = (kept, kept_count);
    }
    height(&polygon[..count])
}

/// Returns an upper bound, up to `limit`, of how far points of a face are from the input, if the
/// triangles of the input around its first corner and others next to them cover it within that.
/// `face` has the points of its corners; `triangles` is a buffer.
pub(crate) fn cover_bound(
    input: &Input,
    face: [u32; 3],
    limit: f64,
    triangles: &mut Vec<u32>,
) -> Option<f64> {
    let base = Base::new(input.corners_of(face), limit)?;
    let around = input.triangles_around.row(face[0]);
    if around.len() > MAX_AROUND {
        return None;
    }
    triangles.clear();
    triangles.extend_from_slice(around);
    let (mut highest, mut windings) = (0.0f64, 0);
    let mut done = 0;
    while let Some(&triangle) = triangles.get(done) {
        done += 1;
        let points = input.triangles[triangle as usize];
        let seen = points.map(|p| base.see(input.point(p)));
        if !base.are_beside(seen) {
            let whole = height(&seen);
            highest = highest.max(if whole > limit { height_over_face(seen) } else { whole });
            if highest > limit {
                return None;
            }
        }
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let edge = [seen[from], seen[to]];
            windings += winding(edge);
            if !base.may_cross(edge) {
                continue;
            }
            let neighbour = neighbour(input, triangle, [points[from], points[to]])?;
            if !triangles.contains(&neighbour) {
                if triangles.len() == MAX_TRIANGLES {
                    return None;
                }
                triangles.push(neighbour);
            }
        }
    }
    let bound = highest + base.margin_width;
    (windings != 0 && bound <= limit).then_some(bound)
}

/// Returns the triangle beyond an edge of another one, if there is just one and it is oriented the
/// same way.
fn neighbour(input: &Input, triangle: u32, [from, to]: [u32; 2]) -> Option<u32> {
    let around = input.triangles_around.row(from);
    if around.len() > MAX_AROUND {
        return None;
    }
    let mut found = None;
    for &other in around.iter().filter(|&&t| t != triangle) {
        let points = input.triangles[other as usize];
        if !points.contains(&to) {
            continue;
        }
        let is_opposite = (0..3).any(|k| points[k] == to && points[(k + 1) % 3] == from);
        if !is_opposite || found.is_some() {
            return None;
        }
        found = Some(other);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::sequence;
    use lodc_fixtures as fixtures;
    use lodc_mesh::{Simplified, SplitMix64, is_degenerate};
    use lodc_nearest::{Triangles, distance_squared, point_at};

    /// The bounds of faces that a share of the steps changed, each compared with distances of
    /// points of the face. Returns how many faces there are, and how many have a bound.
    fn compare(simplified: &Simplified, share: f64, random: &mut SplitMix64) -> [u32; 2] {
        let (input, corner_vertices) = Input::new(simplified, simplified.mesh().positions());
        let collapses = simplified.collapses();
        let step = (collapses.steps() as f64 * share) as usize;
        let Some(step) = step.checked_sub(1) else { return [0, 0] };
        let vertex_at_lod = collapses.resolve_all(collapses.step(step).lod);
        let (mut faces, mut covered) = (0, 0);
        for (vertices, &points) in corner_vertices.iter().zip(&input.triangles) {
            let face = vertices.map(|v| input.point_of_vertex[vertex_at_lod[v as usize] as usize]);
            if face == points || is_degenerate(face) {
                continue;
            }
            faces += 1;
            let bound = cover_bound(&input, face, 0.3 * input.diagonal, &mut vec![]);
            let Some(bound) = bound else { continue };
            covered += 1;
            for _ in 0..30 {
                let (u, v) = (f64::from(random.unit()), f64::from(random.unit()));
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let p = point_at(input.corners_of(face), [1.0 - u - v, u, v]);
                let squared = (0..input.triangles.len() as u32)
                    .map(|t| distance_squared(p, input.corners(t)))
                    .fold(f64::INFINITY, f64::min);
                assert!(squared.sqrt() <= bound + 1e-9, "{face:?}: {} {bound}", squared.sqrt());
            }
        }
        [faces, covered]
    }

    #[test]
    fn no_point_of_a_covered_face_is_farther_than_its_bound() {
        let mut random = SplitMix64::new(5);
        let (mut faces, mut covered) = (0, 0);
        for name in ["icosphere", "torus", "terrain", "open_box", "mobius_strip", "machine_part"] {
            let mesh = fixtures::named(name).expect("a shape");
            let options = lodc_simplify::Options::default();
            let simplified = lodc_simplify::simplify(&mesh, &options, &|_, _| ());
            for share in [0.3, 0.6, 0.8] {
                let more = compare(&simplified, share, &mut random);
                (faces, covered) = (faces + more[0], covered + more[1]);
            }
        }
        assert!(covered > faces / 2, "{covered} of {faces}");
        // Levels that no simplifier makes: they fold and pass through each other.
        let mut covered = 0;
        for seed in 0..60 {
            let simplified = fixtures::random_collapse(&fixtures::random(seed), seed);
            for share in [0.2, 0.5] {
                covered += compare(&simplified, share, &mut random)[1];
            }
        }
        assert!(covered > 50, "{covered}");
    }

    /// A square of 4 by 4 squares, each of two triangles, one of which may be left out, and the
    /// bound of a face from the first corner to points of its sides.
    fn bound_over_sheet(left_out: Option<usize>) -> Option<f64> {
        let at = |i: usize| [(i % 5) as f32, (i / 5) as f32, if i == 12 { 0.25 } else { 0.0 }];
        let positions: Vec<[f32; 3]> = (0..25).map(at).collect();
        let square = |i: u32| [[i, i + 1, i + 6], [i, i + 6, i + 5]];
        let mut triangles: Vec<[u32; 3]> =
            (0..4).flat_map(|y| (0..4).flat_map(move |x| square(5 * y + x))).collect();
        left_out.map(|t| triangles.remove(t));
        let targets: Vec<u32> = (1..25).collect();
        let simplified = sequence(&positions, &triangles, &targets);
        let (input, _) = Input::new(&simplified, simplified.mesh().positions());
        let face = [0, 4, 24].map(|v| input.point_of_vertex[v]);
        let bound = cover_bound(&input, face, 0.1 * input.diagonal, &mut vec![])?;
        Some(bound * input.mesh_scale)
    }

    #[test]
    fn a_part_over_the_face_is_no_higher_than_its_triangle_however_thin() {
        let mut random = SplitMix64::new(9);
        // Many corners nearly on the edges of the face, where rounding decides.
        let near = [-1.0, -1e-17, 0.0, 1e-17, 1e-9, 1.0 / 3.0, 0.5, 1.0, 1.0 + 1e-16, 2.0];
        for _ in 0..200_000 {
            let triangle = [0; 3].map(|_| {
                let [v, w] = [0; 2].map(|_| {
                    near[random.below(near.len())] + 1e-16 * f64::from(random.unit() - 0.5)
                });
                Seen { at: [1.0 - v - w, v, w], height: f64::from(random.unit() - 0.5) }
            });
            assert!(height_over_face(triangle) <= height(&triangle) * (1.0 + 1e-9));
        }
        let at = |v: f64, w: f64, height| Seen { at: [1.0 - v - w, v, w], height };
        // Half of it is over the face, up to half its height.
        let half = [at(0.0, 0.0, 0.0), at(2.0, 0.0, 1.0), at(0.0, 0.5, 0.0)];
        assert!((height_over_face(half) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_face_is_as_far_as_what_is_over_it_and_a_hole_is_not_covered() {
        let bound = bound_over_sheet(None).expect("it is covered");
        assert!((bound - 0.25).abs() < 0.01, "{bound}");
        // A triangle over the face, and one beside it.
        assert_eq!(bound_over_sheet(Some(10)), None);
        assert_eq!(bound_over_sheet(Some(9)), Some(bound));
    }
}
