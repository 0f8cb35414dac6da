//! The star of a vertex (its triangles) and its link (the vertices around it), as lists in the
//! order of fans. The figure is in `partial_mesh/mod.rs`.

use lodc_mesh::NONE;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// The next corner, counter-clockwise, of corners 0, 1 and 2 of a triangle. The number of a corner
/// in a mesh is four times the triangle plus that; the fourth entry only makes masked accesses
/// safe.
pub(crate) const NEXT: [u32; 4] = [1, 2, 0, 0];

/// Stars of more triangles are large: those of high-valence vertices, with hundreds of triangles.
/// Only splits of large stars pay the bits that high-valence vertices need, so the number is high
/// enough for ordinary meshes to have none. A constant of the format; chosen by hand.
pub(crate) const LARGE_STAR: u32 = 256;

/// A triangle seen from one of its corners, at vertex v: (v, a, b) counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StarFace {
    /// The corner at v.
    pub(crate) corner: u32,
    pub(crate) a: u32,
    pub(crate) b: u32,
}

impl StarFace {
    pub(crate) fn face(self) -> u32 {
        self.corner >> 2
    }

    pub(crate) fn corner_a(self) -> u32 {
        self.corner & !3 | NEXT[self.corner as usize & 3]
    }

    pub(crate) fn corner_b(self) -> u32 {
        self.corner & !3 | NEXT[NEXT[self.corner as usize & 3] as usize & 3]
    }
}

/// A vertex of the link of another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LinkVertex {
    pub(crate) vertex: u32,
    /// Index in the star of the triangle whose link edge starts here (of which this is `a`);
    /// [`NONE`] at the end of an open fan.
    pub(crate) outgoing: u32,
    /// Index in the star of the triangle whose link edge ends here (of which this is `b`); [`NONE`]
    /// at the beginning of an open fan.
    pub(crate) incoming: u32,
}

/// Collects the link of a vertex from its star, fan after fan.
pub(crate) fn collect_link(star: &[StarFace], link: &mut Vec<LinkVertex>) {
    link.clear();
    let mut fan_start = 0;
    for (i, face) in star.iter().enumerate() {
        let incoming = if i > fan_start { i as u32 - 1 } else { NONE };
        link.push(LinkVertex { vertex: face.a, outgoing: i as u32, incoming });
        let continues = star.get(i + 1).is_some_and(|next| next.a == face.b);
        if !continues {
            if face.b == star[fan_start].a {
                let first = link.len() - 1 - (i - fan_start);
                link[first].incoming = i as u32;
            } else {
                link.push(LinkVertex { vertex: face.b, outgoing: NONE, incoming: i as u32 });
            }
            fan_start = i + 1;
        }
    }
}

/// Returns whether a star is a single closed fan.
pub(crate) fn is_closed_fan(star: &[StarFace]) -> bool {
    let is_followed = |(i, face): (usize, &StarFace)| face.b == star[(i + 1) % star.len()].a;
    !star.is_empty() && star.iter().enumerate().all(is_followed)
}

/// Puts the triangles of a star in the order of its fans: open ones first, then closed ones.
pub(crate) fn arrange_in_fans(star: &mut [StarFace]) {
    star.sort_unstable_by_key(|face| Reverse(face.corner));
    let mut by_a: BTreeMap<u32, Vec<StarFace>> = BTreeMap::new();
    for &face in &*star {
        by_a.entry(face.a).or_default().push(face);
    }
    let ends: BTreeSet<u32> = star.iter().map(|face| face.b).collect();
    let starts: Vec<u32> = star.iter().rev().map(|face| face.a).collect();
    let open = starts.iter().filter(|a| !ends.contains(a));
    let mut next_slot = 0;
    for &start in open.chain(&starts) {
        let mut next = start;
        while let Some(face) = by_a.get_mut(&next).and_then(Vec::pop) {
            (next, star[next_slot]) = (face.b, face);
            next_slot += 1;
        }
    }
}
