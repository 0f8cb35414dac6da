//! Sharing groups out anew: a region gathered from the regions of the round before.
//!
//! Gathering takes about as long as all pricing of a round, since each group and face has to be
//! found in an old region and given a number in the new one. Hash tables for that would be large
//! and miss the cache, so there are none where something else tells the number: an own group's is
//! its rank in the new order, and a face that is there already is in the (short) star of one of its
//! groups. Only groups of other regions, wedges, and faces at high-valence groups are
//! looked up in tables.

use super::mesh::{
    Corner, Face, HIGH_VALENCE, IS_HIGH_VALENCE, LOCKED, OPEN, RESTRICTED, SEAM, SHARED_POSITION,
    STALE, Star, next, previous,
};
use super::region::{Choice, Region, SLACK};
use super::table::Table;
use crate::number::Wedge;
use lodc_mesh::NONE;
use std::ops::Range;

/// The region of a group, and its number there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Home {
    pub(crate) region: u32,
    pub(crate) group: u32,
}

impl Home {
    /// The home of a group that is gone.
    pub(crate) const NONE: Self = Self { region: NONE, group: NONE };
}

/// Flags that a group takes along.
const KEPT_FLAGS: u8 = OPEN | SEAM | SHARED_POSITION | RESTRICTED;
/// Groups between the one that is added and the one that is prefetched. Gathering without
/// prefetching takes igea 1.1 to 1.2 of the time of the whole simplification; 16 was not tuned
/// further.
const PREFETCH_DISTANCE: usize = 16;

/// Which optional lists the regions of a mesh have: all of them, or none does.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RegionLists {
    /// There are no lists of wedges, since nothing about wedges is compared.
    bare: bool,
    one_wedge_each: bool,
    /// Positions are numbered, since groups may share them.
    shared: bool,
}

impl RegionLists {
    pub(crate) fn new(regions: &[Region]) -> Self {
        Self {
            bare: regions.iter().all(|r| r.wedges.is_bare()),
            one_wedge_each: regions.iter().all(|r| r.mesh.one_wedge_each()),
            shared: regions.iter().any(|r| !r.mesh.position_id.is_empty()),
        }
    }
}

/// The regions of a round, and where their groups are and go.
#[derive(Clone, Copy)]
pub(crate) struct Round<'a> {
    pub(crate) old: &'a [Region],
    pub(crate) lists: RegionLists,
    /// The home of each group of the whole mesh.
    pub(crate) homes: &'a [Home],
    /// The live groups in their new order.
    pub(crate) order: &'a [u32],
    /// The index of each live group in that order.
    pub(crate) ranks: &'a [u32],
}

impl Round<'_> {
    /// Gathers the region of consecutive groups of the new order into the lists of `recycled`,
    /// whose contents are dropped.
    pub(crate) fn gather(&self, range: Range<usize>, mut recycled: Region) -> Region {
        recycled.clear();
        let own_groups = range.len();
        let mut gathering = Gathering {
            round: *self,
            first: range.start as u32,
            own: own_groups as u32,
            new: recycled,
            // Shares here and in `reserve` are chosen by hand, rather too large: a square patch of
            // 12,288 groups has 450 neighbours beyond its border. Lists and tables grow if they are
            // too small.
            others: Table::new(own_groups / 4),
            high_valence_faces: Table::new(0),
            large_groups: Vec::new(),
            wedges: Table::new(if self.lists.bare { 0 } else { own_groups + own_groups / 4 }),
        };
        let order = &self.order[range];
        gathering.reserve(order);
        for (i, &group) in order.iter().enumerate() {
            if let Some(&upcoming) = order.get(i + PREFETCH_DISTANCE) {
                let (old, local) = gathering.home(upcoming);
                old.prefetch(local);
            }
            gathering.add_own(group);
        }
        for (group, i) in (0..own_groups as u32).zip(PREFETCH_DISTANCE / 2..) {
            if let Some(&upcoming) = order.get(i) {
                let (old, local) = gathering.home(upcoming);
                old.mesh.prefetch_faces(local);
            }
            gathering.add_star(group);
        }
        // Only now, since slots have to be numbered for all faces of the region.
        for large in std::mem::take(&mut gathering.large_groups) {
            gathering.new.mesh.make_high_valence(large);
        }
        gathering.point_choices();
        gathering.new
    }
}

/// A region that is being gathered.
struct Gathering<'a> {
    round: Round<'a>,
    /// The index of the first own group in the new order.
    first: u32,
    /// Number of own groups; they have the numbers below this.
    own: u32,
    new: Region,
    /// From the numbers of other regions' groups in the whole mesh to those in the new region.
    others: Table,
    /// From triangles at high-valence groups to faces of the new region.
    high_valence_faces: Table,
    /// Own groups that are high-valence groups.
    large_groups: Vec<u32>,
    /// From wedges' numbers in the whole mesh to those in the new region.
    wedges: Table,
}

impl<'a> Gathering<'a> {
    fn home(&self, group: u32) -> (&'a Region, u32) {
        let home = self.round.homes[group as usize];
        (&self.round.old[home.region as usize], home.group)
    }

    /// Reserves the lists: exactly for own groups and their stars, by estimate for other groups and
    /// for faces.
    fn reserve(&mut self, own_groups: &[u32]) {
        let corners: usize = own_groups
            .iter()
            .map(|&g| {
                let (old, local) = self.home(g);
                old.mesh.valence(local) + SLACK as usize
            })
            .sum();
        let (own_groups, all) = (own_groups.len(), own_groups.len() + own_groups.len() / 8);
        let Region { mesh, quadrics, choices, stamps, groups, .. } = &mut self.new;
        mesh.arena.reserve_exact(corners);
        mesh.faces.reserve(2 * all);
        mesh.group_positions.reserve(all);
        mesh.flags.reserve(all);
        mesh.stars.reserve(all);
        groups.reserve(all);
        quadrics.surface.reserve_exact(own_groups);
        choices.reserve_exact(own_groups);
        stamps.reserve_exact(own_groups);
    }

    /// The number of an own group of the new region; not below `own` for any other group.
    #[inline]
    fn own_number(&self, group: u32) -> u32 {
        self.round.ranks[group as usize].wrapping_sub(self.first)
    }

    /// Adds a group of the whole mesh as the next one of the region.
    fn add_group(&mut self, group: u32) -> u32 {
        let (old, local) = self.home(group);
        let number = self.new.groups.len() as u32;
        self.new.groups.push(group);
        let mesh = &mut self.new.mesh;
        mesh.group_positions.push(old.mesh.group_positions[local as usize]);
        mesh.flags.push(old.mesh.flags[local as usize] & KEPT_FLAGS);
        if self.round.lists.shared {
            mesh.position_id.push(old.mesh.position_id[local as usize]);
        }
        mesh.stars.push(Star::default());
        number
    }

    fn add_own(&mut self, group: u32) {
        let (old, local) = self.home(group);
        let number = self.add_group(group);
        let new = &mut self.new;
        new.quadrics.surface.push(old.quadrics.surface[local as usize]);
        new.moving.push_of(&old.moving, local);
        if !new.quadrics.border_of.is_empty() {
            new.quadrics.border_of.push(NONE);
        }
        if let Some(&border) = old.quadrics.border(local) {
            new.quadrics.set_border(number, border);
        }
        let choice = old.choices[local as usize];
        // Targets keep their number in the whole mesh until `point_choices`: some have none in this
        // region yet.
        let to = old.groups.get(choice.to as usize).copied().unwrap_or(NONE);
        new.choices.push(Choice { to, ..choice });
        new.stamps.push(old.stamps[local as usize]);
        if old.mesh.has(local, LOCKED | STALE) {
            new.mesh.add_flags(number, STALE);
        }
        if self.round.lists.bare {
            return;
        }
        let first = new.wedges.ids.len() as u32;
        for w in old.wedges.of_group(local) {
            let wedge = old.wedges.wedge(w);
            let number = new.wedges.push(wedge);
            self.wedges.get_or_insert(wedge.id, number);
        }
        new.wedges.push_group(first..new.wedges.ids.len() as u32);
    }

    fn add_star(&mut self, number: u32) {
        let (old, local) = self.home(self.new.groups[number as usize]);
        let star = old.mesh.star(local);
        let start = self.new.mesh.arena.len();
        self.new.mesh.stars[number as usize].start = start as u32;
        let mut locks = false;
        for &corner in star {
            let face = self.add_face(old, corner, number);
            let groups = &self.new.mesh.faces[face as usize].groups;
            locks |= groups.iter().any(|&g| g >= self.own);
            let ahead = groups[next(corner.at())];
            self.new.mesh.arena.push(Corner::new(face, corner.at(), ahead));
            self.new.mesh.stars[number as usize].len += 1;
        }
        let mesh = &mut self.new.mesh;
        let capacity = star.len() + SLACK as usize;
        mesh.arena.resize(start + capacity, Corner::new(0, 0, 0));
        mesh.stars[number as usize].capacity = capacity as u32;
        if old.mesh.has(local, IS_HIGH_VALENCE) {
            self.large_groups.push(number);
        }
        if locks {
            mesh.add_flags(number, LOCKED);
        }
    }

    /// The number of the face at a corner of an own group, which is added if it is new.
    #[inline]
    fn add_face(&mut self, old: &'a Region, corner: Corner, number: u32) -> u32 {
        let Face { groups, triangle } = old.mesh.faces[corner.face() as usize];
        let groups = groups.map(|g| old.groups[g as usize]);
        let numbers = groups.map(|g| self.own_number(g));
        // Own groups come in the order of their numbers, so a face was added with the first of its
        // own groups, and is in the stars of those up to this one.
        let known = [next(corner.at()), previous(corner.at()), corner.at()]
            .into_iter()
            .filter(|&at| numbers[at] <= number)
            .find_map(|at| self.face_at(numbers[at], at, triangle));
        known.unwrap_or_else(|| self.insert_face(old, corner.face(), Face { groups, triangle }))
    }

    /// The face of a triangle at a corner of an own group, if it has been added there.
    #[inline]
    fn face_at(&self, own: u32, at: usize, triangle: u32) -> Option<u32> {
        let mesh = &self.new.mesh;
        if mesh.valence(own) > HIGH_VALENCE {
            return self.high_valence_faces.get(triangle);
        }
        let mut faces = mesh.star(own).iter().filter(|c| c.at() == at).map(|c| c.face());
        faces.find(|&f| mesh.faces[f as usize].triangle == triangle)
    }

    /// Adds a face of an old region, `whole` by the numbers of the whole mesh.
    fn insert_face(&mut self, old: &'a Region, face: u32, whole: Face) -> u32 {
        let Face { groups, triangle } = whole;
        let number = self.new.mesh.faces.len() as u32;
        let groups = groups.map(|group| {
            let own = self.own_number(group);
            if own < self.own {
                return own;
            }
            let (other, known) = self.others.get_or_insert(group, self.new.groups.len() as u32);
            if !known {
                self.add_group(group);
            }
            other
        });
        if old.mesh.faces[face as usize].groups.iter().any(|&g| old.mesh.has(g, IS_HIGH_VALENCE)) {
            self.high_valence_faces.get_or_insert(triangle, number);
        }
        self.new.mesh.faces.push(Face { groups, triangle });
        self.new.mesh.live_faces += 1;
        if !self.round.lists.bare {
            let wedges = old.mesh.wedges(face).map(|w| self.add_wedge(old.wedges.wedge(w)));
            if !self.round.lists.one_wedge_each {
                self.new.mesh.wedges.push(wedges);
            }
        }
        number
    }

    fn add_wedge(&mut self, wedge: Wedge) -> u32 {
        let number = self.new.wedges.ids.len() as u32;
        let (number, known) = self.wedges.get_or_insert(wedge.id, number);
        if !known {
            self.new.wedges.push(wedge);
        }
        number
    }

    /// Gives the choices of own groups the region's numbers.
    fn point_choices(&mut self) {
        for (own, choice) in (0..).zip(&mut self.new.choices) {
            let to = match choice.to {
                NONE => None,
                to => Some(self.round.ranks[to as usize].wrapping_sub(self.first))
                    .filter(|&own| own < self.own)
                    .or_else(|| self.others.get(to)),
            };
            match to {
                Some(to) => choice.to = to,
                // No neighbour any more. A high-valence group is ranked only now and then, so its
                // choice may be old.
                _ => self.new.mesh.flags[own as usize] |= STALE,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Guidance, Options, simplify_with};

    #[test]
    fn hubs_go_from_region_to_region() {
        // Poles of hundreds of faces: more faces of a region are added after theirs.
        for mesh in [lodc_fixtures::uv_sphere(240, 6), lodc_fixtures::pole(300)] {
            for region in [24, 100] {
                let (simplified, _) = simplify_with(
                    &mesh,
                    &Options::DEFAULT,
                    Guidance::default(),
                    region,
                    &|_, _| {},
                );
                if let Err(broken) = lodc_fixtures::check_rules(&mesh, &simplified) {
                    panic!("regions of {region}: {broken}");
                }
            }
        }
    }
}
