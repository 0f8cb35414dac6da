//! From a finished log to a [`Simplified`]: vertices in the order in which they went, triangles
//! last to die first.

use crate::commit::log::CollapseLog;
use crate::cut::region::Region;
use crate::final_log::FinalLog;
use crate::number::input::Input;
use lodc_mesh::{CollapseSequence, Mesh, MeshParts, SequenceParts, Simplified};
use rayon::prelude::*;

/// The sources of the data of every wedge of the whole mesh.
pub(crate) struct Sources<'a> {
    input: &'a Input<'a>,
    /// The input vertices of the fakes' positions and attributes.
    fakes: Vec<(u32, u32)>,
}

impl<'a> Sources<'a> {
    pub(crate) fn new(input: &'a Input<'a>) -> Self {
        Self { input, fakes: Vec::new() }
    }

    /// Gives a region's new fakes their numbers, and its log those of the whole mesh.
    pub(crate) fn number(&mut self, region: &mut Region, log: &mut CollapseLog) {
        let first = self.first_free();
        self.fakes.extend(region.wedges.number_fakes(first));
        name_wedges(region, log);
    }

    /// The number of the next fake.
    pub(crate) fn first_free(&self) -> u32 {
        (self.input.wedges() + self.fakes.len()) as u32
    }

    /// The vertex whose position and other spatial data a wedge has.
    fn position(&self, wedge: u32) -> u32 {
        match self.input.vertex_of().get(wedge as usize) {
            Some(&vertex) => vertex,
            None => self.fakes[wedge as usize - self.input.wedges()].0,
        }
    }

    /// The vertex whose other attributes a wedge has.
    fn attributes(&self, wedge: u32) -> u32 {
        match self.input.vertex_of().get(wedge as usize) {
            Some(&vertex) => vertex,
            None => self.fakes[wedge as usize - self.input.wedges()].1,
        }
    }
}

/// Replaces a region's wedge numbers in its log by those of the whole mesh.
pub(crate) fn name_wedges(region: &Region, log: &mut CollapseLog) {
    for wedge in log.wedges.iter_mut().chain(&mut log.targets) {
        *wedge = region.wedge_id(*wedge);
    }
}

/// Puts the mesh into the order of the log.
pub(crate) fn output(input: &Input<'_>, sources: &Sources<'_>, log: FinalLog) -> Simplified {
    let mesh = input.mesh;
    let mut new_index = vec![u32::MAX; log.order.len()];
    for (new, &w) in (0u32..).zip(&log.order) {
        new_index[w as usize] = new;
    }
    let targets = log.targets.par_iter().map(|&w| new_index[w as usize]).collect();
    let place = |w: u32| sources.position(w);
    let look = |w: u32| sources.attributes(w);
    // A fake's place may belong to a submesh without some stream; then its own attributes' vertex
    // has to do.
    let streams_of =
        |vertex: u32| &mesh.submeshes()[mesh.vertex_submesh()[vertex as usize] as usize].attributes;
    let attributes = mesh
        .attributes()
        .iter()
        .zip(0u32..)
        .map(|(a, i)| {
            a.gathered(log.order.iter().map(|&w| {
                if a.is_spatial() && streams_of(place(w)).contains(&i) { place(w) } else { look(w) }
            }))
        })
        .collect();

    let triangles = last_to_die_first(mesh, &log.death)
        .into_par_iter()
        .map(|t| {
            let vertices = mesh.triangles()[t as usize];
            vertices.map(|v| new_index[input.wedge_of()[v as usize] as usize])
        })
        .collect();

    let parts = MeshParts {
        positions: log.order.par_iter().map(|&w| mesh.positions()[place(w) as usize]).collect(),
        vertex_submesh: log
            .order
            .par_iter()
            .map(|&w| mesh.vertex_submesh()[look(w) as usize])
            .collect(),
        attributes,
        triangles,
        submeshes: mesh.submeshes().to_vec(),
    };
    let collapses = SequenceParts {
        targets,
        step_ends: log.step_ends,
        step_errors: log.step_errors.iter().map(|&e| in_mesh_units(e, input.scale)).collect(),
        step_rms: vec![],
        step_triangles: log.step_triangles,
        triangles: mesh.triangles().len() as u32,
        last_legal_lod: log.last_legal,
        topology_changes: log.topology_changes,
        first_topology_change: log.first_topology_change,
    };
    let mesh = Mesh::try_from(parts)
        .expect("the input's vertices and triangles in another order are still a mesh");
    let collapses = CollapseSequence::try_from(collapses)
        .expect("the log is written in order, targets outlive sources");
    Simplified::new(mesh, collapses).expect("every wedge but the last has one record")
}

/// An error in the mesh's units.
fn in_mesh_units(error: f32, scale: f64) -> f32 {
    (f64::from(error) / scale).min(f64::from(f32::MAX)) as f32
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
