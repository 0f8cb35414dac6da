//! Points: the vertices before the first triangle. At first only their number is coded; the parent
//! and values of a point come with the first split that needs it.
//!
//! The coarsest levels of a mesh of many components have a point for each. If the values of all
//! came first, a long prefix of the stream would show nothing.
//!
//! ```text
//! points announced   0  1  2  3  4  5  6
//! vertex 7 splits off 4 with triangle (7, 4, 2)      4 comes, then 2
//! vertex 8 splits off 7                              no point comes
//! vertex 9 splits off 5, a wedge of 6                5 and 6 come
//! after the last vertex, a step for each group       0 comes, then 1, then 3
//! ```

use lodc_mesh::NONE;
use std::ops::Range;

/// A point of an object.
#[derive(Clone, Debug)]
struct Point {
    is_missing: bool,
    /// The last point that came with this one, still missing, as its parent; or [`NONE`].
    child: u32,
    /// The points of its wedge group; empty while they are not known.
    group: Range<u32>,
    /// Of the first point of a group: the point of it that came last, or [`NONE`].
    last_wedge: u32,
}

/// The points of an object: those that have come, and those of which only the number is known.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    points: Vec<Point>,
    /// Number of points that are missing.
    missing: u32,
    /// True in the first step, which is to show a triangle as early as possible: points come
    /// without the others of their group.
    pub(super) one_by_one: bool,
    /// The point that came last, or [`NONE`].
    last: u32,
    /// All points before it have come.
    first_missing: u32,
    /// Work of the points that have come, see `ObjectCodec::work`.
    pub(super) work: u64,
    /// Bytes of the points that have come, see `ObjectCodec::package_bytes`.
    pub(crate) package_bytes: u64,
}

impl Points {
    pub(super) fn new(count: u32) -> Self {
        let point = Point { is_missing: true, child: NONE, group: 0..0, last_wedge: NONE };
        Self {
            points: vec![point; count as usize],
            missing: count,
            one_by_one: true,
            last: NONE,
            first_missing: 0,
            work: 0,
            package_bytes: 0,
        }
    }

    /// Returns whether a vertex is a point that has not come yet.
    #[inline]
    pub(crate) fn is_missing(&self, vertex: u32) -> bool {
        self.missing > 0 && self.points.get(vertex as usize).is_some_and(|point| point.is_missing)
    }

    /// Returns whether all points have come.
    pub(crate) fn are_complete(&self) -> bool {
        self.missing == 0
    }

    /// Returns the first point that has not come; there must be one.
    pub(super) fn first_missing(&mut self) -> u32 {
        while !self.is_missing(self.first_missing) {
            self.first_missing += 1;
        }
        self.first_missing
    }

    /// Returns the group of a point; empty while it is not known.
    pub(super) fn group(&self, point: u32) -> Range<u32> {
        self.points.get(point as usize).map_or(0..0, |point| point.group.clone())
    }

    /// Returns whether a vertex is a point of a group that is known, and not its first.
    #[inline]
    pub(super) fn is_further_wedge(&self, vertex: u32) -> bool {
        let point = self.points.get(vertex as usize);
        point.is_some_and(|point| point.group.start < vertex && !point.group.is_empty())
    }

    /// Returns whether a vertex is a point whose group is not known yet.
    pub(super) fn has_unknown_group(&self, vertex: u32) -> bool {
        self.points.get(vertex as usize).is_some_and(|point| point.group.is_empty())
    }

    /// Returns the point of a group that came last; none if none of it has come.
    pub(super) fn last_wedge(&self, group: &Range<u32>) -> Option<u32> {
        Some(self.points[group.start as usize].last_wedge).filter(|&wedge| wedge != NONE)
    }

    /// Returns the last point that came with a missing one as its parent, if there is one.
    pub(super) fn child(&self, point: u32) -> Option<u32> {
        Some(self.points[point as usize].child).filter(|&child| child != NONE)
    }

    /// Returns the point that came last of all.
    pub(super) fn last(&self) -> Option<u32> {
        Some(self.last).filter(|&last| last != NONE)
    }

    /// Returns the group of that point; empty before the first one.
    pub(super) fn last_group(&self) -> Range<u32> {
        self.group(self.last)
    }

    /// Records that these points are a group.
    pub(super) fn set_group(&mut self, group: Range<u32>) {
        self.work += u64::from(group.end - group.start);
        for point in group.clone() {
            self.points[point as usize].group = group.clone();
        }
    }

    /// Records that a point with this parent has come.
    pub(super) fn mark_received(&mut self, point: u32, parent: u32) {
        self.points[point as usize].is_missing = false;
        let first = self.points[point as usize].group.start;
        self.points[first as usize].last_wedge = point;
        self.last = point;
        self.missing -= 1;
        self.work += 2;
        // The parent's number (4) and flags (1); the first vertex has no parent.
        self.package_bytes += if point > 0 { 5 } else { 0 };
        if self.is_missing(parent) {
            self.points[parent as usize].child = point;
        }
    }
}
