//! Welding: giving positions that are nearly the same exactly the same coordinates.

use crate::MeshParts;
use std::collections::BTreeMap;

/// Snaps every position to the first earlier one within `tolerance` (mesh units), if there is one. Returns how many
/// vertices moved. Attributes are left alone; raw position streams follow. Triangles that lose their area are left
/// for [`MeshParts::clean`].
pub fn weld_positions(parts: &mut MeshParts, tolerance: f64) -> usize {
    if tolerance.is_nan() || tolerance <= 0.0 {
        return 0;
    }
    let cell = |p: [f32; 3]| p.map(|c| (f64::from(c) / tolerance).floor());
    let key = |c: [f64; 3]| c.map(|x| (x + 0.0).to_bits());
    let near = |a: [f32; 3], b: [f32; 3]| {
        (0..3).map(|i| (f64::from(a[i]) - f64::from(b[i])).powi(2)).sum::<f64>() <= tolerance * tolerance
    };
    let mut kept: BTreeMap<[u64; 3], Vec<u32>> = BTreeMap::new();
    let mut moved = 0;
    for v in 0..parts.positions.len() {
        let (p, home) = (parts.positions[v], cell(parts.positions[v]));
        let neighbours = (0..27).map(|i| [home[0] + f64::from(i % 3 - 1), home[1] + f64::from(i / 3 % 3 - 1), home[2] + f64::from(i / 9 - 1)]);
        let target = neighbours
            .filter_map(|c| kept.get(&key(c)))
            .flatten()
            .copied()
            .filter(|&u| near(parts.positions[u as usize], p))
            .min();
        match target {
            Some(u) => {
                let q = parts.positions[u as usize];
                if crate::position_key(q) != crate::position_key(p) {
                    moved += 1;
                }
                parts.positions[v] = q;
                let same_layout = parts.vertex_submesh[v] == parts.vertex_submesh[u as usize];
                for a in &mut parts.attributes {
                    if a.semantic == crate::Semantic::Position && a.morph_target.is_none() && same_layout {
                        let stride = a.stride();
                        a.bytes.copy_within(u as usize * stride..(u as usize + 1) * stride, v * stride);
                    }
                }
            }
            None => kept.entry(key(home)).or_default().push(v as u32),
        }
    }
    moved
}
