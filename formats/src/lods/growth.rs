//! The mesh while it grows: vertices in order of arrival, live triangles, and which triangles meet at each vertex.
//!
//! Both sides of a stream keep one; what is said is said in terms of it.

use super::numbers::System;

/// No corner, face or vertex.
pub(super) const NONE: u32 = u32::MAX;

/// Faces at a vertex are put into the order of a fan up to this many; hubs keep the order they have.
const FAN: usize = 64;

/// A live triangle seen from one of its corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Spoke {
    /// The corner: three times the face, plus which of its corners it is.
    pub(super) corner: u32,
    /// The next vertex, counter-clockwise.
    pub(super) a: u32,
    /// The one after it.
    pub(super) b: u32,
}

impl Spoke {
    pub(super) fn face(self) -> u32 {
        self.corner / 3
    }
}

/// A triangle: what is read together stands together.
#[derive(Clone, Copy, Debug)]
struct Face {
    /// The vertex of each corner.
    vertices: [u32; 3],
    /// The next corner of the same vertex.
    next: [u32; 3],
}

/// A mesh that grows from a single vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Growth {
    /// What each vertex is made of: position, then attributes; one system of numbers for each channel.
    pub(super) systems: Vec<System>,
    /// Channels of each vertex: numbers of their systems, and the same as floats, for predictions.
    pub(super) numbers: Vec<(i32, f32)>,
    /// The submesh of each vertex.
    pub(super) submesh: Vec<u32>,
    /// The next vertex of the same step and position, in a circle.
    pub(super) mate: Vec<u32>,
    /// A corner of each vertex.
    head: Vec<u32>,
    faces: Vec<Face>,
}

impl Growth {
    pub(super) fn new(systems: Vec<System>) -> Self {
        Self { systems, ..Self::default() }
    }

    pub(super) fn channels(&self) -> usize {
        self.systems.len()
    }

    pub(super) fn vertices(&self) -> u32 {
        self.submesh.len() as u32
    }

    pub(super) fn faces(&self) -> u32 {
        self.faces.len() as u32
    }

    /// A vertex without triangles, and without values yet.
    pub(super) fn add_vertex(&mut self, submesh: u32) -> u32 {
        let new = self.vertices();
        self.submesh.push(submesh);
        self.mate.push(new);
        self.head.push(NONE);
        new
    }

    /// Gives the last vertex its values.
    pub(super) fn add_values(&mut self, index: &[i32]) {
        self.numbers.extend(index.iter().zip(&self.systems).map(|(&i, s)| (i, s.value(i))));
    }

    /// A triangle, counter-clockwise.
    pub(super) fn add_face(&mut self, vertices: [u32; 3]) -> u32 {
        let face = self.faces();
        let mut next = [NONE; 3];
        for (i, &v) in (0..).zip(&vertices) {
            next[i as usize] = std::mem::replace(&mut self.head[v as usize], 3 * face + i);
        }
        self.faces.push(Face { vertices, next });
        face
    }

    /// The vertices of a triangle.
    pub(super) fn face(&self, face: u32) -> [u32; 3] {
        self.faces[face as usize].vertices
    }

    /// The triangles at a vertex, in any order.
    pub(super) fn spokes(&self, vertex: u32, spokes: &mut Vec<Spoke>) {
        spokes.clear();
        let mut corner = self.head[vertex as usize];
        while corner != NONE {
            let (face, i) = (&self.faces[corner as usize / 3], corner as usize % 3);
            let [x, y, z] = face.vertices;
            let [a, b] = [[y, z], [z, x], [x, y]][i];
            spokes.push(Spoke { corner, a, b });
            corner = face.next[i];
        }
    }

    /// The triangles at a vertex in the order of fans, each from its oldest vertex on if it is closed.
    pub(super) fn ring(&self, vertex: u32, ring: &mut Vec<Spoke>) {
        self.spokes(vertex, ring);
        if ring.len() <= FAN && !sort_closed(ring) {
            sort(ring);
        }
    }

    /// Gives corners of `from` to `to`, and both vertices their corners in the order of the ring.
    pub(super) fn split(&mut self, from: u32, to: u32, ring: &[Spoke], moves: &[bool]) {
        let mut heads = [NONE; 2];
        for (spoke, &moved) in ring.iter().zip(moves).rev() {
            let head = &mut heads[usize::from(moved)];
            let (face, i) = (&mut self.faces[spoke.corner as usize / 3], spoke.corner as usize % 3);
            face.next[i] = *head;
            *head = spoke.corner;
            if moved {
                face.vertices[i] = to;
            }
        }
        [self.head[from as usize], self.head[to as usize]] = heads;
    }
}

/// Puts spokes into the order of a fan that closes, from its oldest vertex on. Does what [`sort`] does, where it can.
fn sort_closed(ring: &mut [Spoke]) -> bool {
    let Some(first) = (0..ring.len()).min_by_key(|&i| (ring[i].a, ring[i].corner)) else { return true };
    ring.swap(0, first);
    for i in 1..ring.len() {
        let end = ring[i - 1].b;
        // A fan that closes too early is not the only one.
        match ring[i..].iter().position(|s| s.a == end) {
            Some(next) if end != ring[0].a => ring.swap(i, i + next),
            _ => return false,
        }
    }
    ring[ring.len() - 1].b == ring[0].a
}

/// Puts spokes into the order of fans: each begins where the one before it ends.
fn sort(ring: &mut [Spoke]) {
    let mut start = 0;
    while start < ring.len() {
        // A fan begins at a border if it has one, else at its oldest vertex.
        let rest = &ring[start..];
        let first = (0..rest.len()).min_by_key(|&i| {
            let inner = rest.iter().any(|s| s.b == rest[i].a);
            (inner, rest[i].a, rest[i].corner)
        });
        let mut at = start + first.unwrap_or_default();
        loop {
            ring.swap(start, at);
            let end = ring[start].b;
            start += 1;
            match ring[start..].iter().position(|s| s.a == end) {
                Some(next) => at = start + next,
                None => break,
            }
        }
    }
}

/// The vertices around spokes in any order, each once. Hubs are too large to look for what is there twice.
pub(super) fn around(spokes: &[Spoke], around: &mut Vec<u32>) {
    around.clear();
    around.extend(spokes.iter().map(|s| s.a));
    if spokes.len() <= FAN {
        for s in spokes {
            if spokes.iter().all(|t| t.a != s.b) {
                around.push(s.b);
            }
        }
    }
}

/// The vertices around a ring, in its order, each fan's once.
pub(super) fn rim(ring: &[Spoke], rim: &mut Vec<u32>) {
    rim.clear();
    let mut fan = ring.first().map_or(NONE, |s| s.a);
    for (i, spoke) in ring.iter().enumerate() {
        rim.push(spoke.a);
        let goes_on = ring.get(i + 1).is_some_and(|next| next.a == spoke.b);
        if !goes_on {
            if spoke.b != fan {
                rim.push(spoke.b);
            }
            fan = ring.get(i + 1).map_or(NONE, |s| s.a);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(faces: &[[u32; 3]]) -> Growth {
        let mut growth = Growth::default();
        for _ in 0..10 {
            growth.add_vertex(0);
        }
        for &f in faces {
            growth.add_face(f);
        }
        growth
    }

    fn around(growth: &Growth, vertex: u32) -> (Vec<u32>, Vec<u32>) {
        let (mut ring, mut out) = (Vec::new(), Vec::new());
        growth.ring(vertex, &mut ring);
        rim(&ring, &mut out);
        (ring.iter().map(|s| s.face()).collect(), out)
    }

    #[test]
    fn a_closed_fan_starts_at_its_oldest_vertex() {
        let growth = with(&[[0, 3, 4], [4, 2, 0], [0, 2, 3]]);
        assert_eq!(around(&growth, 0), (vec![2, 0, 1], vec![2, 3, 4]));
    }

    #[test]
    fn open_fans_start_at_their_border_and_follow_one_another() {
        let growth = with(&[[0, 2, 1], [0, 3, 2], [0, 5, 6]]);
        assert_eq!(around(&growth, 0), (vec![1, 0, 2], vec![3, 2, 1, 5, 6]));
    }

    #[test]
    fn corners_that_move_leave_the_others_in_place() {
        let mut growth = with(&[[0, 1, 2], [0, 2, 3], [0, 3, 1]]);
        let mut ring = Vec::new();
        growth.ring(0, &mut ring);
        growth.split(0, 9, &ring, &[false, true, false]);
        assert_eq!([0, 1, 2].map(|f| growth.face(f)), [[0, 1, 2], [9, 2, 3], [0, 3, 1]]);
        assert_eq!(around(&growth, 9).0, [1]);
        assert_eq!(around(&growth, 0).0, [2, 0]);
    }
}
