//! Seams inside a chart, where a connected region meets itself with other texture coordinates:
//! vertices do not take attributes from beyond such a seam.

use crate::blend::Source;
use crate::level::CoarseMesh;
use lodc_mesh::{Attribute, Mesh, Semantic};

/// Removes the source of every vertex that found a point beyond a seam of its own chart: one whose
/// texture coordinates are nearer to those of another vertex at the same position.
pub(crate) fn keep_to_own_side(
    input: &Mesh,
    level: &CoarseMesh,
    chart_of_vertex: &[u32],
    sources: &mut [Option<Source>],
) {
    let key = |v: &u32| (level.point_of_vertex[*v as usize], chart_of_vertex[*v as usize]);
    let mut order: Vec<u32> = (0..sources.len() as u32).collect();
    order.sort_unstable_by_key(|v| (key(v), *v));
    for wedges in order.chunk_by(|a, b| key(a) == key(b)).filter(|wedges| wedges.len() > 1) {
        for &v in wedges {
            let Some(source) = sources[v as usize] else { continue };
            let own_distance = texture_distance(input, level, v, source);
            if wedges
                .iter()
                .any(|&other| texture_distance(input, level, other, source) < own_distance)
            {
                sources[v as usize] = None;
            }
        }
    }
}

/// The squared distance of a vertex's texture coordinates from those at a point of the input.
fn texture_distance(
    input: &Mesh,
    level: &CoarseMesh,
    v: u32,
    Source { vertices, weights }: Source,
) -> f64 {
    let streams = input.attributes().iter().zip(level.mesh.attributes());
    let is_texture = |(a, _): &(&Attribute, &Attribute)| {
        matches!(a.semantic, Semantic::TexCoord(_)) && a.morph_target.is_none()
    };
    let difference = |from: &Attribute, to: &Attribute, k: usize| {
        let interpolated =
            vertices.iter().zip(weights).map(|(&vertex, w)| w * f64::from(from.value(vertex, k)));
        interpolated.sum::<f64>() - f64::from(to.value(v, k))
    };
    streams
        .filter(is_texture)
        .flat_map(|(from, to)| (0..2).map(move |k| difference(from, to, k).powi(2)))
        .sum()
}
