//! Levels that morph to the next one: vertices stay where that would spoil a shape in motion.
//!
//! A morph target adds the same way in every shape: exact at rest, but where joints or other
//! targets move a vertex and what it becomes differently, it arrives somewhere else. Half a lip
//! that opens would morph to the corner of the mouth, and hang below it.

use super::refitted::{Originals, measurable_of};
use crate::geomorph::{arrived, bends, with_joints_of};
use lodc_mesh::{Mesh, PositionIds};
use lodc_scene::{ObjectShapes, Shape};
use std::borrow::Cow;
use std::ops::Range;

/// A level that has arrived may be this many times as far from the input, in any shape, as the
/// farther of itself and the next level. Chosen by hand.
const MAX_ERROR_GROWTH: f64 = 1.25;
/// Vertices stay that would arrive farther than this many times the error from the surface, or from
/// their place in the next level: tried in order until the level holds. Chosen by hand.
const LIMITS: [(Deviation, f64); 8] = [
    (Deviation::Surface, f64::INFINITY),
    (Deviation::Surface, 2.0),
    (Deviation::Surface, 1.0),
    (Deviation::Surface, 0.5),
    (Deviation::Place, 2.0),
    (Deviation::Place, 1.0),
    (Deviation::Place, 0.5),
    (Deviation::Place, MAX_ERROR_GROWTH - 1.0),
];
/// The same for shapes with a morph target that errors are not over. Chosen by hand.
const UNMEASURED_LIMIT: f64 = 2.0;

/// What a vertex's deviation is measured from, as an index.
#[derive(Clone, Copy)]
enum Deviation {
    /// The surface of the input, in the shapes that errors are over.
    Surface,
    /// Its place in the next level, there.
    Place,
    /// Its place in the next level, in the others.
    Unmeasured,
}

/// What arrives within this share of the level's extent of its place is there: rounding. Chosen by
/// hand.
const NEGLIGIBLE: f64 = 1e-5;

/// Positions of vertices in a shape.
struct Places {
    now: Vec<[f32; 3]>,
    /// Where they have arrived; with the joints of what they become also where they begin.
    others: Vec<Vec<[f32; 3]>>,
}

/// A level on its way to the next one.
#[derive(Clone, Debug)]
pub struct Way<'a> {
    /// The vertices of the level, and maybe others.
    pub now: &'a Mesh,
    /// The values that they have in the next level.
    pub next: &'a Mesh,
    /// The triangles of the level.
    pub triangles: &'a [[u32; 3]],
    /// The vertices that move.
    pub moving: Range<u32>,
    /// They take the joints of what they become.
    pub takes_joints: bool,
    /// The larger of the errors of the level and of the next one, in mesh units.
    pub error: f64,
}

/// Decides which vertices of an object's levels morph.
pub struct GeomorphJudge<'a> {
    /// The input in the shapes that errors are over.
    originals: Originals<'a>,
    /// The shapes with one morph target each.
    targets: &'a [Shape],
}

impl<'a> GeomorphJudge<'a> {
    /// A judge of levels of `input`, given the shapes that its errors are over, and those with each
    /// morph target at 1. None if nothing bends it.
    #[must_use]
    pub fn new(
        input: &Mesh,
        stated: &'a ObjectShapes,
        targets: &'a ObjectShapes,
    ) -> Option<GeomorphJudge<'a>> {
        bends(input).then(|| Self {
            originals: Originals::new(stated.all(), input),
            targets: targets.of_pose_keys(),
        })
    }

    /// Returns the vertices that have to stay, rising: so few that with the others arrived the
    /// level errs hardly more than levels do, in every shape that errors are over; and those that
    /// any morph target would carry far from where the next level has them. Vertices at one
    /// position stay together.
    #[must_use]
    pub fn staying(&self, way: &Way<'_>) -> Vec<u32> {
        let ids = way.now.position_ids();
        let (deviations, places) = self.deviations(way, &ids);
        let error = way.error + NEGLIGIBLE * extent(way.now.positions());
        let deviation =
            |kind: Deviation, v: u32| deviations[kind as usize][ids.of_vertex[v as usize] as usize];
        let mut before = usize::MAX;
        for (kind, limit) in LIMITS {
            let stays = |v: &u32| {
                deviation(kind, *v) > limit * error
                    || deviation(Deviation::Unmeasured, *v) > UNMEASURED_LIMIT * error
            };
            let staying: Vec<u32> = way.moving.clone().filter(stays).collect();
            // Then no point is farther off than is allowed, and nothing need be measured.
            let is_near =
                |v: u32| deviation(Deviation::Place, v) <= (MAX_ERROR_GROWTH - 1.0) * error;
            if staying.is_empty() && way.moving.clone().all(is_near) {
                return staying;
            }
            if staying.len() == before {
                continue;
            }
            before = staying.len();
            let mut moves = vec![false; way.now.vertex_count()];
            way.moving.clone().for_each(|v| moves[v as usize] = true);
            staying.iter().for_each(|&v| moves[v as usize] = false);
            if self.holds(way, &places, &moves, MAX_ERROR_GROWTH * error) {
                return staying;
            }
        }
        let deviates = |&v: &u32| {
            deviation(Deviation::Place, v).max(deviation(Deviation::Unmeasured, v)) > 0.0
        };
        way.moving.clone().filter(deviates).collect()
    }

    /// How far each position would deviate, by [`Deviation`], and where all vertices are in each
    /// shape that errors are over.
    fn deviations(&self, way: &Way<'_>, ids: &PositionIds) -> ([Vec<f64>; 3], Vec<Places>) {
        let arrived = arrived(way.now, way.next, way.takes_joints);
        let borrowed = way.takes_joints.then(|| with_joints_of(way.now, way.next));
        let mut deviations = [(); 3].map(|()| vec![0.0f64; ids.len()]);
        let mut all = Vec::new();
        let measured = self.originals.shapes.iter().zip(&self.originals.originals);
        let measured = measured.map(|(shape, original)| (shape, Some(original)));
        for (shape, original) in measured.chain(self.targets.iter().map(|shape| (shape, None))) {
            let [now, at, next] =
                [way.now, &arrived, way.next].map(|mesh| shape.of(mesh).into_owned());
            let borrowed = borrowed.as_ref().map(|mesh| shape.of(mesh));
            for v in way.moving.start as usize..way.moving.end as usize {
                // Where it arrives, and with joints of another vertex where it begins.
                let places = [Some((at[v], next[v])), borrowed.as_ref().map(|b| (b[v], now[v]))];
                for (at, place) in places.into_iter().flatten() {
                    let mut raise = |kind: Deviation, by: f64| {
                        let largest = &mut deviations[kind as usize][ids.of_vertex[v] as usize];
                        *largest = largest.max(by);
                    };
                    let from_place = distance(at, place);
                    match original {
                        None => raise(Deviation::Unmeasured, from_place),
                        Some(_) if from_place == 0.0 => {}
                        Some(original) => {
                            raise(Deviation::Place, from_place);
                            raise(Deviation::Surface, original.distance_to(at));
                        }
                    }
                }
            }
            if original.is_some() {
                let others = std::iter::once(at).chain(borrowed.map(Cow::into_owned)).collect();
                all.push(Places { now, others });
            }
        }
        (deviations, all)
    }

    /// Returns whether a level is within a limit in all shapes once some vertices have moved.
    /// `places` are those by shape.
    fn holds(&self, way: &Way<'_>, places: &[Places], moves: &[bool], limit: f64) -> bool {
        self.originals.originals.iter().zip(places).all(|(original, Places { now, others })| {
            others.iter().all(|other| {
                let at = |v: u32| (if moves[v as usize] { other } else { now })[v as usize];
                original.distances(&measurable_of(way.triangles, at)).upper <= limit
            })
        })
    }
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    (0..3).map(|k| (f64::from(a[k]) - f64::from(b[k])).powi(2)).sum::<f64>().sqrt()
}

/// The diagonal of the box of positions.
fn extent(positions: &[[f32; 3]]) -> f64 {
    let Some(&first) = positions.first() else { return 0.0 };
    let [low, high] = positions.iter().fold([first; 2], |[low, high], p| {
        [std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))]
    });
    distance(low, high)
}
