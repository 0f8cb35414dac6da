//! The codec of one object: codes its steps and applies them to its partial mesh. The same code
//! encodes and decodes, see `entropy/coder.rs`. The parts of a split are in the other files of this
//! folder.

use crate::entropy::coder::Coder;
use crate::entropy::integer_codes::GammaCode;
use crate::error_code::ErrorCodes;
use crate::invalid::InvalidStream;
use crate::partial_mesh::mesh::PartialMesh;
use crate::partial_mesh::new_triangle::{NewTriangle, Side};
use crate::partial_mesh::split::{ParentStar, SplitBuffers, SplitEdge};
use crate::partial_mesh::star::{LARGE_STAR, LinkVertex, StarFace, collect_link};
use crate::source::split_source::SplitSource;
use crate::vertex_data::vertex_layout::VertexLayout;
use crate::vertex_data::vertex_values::{Neighbourhood, VertexValues};
use crate::vertex_split::budget::Cost;
use crate::vertex_split::contexts::Contexts;
use crate::vertex_split::corner_transfer::TransferRule;
use crate::vertex_split::group_list::GroupList;
use crate::vertex_split::neighbourhood::SplitNeighbourhood;
use crate::vertex_split::new_triangles::{SplitPattern, TriangleCode};
use crate::vertex_split::parent_distance::ParentDistance;
use crate::vertex_split::points::Points;
use lodc_mesh::NONE;

/// The symbol of a parent that is eight or more wedges away along the circle of wedges.
const FAR_WEDGE: u32 = 8;

/// Memory is reserved for the whole object once this fraction (one in four) of its vertices, or
/// triangles, is decoded. A header may announce any number; so no stream gets more than four times
/// the memory that its decoded vertices and triangles fill. Chosen by hand.
const RESERVE_FRACTION: u32 = 4;

/// Limits of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepLimits {
    /// Vertices that the object will have.
    pub(crate) vertices: u32,
    /// Triangles that the object will have.
    pub(crate) triangles: u32,
    /// Bytes of the stream up to the end of this block.
    pub(crate) bytes: usize,
}

/// One object as it is coded.
#[derive(Clone, Debug)]
pub(crate) struct ObjectCodec {
    pub(crate) mesh: PartialMesh,
    pub(crate) values: VertexValues,
    /// Number of submeshes.
    pub(super) submeshes: u32,
    /// Stars of more triangles are large: [`LARGE_STAR`], or another number in tests.
    pub(crate) large_star: u32,
    /// The vertices before the first triangle.
    pub(crate) points: Points,
    /// The target of each vertex.
    pub(crate) targets: Vec<u32>,
    /// For each vertex whether its step continues with the next one.
    pub(crate) continues: Vec<bool>,
    /// The errors after the last step.
    pub(crate) errors: ErrorCodes,
    /// Triangles and groups visited.
    work: u64,
    /// Bytes of the splits in the thesis's packages, without the vertices themselves: the parent
    /// (4), flags and counts (1), a bit for each triangle of the star, and for each new one a
    /// corner and a strip.
    pub(crate) package_bytes: u64,
    /// True if the step of the newest vertex continues with the next one.
    continued: bool,
    /// True if a position of the step is not finite, which no encoder writes.
    pub(crate) has_infinite_position: bool,
    /// The first vertex of the wedges (same step, same position) that end with the newest one.
    first_sibling: u32,
    /// The parent of the next step's first vertex, if the order is exact; else the group that is
    /// likely to be needed next.
    pub(super) next_parent: u32,
    /// The list that batches are walked through; none if the order of steps is exact.
    pub(super) groups: Option<GroupList>,
    pub(super) split: SplitNeighbourhood,
    pub(super) buffers: Buffers,
}

/// Memory that is used again for each split.
#[derive(Clone, Debug, Default)]
pub(super) struct Buffers {
    split: SplitBuffers,
    new_star: Vec<StarFace>,
    new_star_link: Vec<LinkVertex>,
    /// The vertices around the new one.
    new_link: Vec<u32>,
    /// The indices of the newest vertex.
    pub(super) indices: Vec<i32>,
}

impl ObjectCodec {
    pub(crate) fn new(layout: VertexLayout, submeshes: u32, exact: bool) -> Self {
        Self {
            mesh: PartialMesh::default(),
            values: VertexValues::new(layout),
            submeshes,
            large_star: LARGE_STAR,
            points: Points::default(),
            targets: Vec::new(),
            continues: Vec::new(),
            errors: ErrorCodes::default(),
            work: 0,
            package_bytes: 0,
            continued: false,
            has_infinite_position: false,
            first_sibling: 0,
            next_parent: 0,
            groups: (!exact).then(|| GroupList::new(0)),
            split: SplitNeighbourhood::default(),
            buffers: Buffers::default(),
        }
    }

    /// Returns what the object has cost so far.
    pub(crate) fn cost(&self) -> Cost {
        let elements = u64::from(self.mesh.vertex_count()) + u64::from(self.mesh.face_count());
        Cost {
            size: self.values.indices.len() as u64 + 8 * elements,
            work: self.work + self.points.work,
        }
    }

    /// Returns whether no batch has begun of which steps are still to come; always so if the order
    /// is exact.
    pub(crate) fn is_between_batches(&self) -> bool {
        self.groups.as_ref().is_none_or(|groups| groups.steps_remaining == 0)
    }

    /// Codes one step: its vertices, then the errors of the mesh with all of them.
    pub(crate) fn code_step<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
        limits: StepLimits,
    ) -> Result<(), InvalidStream> {
        if self.mesh.vertex_count() == 0 {
            self.announce_points(coder, source, contexts, limits)?;
        }
        if self.mesh.vertex_count() == limits.vertices && !self.points.are_complete() {
            self.code_remaining_points(coder, source, contexts);
            let errors = source.error_codes(limits.vertices - 1);
            self.code_errors(coder, errors, contexts);
            return Ok(());
        }
        if self.groups.is_some() && self.mesh.vertex_count() < limits.vertices {
            self.code_group(coder, source, contexts, limits)?;
        }
        self.reserve(limits);
        loop {
            let new = self.mesh.vertex_count();
            if new >= limits.vertices {
                return Err(InvalidStream("has more vertices than its header says"));
            }
            self.code_vertex(coder, source, contexts, limits.vertices)?;
            self.continues.push(self.continued);
            if !self.cost().is_within_budget(limits.bytes) {
                return Err(InvalidStream("expands more than any real stream"));
            }
            if !self.continued {
                self.points.one_by_one = false;
                if self.is_between_batches() {
                    self.code_errors(coder, source.error_codes(new), contexts);
                }
                return Ok(());
            }
        }
    }

    /// Reserves memory for all vertices and triangles once enough are decoded (see
    /// [`RESERVE_FRACTION`]), so that growing vectors do not end with twice what they need.
    fn reserve(&mut self, limits: StepLimits) {
        let vertices = self.mesh.vertex_count();
        if vertices >= limits.vertices / RESERVE_FRACTION
            && self.continues.capacity() < limits.vertices as usize
        {
            let more = (limits.vertices - vertices) as usize;
            self.mesh.reserve(more);
            self.targets.reserve_exact(more);
            self.continues.reserve_exact(limits.vertices as usize - self.continues.len());
            self.values.indices.reserve_exact(more * self.values.channels());
            if let Some(groups) = &mut self.groups {
                groups.reserve(more);
            }
        }
        let triangles = self.mesh.face_count();
        let faces = &mut self.mesh.faces;
        if triangles >= limits.triangles / RESERVE_FRACTION
            && faces.capacity() < limits.triangles as usize
        {
            faces.reserve_exact((limits.triangles - triangles) as usize);
        }
    }

    /// Gives all vertices values (index 0) after a step that failed, so that the mesh can be read.
    pub(crate) fn complete_values(&mut self) {
        let length = self.mesh.vertex_count() as usize * self.values.channels();
        self.values.indices.resize(length, 0);
    }

    fn code_errors<C: Coder>(&mut self, coder: &mut C, codes: ErrorCodes, contexts: &mut Contexts) {
        let mut code = |last: &mut u32, wanted, falls: &mut _, drop_code: &mut GammaCode| {
            let drop = last.wrapping_sub(wanted);
            if coder.bit(falls, drop != 0) {
                *last = last.wrapping_sub(drop_code.code(coder, drop));
            }
        };
        let Contexts { error_falls, error_drop, rms_falls, rms_drop, .. } = contexts;
        code(&mut self.errors.error, codes.error, error_falls, error_drop);
        code(&mut self.errors.rms, codes.rms, rms_falls, rms_drop);
    }

    fn code_vertex<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
        vertices: u32,
    ) -> Result<(), InvalidStream> {
        let new = self.mesh.vertex_count();
        let continued = self.continued;
        let parent = if continued {
            self.code_wedge_parent(coder, source, contexts, self.split.parent)
        } else {
            self.next_parent
        };
        if self.points.is_missing(parent) {
            self.code_points(coder, source, contexts, parent);
        }
        self.targets.push(parent);
        let submesh = self.code_submesh(coder, source, contexts, parent);
        self.mesh.add_vertex(submesh);
        let number = if continued { self.number_in_step() } else { 0 };
        let context = &mut contexts.continues[number][self.further_wedges(parent)];
        self.continued = coder.bit(context, source.continues(new));
        if self.groups.is_none() && !self.continued && new + 1 < vertices {
            // Coded this early so that a decoder can prefetch the next parent's corners.
            let wanted = source.parent(new + 1);
            let distance = ParentDistance { from: parent, vertices: new + 1 };
            self.next_parent = distance.code(coder, contexts, wanted);
            self.mesh.prefetch_corners(self.next_parent);
        }

        self.split.start(new, parent, continued);
        let (face_list, large) = (&mut contexts.face_list, self.large_star);
        self.split.code_star(coder, source, face_list, &self.mesh, large)?;
        self.work += 2 + self.split.star.len() as u64;
        self.package_bytes += 5 + self.split.star.len().div_ceil(8) as u64;
        let pattern = self.code_triangles(coder, source, contexts)?;
        let keeps_all = self.split_mesh(coder, source, contexts, pattern)?;
        // An encoder only uses a sibling as parent to keep away from a large star.
        let target = self.targets[parent as usize];
        if keeps_all && self.mesh.corners.count(target) > large {
            let repeats = source.repeats_target(new);
            if coder.bit(&mut contexts.repeats_target, repeats) {
                self.targets[new as usize] = target;
            }
        }
        self.code_values(coder, source, contexts);
        Ok(())
    }

    /// Returns how many vertices of the step came before the newest one, up to 3.
    fn number_in_step(&self) -> usize {
        self.continues.iter().rev().take(3).take_while(|&&continues| continues).count()
    }

    /// Returns how many further wedges are in the circle of a vertex, up to 3.
    fn further_wedges(&self, vertex: u32) -> usize {
        let next = |v: u32| self.mesh.next_wedge[v as usize];
        let others = std::iter::successors(Some(next(vertex)), |&v| Some(next(v)));
        others.take(3).take_while(|&v| v != vertex).count()
    }

    /// Codes the group that the next step splits off, and its parent.
    fn code_group<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
        limits: StepLimits,
    ) -> Result<(), InvalidStream> {
        let Some(groups) = &mut self.groups else { return Ok(()) };
        let new = self.mesh.vertex_count();
        if groups.steps_remaining == 0 {
            let more = contexts.batches.steps.code(coder, source.batch_steps(new).wrapping_sub(1));
            groups.begin(more.saturating_add(1));
        }
        let wanted = source.group(source.parent(new));
        loop {
            self.work += 1;
            if groups.group == NONE {
                return Err(InvalidStream("has a batch of more steps than there are"));
            }
            // Points whose group is known are no groups of their own.
            let is_group = !self.points.is_further_wedge(groups.group);
            let triangles = self.mesh.corners.count(groups.group);
            let context = groups.context(&mut contexts.batches, triangles);
            if is_group && coder.bit(context, groups.group == wanted) {
                break;
            }
            groups.advance();
            let cost = Cost { size: 0, work: self.work };
            if !cost.is_within_budget(limits.bytes) {
                return Err(InvalidStream("expands more than any real stream"));
            }
        }
        groups.count_split();
        let group = groups.group;
        let following = groups.following();
        if self.points.is_missing(group) {
            self.code_points(coder, source, contexts, group);
        }
        self.next_parent = group;
        if self.mesh.next_wedge[group as usize] != group {
            self.next_parent = self.code_wedge_parent(coder, source, contexts, group);
        }
        self.mesh.prefetch_corners(following.unwrap_or(group));
        Ok(())
    }

    /// Codes the parent of a vertex: mostly a few wedges from `from` along its circle.
    fn code_wedge_parent<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
        from: u32,
    ) -> u32 {
        let vertices = self.mesh.vertex_count();
        let wanted = source.parent(vertices);
        let next = |v: u32| self.mesh.next_wedge[v as usize];
        let (mut distance, mut v) = (0, from);
        while distance < FAR_WEDGE && v != wanted {
            v = next(v);
            distance = if v == from { FAR_WEDGE } else { distance + 1 };
        }
        let is_first = usize::from(!self.continued);
        let distance = coder.symbol(&mut contexts.wedge_distance[is_first], distance);
        if distance < FAR_WEDGE {
            return (0..distance).fold(from, |v, _| next(v));
        }
        ParentDistance { from, vertices }.code(coder, contexts, wanted)
    }

    fn code_submesh<C: Coder, S: SplitSource>(
        &self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
        parent: u32,
    ) -> u32 {
        let parent_submesh = self.mesh.submesh[parent as usize];
        if self.submeshes == 1 {
            return parent_submesh;
        }
        let wanted = source.submesh(self.mesh.vertex_count());
        if coder.bit(&mut contexts.same_submesh, wanted == parent_submesh) {
            parent_submesh
        } else {
            coder.uniform(self.submeshes, wanted)
        }
    }

    fn code_triangles<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
    ) -> Result<SplitPattern, InvalidStream> {
        let mut code = TriangleCode {
            coder: &mut *coder,
            contexts: &mut contexts.triangles,
            split: &mut self.split,
            package_bytes: 0,
        };
        let pattern = code.code(source)?;
        self.package_bytes += code.package_bytes;
        if pattern == SplitPattern::General {
            self.code_corner_points(coder, source, contexts);
        }
        if self.submeshes > 1 {
            self.split.check_submeshes(&self.mesh.submesh)?;
        }
        Ok(pattern)
    }

    /// Codes the transfer of triangles, splits the mesh, and collects the new vertex's link.
    /// Returns whether the parent keeps all its triangles.
    fn split_mesh<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
        pattern: SplitPattern,
    ) -> Result<bool, InvalidStream> {
        let (split, buffers) = (&mut self.split, &mut self.buffers);
        let edge = SplitEdge { parent: split.parent, new: split.new };
        let may_be_arcs = pattern == SplitPattern::Both && !split.is_named;
        let arcs = if may_be_arcs { split.arcs() } else { None };
        let link = &mut buffers.new_link;
        let mut keeps_all = false;
        if !arcs.is_some_and(|arcs| self.mesh.split_arcs(edge, &split.star, arcs, link)) {
            let rule = if split.is_named { TransferRule::All } else { pattern.transfer_rule() };
            split.code_transfer(coder, source, &mut contexts.transfer, rule)?;
            keeps_all = !split.transfer.contains(&true);
            let (faces, transfer) = (&split.star[..], &split.transfer[..]);
            let star = ParentStar { faces, transfer, is_part: split.is_named };
            let new_star = &mut buffers.new_star;
            self.mesh.split(edge, star, &split.triangles, &mut buffers.split, new_star);
            collect_link(new_star, &mut buffers.new_star_link);
            link.clear();
            link.extend(buffers.new_star_link.iter().map(|l| l.vertex));
        }
        // Inserting corners passes over a corner list, or over a block of a long one.
        let list_work = |v: u32| u64::from(self.mesh.corners.count(v).min(LARGE_STAR));
        let longest = split.triangles.iter().map(|t| list_work(t.next).max(list_work(t.previous)));
        self.work += longest.sum::<u64>();
        Ok(keeps_all)
    }

    /// Codes whether the new vertex is a wedge of the one before, and its values.
    fn code_values<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
    ) {
        let SplitNeighbourhood { new, parent, continued, .. } = self.split;
        let position = |v: u32| source.indices(v).get(..3);
        let wedge = continued.then(|| new - 1).filter(|&previous| {
            coder.bit(&mut contexts.same_position, position(previous) == position(new))
        });
        if let Some(previous) = wedge {
            self.mesh.add_wedge(new, previous);
        }
        if let Some(groups) = &mut self.groups {
            groups.add_vertex(wedge.is_none());
        }
        let channels = self.values.channels();
        let indices = &self.values.indices;
        let first_index = |v: u32| indices.get(v as usize * channels).copied().unwrap_or_default();
        self.mesh.prefetch_link(self.next_parent, first_index);
        if wedge.is_none() {
            self.first_sibling = new;
        }
        let apex = |side: Side, apex_of: fn(&NewTriangle) -> u32| {
            self.split.triangles.iter().find(|t| t.side == side).map_or(parent, apex_of)
        };
        let neighbourhood = Neighbourhood {
            parent,
            siblings: self.first_sibling..new,
            link: &self.buffers.new_link,
            apexes: [apex(Side::Left, |t| t.next), apex(Side::Right, |t| t.previous)],
        };
        let wanted = if C::ENCODES { source.indices(new) } else { &[] };
        let coded = &mut self.buffers.indices;
        self.values.code(coder, &mut contexts.values, &neighbourhood, wanted, coded);
        if !C::ENCODES {
            self.check_position();
        }
        self.values.indices.extend_from_slice(&self.buffers.indices);
    }

    /// Replaces a position that was just decoded by index 0 if it is not finite, and marks the step
    /// as failed: the mesh stays readable.
    pub(super) fn check_position(&mut self) {
        let mut channels = self.values.layout.systems.iter().zip(&mut self.buffers.indices).take(3);
        if channels.any(|(system, index)| !system.value(*index).is_finite()) {
            self.buffers.indices[..3].fill(0);
            self.has_infinite_position = true;
        }
    }
}
