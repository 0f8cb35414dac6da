//! Coding of points: first their number, later the wedge group, parent, submesh and values of each,
//! when a split needs it (docs/STREAM.md, section 4).

use crate::entropy::coder::Coder;
use crate::error_code::ErrorCodes;
use crate::invalid::InvalidStream;
use crate::source::split_source::SplitSource;
use crate::vertex_data::vertex_values::Neighbourhood;
use crate::vertex_split::budget::Cost;
use crate::vertex_split::contexts::Contexts;
use crate::vertex_split::group_list::GroupList;
use crate::vertex_split::object_codec::{ObjectCodec, StepLimits};
use crate::vertex_split::parent_distance::ParentDistance;
use crate::vertex_split::point_contexts::PointContexts;
use crate::vertex_split::points::Points;
use std::ops::Range;

impl ObjectCodec {
    /// Codes the values of a vertex without a reference into the buffer of indices.
    fn code_absolute<C: Coder>(&mut self, coder: &mut C, wanted: &[i32], contexts: &mut Contexts) {
        self.buffers.indices.clear();
        for channel in 0..self.values.channels() {
            let wanted = wanted.get(channel).copied().unwrap_or_default();
            let index = contexts.first_index.code(coder, fold(wanted));
            self.buffers.indices.push(unfold(index));
        }
    }

    /// Codes the number of points and, in the exact order, the parent of the first vertex behind
    /// them.
    pub(super) fn announce_points<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
        limits: StepLimits,
    ) -> Result<(), InvalidStream> {
        let wanted = source.points().wrapping_sub(1);
        let count = contexts.points.count.code(coder, wanted).saturating_add(1);
        if count > limits.vertices {
            return Err(InvalidStream("has more vertices than its header says"));
        }
        let size = u64::from(count) * (self.values.channels() as u64 + 8);
        if !(Cost { size, work: 0 }).is_within_budget(limits.bytes) {
            return Err(InvalidStream("expands more than any real stream"));
        }
        for _ in 0..count {
            self.mesh.add_vertex(0);
        }
        self.errors = ErrorCodes::UNKNOWN;
        self.points = Points::new(count);
        self.targets.resize(count as usize, 0);
        self.continues.resize(count as usize, false);
        self.complete_values();
        if let Some(groups) = &mut self.groups {
            *groups = GroupList::new(count);
        } else if count < limits.vertices {
            let distance = ParentDistance { from: 0, vertices: count };
            self.next_parent = distance.code(coder, contexts, source.parent(count));
        }
        Ok(())
    }

    /// Codes the group of the first point that has not come, as a step after the last vertex.
    pub(super) fn code_remaining_points<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
    ) {
        self.points.one_by_one = false;
        let point = self.points.first_missing();
        self.code_points(coder, source, contexts, point);
    }

    /// Codes the points that the new triangles need, in the order of their corners.
    pub(super) fn code_corner_points<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
    ) {
        if self.points.are_complete() {
            return;
        }
        for i in 0..self.split.triangles.len() {
            let triangle = &self.split.triangles[i];
            for corner in [triangle.next, triangle.previous] {
                if self.points.is_missing(corner) {
                    self.code_points(coder, source, contexts, corner);
                }
            }
        }
    }

    /// Codes a point that is missing. After the first step all missing points of its group come
    /// too.
    pub(super) fn code_points<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
        point: u32,
    ) {
        if self.points.has_unknown_group(point) {
            self.code_point_group(coder, source, &mut contexts.points, point);
        }
        let group = self.points.group(point);
        for point in if self.points.one_by_one { point..point + 1 } else { group } {
            if self.points.is_missing(point) {
                self.code_point(coder, source, contexts, point);
            }
        }
    }

    fn code_point<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut Contexts,
        point: u32,
    ) {
        let wedge = self.points.last_wedge(&self.points.group(point));
        let parent = self.code_point_parent(coder, source, &mut contexts.points, point, wedge);
        self.targets[point as usize] = parent;
        let reference = self.reference(point, wedge);
        self.mesh.submesh[point as usize] =
            self.code_point_submesh(coder, source.submesh(point), contexts, reference);
        let wanted = if C::ENCODES { source.indices(point) } else { &[] };
        match reference {
            None => self.code_absolute(coder, wanted, contexts),
            Some(parent) => {
                let siblings = wedge.map_or(0..0, |wedge| wedge..wedge + 1);
                let neighbourhood =
                    Neighbourhood { parent, siblings, link: &[], apexes: [parent; 2] };
                let (values, coded) = (&mut contexts.points.values, &mut self.buffers.indices);
                self.values.code(coder, values, &neighbourhood, wanted, coded);
            }
        }
        if !C::ENCODES {
            self.check_position();
        }
        let channels = self.values.channels();
        self.values.indices[point as usize * channels..][..channels]
            .copy_from_slice(&self.buffers.indices);
        self.points.mark_received(point, parent);
    }

    /// Codes the wedge group of a point: the consecutive points around it of its step and position.
    /// Then whether the step of the point before them continues with them.
    fn code_point_group<C: Coder, S: SplitSource>(
        &mut self,
        coder: &mut C,
        source: &S,
        contexts: &mut PointContexts,
        point: u32,
    ) {
        let position = |v: u32| source.indices(v).get(..3);
        let is_wedge = |v: u32| source.continues(v - 1) && position(v - 1) == position(v);
        let [mut first, mut end] = [point, point + 1];
        while first > 0
            && self.points.has_unknown_group(first - 1)
            && coder.bit(&mut contexts.wedge[0], is_wedge(first))
        {
            first -= 1;
        }
        while self.points.has_unknown_group(end) && coder.bit(&mut contexts.wedge[1], is_wedge(end))
        {
            end += 1;
        }
        if first > 0 {
            let wanted = source.continues(first - 1);
            self.continues[first as usize - 1] = coder.bit(&mut contexts.continues, wanted);
        }
        self.points.set_group(first..end);
        for point in first + 1..end {
            self.continues[point as usize - 1] = true;
            self.mesh.add_wedge(point, point - 1);
        }
    }

    /// Codes the parent of a point, given the wedge of its group that came last: mostly the first
    /// vertex of all, or a point of the group that came last of all.
    fn code_point_parent<C: Coder, S: SplitSource>(
        &self,
        coder: &mut C,
        source: &S,
        contexts: &mut PointContexts,
        point: u32,
        wedge: Option<u32>,
    ) -> u32 {
        if point == 0 {
            return 0;
        }
        let wanted = source.parent(point);
        if let Some(wedge) = wedge {
            let from = self.targets[wedge as usize].min(point - 1);
            let to_end = point - from;
            let distance = if wanted >= from { wanted - from } else { wanted + to_end };
            let distance = contexts.next_parent.code(coder, distance) % point;
            return if distance >= to_end { distance - to_end } else { from + distance };
        }
        let Range { start, end } = self.points.last_group();
        let end = end.min(point);
        if start < end && coder.bit(&mut contexts.in_last, (start..end).contains(&wanted)) {
            return start + coder.uniform(end - start, wanted.wrapping_sub(start));
        }
        contexts.parent.code(coder, wanted) % point
    }

    /// Returns the vertex from which a point is predicted. The first of these that exists: the
    /// wedge of its group that came last, if it has the same parent; a point that splits off this
    /// one; its parent, if it has come; that wedge with any parent; the point that came last of
    /// all. None for the first point of all.
    fn reference(&self, point: u32, wedge: Option<u32>) -> Option<u32> {
        let parent = self.targets[point as usize];
        let same_parent = |wedge: &u32| self.targets[*wedge as usize] == parent;
        wedge
            .filter(same_parent)
            .or(self.points.child(point))
            .or((!self.points.is_missing(parent)).then_some(parent))
            .or(wedge)
            .or(self.points.last())
    }

    fn code_point_submesh<C: Coder>(
        &self,
        coder: &mut C,
        wanted: u32,
        contexts: &mut Contexts,
        reference: Option<u32>,
    ) -> u32 {
        if self.submeshes == 1 {
            return 0;
        }
        match reference.map(|r| self.mesh.submesh[r as usize]) {
            Some(s) if coder.bit(&mut contexts.points.same_submesh, wanted == s) => s,
            _ => coder.uniform(self.submeshes, wanted),
        }
    }
}

/// Returns a number that is small where the index is near 0: 0, −1, 1, −2, … become 0, 1, 2, 3, …
fn fold(index: i32) -> u32 {
    (index << 1 ^ index >> 31) as u32
}

/// The inverse of [`fold`].
fn unfold(folded: u32) -> i32 {
    (folded >> 1) as i32 ^ -((folded & 1) as i32)
}
