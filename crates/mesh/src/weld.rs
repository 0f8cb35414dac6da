//! Welding: snaps positions that are within a tolerance of each other to exactly the same
//! coordinates.

use crate::{MeshParts, Semantic, position_key};
use std::collections::BTreeMap;

/// Snaps every position to the first earlier one within `tolerance` (mesh units), if there is one.
/// Returns how many vertices moved. Attributes are left alone; raw position streams follow.
/// Triangles that lose their area are left for [`MeshParts::clean`].
pub fn weld_positions(parts: &mut MeshParts, tolerance: f64) -> usize {
    if tolerance.is_nan() || tolerance <= 0.0 {
        return 0;
    }
    let cell = |p: [f32; 3]| p.map(|c| (f64::from(c) / tolerance).floor());
    let key = |c: [f64; 3]| c.map(|x| (x + 0.0).to_bits());
    let is_within_tolerance = |a: [f32; 3], b: [f32; 3]| {
        (0..3).map(|i| (f64::from(a[i]) - f64::from(b[i])).powi(2)).sum::<f64>()
            <= tolerance * tolerance
    };
    let raw_streams: Vec<usize> = (0..parts.attributes.len())
        .filter(|&a| {
            parts.attributes[a].semantic == Semantic::Position
                && parts.attributes[a].morph_target.is_none()
        })
        .collect();
    // A raw position can only be taken over from a vertex whose submesh stores it in the same
    // stream.
    let stores = |parts: &MeshParts, v: u32, stream: usize| {
        let submesh = parts.submeshes.get(parts.vertex_submesh[v as usize] as usize);
        submesh.is_some_and(|s| s.attributes.contains(&(stream as u32)))
    };
    // Vertices that keep their position, by cell. They are farther than the tolerance from each
    // other (unless streams differ), so a cell holds only a few.
    let mut fixed_vertices: BTreeMap<[u64; 3], Vec<u32>> = BTreeMap::new();
    let mut moved = 0;
    for v in 0..parts.positions.len() as u32 {
        let (p, own_cell) = (parts.positions[v as usize], cell(parts.positions[v as usize]));
        let mut earlier: Vec<u32> = cells_around(own_cell)
            .filter_map(|c| fixed_vertices.get(&key(c)))
            .flatten()
            .copied()
            .filter(|&u| is_within_tolerance(parts.positions[u as usize], p))
            .collect();
        earlier.sort_unstable();
        let can_move_to =
            |u: &u32| raw_streams.iter().all(|&s| !stores(parts, v, s) || stores(parts, *u, s));
        if earlier.is_empty() {
            fixed_vertices.entry(key(own_cell)).or_default().push(v);
        } else if let Some(u) = earlier.into_iter().find(can_move_to) {
            let q = parts.positions[u as usize];
            if position_key(q) != position_key(p) {
                moved += 1;
                parts.positions[v as usize] = q;
                for &stream in &raw_streams {
                    if stores(parts, v, stream) {
                        let a = &mut parts.attributes[stream];
                        let (stride, from) = (a.stride(), u as usize * a.stride());
                        a.bytes.copy_within(from..from + stride, v as usize * stride);
                    }
                }
            }
        }
    }
    moved
}

/// Iterates over a cell and its 26 neighbours.
fn cells_around(home: [f64; 3]) -> impl Iterator<Item = [f64; 3]> {
    (0..27).map(move |i| [i % 3, i / 3 % 3, i / 9].map(|x| f64::from(x - 1))).map(move |d| {
        let [x, y, z] = home;
        [x + d[0], y + d[1], z + d[2]]
    })
}
