//! Surfaces that must stay on their side of others: points of a level near its other components.

use crate::guard::cross;
use crate::input::Input;
use crate::level::CoarseMesh;
use glam::DVec3;
use lodc_nearest::{TriangleTree, point_at};
use rayon::prelude::*;

/// A point is on a side of a component if it is farther away than this share of the reach: surfaces
/// that touch have no sides. Chosen by hand.
const MIN_GAP_SHARE: f64 = 0.25;
/// Faces that one thread looks at one after the other, at least. Chosen by hand.
const MIN_FACES: usize = 1 << 8;

/// A point of a face that lies near another component of the level, and on which side of it.
struct Neighbour {
    face: u32,
    barycentric: [f64; 3],
    /// The other component.
    other: u32,
    /// From the other component to the point.
    away: DVec3,
}

/// Points of a level near its other components.
pub(crate) struct Neighbours {
    all: Vec<Neighbour>,
    /// The component of each face.
    components: Vec<u32>,
    reach: f64,
}

/// The corners of a face and its centroid.
const PLACES: [[f64; 3]; 4] =
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0]];

impl Neighbours {
    /// Those of a level where the simplifier left it, whose faces are in `tree`, within `reach`.
    pub(crate) fn new(input: &Input, level: &CoarseMesh, tree: &TriangleTree, reach: f64) -> Self {
        let components = level.input_triangles.iter().map(|&t| input.components[t as usize]);
        let components: Vec<u32> = components.collect();
        let is_one = components.iter().all(|c| *c == components[0]);
        let faces = if is_one { 0 } else { level.faces.len() };
        let min_gap = MIN_GAP_SHARE * reach;
        let of_face = |face: usize| {
            let own = components[face];
            let corners = level.faces[face].map(|p| level.points[p as usize]);
            PLACES.into_iter().filter_map({
                let components = &components;
                move |barycentric| {
                    let p = point_at(corners, barycentric);
                    let is_other = |f: u32| components[f as usize] != own;
                    let near = tree.nearest_of(p, reach * reach, is_other)?;
                    let on = point_at(tree.corners_of(near.triangle), near.barycentric);
                    let other = components[near.triangle as usize];
                    (near.squared > min_gap * min_gap).then_some(Neighbour {
                        face: face as u32,
                        barycentric,
                        other,
                        away: p - on,
                    })
                }
            })
        };
        let found: Vec<Vec<Neighbour>> = (0..faces)
            .into_par_iter()
            .with_min_len(MIN_FACES)
            .map(|face| of_face(face).collect())
            .collect();
        Self { all: found.into_iter().flatten().collect(), components, reach }
    }

    /// Returns the faces that have come through another component, and those that they came
    /// through. `tree` has the level's faces where its points are at `positions`.
    pub(crate) fn crossed(
        &self,
        level: &CoarseMesh,
        tree: &TriangleTree,
        positions: &[DVec3],
    ) -> Vec<usize> {
        let crossed = |n: &Neighbour| {
            let corners = level.faces[n.face as usize].map(|p| positions[p as usize]);
            let p = point_at(corners, n.barycentric);
            let reach = 2.0 * self.reach + n.away.length();
            let is_other = |f: u32| self.components[f as usize] == n.other;
            let near = tree.nearest_of(p, reach * reach, is_other)?;
            let on = point_at(tree.corners_of(near.triangle), near.barycentric);
            let normal = cross(tree.corners_of(near.triangle));
            let was_above = n.away.dot(normal) > 0.0;
            let is_above = (p - on).dot(normal) > 0.0;
            let has_crossed = (p - on).dot(n.away) < 0.0 && was_above != is_above;
            has_crossed.then_some([n.face as usize, near.triangle as usize])
        };
        let faces: Vec<Option<[usize; 2]>> =
            self.all.par_iter().with_min_len(MIN_FACES).map(crossed).collect();
        faces.into_iter().flatten().flatten().collect()
    }
}
