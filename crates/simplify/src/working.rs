//! The mesh while it is being simplified: groups, faces and stars in flat arrays.
//!
//! Everything here is indexed by *group* (a wedge group), *face* (a triangle of the input) or
//! *wedge* (a vertex). Groups are numbered along a space-filling curve, so neighbours in space are
//! neighbours in memory.

use glam::{DVec3, Vec3};

/// A collapse with more dying faces than this takes them out of each star in one pass.
const FEW: usize = 16;

/// A corner of a face: `face << 2 | corner`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Corner(pub(crate) u32);

impl Corner {
    #[inline]
    pub(crate) fn new(face: u32, corner: usize) -> Self {
        Self(face << 2 | corner as u32)
    }
    #[inline]
    pub(crate) fn face(self) -> u32 {
        self.0 >> 2
    }
    /// Which corner of the face: 0, 1 or 2.
    #[inline]
    pub(crate) fn at(self) -> usize {
        (self.0 & 3) as usize
    }
}

/// The corner after `c`, counter-clockwise.
#[inline]
pub(crate) fn next(c: usize) -> usize {
    if c == 2 { 0 } else { c + 1 }
}

/// The corner before `c`.
#[inline]
pub(crate) fn previous(c: usize) -> usize {
    if c == 0 { 2 } else { c - 1 }
}

/// A triangle, half a cache line: what ranking reads of it lies together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    /// The groups at its corners.
    pub(crate) groups: [u32; 3],
    /// Unit normal; zero if the face has no area.
    pub(crate) normal: Vec3,
    /// Area, in squared working units.
    pub(crate) area: f32,
    /// Its triangle in the input.
    pub(crate) triangle: u32,
}

/// Where a group's corners lie in the arena.
#[derive(Clone, Copy, Debug, Default)]
struct Star {
    start: u32,
    len: u32,
    capacity: u32,
}

/// What neighbours read of a group: four to a cache line.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Place {
    /// In working units.
    pub(crate) position: Vec3,
    /// What the metric wants to find here: its price for arriving at this group.
    pub(crate) arrival: f32,
}

/// The star is not a closed fan: it may have borders or more than two faces on an edge.
pub(crate) const OPEN: u8 = 1;
/// Some of the group's collapses were refused the last time it was looked at.
pub(crate) const RESTRICTED: u8 = 2;
/// An edge at this group is a seam: wedges or submeshes differ across it.
pub(crate) const SEAM: u8 = 4;
/// Another group started at the same position.
pub(crate) const SHARED_POSITION: u8 = 8;

pub(crate) struct Working {
    pub(crate) places: Vec<Place>,
    pub(crate) flags: Vec<u8>,
    pub(crate) faces: Vec<Face>,
    /// The wedge at each corner of each face; empty where every group has one wedge, with the
    /// group's number.
    wedges: Vec<[u32; 3]>,
    /// Each group's position, as a number shared by the groups there.
    pub(crate) position_id: Vec<u32>,
    stars: Vec<Star>,
    arena: Vec<Corner>,
    pub(crate) live_faces: u32,
}

impl Working {
    /// Builds the stars of all groups.
    pub(crate) fn new(
        places: Vec<Place>,
        flags: Vec<u8>,
        faces: Vec<Face>,
        wedges: Vec<[u32; 3]>,
        position_id: Vec<u32>,
    ) -> Self {
        let mut stars = vec![Star::default(); places.len()];
        for f in &faces {
            for &g in &f.groups {
                stars[g as usize].capacity += 1;
            }
        }
        let mut start = 0;
        for s in &mut stars {
            s.start = start;
            start += s.capacity;
        }
        let mut arena = vec![Corner(0); start as usize];
        for (f, face) in (0..).zip(&faces) {
            for (c, &g) in face.groups.iter().enumerate() {
                let s = &mut stars[g as usize];
                arena[(s.start + s.len) as usize] = Corner::new(f, c);
                s.len += 1;
            }
        }
        let live_faces = faces.len() as u32;
        Self { places, flags, faces, wedges, position_id, stars, arena, live_faces }
    }

    #[inline]
    pub(crate) fn position(&self, group: u32) -> DVec3 {
        self.places[group as usize].position.as_dvec3()
    }

    #[inline]
    pub(crate) fn has(&self, group: u32, flag: u8) -> bool {
        self.flags[group as usize] & flag != 0
    }

    #[inline]
    pub(crate) fn add_flags(&mut self, group: u32, flags: u8) {
        self.flags[group as usize] |= flags;
    }

    /// The wedges at a face's corners.
    #[inline]
    pub(crate) fn wedges(&self, face: u32) -> [u32; 3] {
        match self.wedges.get(face as usize) {
            Some(&wedges) => wedges,
            None => self.faces[face as usize].groups,
        }
    }

    /// Puts another wedge at a corner.
    pub(crate) fn set_wedge(&mut self, corner: Corner, wedge: u32) {
        if let Some(wedges) = self.wedges.get_mut(corner.face() as usize) {
            wedges[corner.at()] = wedge;
        }
    }

    /// Whether every group has one wedge, with the group's number.
    pub(crate) fn one_wedge_each(&self) -> bool {
        self.wedges.is_empty()
    }

    /// The live corners at a group.
    #[inline]
    pub(crate) fn star(&self, group: u32) -> &[Corner] {
        let s = self.stars[group as usize];
        &self.arena[s.start as usize..(s.start + s.len) as usize]
    }

    /// The live faces, each once, in the order of the groups at their first corners.
    pub(crate) fn live(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.places.len() as u32)
            .flat_map(|g| self.star(g))
            .filter(|c| c.at() == 0)
            .map(|c| c.face())
    }

    /// The groups at a face's other two corners.
    #[inline]
    pub(crate) fn others(&self, corner: Corner) -> [u32; 2] {
        let groups = &self.faces[corner.face() as usize].groups;
        [groups[next(corner.at())], groups[previous(corner.at())]]
    }

    /// Visits the groups next to a group, each once if its star is a closed fan, else some of them
    /// twice.
    #[inline]
    pub(crate) fn each_neighbour(&self, group: u32, mut visit: impl FnMut(u32)) {
        // In a closed fan every neighbour is the next corner of exactly one face.
        let open = self.has(group, OPEN);
        for &corner in self.star(group) {
            let [ahead, behind] = self.others(corner);
            visit(ahead);
            if open {
                visit(behind);
            }
        }
    }

    /// The face with its normal and area as its corners' positions give them.
    pub(crate) fn set_plane(&mut self, face: u32) {
        let [a, b, c] = self.faces[face as usize].groups.map(|g| self.position(g));
        let n = (b - a).cross(c - a);
        let length = n.length();
        let f = &mut self.faces[face as usize];
        f.normal = if length > 0.0 { (n / length).as_vec3() } else { Vec3::ZERO };
        f.area = (0.5 * length) as f32;
    }

    /// The area of a face with its corners at these groups, in squared working units.
    pub(crate) fn area_of(&self, groups: [u32; 3]) -> f64 {
        let [a, b, c] = groups.map(|g| self.position(g));
        0.5 * (b - a).cross(c - a).length()
    }

    /// Moves all of `from`'s faces to `to`. Faces that lose a corner die: they leave every star,
    /// and `died` is told their triangles. Faces that live get new planes.
    pub(crate) fn merge(&mut self, from: u32, to: u32, mut died: impl FnMut(u32)) {
        let from_star = std::mem::take(&mut self.stars[from as usize]);
        let incoming = from_star.start as usize..(from_star.start + from_star.len) as usize;
        // Dead faces go first, so that the star of `to` has room for the others.
        let mut kept = incoming.start;
        let mut dead = 0;
        for i in incoming.clone() {
            let corner = self.arena[i];
            if self.others(corner).contains(&to) {
                dead += 1;
            } else {
                // The dead gather behind the living.
                self.arena.swap(i, kept);
                kept += 1;
            }
        }
        for i in kept..incoming.end {
            let corner = self.arena[i];
            self.live_faces -= 1;
            died(self.faces[corner.face() as usize].triangle);
            if dead <= FEW {
                for g in self.others(corner) {
                    self.leave(g, corner.face());
                }
            }
        }
        if dead > FEW {
            self.leave_all(kept..incoming.end);
        }
        let moved = from_star.start as usize..kept;
        for i in moved.clone() {
            let corner = self.arena[i];
            self.faces[corner.face() as usize].groups[corner.at()] = to;
            self.set_plane(corner.face());
        }
        self.join(from_star, moved, to);
    }

    /// Appends corners to the star of `to`, in `from`'s room, its own, or new room.
    fn join(&mut self, from: Star, moved: std::ops::Range<usize>, to: u32) {
        let mut star = self.stars[to as usize];
        let len = star.len + moved.len() as u32;
        if len > star.capacity {
            let old = star.start as usize..(star.start + star.len) as usize;
            if len <= from.capacity {
                let at = moved.end;
                let shift = moved.start;
                debug_assert_eq!(shift, from.start as usize);
                self.arena.copy_within(old, at);
                self.stars[to as usize] = Star { start: from.start, len, capacity: from.capacity };
                return;
            }
            star.capacity = len + len / 2;
            star.start = self.arena.len() as u32;
            self.arena.extend_from_within(old);
            self.arena.resize(star.start as usize + star.capacity as usize, Corner(0));
        }
        self.arena.copy_within(moved, (star.start + star.len) as usize);
        star.len = len;
        self.stars[to as usize] = star;
    }

    /// Takes many faces, given by one corner each, out of the stars at their other corners: one
    /// pass over each star.
    fn leave_all(&mut self, corners: std::ops::Range<usize>) {
        let mut groups: Vec<u32> =
            corners.clone().flat_map(|i| self.others(self.arena[i])).collect();
        groups.sort_unstable();
        groups.dedup();
        let mut dead: Vec<u32> = corners.map(|i| self.arena[i].face()).collect();
        dead.sort_unstable();
        for g in groups {
            let s = self.stars[g as usize];
            let mut len = 0;
            for i in s.start..s.start + s.len {
                let corner = self.arena[i as usize];
                if dead.binary_search(&corner.face()).is_err() {
                    self.arena[(s.start + len) as usize] = corner;
                    len += 1;
                }
            }
            self.stars[g as usize].len = len;
        }
    }

    fn leave(&mut self, group: u32, face: u32) {
        let s = &mut self.stars[group as usize];
        let star = &mut self.arena[s.start as usize..(s.start + s.len) as usize];
        if let Some(i) = star.iter().position(|c| c.face() == face) {
            star.swap(i, s.len as usize - 1);
            s.len -= 1;
        }
    }
}
