//! Follows every triangle through every record, in time proportional to how often live corners
//! move: the reference that models are compared with. [`Tracker::apply_step`] is called for each
//! step in order, then [`Tracker::finish`], which says what was wrong: counts of triangles,
//! submeshes, triangles that came back, and tears. Nothing is torn as long as the border of the
//! live triangles is LOD 0's border moved by the records; so that is followed, too.
//!
//! Each vertex has the list of the corners (of live triangles, and of LOD 0's border edges) that
//! have become it; a record hands the list on. Dead triangles are not moved any more: [`Ties`]
//! tells if their corners ever part, and only then everything is computed anew. (Otherwise meshes
//! of many pieces would be quadratic: in the end the dead triangles of all pieces hang on one
//! vertex, which moves once for every piece.)

use crate::boundary::{boundary, edge_value, edges, first_nonzero};
use crate::check::Check;
use crate::difference::Failure;
use crate::ties::Ties;
use lodc_mesh::{
    Lod, NONE, OrientedTriangle, PositionIds, Simplified, TriangleHash, is_degenerate,
};

/// A sequence moves the corners of live triangles far more often than that of a real mesh, which
/// moves each about ten times. To follow it would take very long.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("up to LOD {} corners move more often than can be verified", lod.0)]
pub struct TooMuchWork {
    /// The LOD at which it became too much.
    pub lod: Lod,
}

/// Largest number of moves per corner, and corners that are added to those of small meshes. Chosen
/// by hand: real meshes move each corner about ten times.
const MAX_MOVES: u64 = 200;
const ADDED_CORNERS: u64 = 10_000;
/// Moves that a restart counts for, for each corner and vertex. Chosen by hand.
const MOVES_PER_RESTART: u64 = 4;

/// The live triangles and the border as they are after some steps.
pub(super) struct Tracker<'a> {
    simplified: &'a Simplified,
    positions: PositionIds,
    ties: Ties,
    /// True until something comes apart: so long the vertices of a step are taken for one group.
    one_group: bool,
    /// The corners of each triangle; of a dead one those that it had when it died, or at the last
    /// restart.
    corners: Vec<[u32; 3]>,
    /// The step in which each triangle died; `NONE` of live ones.
    removal_step: Vec<u32>,
    /// The border edges of LOD 0, as [`boundary`] returns them.
    input_border: Vec<[u32; 2]>,
    /// The same edges moved by the steps so far.
    moved_border: Vec<[u32; 2]>,
    /// How often each border edge counts: 0 once it has no length or was added to another one.
    weight: Vec<i64>,
    /// The step in which each triangle, then each border edge, was last touched.
    touched_in: Vec<u32>,
    /// First and last corner of each vertex's list, and the corner after each. Corners are
    /// numbered: three for each triangle, then two for each border edge.
    first: Vec<u32>,
    last: Vec<u32>,
    next: Vec<u32>,
    /// The hash of the live triangles.
    hash: TriangleHash,
    /// Number of live triangles.
    live: u32,
    /// The value (`edge_value`) of the boundary of the live triangles minus that of `moved_border`.
    /// Zero means no tear. While a step is applied, touched triangles are subtracted and touched
    /// border edges added; `settle` puts them back.
    tear: u64,
    /// Number of corners that were moved.
    moves: u64,
    /// The triangles and edges touched in the current step.
    triangles_touched: Vec<u32>,
    border_touched: Vec<u32>,
    /// For sorting touched border edges: empty in between, kept to save allocating.
    edges_between: Vec<([u32; 2], usize)>,
    failures: Failures,
}

/// The first failure of each kind.
#[derive(Default)]
struct Failures {
    count: Option<Failure>,
    returned: Option<Failure>,
    submesh: Option<Failure>,
    torn: Option<Failure>,
}

impl<'a> Tracker<'a> {
    pub(super) fn new(simplified: &'a Simplified) -> Self {
        let positions = simplified.mesh().position_ids();
        let border = boundary(simplified.mesh(), &positions);
        let (triangles, vertices) =
            (simplified.mesh().triangles().len(), simplified.mesh().vertex_count());
        let mut tracker = Self {
            ties: Ties::new(&[], 0, &positions),
            one_group: true,
            corners: simplified.mesh().triangles().to_vec(),
            removal_step: vec![NONE; triangles],
            weight: vec![1; border.len()],
            touched_in: vec![NONE; triangles + border.len()],
            first: vec![NONE; vertices],
            last: vec![NONE; vertices],
            next: vec![NONE; 3 * triangles + 2 * border.len()],
            hash: simplified.triangles_at_with(Lod(0), &positions).into_iter().collect(),
            live: triangles as u32,
            tear: 0,
            moves: 0,
            triangles_touched: Vec::new(),
            border_touched: Vec::new(),
            edges_between: Vec::new(),
            failures: Failures::default(),
            simplified,
            positions,
            moved_border: border.clone(),
            input_border: border,
        };
        tracker.list_corners();
        tracker
    }

    pub(super) fn hash(&self) -> TriangleHash {
        self.hash
    }

    pub(super) fn positions(&self) -> &PositionIds {
        &self.positions
    }

    /// Applies the records of one step.
    pub(super) fn apply_step(&mut self, step: usize) -> Result<(), TooMuchWork> {
        let (targets, ends) =
            (self.simplified.collapses().targets(), &self.simplified.collapses().parts().step_ends);
        let (start, end) = (if step == 0 { 0 } else { ends[step - 1] }, ends[step]);
        if self.ties.step(targets, start..end, self.one_group) {
            for record in start..end {
                self.apply_record(record, targets[record as usize], step as u32);
            }
            self.settle(step as u32, Lod(end));
        } else {
            // Something has come apart.
            self.restart(step as u32, Lod(end));
        }
        if self.moves > MAX_MOVES * (self.next.len() as u64 + ADDED_CORNERS) {
            return Err(TooMuchWork { lod: Lod(end) });
        }
        let stored = self.simplified.collapses().step(step).triangles;
        if stored != self.live && self.failures.count.is_none() {
            self.failures.count =
                Some(Failure::TriangleCount { lod: Lod(end), stored, counted: self.live });
        }
        if self.tear != 0 && self.failures.torn.is_none() {
            self.failures.torn = self.find_tear(Lod(end));
        }
        Ok(())
    }

    /// Hands the corners of a record's vertex on to its target, but for those of dead triangles and
    /// edges.
    fn apply_record(&mut self, record: u32, target: u32, step: u32) {
        let triangles = self.corners.len();
        let mut corner = self.first[record as usize];
        while corner != NONE {
            let following = self.next[corner as usize];
            self.moves += 1;
            if corner as usize >= 3 * triangles {
                let offset = corner as usize - 3 * triangles;
                let (edge, corner_index) = (offset / 2, offset % 2);
                if self.weight[edge] != 0 {
                    if self.touched_in[triangles + edge] != step {
                        self.touched_in[triangles + edge] = step;
                        self.border_touched.push(edge as u32);
                        self.tear = self.tear.wrapping_add(self.border_value(edge));
                    }
                    self.moved_border[edge][corner_index] = target;
                    self.append(target, corner);
                }
            } else {
                let (triangle, corner_index) = (corner as usize / 3, corner as usize % 3);
                if self.removal_step[triangle] == NONE {
                    if self.touched_in[triangle] != step {
                        self.touched_in[triangle] = step;
                        self.triangles_touched.push(triangle as u32);
                        self.hash.remove(self.oriented(triangle));
                        self.tear = self.tear.wrapping_sub(self.edge_sum(triangle));
                    }
                    self.corners[triangle][corner_index] = target;
                    self.append(target, corner);
                }
            }
            corner = following;
        }
    }

    /// Puts a corner at the end of a vertex's list.
    fn append(&mut self, vertex: u32, corner: u32) {
        match std::mem::replace(&mut self.last[vertex as usize], corner) {
            NONE => self.first[vertex as usize] = corner,
            end => self.next[end as usize] = corner,
        }
        self.next[corner as usize] = NONE;
    }

    /// Lists the corners of all live triangles and border edges.
    fn list_corners(&mut self) {
        self.first.fill(NONE);
        self.last.fill(NONE);
        let triangles = self.corners.len();
        for triangle in 0..triangles {
            if self.removal_step[triangle] == NONE {
                (0..3).for_each(|corner_index| {
                    self.append(
                        self.corners[triangle][corner_index],
                        (3 * triangle + corner_index) as u32,
                    );
                });
            }
        }
        for edge in 0..self.moved_border.len() {
            if self.weight[edge] != 0 {
                let first = 3 * triangles + 2 * edge;
                (0..2).for_each(|corner_index| {
                    self.append(
                        self.moved_border[edge][corner_index],
                        (first + corner_index) as u32,
                    );
                });
            }
        }
    }

    /// Adds the triangles and edges that were touched to the sums again, unless they have died.
    fn settle(&mut self, step: u32, lod: Lod) {
        let mut touched = std::mem::take(&mut self.triangles_touched);
        for triangle in touched.drain(..) {
            self.settle_triangle(triangle as usize, step, lod);
        }
        self.triangles_touched = touched;
        let mut touched = std::mem::take(&mut self.border_touched);
        self.settle_border(&mut touched);
        touched.clear();
        self.border_touched = touched;
    }

    /// Removes a triangle if it is degenerate, else adds it to the sums. It is live as far as is
    /// known, and in none of the sums.
    fn settle_triangle(&mut self, triangle: usize, step: u32, lod: Lod) {
        let corners = self.corners[triangle];
        let [a, b, c] = corners;
        let [p, q, r] = self.positions_of(corners);
        if is_degenerate([p, q, r]) {
            self.live -= 1;
            self.removal_step[triangle] = step;
            // Two corners that are one vertex never come apart.
            let stays_degenerate = is_degenerate(corners);
            if !stays_degenerate {
                let (a, b) = if p == q {
                    (a, b)
                } else if q == r {
                    (b, c)
                } else {
                    (c, a)
                };
                self.ties.tie(a, b);
            }
            return;
        }
        let submesh = self.simplified.mesh().vertex_submesh();
        let expected = self.submesh(triangle);
        if corners.iter().any(|&v| submesh[v as usize] != expected) {
            self.failures
                .submesh
                .get_or_insert(Failure::Submesh { lod, triangle: triangle as u32 });
        }
        self.hash.add(self.oriented(triangle));
        self.tear = self.tear.wrapping_add(self.edge_sum(triangle));
    }

    /// Adds border edges that have become the same, up to direction, to one of them: dead pieces
    /// then have no boundary left that would have to be moved. The `touched` edges are in none of
    /// the sums.
    fn settle_border(&mut self, touched: &mut Vec<u32>) {
        touched.retain(|&edge| {
            let [a, b] = self.moved_border[edge as usize];
            let flat = self.positions.of_vertex[a as usize] == self.positions.of_vertex[b as usize];
            if flat {
                self.ties.tie(a, b);
                self.weight[edge as usize] = 0;
            }
            !flat
        });
        let mut edges = std::mem::take(&mut self.edges_between);
        edges.extend(touched.iter().map(|&edge| {
            let [a, b] = self.moved_border[edge as usize].map(|v| self.ties.set(v));
            ([a.min(b), a.max(b)], edge as usize)
        }));
        edges.sort_unstable();
        for run in edges.chunk_by(|x, y| x.0 == y.0) {
            let representative = run[0].1;
            let head = self.ties.set(self.moved_border[representative][0]);
            for &(_, merged) in &run[1..] {
                let weight = std::mem::take(&mut self.weight[merged]);
                let same_direction = self.ties.set(self.moved_border[merged][0]) == head;
                self.weight[representative] += if same_direction { weight } else { -weight };
            }
            self.tear = self.tear.wrapping_sub(self.border_value(representative));
        }
        edges.clear();
        self.edges_between = edges;
    }

    /// Computes everything anew from LOD 0, without assuming that steps move one group.
    fn restart(&mut self, step: u32, lod: Lod) {
        let collapses = self.simplified.collapses();
        let map = collapses.resolve_all(lod);
        // Sequences with thousands of wrong records come here a few times; on one that is crafted
        // to come here often, verification gives up.
        self.moves += MOVES_PER_RESTART * (self.next.len() as u64 + map.len() as u64);
        self.one_group = false;
        self.ties = Ties::new(collapses.targets(), lod.0, &self.positions);
        (self.hash, self.live, self.tear) = (TriangleHash::default(), self.corners.len() as u32, 0);
        for triangle in 0..self.corners.len() {
            self.corners[triangle] =
                self.simplified.mesh().triangles()[triangle].map(|v| map[v as usize]);
            let removed_at = std::mem::replace(&mut self.removal_step[triangle], NONE);
            self.settle_triangle(triangle, step, lod);
            if removed_at == NONE {
                continue;
            }
            if self.removal_step[triangle] == NONE {
                self.failures
                    .returned
                    .get_or_insert(Failure::Returned { lod, triangle: triangle as u32 });
            } else {
                self.removal_step[triangle] = removed_at;
            }
        }
        self.moved_border = self.input_border.iter().map(|e| e.map(|v| map[v as usize])).collect();
        self.weight.fill(1);
        self.settle_border(&mut (0..self.moved_border.len() as u32).collect());
        self.list_corners();
    }

    fn positions_of<const N: usize>(&self, vertices: [u32; N]) -> [u32; N] {
        vertices.map(|v| self.positions.of_vertex[v as usize])
    }

    fn submesh(&self, triangle: usize) -> u32 {
        self.simplified.mesh().vertex_submesh()
            [self.simplified.mesh().triangles()[triangle][0] as usize]
    }

    fn oriented(&self, triangle: usize) -> OrientedTriangle {
        OrientedTriangle::new(self.submesh(triangle), self.corners[triangle])
    }

    /// The value of a triangle's edges.
    fn edge_sum(&self, triangle: usize) -> u64 {
        edges(self.positions_of(self.corners[triangle]))
            .into_iter()
            .map(edge_value)
            .fold(0, u64::wrapping_add)
    }

    /// The part of a border edge in the value of `moved_border`.
    fn border_value(&self, edge: usize) -> u64 {
        edge_value(self.positions_of(self.moved_border[edge]))
            .wrapping_mul(self.weight[edge] as u64)
    }

    /// Computes the boundary in full to name an edge.
    fn find_tear(&self, lod: Lod) -> Option<Failure> {
        let live = (0..self.corners.len()).filter(|&t| self.removal_step[t] == NONE);
        let shown = live.flat_map(|t| edges(self.positions_of(self.corners[t]))).map(|e| (e, 1));
        let map = self.simplified.collapses().resolve_all(lod);
        let image =
            self.input_border.iter().map(|e| (self.positions_of(e.map(|v| map[v as usize])), -1));
        let (edge, surplus) = first_nonzero(shown.chain(image))?;
        let point = |p: u32| {
            self.simplified.mesh().positions()[self.positions.first_vertex[p as usize] as usize]
        };
        Some(Failure::Torn { lod, edge: edge.map(point), surplus })
    }

    /// The first triangle that comes after one of its submesh that died before it.
    fn out_of_order(&self) -> Option<Failure> {
        self.simplified.mesh().submeshes().iter().find_map(|s| {
            let i =
                self.removal_step[s.triangles()].windows(2).position(|pair| pair[0] < pair[1])?;
            Some(Failure::TriangleOrder { triangle: s.first_triangle + i as u32 + 1 })
        })
    }

    /// Returns the checks that were made on the way.
    pub(super) fn finish(self) -> Vec<Check> {
        let lods = self.simplified.collapses().steps() as u64 + 1;
        let order = self.out_of_order();
        // Sums were compared, no whole meshes.
        let check = |name, failure| Check { model: "sequence", name, lods, full: 0, failure };
        vec![
            check("stored triangle counts", self.failures.count),
            check("no tear", self.failures.torn),
            check("no triangle returns", self.failures.returned),
            check("corners stay in their submesh", self.failures.submesh),
            check("order of triangles", order),
        ]
    }
}
