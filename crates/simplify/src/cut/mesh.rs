//! The mesh while it is being simplified: groups, faces and stars (the faces around each group) in
//! flat arrays.
//!
//! Everything here is indexed by *group* (a wedge group), *face* (a triangle) or *wedge* (a
//! vertex), all numbered within one region. Groups of a region are neighbours in space, so they are
//! neighbours in memory.

use glam::{DVec3, Vec3, Vec4};
use prefetch_index::prefetch_index;

/// A corner of a face in the star of its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Corner {
    /// The group at the next corner of the face. Right in closed fans only.
    pub(crate) ahead: u32,
    /// `face << 2 | corner`.
    packed: u32,
}

impl Corner {
    #[inline]
    pub(crate) fn new(face: u32, corner: usize, ahead: u32) -> Self {
        Self { ahead, packed: face << 2 | corner as u32 }
    }

    #[inline]
    pub(crate) fn face(self) -> u32 {
        self.packed >> 2
    }

    /// The corner's index in its face: 0, 1 or 2.
    #[inline]
    pub(crate) fn at(self) -> usize {
        (self.packed & 3) as usize
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

/// A triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    /// The groups at its corners.
    pub(crate) groups: [u32; 3],
    /// Its triangle in the input.
    pub(crate) triangle: u32,
}

/// The plane of a face and the area in it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Facet {
    /// Unit normal; zero if the face has no area.
    pub(crate) normal: Vec3,
    /// In squared working units.
    pub(crate) area: f32,
}

impl Facet {
    /// The facet of a triangle given by its corners, counter-clockwise.
    #[inline]
    pub(crate) fn new([a, b, c]: [DVec3; 3]) -> Self {
        let n = (b - a).cross(c - a);
        let length = n.length();
        Self {
            normal: if length > 0.0 { (n / length).as_vec3() } else { Vec3::ZERO },
            area: (0.5 * length) as f32,
        }
    }
}

/// The range of a group's corners in the arena.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Star {
    pub(crate) start: u32,
    pub(crate) len: u32,
    pub(crate) capacity: u32,
}

/// The data of a group that neighbours read: four to a cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct GroupPosition {
    /// In working units.
    pub(crate) position: Vec3,
    /// The accumulated part of the cost of any collapse onto this group.
    pub(crate) target_cost: f32,
}

impl GroupPosition {
    /// Position and cost as one vector.
    #[inline]
    pub(crate) fn row(&self) -> Vec4 {
        self.position.extend(self.target_cost)
    }
}

/// The star is not a closed fan in counter-clockwise order: it may have borders, more than two
/// faces on an edge, or very many faces.
pub(crate) const OPEN: u8 = 1;
/// Some of the group's collapses were refused when they were last checked.
pub(crate) const RESTRICTED: u8 = 2;
/// An edge at this group is a seam: wedges or submeshes differ across it.
pub(crate) const SEAM: u8 = 4;
/// Another group was at the same position in the input.
pub(super) const SHARED_POSITION: u8 = 8;
/// A neighbour belongs to another region: the group stays where it is in this round.
pub(crate) const LOCKED: u8 = 16;
/// What the group's choice was ranked by has changed since.
pub(crate) const STALE: u8 = 32;
/// The group is a high-valence group: its star is large, and `star_slots` has the slots of its
/// faces in it.
pub(crate) const IS_HIGH_VALENCE: u8 = 64;
/// The group has moved onto another.
pub(crate) const DEAD: u8 = 128;

/// Stars with more faces than this are high-valence groups. Below, leaving a star is a scan of at
/// most eight cache lines; above, one collapse after another at a large fan would take quadratic
/// time. Chosen by hand: scans have no such stars, CAD and terrain around a pole do.
pub(crate) const HIGH_VALENCE: usize = 64;

/// Groups, faces and stars of one region.
#[derive(Default)]
pub(crate) struct WorkingMesh {
    pub(crate) group_positions: Vec<GroupPosition>,
    /// For each group the bits above, from [`OPEN`] to [`DEAD`].
    pub(crate) flags: Vec<u8>,
    pub(crate) faces: Vec<Face>,
    /// The wedge at each corner of each face; empty where every group has one wedge, with the
    /// group's number.
    pub(super) wedges: Vec<[u32; 3]>,
    /// Each group's position, as a number that groups there share; empty if no two share one.
    pub(super) position_id: Vec<u32>,
    /// The facet of each face, if they are kept instead of computed.
    facets: Vec<Facet>,
    pub(crate) stars: Vec<Star>,
    /// The corners of all stars, with unused room between them.
    pub(crate) arena: Vec<Corner>,
    /// For each corner of each face its slot (index) in the star of the group there, if that is a
    /// high-valence group; empty without high-valence groups.
    pub(crate) star_slots: Vec<[u32; 3]>,
    /// Rises whenever two high-valence groups may have come to share a face.
    pub(crate) high_valence_epoch: u32,
    /// A buffer for a star that is being put together.
    pub(crate) joined: Vec<Corner>,
    pub(crate) live_faces: u32,
}

impl WorkingMesh {
    /// Empties all lists, which keep their capacity.
    pub(super) fn clear(&mut self) {
        self.group_positions.clear();
        self.flags.clear();
        self.faces.clear();
        self.wedges.clear();
        self.position_id.clear();
        self.facets.clear();
        self.stars.clear();
        self.arena.clear();
        self.star_slots.clear();
        self.joined.clear();
        (self.high_valence_epoch, self.live_faces) = (0, 0);
    }

    #[inline]
    pub(crate) fn position(&self, group: u32) -> DVec3 {
        self.group_positions[group as usize].position.as_dvec3()
    }

    #[inline]
    pub(crate) fn has(&self, group: u32, flag: u8) -> bool {
        self.flags[group as usize] & flag != 0
    }

    #[inline]
    pub(crate) fn add_flags(&mut self, group: u32, flags: u8) {
        self.flags[group as usize] |= flags;
    }

    #[inline]
    pub(crate) fn clear_flags(&mut self, group: u32, flags: u8) {
        self.flags[group as usize] &= !flags;
    }

    /// The wedges at a face's corners.
    #[inline]
    pub(crate) fn wedges(&self, face: u32) -> [u32; 3] {
        match self.wedges.get(face as usize) {
            Some(&wedges) => wedges,
            None => self.faces[face as usize].groups,
        }
    }

    /// The wedges at a face's corners, from this one on.
    #[inline]
    pub(crate) fn wedges_from(&self, corner: Corner) -> [u32; 3] {
        let (wedges, at) = (self.wedges(corner.face()), corner.at());
        [wedges[at], wedges[next(at)], wedges[previous(at)]]
    }

    /// Puts another wedge at a corner.
    pub(crate) fn set_wedge(&mut self, corner: Corner, wedge: u32) {
        if let Some(wedges) = self.wedges.get_mut(corner.face() as usize) {
            wedges[corner.at()] = wedge;
        }
    }

    /// Returns whether every group has one wedge, with the group's number.
    pub(crate) fn one_wedge_each(&self) -> bool {
        self.wedges.is_empty()
    }

    /// The live corners at a group; in a closed fan counter-clockwise.
    #[inline]
    pub(crate) fn star(&self, group: u32) -> &[Corner] {
        let s = self.stars[group as usize];
        &self.arena[s.start as usize..(s.start + s.len) as usize]
    }

    /// Number of live corners at a group.
    #[inline]
    pub(crate) fn valence(&self, group: u32) -> usize {
        self.stars[group as usize].len as usize
    }

    /// The live faces, each once, in the order of the groups at their first corners.
    pub(crate) fn live(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.group_positions.len() as u32)
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
        if self.has(group, OPEN) {
            for &corner in self.star(group) {
                let [ahead, behind] = self.others(corner);
                visit(ahead);
                visit(behind);
            }
        } else {
            for corner in self.star(group) {
                visit(corner.ahead);
            }
        }
    }

    /// The neighbours of `from` that are other groups at the position of `to`, some of them twice.
    pub(crate) fn twins(&self, from: u32, to: u32) -> impl Iterator<Item = u32> + '_ {
        let star = if self.has(to, SHARED_POSITION) { self.star(from) } else { &[] };
        let position = |group: u32| self.position_id[group as usize];
        let others = star.iter().flat_map(|&corner| self.others(corner));
        others.filter(move |&g| g != to && position(g) == position(to))
    }

    /// Prefetches the corners of a group.
    #[inline]
    pub(super) fn prefetch_star(&self, group: u32) {
        let star = self.stars[group as usize];
        prefetch_index(&self.arena, star.start as usize);
        prefetch_index(&self.arena, (star.start + star.len.saturating_sub(1)) as usize);
    }

    /// Prefetches the faces of a group and the ranges of its neighbours' stars.
    #[inline]
    pub(crate) fn prefetch_neighbours(&self, group: u32) {
        for corner in self.star(group) {
            prefetch_index(&self.stars, corner.ahead as usize);
            prefetch_index(&self.faces, corner.face() as usize);
        }
    }

    /// Prefetches the faces at a group.
    #[inline]
    pub(super) fn prefetch_faces(&self, group: u32) {
        for corner in self.star(group) {
            prefetch_index(&self.faces, corner.face() as usize);
        }
    }

    /// A face's plane and area.
    #[inline]
    pub(crate) fn facet(&self, face: u32) -> Facet {
        match self.facets.get(face as usize) {
            Some(&facet) => facet,
            None => Facet::new(self.faces[face as usize].groups.map(|g| self.position(g))),
        }
    }

    /// A face's unit normal; zero if it has no area.
    #[inline]
    pub(crate) fn normal(&self, face: u32) -> Vec3 {
        self.facet(face).normal
    }

    /// Computes the facets of all faces and keeps them up to date from now on.
    pub(crate) fn keep_facets(&mut self) {
        self.facets.clear();
        self.facets = (0..self.faces.len() as u32).map(|f| self.facet(f)).collect();
    }

    /// Computes a face's facet anew, if facets are kept.
    #[inline]
    pub(crate) fn update_facet(&mut self, face: u32) {
        if !self.facets.is_empty() {
            let corners = self.faces[face as usize].groups.map(|g| self.position(g));
            self.facets[face as usize] = Facet::new(corners);
        }
    }

    /// The area of a face with its corners at these groups, in squared working units.
    pub(crate) fn area_of(&self, groups: [u32; 3]) -> f64 {
        let [a, b, c] = groups.map(|g| self.position(g));
        0.5 * (b - a).cross(c - a).length()
    }

    /// Makes a group a high-valence group.
    pub(crate) fn make_high_valence(&mut self, group: u32) {
        self.add_flags(group, IS_HIGH_VALENCE | OPEN);
        self.high_valence_epoch += 1;
        self.star_slots.resize(self.faces.len(), [0; 3]);
        self.number_slots(group, 0);
    }

    /// Writes the slots of a high-valence group's faces, from the slot `first` on.
    pub(crate) fn number_slots(&mut self, large: u32, first: usize) {
        let star = self.stars[large as usize];
        for slot in first as u32..star.len {
            let corner = self.arena[(star.start + slot) as usize];
            self.star_slots[corner.face() as usize][corner.at()] = slot;
        }
    }
}
