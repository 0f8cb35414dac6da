//! What an encoder knows of an object: all its vertex splits, derived from its collapse sequence.
//!
//! The stream runs backwards through the sequence: vertex `i` of the stream is vertex `last − i` of
//! the sequence. Corner `c` of triangle `t` has the number 4 t + c; the fourth is unused.

use crate::error_code::{ErrorCodes, error_code, rms_code};
use crate::partial_mesh::new_triangle::Side;
use crate::source::batches::{
    Batch, StepOrder, StepTree, errors_by_steps, find_continued_steps, fixed_levels, wedge_groups,
};
use crate::source::coding_parents::{SplitPlan, Splits, StarRule};
use crate::source::face_lists::{FaceLists, Transfers};
use crate::source::first_appearance::{FirstAppearance, first_appearances};
use crate::source::split_source::{SourceTriangle, SplitSource};
use crate::vertex_data::vertex_layout::VertexLayout;
use lodc_mesh::{CollapseSequence, Csr, Lod, NONE, Simplified};
use std::ops::Range;

/// All splits of a simplified mesh.
pub(crate) struct EncoderSource {
    /// The target of each vertex.
    targets: Vec<u32>,
    /// The vertex that each one is coded as split off, see `coding_parents`.
    parents: Vec<u32>,
    /// For each vertex whether its step continues with the next one.
    continues: Vec<bool>,
    /// The submesh of each vertex.
    submesh: Vec<u32>,
    /// Number of channels of a vertex.
    channels: usize,
    /// The values of all channels of all vertices, as indices of their number systems.
    indices: Vec<i32>,
    triangles: Vec<SourceTriangle>,
    /// For each vertex the index in `triangles` of the first that comes with it; last their number.
    first_triangle: Vec<u32>,
    /// The vertex of LOD 0 at each corner of each triangle; the fourth is unused.
    final_vertices: Vec<u32>,
    /// For each vertex the interval of preorder numbers in the tree of splits that it and all
    /// vertices that split off it have, directly or not.
    subtree: Vec<Range<u32>>,
    face_lists: FaceLists,
    /// The errors after each vertex, as if its step ended there.
    error_codes: Vec<ErrorCodes>,
    /// Number of points: the vertices before the first triangle.
    points: u32,
    /// The first vertex of the wedge group of each one.
    groups: Vec<u32>,
    /// None if the order is exact.
    batches: Option<Vec<Batch>>,
}

impl EncoderSource {
    /// Derives the splits. They come in batches if these are wanted and the sequence has that
    /// order.
    pub(crate) fn new(
        simplified: &Simplified,
        layout: &VertexLayout,
        step_order: StepOrder,
        rule: StarRule,
    ) -> Self {
        let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
        let vertices = mesh.vertex_count();
        let last = collapses.records();
        let targets = collapses.targets().iter().rev().map(|&t| last - t);
        let targets: Vec<u32> = std::iter::once(0).chain(targets).take(vertices).collect();
        let (appearances, continues) =
            (first_appearances(simplified), find_continued_steps(simplified));
        let by_vertex = Csr::new(vertices, appearances.iter().map(|a| a.vertices[0]).zip(0..));
        let points = count_points(&by_vertex.offsets, &continues);
        let splits = Splits {
            targets: &targets,
            points,
            appearances: &appearances,
            by_vertex: &by_vertex,
            triangles: mesh.triangles(),
        };
        let SplitPlan { parents, listed } = splits.plan(rule);
        let order = coding_order(&appearances, &parents);
        let entries = order.iter().map(|&t| (appearances[t as usize].vertices[0], t));
        let by_vertex = Csr::new(vertices, entries);
        let triangle = |&t: &u32| {
            let [_, next, previous] = appearances[t as usize].vertices;
            SourceTriangle { next, previous }
        };
        let first_triangle = by_vertex.offsets;
        let final_vertices = final_vertices(mesh.triangles(), &appearances, &order, last);
        let transfers = Transfers {
            targets: &targets,
            first_triangle: &first_triangle,
            final_vertices: &final_vertices,
        };
        let (channels, indices) = (layout.systems.len(), layout.indices(mesh));
        let position = |v: usize| &indices[v * channels..][..3];
        let groups = wedge_groups(&continues, |a, b| position(a) == position(b));
        let tree = StepTree {
            targets: &targets,
            continues: &continues,
            groups: &groups,
            points,
            fixed_levels: fixed_levels(simplified),
            errors: errors_by_steps(simplified, points, step_order),
        };
        let exact = step_order == StepOrder::Exact;
        let batches = if exact || parents != targets { None } else { tree.batches() };
        Self {
            face_lists: transfers.face_lists(listed),
            points,
            subtree: subtrees(&targets),
            continues,
            submesh: mesh.vertex_submesh().iter().rev().copied().collect(),
            channels,
            indices,
            triangles: order.iter().map(triangle).collect(),
            first_triangle,
            final_vertices,
            error_codes: error_codes(collapses),
            targets,
            parents,
            groups,
            batches,
        }
    }

    /// The batches; none if the order is exact.
    pub(crate) fn batches(&self) -> Option<&[Batch]> {
        self.batches.as_deref()
    }

    /// Counts the steps of the stream: those after the points, and one for each wedge group with
    /// points that no split has needed.
    pub(crate) fn count_steps(&self) -> u32 {
        let (points, all) = (self.points as usize, self.parents.len());
        // In the first step single points come; a later one brings whole groups.
        let first_step = points + self.continues[points..].iter().take_while(|&&c| c).count();
        let [mut came_alone, mut came_with_group] = [vec![false; points], vec![false; points]];
        for vertex in points..all {
            let came = if vertex <= first_step { &mut came_alone } else { &mut came_with_group };
            let corners =
                self.new_triangles(vertex as u32).iter().flat_map(|t| [t.next, t.previous]);
            // In a batch the first vertex of a step also needs the first one of its parent's group,
            // which names the group.
            let parent = self.parents[vertex];
            let is_first_of_step = vertex == points || !self.continues[vertex - 1];
            let named = if self.batches.is_some() && is_first_of_step {
                self.groups[parent as usize]
            } else {
                parent
            };
            for needed in corners.chain([parent, named]) {
                if let Some(came) = came.get_mut(needed as usize) {
                    *came = true;
                }
            }
        }
        let (mut incomplete, mut first) = (0, 0);
        for end in 1..=points {
            if end == points || self.groups[end] as usize == end {
                let is_whole = came_alone[first..end].iter().all(|&came| came)
                    || came_with_group[first..end].contains(&true);
                incomplete += u32::from(!is_whole);
                first = end;
            }
        }
        incomplete + self.continues[points..].iter().filter(|&&continues| !continues).count() as u32
    }
}

impl SplitSource for EncoderSource {
    fn points(&self) -> u32 {
        self.points
    }
    fn parent(&self, new: u32) -> u32 {
        self.parents[new as usize]
    }
    fn group(&self, vertex: u32) -> u32 {
        self.groups[vertex as usize]
    }
    fn batch_steps(&self, new: u32) -> u32 {
        let batches = self.batches.as_deref().unwrap_or_default();
        let index = batches.partition_point(|batch| batch.first_vertex < new);
        batches.get(index).map_or(1, |batch| batch.steps)
    }
    fn repeats_target(&self, new: u32) -> bool {
        self.parents[new as usize] != self.targets[new as usize]
    }
    fn continues(&self, new: u32) -> bool {
        self.continues[new as usize]
    }
    fn submesh(&self, new: u32) -> u32 {
        self.submesh[new as usize]
    }
    fn new_triangles(&self, new: u32) -> &[SourceTriangle] {
        let [from, to] = [new, new + 1].map(|v| self.first_triangle[v as usize] as usize);
        &self.triangles[from..to]
    }
    fn is_transferred(&self, corner: u32, new: u32) -> bool {
        let vertex = self.final_vertices[corner as usize];
        self.subtree[new as usize].contains(&self.subtree[vertex as usize].start)
    }
    fn face_list(&self, new: u32) -> Option<&[u32]> {
        self.face_lists.triangles(new)
    }
    fn indices(&self, new: u32) -> &[i32] {
        &self.indices[new as usize * self.channels..][..self.channels]
    }
    fn error_codes(&self, new: u32) -> ErrorCodes {
        self.error_codes[new as usize]
    }
}

/// Counts the vertices before the first step that adds a triangle. `first_triangle` has, for each
/// vertex, the number of triangles that come before it.
fn count_points(first_triangle: &[u32], continues: &[bool]) -> u32 {
    let mut points = first_triangle.iter().skip(1).take_while(|&&end| end == 0).count();
    while points > 0 && points < continues.len() && continues[points - 1] {
        points -= 1;
    }
    points as u32
}

/// Returns the vertex of LOD 0 at each corner of each triangle, triangles in stream order.
fn final_vertices(
    triangles: &[[u32; 3]],
    appearances: &[FirstAppearance],
    order: &[u32],
    last: u32,
) -> Vec<u32> {
    let corners = |&t: &u32| {
        let (vertices, rotation) = (triangles[t as usize], appearances[t as usize].rotation);
        let corner = |c| if c < 3 { last - vertices[(rotation + c) % 3] } else { NONE };
        [corner(0), corner(1), corner(2), corner(3)]
    };
    order.iter().flat_map(corners).collect()
}

/// Returns the codes of the errors after each vertex, as if its step ended there.
fn error_codes(collapses: &CollapseSequence) -> Vec<ErrorCodes> {
    let last = collapses.records();
    let errors = |new| {
        let lod = Lod(last - new);
        ErrorCodes {
            error: error_code(collapses.error_at(lod)),
            rms: rms_code(collapses.rms_at(lod)),
        }
    };
    (0..=last).map(errors).collect()
}

/// Returns the triangles of the mesh in stream order: by vertex, then by side of the split edge.
fn coding_order(appearances: &[FirstAppearance], parents: &[u32]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..appearances.len() as u32).collect();
    order.sort_by_key(|&t| {
        let [v, next, previous] = appearances[t as usize].vertices;
        let side = Side::of(next, previous, parents[v as usize]);
        (v, side as u32, next, previous, t)
    });
    order
}

/// Numbers the vertices in preorder of the tree of splits, and returns the interval of numbers of
/// each subtree.
fn subtrees(parents: &[u32]) -> Vec<Range<u32>> {
    let mut size = vec![1u32; parents.len()];
    for v in (1..parents.len()).rev() {
        size[parents[v] as usize] += size[v];
    }
    let mut subtrees: Vec<Range<u32>> = Vec::with_capacity(parents.len());
    // For each vertex the number of its next child.
    let mut next_number = vec![0u32; parents.len()];
    for v in 0..parents.len() {
        let start = if v == 0 { 0 } else { next_number[parents[v] as usize] };
        if v > 0 {
            next_number[parents[v] as usize] = start + size[v];
        }
        subtrees.push(start..start + size[v]);
        next_number[v] = start + 1;
    }
    subtrees
}
