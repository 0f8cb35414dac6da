//! The reference, kept incrementally: every triangle is followed through every record by itself.
//!
//! Shares no code with any model. Each vertex has the list of the corners (of triangles, and of LOD 0's boundary edges)
//! that have become it; a record hands the list on. A triangle is followed until two of its corners are the same vertex,
//! not only until it is dead, so that one that returned would be seen.

use super::boundary::{boundary, edges, first_rest, value};
use super::{Check, Failure, facts};
use lodc_mesh::{Lod, OrientedTriangle, PositionIds, Simplified, TriangleHash};
use std::fmt;

/// The hash of the reference at every step, and whatever is wrong with the sequence itself.
#[derive(Clone, Debug)]
pub struct Reference<'a> {
    simplified: &'a Simplified,
    /// At LOD 0 and after each step.
    hashes: Vec<TriangleHash>,
    checks: Vec<Check>,
}

/// A sequence moves so many corners that following them would take very long. Real ones move each about ten times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooMuchWork {
    /// The LOD at which it became too much.
    pub lod: Lod,
}

impl fmt::Display for TooMuchWork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "up to LOD {} corners move more often than can be verified", self.lod.0)
    }
}

impl std::error::Error for TooMuchWork {}

impl<'a> Reference<'a> {
    /// Follows all triangles from LOD 0 to the last. Time in proportion to how often corners move.
    ///
    /// # Errors
    /// If that is more than some hundred times per corner.
    pub fn new(simplified: &'a Simplified) -> Result<Self, TooMuchWork> {
        let mut pass = Pass::new(simplified);
        let mut hashes = Vec::with_capacity(simplified.collapses().steps() + 1);
        hashes.push(pass.hash);
        for step in 0..simplified.collapses().steps() {
            pass.step(step)?;
            hashes.push(pass.hash);
        }
        pass.order();
        let mut checks = pass.checks();
        checks.extend(facts::check(simplified, &pass.positions));
        Ok(Self { simplified, hashes, checks })
    }

    /// What was found out about the sequence itself: stored triangle counts, order of triangles, tears, dead triangles
    /// that return, submeshes, steps that do not move one position onto one position, fakes out of place.
    #[must_use]
    pub fn checks(&self) -> &[Check] {
        &self.checks
    }

    /// Number of steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.hashes.len() - 1
    }

    /// The LOD after so many steps.
    #[must_use]
    pub fn lod(&self, steps: usize) -> Lod {
        if steps == 0 { Lod(0) } else { self.simplified.collapses().step(steps - 1).lod }
    }

    /// The hash of the triangles after so many steps.
    #[must_use]
    pub fn hash(&self, steps: usize) -> TriangleHash {
        self.hashes[steps]
    }
}

const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Life {
    Live,
    /// Two corners at one position, but different vertices.
    Dead,
    /// Two corners are one vertex: nothing to follow any more.
    Gone,
}

/// The state of things while following.
struct Pass<'a> {
    simplified: &'a Simplified,
    positions: PositionIds,
    corners: Vec<[u32; 3]>,
    life: Vec<Life>,
    /// How many steps were done when each triangle died.
    death: Vec<u32>,
    /// The step in which each triangle, then each boundary edge, was last touched.
    touched_in: Vec<u32>,
    border: Vec<[u32; 2]>,
    /// First and last corner of each vertex's list, and the corner after each. Corners are numbered: three for each
    /// triangle, then two for each boundary edge.
    first: Vec<u32>,
    last: Vec<u32>,
    next: Vec<u32>,
    hash: TriangleHash,
    live: u32,
    /// Value of the boundary of the live triangles minus the image of LOD 0's boundary.
    tear: u64,
    moves: u64,
    count: Option<Failure>,
    returned: Option<Failure>,
    submesh: Option<Failure>,
    torn: Option<Failure>,
    out_of_order: Option<Failure>,
}

impl<'a> Pass<'a> {
    fn new(simplified: &'a Simplified) -> Self {
        let mesh = simplified.mesh();
        let positions = PositionIds::new(mesh.positions());
        let border = boundary(mesh, &positions);
        let corners = mesh.triangles().to_vec();
        let vertices = mesh.vertex_count();
        let mut pass = Self {
            life: vec![Life::Live; corners.len()],
            death: vec![NONE; corners.len()],
            touched_in: vec![NONE; corners.len() + border.len()],
            first: vec![NONE; vertices],
            last: vec![NONE; vertices],
            next: vec![NONE; 3 * corners.len() + 2 * border.len()],
            hash: simplified.triangles_at_with(Lod(0), &positions).into_iter().collect(),
            live: corners.len() as u32,
            tear: 0,
            moves: 0,
            count: None,
            returned: None,
            submesh: None,
            torn: None,
            out_of_order: None,
            simplified,
            positions,
            corners,
            border,
        };
        let all = pass.corners.as_flattened().iter().chain(pass.border.as_flattened());
        for (corner, &v) in all.enumerate() {
            append(&mut pass.first, &mut pass.last, &mut pass.next, v, corner as u32);
        }
        pass
    }

    fn step(&mut self, step: usize) -> Result<(), TooMuchWork> {
        let ends = &self.simplified.collapses().parts().step_ends;
        let (start, end) = (if step == 0 { 0 } else { ends[step - 1] }, ends[step]);
        let mut touched = Vec::new();
        for record in start..end {
            self.record(record, step as u32, &mut touched);
        }
        if self.moves > 200 * (self.next.len() as u64 + 10_000) {
            return Err(TooMuchWork { lod: Lod(end) });
        }
        for item in touched {
            self.settle(item as usize, step as u32, Lod(end));
        }
        let stored = self.simplified.collapses().step(step).triangles;
        if stored != self.live && self.count.is_none() {
            self.count = Some(Failure::TriangleCount { lod: Lod(end), stored, counted: self.live });
        }
        if self.tear != 0 && self.torn.is_none() {
            self.torn = self.find_tear(Lod(end));
        }
        Ok(())
    }

    /// Hands the corners of a record's vertex on to its target.
    fn record(&mut self, record: u32, step: u32, touched: &mut Vec<u32>) {
        let target = self.simplified.collapses().targets()[record as usize];
        let mut corner = self.first[record as usize];
        while corner != NONE {
            let following = self.next[corner as usize];
            self.moves += 1;
            let triangles = self.corners.len();
            let (item, place) = match corner as usize {
                c if c < 3 * triangles => (c / 3, c % 3),
                c => (triangles + (c - 3 * triangles) / 2, (c - 3 * triangles) % 2),
            };
            if item >= triangles || self.life[item] != Life::Gone {
                if self.touched_in[item] != step {
                    self.touched_in[item] = step;
                    self.take_out(item);
                    touched.push(item as u32);
                }
                match item.checked_sub(triangles) {
                    None => self.corners[item][place] = target,
                    Some(edge) => self.border[edge][place] = target,
                }
                append(&mut self.first, &mut self.last, &mut self.next, target, corner);
            }
            corner = following;
        }
    }

    /// Takes a triangle or boundary edge out of the sums, before it changes.
    fn take_out(&mut self, item: usize) {
        if item >= self.corners.len() {
            self.tear = self.tear.wrapping_add(value(self.at(self.border[item - self.corners.len()])));
        } else if self.life[item] == Life::Live {
            self.hash.remove(self.oriented(item));
            self.tear = self.tear.wrapping_sub(self.rim(item));
        }
    }

    /// Puts a triangle or boundary edge back, after it has changed.
    fn settle(&mut self, item: usize, step: u32, lod: Lod) {
        if item >= self.corners.len() {
            self.tear = self.tear.wrapping_sub(value(self.at(self.border[item - self.corners.len()])));
            return;
        }
        let [a, b, c] = self.corners[item];
        let [p, q, r] = self.at([a, b, c]);
        let before = self.life[item];
        self.life[item] = if a == b || b == c || c == a {
            Life::Gone
        } else if p == q || q == r || r == p {
            Life::Dead
        } else {
            Life::Live
        };
        if self.life[item] != Life::Live {
            if before == Life::Live {
                self.live -= 1;
                self.death[item] = step;
            }
            return;
        }
        if before != Life::Live {
            self.live += 1;
            self.returned.get_or_insert(Failure::Returned { lod, triangle: item as u32 });
        }
        let submesh = self.simplified.mesh().vertex_submesh();
        let own = submesh[self.simplified.mesh().triangles()[item][0] as usize];
        if [a, b, c].iter().any(|&v| submesh[v as usize] != own) {
            self.submesh.get_or_insert(Failure::Submesh { lod, triangle: item as u32 });
        }
        self.hash.add(self.oriented(item));
        self.tear = self.tear.wrapping_add(self.rim(item));
    }

    fn at<const N: usize>(&self, vertices: [u32; N]) -> [u32; N] {
        vertices.map(|v| self.positions.of_vertex[v as usize])
    }

    fn oriented(&self, triangle: usize) -> OrientedTriangle {
        let submesh = self.simplified.mesh().vertex_submesh();
        let of = self.simplified.mesh().triangles()[triangle][0];
        OrientedTriangle::new(submesh[of as usize], self.corners[triangle])
    }

    fn rim(&self, triangle: usize) -> u64 {
        edges(self.at(self.corners[triangle])).into_iter().map(value).fold(0, u64::wrapping_add)
    }

    /// Works the sum out in full to name an edge.
    fn find_tear(&self, lod: Lod) -> Option<Failure> {
        let live = (0..self.corners.len()).filter(|&t| self.life[t] == Life::Live);
        let shown = live.flat_map(|t| edges(self.at(self.corners[t]))).map(|e| (e, 1));
        let image = self.border.iter().map(|&e| (self.at(e), -1));
        let (edge, surplus) = first_rest(shown.chain(image))?;
        let point = |p: u32| self.simplified.mesh().positions()[self.positions.first_vertex[p as usize] as usize];
        Some(Failure::Torn { lod, edge: edge.map(point), surplus })
    }

    /// Within a submesh, triangles must stand in reverse order of their death.
    fn order(&mut self) {
        for s in self.simplified.mesh().submeshes() {
            let deaths = &self.death[s.triangles()];
            if let Some(i) = deaths.windows(2).position(|pair| pair[0] < pair[1]) {
                self.out_of_order = Some(Failure::TriangleOrder { triangle: s.first_triangle + i as u32 + 1 });
                return;
            }
        }
    }

    fn checks(&mut self) -> Vec<Check> {
        let lods = self.simplified.collapses().steps() as u64 + 1;
        let check =
            |name, failure: &mut Option<Failure>| Check { model: "sequence", name, lods, failure: failure.take() };
        vec![
            check("stored triangle counts", &mut self.count),
            check("no tear", &mut self.torn),
            check("no triangle returns", &mut self.returned),
            check("corners stay in their submesh", &mut self.submesh),
            check("order of triangles", &mut self.out_of_order),
        ]
    }
}

/// Puts a corner at the end of a vertex's list.
fn append(first: &mut [u32], last: &mut [u32], next: &mut [u32], vertex: u32, corner: u32) {
    let vertex = vertex as usize;
    match last[vertex] {
        NONE => first[vertex] = corner,
        end => next[end as usize] = corner,
    }
    last[vertex] = corner;
    next[corner as usize] = NONE;
}
