//! The check of geomorphing levels: at the end of its morph target each level is the next one,
//! triangle by triangle.
//!
//! `from` is the level, its `values` before the morph and `moved` after it; `to` is the next level.
//! Parts of one `kind` are compared together. A file may state a number of vertices that *stay*
//! although the next level has them elsewhere: the triangles at them may be others than the next
//! level's.

use super::report::CheckReport;
use lodc_formats::{ExportedLevels, Geomorph, GeomorphPart};
use lodc_mesh::{DisjointSets, position_key};
use std::collections::{BTreeMap, BTreeSet};

/// Largest number of positions that rounding cannot tell apart for one vertex. Chosen by hand, to
/// bound the time that crafted files take.
const MAX_CANDIDATES: usize = 64;

/// Checks that each level that moves becomes the next one: the triangles that then have an area are
/// the next level's, all of them, corner by corner, with the other values that move, to one unit in
/// the last place of the larger number. Positions of the next level that rounding cannot tell apart
/// for a vertex that moves are one: triangles between them have no area. None if no level moves.
#[must_use]
pub fn check_geomorph(exported: &ExportedLevels) -> Option<CheckReport> {
    let count = exported.morphs.len() as u64;
    let stated =
        |level: usize| exported.stated.levels.get(level)?.geomorph.map(|geomorph| geomorph.staying);
    let mut may_stay: BTreeMap<usize, u64> = BTreeMap::new();
    let found = exported.morphs.iter().find_map(|geomorph| {
        let level = geomorph.level;
        let may_stay = may_stay.entry(level).or_insert_with(|| stated(level).unwrap_or(0));
        let what = difference(geomorph, may_stay)?;
        Some(format!("level {level}, fully morphed: {}: {what}", geomorph.location))
    });
    let report = CheckReport::new(None, "levels", "morph into the next level");
    (count > 0).then(|| report.of(count, found))
}

/// A triangle by its corners, of which that with the smallest position comes first.
struct Corners {
    /// Numbers of the positions of the next level.
    positions: [u32; 3],
    /// Vertices of its own level.
    vertices: [u32; 3],
}

/// What differs first once a level has moved. `may_stay` is how many vertices may stay; those that
/// do are taken off.
fn difference(geomorph: &Geomorph, may_stay: &mut u64) -> Option<String> {
    let mut kinds: Vec<&str> =
        geomorph.from.iter().chain(&geomorph.to).map(|part| &*part.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds.into_iter().find_map(|kind| {
        let parts_of_kind =
            |parts: &[GeomorphPart]| joined(parts.iter().filter(|part| part.kind == kind));
        kind_difference(&parts_of_kind(&geomorph.from), &parts_of_kind(&geomorph.to), may_stay)
    })
}

/// Several primitives as one.
fn joined<'a>(parts: impl Iterator<Item = &'a GeomorphPart>) -> GeomorphPart {
    let mut all = GeomorphPart::default();
    for part in parts {
        let first = all.values.len().checked_div(part.width).unwrap_or(0) as u32;
        all.width = part.width;
        all.values.extend_from_slice(&part.values);
        all.moved.extend_from_slice(&part.moved);
        all.triangles.extend(part.triangles.iter().map(|t| t.map(|v| first + v)));
    }
    all
}

/// As [`difference`], of the parts of one kind: finds where each vertex has come to, then compares
/// the triangles that have arrived with those of the next level.
fn kind_difference(from: &GeomorphPart, to: &GeomorphPart, may_stay: &mut u64) -> Option<String> {
    let width = from.width.max(to.width);
    let are_all_moved = from.values.len() == from.moved.len();
    if width < 3 || !are_all_moved {
        let what =
            if are_all_moved { "has no positions" } else { "moves only some of its vertices" };
        return (!from.triangles.is_empty()).then(|| what.to_owned());
    }
    if from.width != to.width && !from.triangles.is_empty() && !to.triangles.is_empty() {
        return Some("the morph target has other attributes than the next level".to_owned());
    }
    let mut positions = CornerPositions::of(to, width);
    let mut found: Vec<Option<u32>> = vec![None; from.values.len() / width];
    let mut is_sought = vec![false; found.len()];
    for &v in from.triangles.as_flattened() {
        if !std::mem::replace(&mut is_sought[v as usize], true) {
            let [before, moved] = [&from.values, &from.moved].map(|all| row(all, v, width));
            found[v as usize] = positions.find(before, moved);
        }
    }
    let some_stay = *may_stay > 0;
    let mut stays = vec![false; found.len()];
    if some_stay {
        for (v, stays) in (0..).zip(&mut stays) {
            *stays = row(&from.values, v, width) == row(&from.moved, v, width);
        }
    }
    // Vertices that stay, and the number of triangles at them that are none of the next level.
    let (mut staying, mut left_behind) = (BTreeSet::new(), 0);
    let mut arrived: Vec<Corners> = Vec::new();
    for t in &from.triangles {
        let moved_to = t.map(|v| found[v as usize].map(|number| positions.one_of(number)));
        match moved_to {
            [Some(a), Some(b), Some(c)] if a != b && b != c && c != a => {
                arrived.push(rotated([a, b, c], *t));
            }
            _ if t.iter().any(|&v| stays[v as usize])
                && t.iter().zip(moved_to).all(|(&v, to)| to.is_some() || stays[v as usize]) =>
            {
                let lost = t.iter().zip(moved_to).filter(|(_, to)| to.is_none());
                staying.extend(lost.map(|(&v, _)| v));
                left_behind += 1;
            }
            [Some(_), Some(_), Some(_)] => {}
            _ if is_flat(from, *t, width) => {}
            _ => {
                let lost = t.iter().zip(moved_to).find(|(_, position)| position.is_none());
                let vertex = lost.map_or(0, |(&v, _)| v);
                return Some(format!("vertex {vertex} is where the next level has none"));
            }
        }
    }
    let mut wanted: Vec<Corners> = to
        .triangles
        .iter()
        .map(|t| rotated(t.map(|v| positions.one_of(positions.of_vertex[v as usize])), *t))
        .collect();
    wanted.retain(|&Corners { positions: [a, b, c], .. }| a != b && b != c && c != a);
    // Triangles at the same positions are sorted by their other values, rounded so that values
    // which differ by rounding errors are equal.
    let order = |part: &GeomorphPart,
                 all: &mut Vec<Corners>,
                 values: fn(&GeomorphPart) -> &[f32]| {
        let rounded = |t: &Corners| -> Vec<i64> {
            let others = t.vertices.iter().flat_map(|&v| &row(values(part), v, width)[3..]);
            others.map(|x| (f64::from(*x) * 1e4).round() as i64).collect()
        };
        all.sort_by(|a, b| a.positions.cmp(&b.positions).then_with(|| rounded(a).cmp(&rounded(b))));
    };
    order(from, &mut arrived, |part| &part.moved);
    order(to, &mut wanted, |part| &part.values);
    if some_stay {
        let taken_out = leave_behind(&mut arrived, &mut wanted, &stays);
        left_behind += taken_out.arrived;
        *may_stay = match may_stay.checked_sub(staying.len() as u64) {
            Some(rest) if taken_out.wanted <= left_behind => rest,
            Some(_) => {
                return Some(format!("lacks {} triangles of the next level", taken_out.wanted));
            }
            None => {
                return Some(format!(
                    "{} vertices do not move, more than the file states",
                    staying.len()
                ));
            }
        };
    }
    if arrived.len() != wanted.len() {
        return Some(format!(
            "has {} triangles, and the next level {}",
            arrived.len(),
            wanted.len()
        ));
    }
    sides_difference([from, to], [&arrived, &wanted], &stays, width)
}

/// What differs between triangles that have arrived and those of the next level, both in one order.
fn sides_difference(
    [from, to]: [&GeomorphPart; 2],
    [arrived, wanted]: [&[Corners]; 2],
    stays: &[bool],
    width: usize,
) -> Option<String> {
    arrived.iter().zip(wanted).find_map(|(triangle, next)| {
        if triangle.positions != next.positions {
            return Some(format!("its triangle {:?} is not in the next level", triangle.vertices));
        }
        (0..3).find_map(|k| {
            let (v, w) = (triangle.vertices[k], next.vertices[k]);
            if stays[v as usize] {
                return None;
            }
            let (before, moved) = (row(&from.values, v, width), row(&from.moved, v, width));
            let goal = row(&to.values, w, width);
            let wrong = (3..width).find(|&c| !is_near(before[c], moved[c], goal[c]))?;
            Some(format!(
                "component {wrong} of vertex {v} is {}, and {} in the next level",
                moved[wrong], goal[wrong]
            ))
        })
    })
}

/// Numbers of triangles that were taken out of either list.
struct TakenOut {
    arrived: usize,
    wanted: usize,
}

/// Takes those triangles out of two sorted lists that are at positions which the next level has
/// more often, or the level has more often and a vertex of theirs stays.
fn leave_behind(arrived: &mut Vec<Corners>, wanted: &mut Vec<Corners>, stays: &[bool]) -> TakenOut {
    let mut balance: BTreeMap<[u32; 3], i64> = BTreeMap::new();
    let touched = |t: &Corners| t.vertices.iter().any(|&v| stays[v as usize]);
    let at_staying: BTreeSet<[u32; 3]> =
        arrived.iter().filter(|t| touched(t)).map(|t| t.positions).collect();
    arrived.iter().for_each(|t| *balance.entry(t.positions).or_default() += 1);
    wanted.iter().for_each(|t| *balance.entry(t.positions).or_default() -= 1);
    let is_open = |t: &Corners| {
        balance[&t.positions] < 0 || balance[&t.positions] > 0 && at_staying.contains(&t.positions)
    };
    let before = [arrived.len(), wanted.len()];
    arrived.retain(|t| !is_open(t));
    wanted.retain(|t| !is_open(t));
    TakenOut { arrived: before[0] - arrived.len(), wanted: before[1] - wanted.len() }
}

/// The values of a vertex.
fn row(values: &[f32], vertex: u32, width: usize) -> &[f32] {
    &values[vertex as usize * width..][..width]
}

/// A triangle with its smallest position first.
fn rotated(positions: [u32; 3], vertices: [u32; 3]) -> Corners {
    let smallest = (0..3).min_by_key(|&k| positions[k]).unwrap_or(0);
    let rotate = |all: [u32; 3]| std::array::from_fn(|k| all[(smallest + k) % 3]);
    Corners { positions: rotate(positions), vertices: rotate(vertices) }
}

/// Returns whether a number that has moved is the wanted one, to a unit in the last place of the
/// larger of the number before and the wanted one. No difference leads to or from what is not
/// finite, so that stays.
fn is_near(before: f32, moved: f32, wanted: f32) -> bool {
    if !before.is_finite() || !wanted.is_finite() {
        return moved == before || moved.is_nan() && before.is_nan();
    }
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
fn is_flat(part: &GeomorphPart, t: [u32; 3], width: usize) -> bool {
    (0..3).any(|k| {
        let [v, w] = [t[k], t[(k + 1) % 3]];
        let same = |c: usize| {
            let before = [v, w].map(|v| row(&part.values, v, width)[c]);
            let moved = [v, w].map(|v| row(&part.moved, v, width)[c]);
            let larger = before[0].abs().max(before[1].abs()).max(moved[0].abs());
            (f64::from(moved[0]) - f64::from(moved[1])).abs() <= 2.0 * unit(larger)
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
    /// The number of each vertex's position; `u32::MAX` of vertices that no triangle uses.
    of_vertex: Vec<u32>,
    /// For each axis the numbers in the order of their coordinates on it.
    by_coordinate: [Vec<u32>; 3],
    /// Those that rounding cannot tell apart.
    alike: DisjointSets,
}

impl CornerPositions {
    fn of(part: &GeomorphPart, width: usize) -> Self {
        let vertices = part.values.len() / width;
        let (mut numbers, mut positions) = (BTreeMap::new(), Vec::new());
        let mut of_vertex = vec![u32::MAX; vertices];
        for &v in part.triangles.as_flattened() {
            let position = position(row(&part.values, v, width));
            of_vertex[v as usize] = *numbers.entry(position_key(position)).or_insert_with(|| {
                positions.push(position);
                positions.len() as u32 - 1
            });
        }
        let by_coordinate = [0, 1, 2].map(|axis| {
            let mut all: Vec<u32> = (0..positions.len() as u32).collect();
            let coordinate = |n: &u32| positions[*n as usize][axis];
            all.sort_by(|a, b| coordinate(a).total_cmp(&coordinate(b)));
            all
        });
        let alike = DisjointSets::new(positions.len());
        Self { numbers, positions, of_vertex, by_coordinate, alike }
    }

    /// The number that stands for a position and for all that rounding cannot tell from it.
    fn one_of(&mut self, number: u32) -> u32 {
        self.alike.find(number)
    }

    /// Returns a position that a vertex has moved to: exactly, or one that it may have missed by
    /// rounding. All of these are one from now on.
    fn find(&mut self, before: &[f32], moved: &[f32]) -> Option<u32> {
        let exact = self.numbers.get(&position_key(position(moved))).copied();
        if before[..3] == moved[..3] && exact.is_some() {
            return exact;
        }
        let near_on_axis = |axis: usize| -> &[u32] {
            let (all, to) = (&self.by_coordinate[axis], moved[axis]);
            let coordinate = |n: &u32| self.positions[*n as usize][axis];
            let is_near = |n: &u32| is_near(before[axis], to, coordinate(n));
            let first = all.partition_point(|n| coordinate(n) < to && !is_near(n));
            let end = all.partition_point(|n| coordinate(n) <= to || is_near(n));
            &all[first..end.max(first)]
        };
        // The axis on which the fewest are near: on another many coordinates may be about zero.
        let fewest = [0, 1, 2].map(near_on_axis).into_iter().min_by_key(|all| all.len())?;
        let is_candidate = |n: &&u32| {
            (0..3).all(|k| is_near(before[k], moved[k], self.positions[**n as usize][k]))
        };
        let mut candidates = fewest.iter().filter(is_candidate).take(MAX_CANDIDATES).copied();
        let first = exact.or_else(|| candidates.next())?;
        candidates.for_each(|other| {
            self.alike.join(first, other);
        });
        Some(first)
    }
}

fn position(row: &[f32]) -> [f32; 3] {
    [row[0], row[1], row[2]]
}
