//! Welding: snaps positions that are within a tolerance of each other, at rest and in motion, to
//! exactly the same coordinates.

use crate::{Attribute, MeshParts, position_key};
use std::collections::BTreeMap;

/// The most earlier vertices of a cell that a vertex is compared with. At rest a cell has a few;
/// only vertices that part in motion, each in another way, may be many at one place. Chosen by
/// hand.
const MAX_COMPARED: usize = 256;

/// Snaps every position to the first earlier one within `tolerance` (mesh units) that moves alike:
/// no morph target moves it otherwise by more, and joints have nearly the same weights. What moves
/// the vertex comes from the earlier one, too. Returns how many vertices moved. Other attributes
/// are left alone; raw position streams follow. Triangles that lose their area are left for
/// [`MeshParts::clean`].
pub fn weld_positions(parts: &mut MeshParts, tolerance: f64) -> usize {
    if tolerance.is_nan() || tolerance <= 0.0 {
        return 0;
    }
    let snaps = snaps(parts, tolerance);
    let spatial: Vec<usize> =
        (0..parts.attributes.len()).filter(|&a| parts.attributes[a].is_spatial()).collect();
    for &(v, u) in &snaps {
        parts.positions[v as usize] = parts.positions[u as usize];
        for &stream in &spatial {
            if stores(parts, v, stream) && stores(parts, u, stream) {
                let a = &mut parts.attributes[stream];
                let (stride, from) = (a.stride(), u as usize * a.stride());
                a.bytes.copy_within(from..from + stride, v as usize * stride);
            }
        }
    }
    snaps.len()
}

/// Returns whether the submesh of a vertex has a stream.
fn stores(parts: &MeshParts, vertex: u32, stream: usize) -> bool {
    let submesh = parts.submeshes.get(parts.vertex_submesh[vertex as usize] as usize);
    submesh.is_some_and(|s| s.attributes.contains(&(stream as u32)))
}

/// Returns the vertices that move, each with the one that it moves to, which does not move.
fn snaps(parts: &MeshParts, tolerance: f64) -> Vec<(u32, u32)> {
    let cell = |p: [f32; 3]| p.map(|c| (f64::from(c) / tolerance).floor());
    let key = |c: [f64; 3]| c.map(|x| (x + 0.0).to_bits());
    let is_within_tolerance = |a: [f32; 3], b: [f32; 3]| {
        (0..3).map(|i| (f64::from(a[i]) - f64::from(b[i])).powi(2)).sum::<f64>()
            <= tolerance * tolerance
    };
    let motion = parts.motion();
    let streams = |is_one: fn(&Attribute) -> bool| -> Vec<usize> {
        (0..parts.attributes.len()).filter(|&a| is_one(&parts.attributes[a])).collect()
    };
    let raw = streams(|a| a.is_spatial() && !a.moves());
    let moving = streams(Attribute::moves);
    // What a vertex's submesh stores can only be taken over from a vertex whose submesh stores it
    // in the same stream.
    let can_take_over = |streams: &[usize], v: u32, u: u32| {
        streams.iter().all(|&s| !stores(parts, v, s) || stores(parts, u, s))
    };
    // Vertices that keep their position, by cell. They are farther than the tolerance from each
    // other (unless streams differ or they part in motion), so a cell holds only a few.
    let mut fixed_vertices: BTreeMap<[u64; 3], Vec<u32>> = BTreeMap::new();
    let mut snaps = Vec::new();
    for v in 0..parts.positions.len() as u32 {
        let (p, own_cell) = (parts.positions[v as usize], cell(parts.positions[v as usize]));
        let mut earlier: Vec<u32> = cells_around(own_cell)
            .filter_map(|c| fixed_vertices.get(&key(c)))
            .flat_map(|fixed| fixed.iter().take(MAX_COMPARED))
            .copied()
            .filter(|&u| is_within_tolerance(parts.positions[u as usize], p))
            .filter(|&u| motion.move_nearly_alike(u, v, tolerance))
            .collect();
        earlier.sort_unstable();
        let can_move_to = |&u: &u32| {
            can_take_over(&raw, v, u) && (can_take_over(&moving, v, u) || motion.move_alike(u, v))
        };
        if earlier.is_empty() {
            fixed_vertices.entry(key(own_cell)).or_default().push(v);
        } else if let Some(u) = earlier.into_iter().find(can_move_to) {
            let is_there = position_key(parts.positions[u as usize]) == position_key(p);
            if !is_there || !motion.move_alike(u, v) {
                snaps.push((v, u));
            }
        }
    }
    snaps
}

/// Iterates over a cell and its 26 neighbours.
fn cells_around(home: [f64; 3]) -> impl Iterator<Item = [f64; 3]> {
    (0..27).map(move |i| [i % 3, i / 3 % 3, i / 9].map(|x| f64::from(x - 1))).map(move |d| {
        let [x, y, z] = home;
        [x + d[0], y + d[1], z + d[2]]
    })
}
