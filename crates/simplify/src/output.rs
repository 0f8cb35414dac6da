//! From a finished log to a [`Simplified`]: vertices in the order in which they went, triangles
//! last to die first.

use crate::log::Log;
use crate::wedges::Wedges;
use lodc_mesh::{CollapseSequence, Mesh, MeshParts, SequenceParts, Simplified};

/// `wedge_of` names the wedge of each vertex of the input, `error_scale` turns working units into
/// the mesh's.
pub(crate) fn output(
    input: &Mesh,
    wedges: &Wedges,
    wedge_of: &[u32],
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
    // A fake's place may belong to a submesh without some stream; then its own attributes' vertex
    // has to do.
    let streams_of = |vertex: u32| {
        &input.submeshes()[input.vertex_submesh()[vertex as usize] as usize].attributes
    };
    let attributes = input
        .attributes()
        .iter()
        .zip(0u32..)
        .map(|(a, i)| {
            a.gathered(log.order.iter().map(|&w| {
                if a.is_spatial() && streams_of(place(w)).contains(&i) { place(w) } else { look(w) }
            }))
        })
        .collect();

    let triangles = last_to_die_first(input, &log.death)
        .into_iter()
        .map(|t| input.triangles()[t as usize].map(|v| new_index[wedge_of[v as usize] as usize]))
        .collect();

    let mesh = MeshParts {
        positions: log.order.iter().map(|&w| input.positions()[place(w) as usize]).collect(),
        vertex_submesh: log.order.iter().map(|&w| submesh(w)).collect(),
        attributes,
        triangles,
        submeshes: input.submeshes().to_vec(),
    };
    let collapses = SequenceParts {
        targets,
        step_ends: log.step_ends,
        step_errors: log
            .step_errors
            .iter()
            .map(|&e| (e * error_scale).min(f64::from(f32::MAX)) as f32)
            .collect(),
        step_rms: vec![],
        step_triangles: log.step_triangles,
        triangles: input.triangles().len() as u32,
        last_legal_lod: log.last_legal,
        topology_changes: log.topology_changes,
        first_topology_change: log.first_topology_change,
    };
    let mesh = Mesh::try_from(mesh)
        .expect("the input's vertices and triangles in another order are still a mesh");
    let collapses = CollapseSequence::try_from(collapses)
        .expect("the log is written in order, targets outlive sources");
    Simplified::new(mesh, collapses).expect("every wedge but the last has one record")
}

/// The input's triangles, within each submesh the last to die first, ties in the input's order.
fn last_to_die_first(input: &Mesh, death: &[u32]) -> Vec<u32> {
    // Two passes of a counting sort over the LODs: by death, then by submesh.
    let last = death.iter().copied().max().unwrap_or(0);
    let by_death = counting_sort(0..death.len() as u32, death.len(), last as usize + 1, |t| {
        last - death[t as usize]
    });
    let mut submesh_of = vec![0u32; death.len()];
    for (i, s) in (0..).zip(input.submeshes()) {
        submesh_of[s.triangles()].fill(i);
    }
    if input.submeshes().len() <= 1 {
        return by_death;
    }
    counting_sort(by_death.iter().copied(), death.len(), input.submeshes().len(), |t| {
        submesh_of[t as usize]
    })
}

/// Items in order of a key below `keys`; items of equal keys keep their order.
fn counting_sort(
    items: impl Iterator<Item = u32> + Clone,
    count: usize,
    keys: usize,
    key: impl Fn(u32) -> u32,
) -> Vec<u32> {
    let mut start = vec![0u32; keys + 1];
    for item in items.clone() {
        start[key(item) as usize + 1] += 1;
    }
    for i in 1..start.len() {
        start[i] += start[i - 1];
    }
    let mut sorted = vec![0; count];
    for item in items {
        let slot = &mut start[key(item) as usize];
        sorted[*slot as usize] = item;
        *slot += 1;
    }
    sorted
}
