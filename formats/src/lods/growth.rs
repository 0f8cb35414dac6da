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

/// A mesh that grows from a single vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Growth {
    /// What each vertex is made of: position, then attributes; one system of numbers for each channel.
    pub(super) systems: Vec<System>,
    /// Channels of each vertex as numbers of their systems.
    pub(super) index: Vec<i32>,
    /// The same as floats, for predictions.
    pub(super) value: Vec<f32>,
    /// The submesh of each vertex.
    pub(super) submesh: Vec<u32>,
    /// The next vertex of the same step and position, in a circle.
    pub(super) mate: Vec<u32>,
    /// A corner of each vertex.
    head: Vec<u32>,
    /// The vertex of each corner.
    pub(super) corners: Vec<u32>,
    /// The next corner of the same vertex.
    next: Vec<u32>,
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
        self.corners.len() as u32 / 3
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
        self.index.extend_from_slice(index);
        self.value.extend(index.iter().zip(&self.systems).map(|(&i, s)| s.value(i)));
    }

    /// A triangle, counter-clockwise.
    pub(super) fn add_face(&mut self, vertices: [u32; 3]) -> u32 {
        let face = self.faces();
        for (corner, &v) in (3 * face..).zip(&vertices) {
            self.corners.push(v);
            self.next.push(std::mem::replace(&mut self.head[v as usize], corner));
        }
        face
    }

    /// The vertex that follows a corner in its face.
    pub(super) fn after(&self, corner: u32) -> u32 {
        self.corners[if corner % 3 == 2 { corner - 2 } else { corner + 1 } as usize]
    }

    /// The vertex before a corner in its face.
    pub(super) fn before(&self, corner: u32) -> u32 {
        self.corners[if corner % 3 == 0 { corner + 2 } else { corner - 1 } as usize]
    }

    /// The triangles at a vertex in the order of fans, each from its oldest vertex on if it is closed.
    pub(super) fn ring(&self, vertex: u32, ring: &mut Vec<Spoke>) {
        ring.clear();
        let mut corner = self.head[vertex as usize];
        while corner != NONE {
            ring.push(Spoke { corner, a: self.after(corner), b: self.before(corner) });
            corner = self.next[corner as usize];
        }
        if ring.len() <= FAN {
            sort(ring);
        }
    }

    /// Gives corners of `from` to `to`, and both vertices their corners in the order of the ring.
    pub(super) fn split(&mut self, from: u32, to: u32, ring: &[Spoke], moves: &[bool]) {
        let mut heads = [NONE; 2];
        for (spoke, &moved) in ring.iter().zip(moves).rev() {
            let head = &mut heads[usize::from(moved)];
            self.next[spoke.corner as usize] = *head;
            *head = spoke.corner;
            if moved {
                self.corners[spoke.corner as usize] = to;
            }
        }
        [self.head[from as usize], self.head[to as usize]] = heads;
    }
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
        assert_eq!(growth.corners, [0, 1, 2, 9, 2, 3, 0, 3, 1]);
        assert_eq!(around(&growth, 9).0, [1]);
        assert_eq!(around(&growth, 0).0, [2, 0]);
    }
}
