//! From a finished log to a [`Simplified`]: vertices in the order in which they went, triangles last to die first.

use crate::engine::Log;
use crate::wedges::Wedges;
use lodc_mesh::{CollapseSequence, Mesh, MeshParts, SequenceParts, Simplified, Submesh};

/// `triangle_of` names the input triangle of each face, `error_scale` turns working units into the mesh's.
pub(crate) fn output(
    input: &Mesh,
    wedges: &Wedges,
    corners: &[[u32; 3]],
    triangle_of: &[u32],
    log: Log,
    error_scale: f64,
) -> Simplified {
    let mut new_index = vec![u32::MAX; log.order.len()];
    for (new, &w) in (0u32..).zip(&log.order) {
        new_index[w as usize] = new;
    }
    let targets = log.targets.iter().map(|&w| new_index[w as usize]).collect();

    let place = |w: u32| wedges.place_of[w as usize];
    let look = |w: u32| wedges.attributes_of[w as usize];
    let submesh = |w: u32| wedges.submesh[w as usize];
    // A fake's place may belong to a submesh without some stream; then its own attributes' vertex has to do.
    let streams_of = |vertex: u32| &input.submeshes()[input.vertex_submesh()[vertex as usize] as usize].attributes;
    let attributes = input
        .attributes()
        .iter()
        .zip(0u32..)
        .map(|(a, i)| {
            a.gathered(
                log.order
                    .iter()
                    .map(|&w| if a.is_spatial() && streams_of(place(w)).contains(&i) { place(w) } else { look(w) }),
            )
        })
        .collect();

    // Within each submesh the last to die comes first.
    let mut death = vec![0; triangle_of.len()];
    let mut face_of = vec![0; triangle_of.len()];
    for (f, &t) in (0u32..).zip(triangle_of) {
        death[t as usize] = log.death[f as usize];
        face_of[t as usize] = f;
    }
    let mut triangles = Vec::with_capacity(triangle_of.len());
    let mut submeshes: Vec<Submesh> = Vec::with_capacity(input.submeshes().len());
    for s in input.submeshes() {
        let mut order: Vec<u32> = s.triangles().map(|t| t as u32).collect();
        order.sort_by_key(|&t| (std::cmp::Reverse(death[t as usize]), t));
        triangles.extend(order.iter().map(|&t| corners[face_of[t as usize] as usize].map(|w| new_index[w as usize])));
        submeshes.push(s.clone());
    }

    let mesh = MeshParts {
        positions: log.order.iter().map(|&w| input.positions()[place(w) as usize]).collect(),
        vertex_submesh: log.order.iter().map(|&w| submesh(w)).collect(),
        attributes,
        triangles,
        submeshes,
    };
    let collapses = SequenceParts {
        targets,
        step_ends: log.step_ends,
        step_errors: log.step_errors.iter().map(|&e| (e * error_scale).min(f64::from(f32::MAX)) as f32).collect(),
        step_triangles: log.step_triangles,
        triangles: triangle_of.len() as u32,
        last_legal_lod: log.last_legal,
        topology_changes: log.topology_changes,
        first_topology_change: log.first_topology_change,
    };
    let mesh = Mesh::try_from(mesh).expect("the input's vertices and triangles in another order are still a mesh");
    let collapses =
        CollapseSequence::try_from(collapses).expect("the log is written in order, targets outlive sources");
    Simplified::new(mesh, collapses).expect("every wedge but the last has one record")
}
