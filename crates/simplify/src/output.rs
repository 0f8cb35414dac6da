//! The last step: the log becomes a [`Simplified`].
//!
//! The input is the log of the whole mesh. Regions wrote it side by side, so the legal steps are
//! sorted by their stamps first. The output is the vertices in the order in which they disappeared,
//! fakes among them, each with the bytes of the input's vertices that its data come from; and the
//! triangles, those that are removed last first. Models rely on both orders: a level is a range of
//! vertices and, within each submesh, of triangles.

use crate::commit::{CollapseLog, Sources};
use crate::number::{Input, sorted};
use lodc_mesh::{CollapseSequence, Lod, Mesh, MeshParts, SequenceParts, Simplified};
use rayon::prelude::*;

/// Puts the mesh into the order of its log, of which the first `legal` steps are legal.
/// `by_stamp` says that they are not in order yet.
pub(crate) fn output(
    input: &Input<'_>,
    sources: &Sources<'_>,
    log: CollapseLog,
    legal: usize,
    by_stamp: bool,
) -> Simplified {
    let Ordered { wedges, removal_lod, mut sequence } = Ordered::new(&log, legal, input, by_stamp);
    drop(log);
    let mesh = input.mesh;
    let mut new_index = vec![u32::MAX; wedges.len()];
    for (new, &w) in (0u32..).zip(&wedges) {
        new_index[w as usize] = new;
    }
    sequence.targets.par_iter_mut().for_each(|w| *w = new_index[*w as usize]);
    for e in &mut sequence.step_errors {
        *e = (f64::from(*e) / input.scale).min(f64::from(f32::MAX)) as f32;
    }
    let position_of = |w: u32| sources.of(w).position;
    let attributes_of = |w: u32| sources.of(w).attributes;
    // The vertex that a fake's position comes from may belong to a submesh that lacks a spatial
    // attribute; it is read from the vertex of the other attributes then.
    let users = mesh.users_of_streams();
    let attributes = mesh
        .attributes()
        .iter()
        .zip(0u32..)
        .map(|(a, i)| {
            let mut uses_position_vertex = vec![false; mesh.submeshes().len()];
            if a.is_spatial() {
                users.row(i).iter().for_each(|&s| uses_position_vertex[s as usize] = true);
            }
            let has =
                |vertex: u32| uses_position_vertex[mesh.vertex_submesh()[vertex as usize] as usize];
            a.gathered(
                wedges
                    .iter()
                    .map(|&w| if has(position_of(w)) { position_of(w) } else { attributes_of(w) }),
            )
        })
        .collect();
    let triangles = last_removed_first(mesh, &removal_lod)
        .into_par_iter()
        .map(|t| {
            let vertices = mesh.triangles()[t as usize];
            vertices.map(|v| new_index[input.wedge_of()[v as usize] as usize])
        })
        .collect();
    let mesh = Mesh::try_from(MeshParts {
        positions: wedges.par_iter().map(|&w| mesh.positions()[position_of(w) as usize]).collect(),
        vertex_submesh: wedges.par_iter().map(|&w| sources.of(w).submesh).collect(),
        attributes,
        triangles,
        submeshes: mesh.submeshes().to_vec(),
    })
    .expect("the input's vertices and triangles in another order are still a mesh");
    let collapses = CollapseSequence::try_from(sequence)
        .expect("the log is written in order, targets outlive sources");
    Simplified::new(mesh, collapses).expect("every wedge but the last has one record")
}

/// The collapses of a whole mesh in their final order.
struct Ordered {
    /// Wedges in the order in which they disappear.
    wedges: Vec<u32>,
    /// The LOD at which each input triangle is removed.
    removal_lod: Vec<u32>,
    /// Its targets are still wedges, its errors in working units.
    sequence: SequenceParts,
}

impl Ordered {
    /// Puts a log in its final order.
    fn new(log: &CollapseLog, legal: usize, input: &Input<'_>, by_stamp: bool) -> Self {
        let triangles = input.mesh.triangles().len();
        let steps = log.steps.len();
        let sequence = SequenceParts {
            targets: Vec::with_capacity(log.targets.len()),
            step_ends: Vec::with_capacity(steps),
            step_errors: Vec::with_capacity(steps),
            step_triangles: Vec::with_capacity(steps),
            triangles: triangles as u32,
            ..SequenceParts::default()
        };
        let wedges = Vec::with_capacity(log.wedges.len());
        let mut ordered = Self { wedges, removal_lod: vec![0; triangles], sequence };
        let mut live_triangles = triangles as u32;
        for i in final_order(log, legal, by_stamp) {
            ordered.append_step(log, i as usize, i as usize >= legal, &mut live_triangles);
        }
        // The last wedge becomes nothing.
        ordered.wedges.extend(log.wedges.get(log.targets.len()..).into_iter().flatten());
        ordered
    }

    /// Appends a step.
    fn append_step(
        &mut self,
        log: &CollapseLog,
        i: usize,
        is_terminal: bool,
        live_triangles: &mut u32,
    ) {
        let (step, records, dead) = (log.steps[i], log.records(i), log.removals(i));
        self.wedges.extend_from_slice(&log.wedges[records.clone()]);
        let lod = self.wedges.len() as u32;
        for &triangle in dead {
            self.removal_lod[triangle as usize] = lod;
        }
        *live_triangles -= dead.len() as u32;
        let sequence = &mut self.sequence;
        sequence.targets.extend_from_slice(&log.targets[records]);
        let error = sequence.step_errors.last().copied().unwrap_or(0.0).max(step.error);
        sequence.step_ends.push(lod);
        sequence.step_errors.push(error);
        sequence.step_triangles.push(*live_triangles);
        if !is_terminal {
            sequence.last_legal_lod = Lod(lod);
            if step.changes_topology {
                sequence.topology_changes += 1;
                sequence.first_topology_change.get_or_insert(Lod(lod));
            }
        }
    }
}

/// The steps of a log in their final order: the first `legal` ones by stamp, equal ones as they
/// happened, unless they are in order already; the others follow. A step's stamp is no less than
/// those of the steps it builds on, so these stay before it.
pub(crate) fn final_order(log: &CollapseLog, legal: usize, by_stamp: bool) -> Vec<u32> {
    let stamp = |i: u32| u64::from(log.steps[i as usize].stamp.to_bits());
    let mut order = if by_stamp { sorted(legal, 32, stamp) } else { (0..legal as u32).collect() };
    order.extend(legal as u32..log.steps.len() as u32);
    order
}

/// The input's triangles, within each submesh the last removed first, ties in the input's order.
fn last_removed_first(input: &Mesh, removal_lod: &[u32]) -> Vec<u32> {
    let last = removal_lod.iter().copied().max().unwrap_or(0);
    let mut submesh_of = vec![0u32; removal_lod.len()];
    for (i, s) in (0..).zip(input.submeshes()) {
        submesh_of[s.triangles()].fill(i);
    }
    let bits = |most: u32| u32::BITS - most.leading_zeros();
    let (lod_bits, submeshes) = (bits(last), input.submeshes().len() as u32);
    sorted(removal_lod.len(), lod_bits + bits(submeshes.saturating_sub(1)), |t| {
        u64::from(submesh_of[t as usize]) << lod_bits | u64::from(last - removal_lod[t as usize])
    })
}
