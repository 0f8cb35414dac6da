//! Batches: steps in the order of the tree of targets, as a stream that keeps no exact order has
//! them.
//!
//! A level of half-edge collapses depends on the set of its vertices alone, so any order with
//! targets before what splits off them gives the same levels where the sets are the same. Steps are
//! cut into batches; within one they come in the order in which a list of all wedge groups is
//! walked through once. A group goes on being split until the batch has no more splits of it; each
//! new group stands right behind the one that it splits off. A bit for each visit says all of it.
//!
//! ```text
//!   list           0   1   2          before the batch
//!   splits         3 off 0, 4 off 2, 5 off 3
//!   walked         0 3 5 1 2 4        bits 1 0 · 1 0 · 0 · 0 · 1, and the batch is over
//! ```

use lodc_mesh::{MeshParts, NONE, PositionIds, SequenceParts, Simplified, removal_lods};
use lodc_mesh::{CollapseSequence, Lod, Mesh};

/// A batch has one step, and one more for so many steps before it: it grows the mesh by a quarter.
/// Of 20, 25 and 30 %, shorter ones cost more bits, longer ones show worse levels within.
const STEPS_FOR_ONE_MORE: usize = 4;

/// The splits of an object in stream order.
pub(crate) struct StepTree<'a> {
    /// The target of each vertex.
    pub(crate) targets: &'a [u32],
    /// For each vertex whether its step continues with the next one.
    pub(crate) continues: &'a [bool],
    /// The first vertex of the wedge group of each one.
    pub(crate) groups: &'a [u32],
    /// Vertices before the first triangle.
    pub(crate) points: u32,
    /// Numbers of vertices at which a level must not be changed: the last legal one, and the first
    /// with another topology.
    pub(crate) fixed: [u32; 2],
}

/// Steps in the order of their batches.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct BatchPlan {
    /// The first vertex of each step, as they were numbered.
    pub(crate) order: Vec<u32>,
    /// The number of steps of each batch.
    pub(crate) sizes: Vec<u32>,
}

impl BatchPlan {
    /// Returns whether the steps are in this order already.
    pub(crate) fn is_identity(&self) -> bool {
        self.order.is_sorted()
    }
}

impl StepTree<'_> {
    /// Plans batches. `None` if a step is not a whole wedge group that splits off one other group,
    /// and points.
    pub(crate) fn plan(&self) -> Option<BatchPlan> {
        let steps = self.steps()?;
        let mut plan = BatchPlan { order: Vec::with_capacity(steps.len()), sizes: Vec::new() };
        let vertices = self.targets.len();
        let mut next: Vec<u32> = (1..=vertices as u32).collect();
        if let Some(last) = (self.points as usize).checked_sub(1) {
            next[last] = NONE;
        }
        // The steps of the batch by the group that they split off, in their order.
        let (mut first, mut sibling) = (vec![NONE; vertices], vec![NONE; vertices]);
        while plan.order.len() < steps.len() {
            let done = plan.order.len();
            let most = (done + 1 + done / STEPS_FOR_ONE_MORE).min(steps.len());
            let is_fixed = |&end: &usize| steps.get(end).is_some_and(|s| self.fixed.contains(s));
            let end = (done + 1..most).find(is_fixed).unwrap_or(most);
            for &step in steps[done..end].iter().rev() {
                let off = &mut first[self.groups[self.targets[step as usize] as usize] as usize];
                sibling[step as usize] = std::mem::replace(off, step);
            }
            let mut group = 0;
            while plan.order.len() < end && group != NONE {
                let step = first[group as usize];
                if step == NONE {
                    group = next[group as usize];
                } else {
                    first[group as usize] = sibling[step as usize];
                    next[step as usize] = std::mem::replace(&mut next[group as usize], step);
                    plan.order.push(step);
                }
            }
            plan.sizes.push((end - done) as u32);
        }
        Some(plan)
    }

    /// The first vertex of each step behind the points, if all are whole groups off one group.
    fn steps(&self) -> Option<Vec<u32>> {
        let mut steps = Vec::new();
        let group_of_target = |v: usize| self.groups[self.targets[v] as usize];
        for v in self.points as usize..self.targets.len() {
            let continued = v > 0 && self.continues[v - 1] && v > self.points as usize;
            if !continued {
                if self.groups[v] as usize != v {
                    return None;
                }
                steps.push(v as u32);
            } else {
                // Points are there from the beginning, whatever group they are of.
                let follows = self.targets[v] < self.points
                    || group_of_target(v) == group_of_target(v - 1);
                if self.groups[v] != self.groups[v - 1] || !follows {
                    return None;
                }
            }
        }
        Some(steps)
    }
}

/// Returns the first vertex of each one's group: those of a step that have the same position as the
/// vertex before.
pub(crate) fn wedge_groups(
    continues: &[bool],
    same_position: impl Fn(usize, usize) -> bool,
) -> Vec<u32> {
    let mut groups: Vec<u32> = (0..continues.len() as u32).collect();
    for v in 1..groups.len() {
        if continues[v - 1] && same_position(v - 1, v) {
            groups[v] = groups[v - 1];
        }
    }
    groups
}

/// Returns a mesh with the steps of its sequence in batches, as a stream has them: the levels at
/// the ends of batches are as they were, and so are their errors. `None` if it has an order in
/// which streams cannot have it, or if it is in that order already.
#[must_use]
pub fn in_batches(simplified: &Simplified) -> Option<Simplified> {
    let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
    let (vertices, last) = (mesh.vertex_count(), collapses.records());
    let targets = collapses.targets().iter().rev().map(|&t| last - t);
    let targets: Vec<u32> = std::iter::once(0).chain(targets).take(vertices).collect();
    let continues = super::encoder_source::continues(simplified);
    let bits = |v: usize| mesh.positions()[last as usize - v].map(f32::to_bits);
    let parts = collapses.parts();
    let visible = parts.step_triangles.partition_point(|&t| t > 0);
    let points = match parts.step_ends.get(visible) {
        Some(&end) if mesh.triangles().len() > 0 => vertices as u32 - end,
        _ => vertices as u32,
    };
    let tree = StepTree {
        targets: &targets,
        continues: &continues,
        groups: &wedge_groups(&continues, |a, b| bits(a) == bits(b)),
        points,
        fixed: fixed_levels(simplified),
    };
    let plan = tree.plan().filter(|plan| !plan.is_identity())?;
    reordered(simplified, points, &continues, &plan)
}

/// The numbers of vertices at the levels that batches leave as they are.
pub(crate) fn fixed_levels(simplified: &Simplified) -> [u32; 2] {
    let parts = simplified.collapses().parts();
    let topology = parts.first_topology_change.unwrap_or(parts.last_legal_lod);
    [parts.last_legal_lod, topology].map(|Lod(lod)| simplified.mesh().vertex_count() as u32 - lod)
}

/// The mesh with its vertices in the order of a plan.
fn reordered(
    simplified: &Simplified,
    points: u32,
    continues: &[bool],
    plan: &BatchPlan,
) -> Option<Simplified> {
    let last = simplified.collapses().records();
    // In stream order: for each vertex its number before.
    let mut before: Vec<u32> = (0..points).collect();
    let mut steps = Vec::with_capacity(plan.order.len());
    for &step in &plan.order {
        let more = continues[step as usize..].iter().take_while(|&&c| c).count() as u32;
        steps.push(more + 1);
        before.extend(step..=step + more);
    }
    let old = |k: u32| last - before[(last - k) as usize];
    let mut now = vec![0; before.len()];
    for k in 0..=last {
        now[old(k) as usize] = k;
    }
    let (mesh, sequence) = simplified.clone().into_parts();
    let (mesh, sequence) = (mesh.into_parts(), sequence.into_parts());
    let order = || (0..=last).map(|k| old(k) as usize);
    let attributes = mesh.attributes.iter().map(|a| {
        let stride = a.stride();
        let bytes = order().flat_map(|v| &a.bytes[v * stride..][..stride]).copied().collect();
        lodc_mesh::Attribute { bytes, ..a.described() }
    });
    let mesh = MeshParts {
        positions: order().map(|v| mesh.positions[v]).collect(),
        vertex_submesh: order().map(|v| mesh.vertex_submesh[v]).collect(),
        attributes: attributes.collect(),
        triangles: mesh.triangles.iter().map(|t| t.map(|v| now[v as usize])).collect(),
        submeshes: mesh.submeshes,
    };
    let targets = (0..last).map(|k| now[sequence.targets[old(k) as usize] as usize]).collect();
    let (errors, rms) = errors_of_batches(&sequence, plan);
    let mut step_ends = Vec::with_capacity(sequence.step_ends.len());
    let mut end = 0;
    for &step in steps.iter().rev() {
        end += step;
        step_ends.push(end);
    }
    step_ends.extend_from_slice(&sequence.step_ends[steps.len()..]);
    let sequence = SequenceParts {
        targets,
        step_triangles: vec![sequence.triangles; step_ends.len()],
        step_ends,
        step_errors: errors,
        step_rms: rms,
        ..sequence
    };
    let mesh = Mesh::try_from(mesh).ok()?;
    let unmeasured = SequenceParts {
        step_errors: vec![0.0; sequence.step_errors.len()],
        step_rms: Vec::new(),
        ..sequence.clone()
    };
    let simplified = Simplified::new(mesh, CollapseSequence::try_from(unmeasured).ok()?).ok()?;
    let simplified = with_removals(simplified)?;
    if has_triangles_across_submeshes(&simplified) {
        return None;
    }
    let (mesh, counted) = simplified.into_parts();
    let parts = counted.into_parts();
    let (step_errors, step_rms) = (sequence.step_errors, sequence.step_rms);
    let parts = SequenceParts { step_errors, step_rms, ..parts };
    Simplified::new(mesh, CollapseSequence::try_from(parts).ok()?).ok()
}

/// Returns whether a triangle of a level has corners in two submeshes: where a vertex goes on as
/// one of another submesh, its triangles are to be gone by then.
fn has_triangles_across_submeshes(simplified: &Simplified) -> bool {
    let submesh = simplified.mesh().vertex_submesh();
    let targets = simplified.collapses().targets();
    // How often the submesh changes on the way from a vertex to the last one.
    let mut changes = vec![0u32; submesh.len()];
    for v in (0..targets.len()).rev() {
        let target = targets[v] as usize;
        changes[v] = changes[target] + u32::from(submesh[v] != submesh[target]);
    }
    let last = simplified.collapses().records();
    let appearances = super::first_appearance::first_appearances(simplified);
    let is_across = |(appearance, triangle): (&super::first_appearance::FirstAppearance, &[u32; 3])| {
        (0..3).any(|i| {
            let first = last - appearance.vertices[i];
            let finest = triangle[(appearance.rotation + i) % 3];
            changes[first as usize] != changes[finest as usize]
        })
    };
    appearances.iter().zip(simplified.mesh().triangles()).any(is_across)
}

/// The errors after each step: within a batch those at its beginning.
fn errors_of_batches(sequence: &SequenceParts, plan: &BatchPlan) -> (Vec<f32>, Vec<f32>) {
    let (mut errors, mut rms) = (sequence.step_errors.clone(), sequence.step_rms.clone());
    let mut end = plan.order.len();
    for &size in &plan.sizes {
        // Collapsed, the batch is the steps from `start` on, and `end - 1` leads to its beginning.
        let start = end - size as usize;
        for list in [&mut errors, &mut rms] {
            if let Some(&last) = list.get(end - 1) {
                list[start..end].fill(last);
            }
        }
        end = start;
    }
    (errors, rms)
}

/// Counts the triangles after each step, and puts triangles that are removed first last. `None` for
/// a mesh and a sequence that do not belong together.
#[must_use]
pub fn with_removals(simplified: Simplified) -> Option<Simplified> {
    let removals = removal_lods(&simplified, &PositionIds::new(simplified.mesh().positions()));
    let (mesh, sequence) = simplified.into_parts();
    let (mut mesh, mut sequence) = (mesh.into_parts(), sequence.into_parts());
    let mut sorted = removals.clone();
    sorted.sort_unstable();
    let live =
        |&end: &u32| (sorted.len() - sorted.partition_point(|&removal| removal <= end)) as u32;
    sequence.step_triangles = sequence.step_ends.iter().map(live).collect();
    for submesh in &mesh.submeshes {
        let range = submesh.triangles();
        let mut order: Vec<usize> = range.clone().collect();
        order.sort_by_key(|&t| std::cmp::Reverse(removals[t]));
        let triangles: Vec<[u32; 3]> = order.into_iter().map(|t| mesh.triangles[t]).collect();
        mesh.triangles[range].copy_from_slice(&triangles);
    }
    let mesh = Mesh::try_from(mesh).ok()?;
    Simplified::new(mesh, CollapseSequence::try_from(sequence).ok()?).ok()
}
