//! The check of geomorphing levels: at the end of its morph target each level is the next one,
//! triangle by triangle.

use super::report::CheckReport;
use lodc_formats::{Glide, GlidePart, ShippedLevels};
use lodc_mesh::position_key;
use std::collections::BTreeMap;

/// Most positions that are compared of those that rounding cannot tell apart.
const MAX_CANDIDATES: usize = 64;

/// Checks that each level that moves becomes the next one: every triangle that then has an area is
/// one of its, corner by corner, with what else moves, to one unit in the last place of the larger
/// number; and all of its are there. None if no level moves.
#[must_use]
pub fn check_glide(shipped: &ShippedLevels) -> Option<CheckReport> {
    let count = shipped.glides.len() as u64;
    let found = shipped.glides.iter().find_map(|glide| {
        let what = difference(glide)?;
        Some(format!("level {} moves: {}: {what}", glide.level, glide.location))
    });
    let report = CheckReport::new(None, "levels", "become the next ones");
    (count > 0).then(|| report.of(count, found))
}

/// A triangle by the positions of its corners, the smallest first, and where each of them is.
type Corners = ([u32; 3], [u32; 3]);

fn difference(glide: &Glide) -> Option<String> {
    let mut kinds: Vec<&str> = glide.from.iter().chain(&glide.to).map(|part| &*part.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds.into_iter().find_map(|kind| {
        let of_kind = |parts: &[GlidePart]| joined(parts.iter().filter(|part| part.kind == kind));
        different(&of_kind(&glide.from), &of_kind(&glide.to))
    })
}

/// Primitives as one.
fn joined<'a>(parts: impl Iterator<Item = &'a GlidePart>) -> GlidePart {
    let mut all = GlidePart::default();
    for part in parts {
        let first = all.values.len().checked_div(part.width).unwrap_or(0) as u32;
        all.width = part.width;
        all.values.extend_from_slice(&part.values);
        all.moved.extend_from_slice(&part.moved);
        all.triangles.extend(part.triangles.iter().map(|t| t.map(|v| first + v)));
    }
    all
}

fn different(from: &GlidePart, to: &GlidePart) -> Option<String> {
    let width = from.width.max(to.width);
    if width < 3 || from.values.len() != from.moved.len() {
        return (!from.triangles.is_empty()).then(|| "has no positions".to_owned());
    }
    if from.width != to.width && !from.triangles.is_empty() && !to.triangles.is_empty() {
        return Some("moves other values than the next level has".to_owned());
    }
    let positions = CornerPositions::of(to, width);
    let mut arrived: Vec<Corners> = Vec::new();
    for t in &from.triangles {
        let goals =
            t.map(|v| positions.find(row(&from.values, v, width), row(&from.moved, v, width)));
        match goals {
            [Some(a), Some(b), Some(c)] if a != b && b != c && c != a => {
                arrived.push(turned([a, b, c], *t));
            }
            [Some(_), Some(_), Some(_)] => {}
            _ if is_flat(from, *t, width) => {}
            _ => {
                let lost = t.iter().zip(goals).find(|(_, goal)| goal.is_none());
                let vertex = lost.map_or(0, |(&v, _)| v);
                return Some(format!("vertex {vertex} becomes none of the next level"));
            }
        }
    }
    let mut wanted: Vec<Corners> = to
        .triangles
        .iter()
        .map(|t| turned(t.map(|v| positions.of_vertex[v as usize]), *t))
        .collect();
    wanted.retain(|([a, b, c], _)| a != b && b != c && c != a);
    // Of triangles at the same positions those come first whose other values are smaller, roughly:
    // as far as rounding goes these are equal.
    let order = |part: &GlidePart, all: &mut Vec<Corners>, values: fn(&GlidePart) -> &[f32]| {
        let rough = |t: &Corners| -> Vec<i64> {
            let rest = t.1.iter().flat_map(|&v| &row(values(part), v, width)[3..]);
            rest.map(|x| (f64::from(*x) * 1e4).round() as i64).collect()
        };
        all.sort_by(|a, b| a.0.cmp(&b.0).then_with(|| rough(a).cmp(&rough(b))));
    };
    order(from, &mut arrived, |part| &part.moved);
    order(to, &mut wanted, |part| &part.values);
    if arrived.len() != wanted.len() {
        return Some(format!("has {} triangles there, {} are wanted", arrived.len(), wanted.len()));
    }
    arrived.iter().zip(&wanted).find_map(|(own, other)| {
        if own.0 != other.0 {
            return Some(format!("triangle {:?} is none of the next level", own.1));
        }
        (0..3).find_map(|k| {
            let (v, w) = (own.1[k], other.1[k]);
            let (before, moved) = (row(&from.values, v, width), row(&from.moved, v, width));
            let goal = row(&to.values, w, width);
            let wrong = (3..width).find(|&c| !is_near(before[c], moved[c], goal[c]))?;
            Some(format!("vertex {v} has {} in place {wrong}, not {}", moved[wrong], goal[wrong]))
        })
    })
}

fn row(values: &[f32], vertex: u32, width: usize) -> &[f32] {
    &values[vertex as usize * width..][..width]
}

/// A triangle with its smallest position first.
fn turned(positions: [u32; 3], vertices: [u32; 3]) -> Corners {
    let least = (0..3).min_by_key(|&k| positions[k]).unwrap_or(0);
    let from = |all: [u32; 3]| std::array::from_fn(|k| all[(least + k) % 3]);
    (from(positions), from(vertices))
}

/// Returns whether what a number has become is the wanted one, to a unit in the last place of the
/// larger of those that were added.
fn is_near(before: f32, moved: f32, wanted: f32) -> bool {
    let larger = before.abs().max(wanted.abs());
    moved == wanted
        || f64::from(moved) - f64::from(wanted) <= unit(larger)
            && f64::from(wanted) - f64::from(moved) <= unit(larger)
}

/// A unit in the last place of a number.
fn unit(x: f32) -> f64 {
    let above = f32::from_bits(x.to_bits().saturating_add(1));
    if above.is_finite() { f64::from(above) - f64::from(x) } else { f64::INFINITY }
}

/// Returns whether two corners of a triangle have moved to the same position, as far as rounding
/// goes.
fn is_flat(part: &GlidePart, t: [u32; 3], width: usize) -> bool {
    (0..3).any(|k| {
        let [v, w] = [t[k], t[(k + 1) % 3]];
        let of = |values, v| row(values, v, width);
        let same = |c: usize| {
            let [a, b] = [v, w].map(|v| (of(&part.values, v)[c], of(&part.moved, v)[c]));
            let larger = a.0.abs().max(b.0.abs()).max(a.1.abs());
            (f64::from(a.1) - f64::from(b.1)).abs() <= 2.0 * unit(larger)
        };
        (0..3).all(same)
    })
}

/// The positions of a level's corners.
struct CornerPositions {
    /// The number of a position, by its bits.
    numbers: BTreeMap<[u32; 3], u32>,
    /// The positions by number.
    positions: Vec<[f32; 3]>,
    of_vertex: Vec<u32>,
    /// By axis the numbers, their coordinates rising.
    on_axis: [Vec<u32>; 3],
}

impl CornerPositions {
    fn of(part: &GlidePart, width: usize) -> Self {
        let vertices = part.values.len() / width;
        let (mut numbers, mut positions) = (BTreeMap::new(), Vec::new());
        let mut of_vertex = vec![u32::MAX; vertices];
        for &v in part.triangles.as_flattened() {
            let position_of_corner = position(row(&part.values, v, width));
            of_vertex[v as usize] =
                *numbers.entry(position_key(position_of_corner)).or_insert_with(|| {
                    positions.push(position_of_corner);
                    positions.len() as u32 - 1
                });
        }
        let on_axis = [0, 1, 2].map(|axis| {
            let mut all: Vec<u32> = (0..positions.len() as u32).collect();
            let at = |n: &u32| positions[*n as usize][axis];
            all.sort_by(|a, b| at(a).total_cmp(&at(b)));
            all
        });
        Self { numbers, positions, of_vertex, on_axis }
    }

    /// Returns the position that a vertex has moved to: of those that rounding may have made it
    /// miss the nearest.
    fn find(&self, before: &[f32], moved: &[f32]) -> Option<u32> {
        if let Some(&number) = self.numbers.get(&position_key(position(moved))) {
            return Some(number);
        }
        let near = |axis: usize| -> &[u32] {
            let (all, to) = (&self.on_axis[axis], moved[axis]);
            let at = |n: &u32| self.positions[*n as usize][axis];
            let is_near = |n: &u32| is_near(before[axis], to, at(n));
            let first = all.partition_point(|n| at(n) < to && !is_near(n));
            let end = all.partition_point(|n| at(n) <= to || is_near(n));
            &all[first..end.max(first)]
        };
        // One axis tells more apart than another: many coordinates may be next to zero.
        let fewest = [0, 1, 2].map(near).into_iter().min_by_key(|all| all.len())?;
        let position_of_corner = |n: u32| self.positions[n as usize];
        let is_there =
            |n: &&u32| (0..3).all(|k| is_near(before[k], moved[k], position_of_corner(**n)[k]));
        let off = |n: u32| {
            (0..3).map(|k| (position_of_corner(n)[k] - moved[k]).abs()).fold(0.0, f32::max)
        };
        let there = fewest.iter().filter(is_there).take(MAX_CANDIDATES);
        there.copied().min_by(|&a, &b| off(a).total_cmp(&off(b)))
    }
}

fn position(row: &[f32]) -> [f32; 3] {
    [row[0], row[1], row[2]]
}
