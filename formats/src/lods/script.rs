//! What a writer knows: the whole growth, worked out beforehand from the collapse sequence.
//!
//! Vertices are numbered by arrival here: the last one left is 0, the first to disappear comes
//! last.

use super::growth::NONE;
use lodc_mesh::{PositionIds, Simplified};
use lodc_strip::StripSet;

/// A triangle that comes with a vertex: its two other corners, counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(super) struct Birth {
    pub(super) next: u32,
    pub(super) after: u32,
}

/// Where a new triangle stands in the order of drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// The live triangle drawn before it, or none.
    pub(super) after: u32,
    /// Its strip, by order of arrival; a number not yet given for a new one.
    pub(super) strip: u32,
}

/// The truth about a growth. A reader has none: what it answers is not looked at.
pub(super) trait Script {
    /// The vertex that a new one comes out of.
    fn survivor(&self, new: u32) -> u32;
    /// Whether the step goes on after a vertex.
    fn goes_on(&self, new: u32) -> bool;
    /// The submesh of a vertex.
    fn submesh(&self, new: u32) -> u32;
    /// The triangles that come with a vertex.
    fn births(&self, new: u32) -> &[Birth];
    /// Whether a corner of a live triangle goes with a new vertex.
    fn moves(&self, corner: u32, new: u32) -> bool;
    /// The numbers of a vertex.
    fn index(&self, new: u32) -> &[i32];
    /// Where a new triangle stands, there being so many strips.
    fn place(&self, face: u32, strips: u32, strip_of: &dyn Fn(u32) -> u32) -> Place;
    /// How coarse the error of the step that ends with a vertex is.
    fn error(&self, new: u32) -> u32;
}

/// Knows nothing.
pub(super) struct Unknown;

impl Script for Unknown {
    fn survivor(&self, _: u32) -> u32 {
        0
    }
    fn goes_on(&self, _: u32) -> bool {
        false
    }
    fn submesh(&self, _: u32) -> u32 {
        0
    }
    fn births(&self, _: u32) -> &[Birth] {
        &[]
    }
    fn moves(&self, _: u32, _: u32) -> bool {
        false
    }
    fn index(&self, _: u32) -> &[i32] {
        &[]
    }
    fn place(&self, _: u32, _: u32, _: &dyn Fn(u32) -> u32) -> Place {
        Place { after: NONE, strip: 0 }
    }
    fn error(&self, _: u32) -> u32 {
        0
    }
}

/// The growth of a simplified mesh.
pub(super) struct Known {
    survivors: Vec<u32>,
    goes_on: Vec<bool>,
    submesh: Vec<u32>,
    channels: usize,
    index: Vec<i32>,
    births: Vec<Birth>,
    first_birth: Vec<u32>,
    /// The final vertex of each corner of each face; the fourth is nobody's.
    ends: Vec<u32>,
    /// Every vertex with all that come out of it is a run of numbers.
    run: Vec<(u32, u32)>,
    errors: Vec<u32>,
    strips: Option<Drawn>,
}

/// The order of drawing.
struct Drawn {
    /// The face drawn before each among those that came before it.
    previous: Vec<u32>,
    next: Vec<u32>,
    /// The strip of each face.
    strip: Vec<u32>,
}

impl Known {
    /// `index` has the numbers of all vertices by arrival, `errors` what is said of the error when
    /// a vertex has come. Nothing comes back if the strips do not draw the mesh.
    pub(super) fn new(
        simplified: &Simplified,
        index: Vec<i32>,
        channels: usize,
        errors: Vec<u32>,
        strips: Option<&StripSet>,
    ) -> Option<Self> {
        let (mesh, sequence) = (simplified.mesh(), simplified.collapses());
        let last = sequence.records();
        let arrival = |v: u32| last - v;
        let survivors: Vec<u32> = std::iter::once(0)
            .chain(sequence.targets().iter().rev().map(|&t| arrival(t)))
            .take(mesh.vertex_count())
            .collect();
        let mut goes_on = vec![true; mesh.vertex_count()];
        for &end in std::iter::once(&0).chain(&sequence.parts().step_ends) {
            // The step after this one ends, growing, with the first record that it has.
            if let Some(g) = goes_on.get_mut(arrival(end.min(last)) as usize) {
                *g = false;
            }
        }
        let born = births(simplified);
        let mut order: Vec<u32> = (0..born.len() as u32).collect();
        order.sort_by_key(|&t| {
            let [v, next, after] = born[t as usize].corners;
            let survivor = survivors[v as usize];
            // The order in which both sides know them: right of the edge, left of it, elsewhere.
            let kind = if after == survivor { 0 } else { 1 + u32::from(next != survivor) };
            (v, kind, next, after, t)
        });
        let mut first_birth = vec![0; mesh.vertex_count() + 1];
        let mut births = Vec::with_capacity(born.len());
        for &t in &order {
            let [v, next, after] = born[t as usize].corners;
            first_birth[v as usize + 1] += 1;
            births.push(Birth { next, after });
        }
        for v in 1..first_birth.len() {
            first_birth[v] += first_birth[v - 1];
        }
        let run = runs(&survivors);
        let mut ends = Vec::with_capacity(4 * order.len());
        for &t in &order {
            let (corners, turn) = (mesh.triangles()[t as usize], born[t as usize].turn);
            ends.extend((0..3).map(|c| arrival(corners[(turn + c) % 3])));
            ends.push(NONE);
        }
        let strips = match strips {
            Some(strips) => Some(Drawn::new(simplified, strips, &order)?),
            None => None,
        };
        let submesh = mesh.vertex_submesh().iter().rev().copied().collect();
        Some(Self {
            survivors,
            goes_on,
            submesh,
            channels,
            index,
            births,
            first_birth,
            ends,
            run,
            errors,
            strips,
        })
    }
}

impl Script for Known {
    fn survivor(&self, new: u32) -> u32 {
        self.survivors[new as usize]
    }
    fn goes_on(&self, new: u32) -> bool {
        self.goes_on[new as usize]
    }
    fn submesh(&self, new: u32) -> u32 {
        self.submesh[new as usize]
    }
    fn births(&self, new: u32) -> &[Birth] {
        let [from, to] = [new, new + 1].map(|v| self.first_birth[v as usize] as usize);
        &self.births[from..to]
    }
    fn moves(&self, corner: u32, new: u32) -> bool {
        let (from, to) = self.run[new as usize];
        let end = self.ends[corner as usize];
        (from..to).contains(&self.run[end as usize].0)
    }
    fn index(&self, new: u32) -> &[i32] {
        &self.index[new as usize * self.channels..][..self.channels]
    }
    fn place(&self, face: u32, strips: u32, strip_of: &dyn Fn(u32) -> u32) -> Place {
        let Some(drawn) = &self.strips else { return Unknown.place(face, strips, strip_of) };
        let (after, before) = (drawn.previous[face as usize], drawn.next[face as usize]);
        let same =
            |other: u32| other != NONE && drawn.strip[other as usize] == drawn.strip[face as usize];
        let strip = if same(after) {
            strip_of(after)
        } else if same(before) {
            strip_of(before)
        } else {
            strips
        };
        Place { after, strip }
    }
    fn error(&self, new: u32) -> u32 {
        self.errors[new as usize]
    }
}

/// How a triangle is born.
struct Born {
    /// Its corners then, by arrival: first the vertex that it comes with.
    corners: [u32; 3],
    /// Which of the triangle's own corners that is.
    turn: usize,
}

/// How every triangle is born.
fn births(simplified: &Simplified) -> Vec<Born> {
    let (mesh, sequence) = (simplified.mesh(), simplified.collapses());
    let targets = sequence.targets();
    let last = sequence.records();
    let positions = PositionIds::new(mesh.positions()).of_vertex;
    let mut end_of = Vec::with_capacity(targets.len());
    for &end in &sequence.parts().step_ends {
        end_of.resize(end as usize, end);
    }
    let born = |&triangle: &[u32; 3]| {
        let mut corners: [u32; 3] = triangle;
        loop {
            let first = corners[0].min(corners[1]).min(corners[2]);
            // Two corners at the last vertex are at one position, so a live triangle has an earlier
            // one.
            let end = end_of[first as usize];
            let before = corners;
            for v in &mut corners {
                while *v < end {
                    *v = targets[*v as usize];
                }
            }
            let [a, b, c] = corners.map(|v| positions[v as usize]);
            if a == b || b == c || c == a {
                let turn = (0..3).find(|&i| before[i] == first).unwrap_or_default();
                return Born {
                    corners: std::array::from_fn(|i| last - before[(turn + i) % 3]),
                    turn,
                };
            }
        }
    };
    mesh.triangles().iter().map(born).collect()
}

/// Numbers the vertices so that each with all that come out of it is a run.
fn runs(survivors: &[u32]) -> Vec<(u32, u32)> {
    let mut size = vec![1u32; survivors.len()];
    for v in (1..survivors.len()).rev() {
        size[survivors[v] as usize] += size[v];
    }
    let mut run: Vec<(u32, u32)> = vec![(0, 0); survivors.len()];
    let mut free = vec![0u32; survivors.len()];
    for v in 0..survivors.len() {
        let start = if v == 0 { 0 } else { std::mem::replace(&mut free[survivors[v] as usize], 0) };
        if v > 0 {
            free[survivors[v] as usize] = start + size[v];
        }
        run[v] = (start, start + size[v]);
        free[v] = start + 1;
    }
    run
}

impl Drawn {
    /// `order` says which triangle of the mesh each face is. None if the strips do not draw the
    /// mesh.
    fn new(simplified: &Simplified, strips: &StripSet, order: &[u32]) -> Option<Self> {
        let mesh = simplified.mesh();
        // Triangles of the mesh and of the strips by what they are.
        let key = |submesh: u32, t: [u32; 3]| lodc_mesh::OrientedTriangle::new(submesh, t);
        let mut own = Vec::with_capacity(order.len());
        for (s, submesh) in (0..).zip(mesh.submeshes()) {
            own.extend(submesh.triangles().map(|t| (key(s, mesh.triangles()[t]), t as u32)));
        }
        let mut drawn = Vec::with_capacity(order.len());
        for (strip, submesh) in (0..).zip(strips.submeshes()) {
            let triangles = lodc_strip::strip_triangles(strips.strip(strip as usize));
            drawn.extend(triangles.map(|t| (key(submesh, t), strip)));
        }
        let mut sequence: Vec<u32> = (0..drawn.len() as u32).collect();
        sequence.sort_by_key(|&i| (drawn[i as usize].0, i));
        own.sort_unstable();
        if own.len() != drawn.len()
            || sequence.iter().zip(&own).any(|(&i, o)| drawn[i as usize].0 != o.0)
        {
            return None;
        }
        let mut face_of = vec![0; order.len()];
        for (face, &t) in (0..).zip(order) {
            face_of[t as usize] = face;
        }
        let mut faces = vec![0; order.len()];
        let mut strip = vec![0; order.len()];
        for (&i, &(_, t)) in sequence.iter().zip(&own) {
            let face = face_of[t as usize];
            faces[i as usize] = face;
            strip[face as usize] = drawn[i as usize].1;
        }
        let (mut previous, mut next) = (vec![NONE; order.len()], vec![NONE; order.len()]);
        for pair in faces.windows(2) {
            next[pair[0] as usize] = pair[1];
            previous[pair[1] as usize] = pair[0];
        }
        // Those that come later are not there yet.
        for face in (0..order.len()).rev() {
            let (p, n) = (previous[face], next[face]);
            if p != NONE {
                next[p as usize] = n;
            }
            if n != NONE {
                previous[n as usize] = p;
            }
        }
        Some(Self { previous, next, strip })
    }
}
