//! The normals that a surface is shaded with.

use crate::surface::Surface;
use glam::Vec3;

/// Edges between faces that are further apart than this (60°, as its cosine) stay sharp.
const CREASE: f32 = 0.5;

/// One normal for every corner of every triangle: the mean of the unit normals of all triangles
/// that are reached around the corner's position without crossing a sharp edge or a border.
/// Positions are one if they are equal.
pub(crate) fn smooth(surface: &Surface) -> Vec<[Vec3; 3]> {
    let place = places(&surface.positions);
    let corners: Vec<[u32; 3]> =
        surface.triangles.iter().map(|t| t.map(|v| place[v as usize])).collect();
    let own: Vec<Vec3> = (0..corners.len())
        .map(|t| {
            let [a, b, c] = surface.corners(t);
            (b - a).cross(c - a).normalize_or_zero().as_vec3()
        })
        .collect();
    let (start, around) = stars(&corners, surface.positions.len());
    let mut normals = vec![[Vec3::ZERO; 3]; corners.len()];
    let mut fan: Vec<(u32, bool)> = Vec::new();
    let mut open: Vec<u32> = Vec::new();
    for p in 0..surface.positions.len() {
        fan.clear();
        fan.extend(around[start[p] as usize..start[p + 1] as usize].iter().map(|&t| (t, false)));
        for first in 0..fan.len() {
            if std::mem::replace(&mut fan[first].1, true) {
                continue;
            }
            // Everything that is reached from here shares one normal.
            let mut sum = Vec3::ZERO;
            let mut reached = 0;
            open.clear();
            open.push(fan[first].0);
            while let Some(&t) = open.get(reached) {
                reached += 1;
                sum += own[t as usize];
                for (u, taken) in fan.iter_mut().filter(|f| !f.1) {
                    let share = |g: &u32| *g != p as u32 && corners[t as usize].contains(g);
                    if own[t as usize].dot(own[*u as usize]) > CREASE
                        && corners[*u as usize].iter().any(share)
                    {
                        *taken = true;
                        open.push(*u);
                    }
                }
            }
            let normal = sum.normalize_or_zero();
            for &t in &open {
                if let Some(corner) = corners[t as usize].iter().position(|&g| g == p as u32) {
                    normals[t as usize][corner] = normal;
                }
            }
        }
    }
    normals
}

/// For every vertex the first one at its position.
fn places(positions: &[Vec3]) -> Vec<u32> {
    // Adding zero folds the two zeros into one.
    let key = |v: u32| (positions[v as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|&v| (key(v), v));
    let mut place = vec![0; positions.len()];
    let mut first = 0;
    for (i, &v) in order.iter().enumerate() {
        if i == 0 || key(v) != key(order[i - 1]) {
            first = v;
        }
        place[v as usize] = first;
    }
    place
}

/// The triangles around every place: `around[start[p]..start[p + 1]]`.
fn stars(corners: &[[u32; 3]], places: usize) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; places + 1];
    for &p in corners.iter().flatten() {
        start[p as usize + 1] += 1;
    }
    for i in 1..start.len() {
        start[i] += start[i - 1];
    }
    let mut free = start.clone();
    let mut around = vec![0u32; corners.len() * 3];
    for (t, triangle) in (0u32..).zip(corners) {
        for &p in triangle {
            around[free[p as usize] as usize] = t;
            free[p as usize] += 1;
        }
    }
    (start, around)
}
