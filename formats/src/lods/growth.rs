//! The mesh while it grows: vertices in order of arrival, live triangles, and which triangles meet
//! at each vertex.
//!
//! Both sides of a stream keep one; what is said is said in terms of it.

use super::fans::{Fans, OWN};
use super::numbers::System;
use std::hint::black_box;

/// No corner, face or vertex.
pub(super) const NONE: u32 = u32::MAX;

/// A live triangle seen from one of its corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Spoke {
    /// The corner: four times the face, plus which of its corners it is.
    pub(super) corner: u32,
    /// The next vertex, counter-clockwise.
    pub(super) a: u32,
    /// The one after it.
    pub(super) b: u32,
}

impl Spoke {
    pub(super) fn face(self) -> u32 {
        self.corner >> 2
    }

    /// The corner at `a`.
    fn corner_a(self) -> u32 {
        self.corner & !3 | NEXT[self.corner as usize & 3]
    }

    /// The corner at `b`.
    fn corner_b(self) -> u32 {
        self.corner & !3 | NEXT[NEXT[self.corner as usize & 3] as usize & 3]
    }
}

/// Which corner comes after each.
const NEXT: [u32; 4] = [1, 2, 0, 0];

/// A triangle that comes with a vertex, as both sides know it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Born {
    /// Its corners after the new vertex, counter-clockwise.
    pub(super) next: u32,
    pub(super) after: u32,
    pub(super) kind: Kind,
    /// Which triangles of the ring lie beyond the edges that were one before, [`NONE`] if none or
    /// not known: that with the told corner as its `a`, and that with it as its `b`.
    pub(super) beyond: [u32; 2],
}

/// How a new triangle lies to the edge from the survivor to the new vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Right of it: the survivor comes after the other corner.
    Right,
    /// Left of it: the survivor comes next after the new vertex.
    Left,
    /// The survivor is no corner.
    Apart,
}

/// A mesh that grows from a single vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Growth {
    /// What each vertex is made of: position, then attributes; one system of numbers for each
    /// channel.
    pub(super) systems: Vec<System>,
    /// Channels of each vertex as numbers of their systems.
    pub(super) numbers: Vec<i32>,
    /// The submesh of each vertex.
    pub(super) submesh: Vec<u32>,
    /// The next vertex of the same step and position, in a circle.
    pub(super) mate: Vec<u32>,
    /// The corners of each vertex, mostly in the order of fans.
    pub(super) fans: Fans,
    /// The vertices of each triangle; the fourth is nobody's.
    faces: Vec<[u32; 4]>,
    /// A buffer.
    lists: [Vec<u32>; 2],
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
        self.fans.add();
        new
    }

    /// Gives the last vertex its values.
    pub(super) fn add_values(&mut self, index: &[i32]) {
        self.numbers.extend_from_slice(index);
    }

    /// The vertices of a triangle.
    pub(super) fn face(&self, face: u32) -> [u32; 3] {
        let [x, y, z, _] = self.faces[face as usize];
        [x, y, z]
    }

    /// The triangles at a vertex, in the order of its corners. Says whether they are one fan that
    /// closes.
    #[inline]
    pub(super) fn ring(&self, vertex: u32, ring: &mut Vec<Spoke>) -> bool {
        ring.clear();
        let mut chain = true;
        let mut end = NONE;
        ring.extend(self.fans.of(vertex).iter().map(|&corner| {
            let face = &self.faces[corner as usize >> 2];
            let next = NEXT[corner as usize & 3] as usize & 3;
            let (a, b) = (face[next], face[NEXT[next] as usize & 3]);
            chain &= end == a || end == NONE;
            end = b;
            Spoke { corner, a, b }
        }));
        chain && ring.first().is_some_and(|first| first.a == end)
    }

    /// Looks at what will be needed of a vertex: first where its corners are, later the triangles
    /// there and the numbers of their vertices. So these come into the caches while something else
    /// is done. Changes nothing.
    pub(super) fn touch(&self, vertex: u32) {
        black_box(self.fans.count(vertex));
    }

    /// See [`Self::touch`].
    #[inline]
    pub(super) fn touch_numbers(&self, vertex: u32) {
        let channels = self.channels();
        let first = |&c: &u32| {
            let a = self.faces[c as usize >> 2][NEXT[c as usize & 3] as usize & 3];
            self.numbers.get(a as usize * channels).copied().unwrap_or_default()
        };
        black_box(self.fans.of(vertex).iter().take(OWN).fold(0, |all, c| all ^ first(c)));
    }

    /// What [`Self::split`] does in the usual case: a fan that closes comes apart at two of its
    /// triangles, of which the `right` one is the first to stay and the `left` one the first to go.
    /// `near` becomes the vertices around `to`. Not done where lists are long.
    #[inline]
    pub(super) fn part(
        &mut self,
        [from, to]: [u32; 2],
        ring: &[Spoke],
        [right, left]: [usize; 2],
        near: &mut Vec<u32>,
    ) -> bool {
        let n = ring.len();
        let on = |i: usize| if i + 1 == n { 0 } else { i + 1 };
        let (goes, stays) = if left < right {
            (right - left, n + left - right)
        } else {
            (n + right - left, left - right)
        };
        let first = 4 * self.faces();
        if goes + 2 > OWN || stays + 2 > OWN || self.fans.count(from) as usize > OWN {
            return false;
        }
        let (Some(a), Some(b)) = (ring.get(right), ring.get(left)) else { return false };
        let stay = self.fans.own(from, stays + 2);
        let mut i = right;
        stay[0] = first + 2;
        for place in &mut stay[1..=stays] {
            *place = ring[i].corner;
            i = on(i);
        }
        stay[stays + 1] = first + 5;
        let go = self.fans.own(to, goes + 2);
        near.clear();
        for place in &mut go[..goes] {
            let spoke = ring[i];
            *place = spoke.corner;
            near.push(spoke.a);
            self.faces[spoke.face() as usize][spoke.corner as usize & 3] = to;
            i = on(i);
        }
        [go[goes], go[goes + 1]] = [first, first + 4];
        near.extend([a.a, from]);
        self.faces.extend([[to, a.a, from, NONE], [to, from, b.a, NONE]]);
        self.fans.insert(a.a, first + 1, Some((a.corner_a(), true)));
        self.fans.insert(b.a, first + 6, Some((b.corner_a(), true)));
        true
    }

    /// Gives the triangles of `from` that move to `to`, adds those that are born, and puts all
    /// corners into the order of fans, as far as that follows (docs/STREAM.md, "Corner list").
    /// `around` becomes the triangles at `to`.
    pub(super) fn split(
        &mut self,
        [from, to]: [u32; 2],
        ring: &[Spoke],
        moves: &[bool],
        births: &[Born],
        around: &mut Vec<Spoke>,
    ) {
        let first = self.faces();
        let corner = |i: usize, of: u32| 4 * (first + i as u32) + of;
        let numbered = || births.iter().enumerate();
        let [stay, go] = &mut self.lists;
        stay.clear();
        go.clear();
        around.clear();
        stay.extend(numbered().filter(|(_, b)| b.kind == Kind::Right).map(|(i, _)| corner(i, 2)));
        let turn = turned(ring, moves);
        for (spoke, &moved) in
            ring[turn..].iter().zip(&moves[turn..]).chain(ring[..turn].iter().zip(moves))
        {
            if moved {
                go.push(spoke.corner);
                around.push(*spoke);
                self.faces[spoke.face() as usize][spoke.corner as usize & 3] = to;
            } else {
                stay.push(spoke.corner);
            }
        }
        for (i, b) in numbered() {
            self.faces.push([to, b.next, b.after, NONE]);
            go.push(corner(i, 0));
            around.push(Spoke { corner: corner(i, 0), a: b.next, b: b.after });
            match b.kind {
                Kind::Right => self.fans.insert(b.next, corner(i, 1), neighbour(ring, b)),
                Kind::Left => {
                    stay.push(corner(i, 1));
                    self.fans.insert(b.after, corner(i, 2), neighbour(ring, b));
                }
                Kind::Apart => {
                    self.fans.insert(b.next, corner(i, 1), None);
                    self.fans.insert(b.after, corner(i, 2), None);
                }
            }
        }
        self.fans.set(from, stay);
        self.fans.set(to, go);
    }
}

/// The corner beside which a new triangle's corner at the told vertex belongs, and whether it comes
/// behind it.
fn neighbour(ring: &[Spoke], born: &Born) -> Option<(u32, bool)> {
    let at = |i: u32| ring.get(i as usize);
    let behind = at(born.beyond[0]).map(|s| (s.corner_a(), true));
    behind.or_else(|| at(born.beyond[1]).map(|s| (s.corner_b(), false)))
}

/// Where to begin with a ring that closes, so that what goes and what stays are each in one piece:
/// at the end's triangles that share the first one's fate.
fn turned(ring: &[Spoke], moves: &[bool]) -> usize {
    match (ring, moves) {
        ([first, .., last], [begins, ..]) if last.b == first.a => {
            let same = moves.iter().rev().take_while(|&m| m == begins).count();
            if same == moves.len() { 0 } else { (moves.len() - same) % moves.len() }
        }
        _ => 0,
    }
}

/// A vertex around another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RimVertex {
    pub(super) vertex: u32,
    /// Which triangles of the ring have it as their `a`, and as their `b`; [`NONE`] at the ends of
    /// a fan.
    pub(super) beyond: [u32; 2],
}

/// The vertices around a ring, in its order, each fan's once. Fans are told apart by where a
/// triangle does not begin with the vertex that the one before it ends with.
pub(super) fn rim(ring: &[Spoke], rim: &mut Vec<RimVertex>) {
    rim.clear();
    let mut fan = 0;
    for (i, spoke) in ring.iter().enumerate() {
        let before = if i > fan { i as u32 - 1 } else { NONE };
        rim.push(RimVertex { vertex: spoke.a, beyond: [i as u32, before] });
        let goes_on = ring.get(i + 1).is_some_and(|next| next.a == spoke.b);
        if !goes_on {
            if spoke.b == ring[fan].a {
                let begin = rim.len() - 1 - (i - fan);
                rim[begin].beyond[1] = i as u32;
            } else {
                rim.push(RimVertex { vertex: spoke.b, beyond: [NONE, i as u32] });
            }
            fan = i + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A vertex amid six others, split in two.
    fn split() -> Growth {
        let mut growth = Growth::default();
        for _ in 0..8 {
            growth.add_vertex(0);
        }
        let apart = |next, after| Born { next, after, kind: Kind::Apart, beyond: [NONE; 2] };
        let spokes: Vec<Born> = (1..7).map(|i| apart(i, i % 6 + 1)).collect();
        growth.split([7, 0], &[], &[], &spokes, &mut Vec::new());
        let (mut ring, mut found, mut around) = (Vec::new(), Vec::new(), Vec::new());
        assert!(growth.ring(0, &mut ring));
        rim(&ring, &mut found);
        assert_eq!(found.iter().map(|r| r.vertex).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6]);
        assert_eq!(found[0].beyond, [0, 5]);
        // The last and the first two triangles go: from vertex 6 to vertex 3.
        let right = Born { next: 3, after: 0, kind: Kind::Right, beyond: found[2].beyond };
        let left = Born { next: 0, after: 6, kind: Kind::Left, beyond: found[5].beyond };
        let moves = [true, true, false, false, false, true];
        growth.split([0, 7], &ring, &moves, &[right, left], &mut around);
        let new: Vec<_> = around.iter().map(|s| (s.a, s.b)).collect();
        assert_eq!(new, [(6, 1), (1, 2), (2, 3), (3, 0), (0, 6)]);
        growth
    }

    #[test]
    fn fans_stay_in_order() {
        let growth = split();
        let (mut ring, mut found) = (Vec::new(), Vec::new());
        // Those of vertices 3 and 6 were not in order before: what comes is put beside its
        // neighbour.
        let closed = [(0, &[7, 3, 4, 5, 6][..], true), (7, &[6, 1, 2, 3, 0], true)];
        let open = [(3, &[7, 2, 4, 0, 7][..], false), (6, &[0, 5, 1, 7, 0], false)];
        for (vertex, rim_of, closes) in closed.into_iter().chain(open) {
            assert_eq!(growth.ring(vertex, &mut ring), closes, "around {vertex}");
            rim(&ring, &mut found);
            assert_eq!(
                found.iter().map(|r| r.vertex).collect::<Vec<_>>(),
                rim_of,
                "around {vertex}"
            );
        }
    }

    #[test]
    fn fans_that_do_not_close_follow_one_another() {
        let spoke = |a, b| Spoke { corner: 0, a, b };
        let mut found = Vec::new();
        rim(&[spoke(3, 2), spoke(2, 1), spoke(5, 6)], &mut found);
        assert_eq!(found.iter().map(|r| r.vertex).collect::<Vec<_>>(), [3, 2, 1, 5, 6]);
        assert_eq!(found[1].beyond, [1, 0]);
        assert_eq!(found[4].beyond, [NONE, 2]);
        rim(&[], &mut found);
        assert!(found.is_empty());
    }
}
