//! Points of a level tied to points of the input, both ways, to carry over what the input has
//! there.

use crate::fit::Fitted;
use crate::guard::cross;
use crate::level::CoarseMesh;
use crate::sheets::{Sheet, nearest_of_sheet};
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{closest, point_at};
use rayon::prelude::*;

/// Samples, or faces, that one thread looks up one after the other. Chosen by hand.
const SAMPLES_PER_THREAD: usize = 1 << 8;

/// A point of the level tied to one of the input, each by its triangle and barycentric coordinates
/// there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceTie {
    pub(crate) face: u32,
    pub(crate) on_face: [f64; 3],
    pub(crate) triangle: u32,
    pub(crate) on_triangle: [f64; 3],
    /// Share of the whole area.
    pub(crate) weight: f64,
}

/// Returns the samples of the input, each tied to the nearest point of the level, and points of the
/// level tied to the input. Only within a chart of texture coordinates and colours. Faces that are
/// where the fit looked them up last keep what was found there.
pub(crate) fn ties(level: &CoarseMesh, fitted: &Fitted, positions: &[DVec3]) -> Vec<SurfaceTie> {
    let input = &fitted.input;
    let points = input.level_rule.len();
    let corners = level.corners(positions);
    let crosses: Vec<DVec3> = corners.iter().map(|&t| cross(t)).collect();
    let area = crosses.iter().map(|c| c.length()).sum::<f64>().max(f64::MIN_POSITIVE);
    let tie = |face: u32, on_face, triangle: u32, on_triangle, weight| {
        let own_triangle = level.input_triangles[face as usize] as usize;
        let in_chart = input.charts[triangle as usize] == input.charts[own_triangle];
        in_chart.then_some(SurfaceTie { face, on_face, triangle, on_triangle, weight })
    };
    let face_sheet = |face: u32| Sheet {
        component: input.components[level.input_triangles[face as usize] as usize],
        normal: crosses[face as usize],
    };
    let stayed = fitted.stayed(level, positions);
    let mut tree = fitted.tree.clone();
    tree.move_to(&corners);
    let runs = fitted.hints.par_chunks(SAMPLES_PER_THREAD).enumerate();
    let from_input = runs.flat_map_iter(|(run, hints)| {
        let mut found = Vec::with_capacity(SAMPLES_PER_THREAD);
        for (i, &hint) in (SAMPLES_PER_THREAD * run..).zip(hints) {
            let (triangle, barycentric, weight) = input.sample_location(i);
            let p = input.surface_point(triangle, barycentric);
            let sheet = input.sheet(triangle);
            let is_own = |face: u32| sheet.goes_with(face_sheet(face));
            let nearest = if hint != NONE && stayed[hint as usize] {
                Some((hint, closest(p, corners[hint as usize]).0))
            } else {
                nearest_of_sheet(&tree, p, hint, fitted.reach, is_own)
                    .map(|(nearest, _)| (nearest.triangle, nearest.barycentric))
            };
            let Some((face, on_face)) = nearest else { continue };
            found.extend(tie(face, on_face, triangle as u32, barycentric, weight));
        }
        found
    });
    let faces = fitted.tree.spatial_order().par_chunks(SAMPLES_PER_THREAD);
    let hints = fitted.backward_hints.par_chunks(SAMPLES_PER_THREAD * points);
    let from_level = faces.zip(hints).flat_map_iter(|(faces, hints)| {
        let mut found = Vec::with_capacity(points * SAMPLES_PER_THREAD);
        for (&face, hints) in faces.iter().zip(hints.chunks(points)) {
            for (&(barycentric, share), &hint) in input.level_rule.iter().zip(hints) {
                let q = point_at(corners[face as usize], barycentric);
                let sheet = face_sheet(face);
                let is_own = |triangle: u32| sheet.goes_with(input.sheet(triangle as usize));
                let nearest = if hint != NONE && stayed[face as usize] {
                    Some((hint, closest(q, input.tree.corners_of(hint)).0))
                } else {
                    nearest_of_sheet(&input.tree, q, hint, fitted.reach, is_own)
                        .map(|(nearest, _)| (nearest.triangle, nearest.barycentric))
                };
                let Some((triangle, on_triangle)) = nearest else { continue };
                let weight = crosses[face as usize].length() * share / area;
                found.extend(tie(face, barycentric, triangle, on_triangle, weight));
            }
        }
        found
    });
    from_input.chain(from_level).collect()
}
