//! Sharing groups out anew: a region gathered from the regions of the round before.

use crate::choice::Choice;
use crate::region::Region;
use crate::table::Table;
use crate::wedges::Wedge;
use crate::working::{
    Corner, Face, IS_HUB, LOCKED, OPEN, RESTRICTED, SEAM, SHARED_POSITION, STALE, Star, next,
};
use lodc_mesh::NONE;

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
/// Spare room in each star.
const SLACK: u32 = 2;

/// Lists that all regions of a mesh keep, or none does.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kept {
    bare: bool,
    one_wedge_each: bool,
    /// True if groups may share positions.
    shared: bool,
}

impl Kept {
    pub(crate) fn new(regions: &[Region]) -> Self {
        Self {
            bare: regions.iter().all(|r| r.wedges.is_bare()),
            one_wedge_each: regions.iter().all(|r| r.mesh.one_wedge_each()),
            shared: regions.iter().any(|r| !r.mesh.position_id.is_empty()),
        }
    }
}

/// Gathers the region of some live groups, given by their numbers in the whole mesh.
pub(crate) fn gather(old: &[Region], kept: Kept, homes: &[Home], members: &[u32]) -> Region {
    let mut gathering = Gathering {
        old,
        homes,
        new: Region::default(),
        groups: Table::new(members.len() + members.len() / 4),
        faces: Table::new(2 * members.len() + members.len() / 4),
        wedges: Table::new(members.len() + members.len() / 4),
        kept,
    };
    for &g in members {
        gathering.add_own(g);
    }
    for own in 0..members.len() as u32 {
        gathering.add_star(own);
    }
    gathering.point_choices();
    gathering.new
}

/// A region that is being gathered.
struct Gathering<'a> {
    old: &'a [Region],
    homes: &'a [Home],
    new: Region,
    /// From numbers in the whole mesh to those in the new region.
    groups: Table,
    faces: Table,
    wedges: Table,
    kept: Kept,
}

impl<'a> Gathering<'a> {
    fn home(&self, group: u32) -> (&'a Region, u32) {
        let home = self.homes[group as usize];
        (&self.old[home.region as usize], home.group)
    }

    /// Adds a group of the whole mesh as the next one of the region.
    fn add_group(&mut self, group: u32) -> u32 {
        let (old, local) = self.home(group);
        let number = self.new.groups.len() as u32;
        self.new.groups.push(group);
        let mesh = &mut self.new.mesh;
        mesh.places.push(old.mesh.places[local as usize]);
        mesh.flags.push(old.mesh.flags[local as usize] & KEPT_FLAGS);
        if self.kept.shared {
            mesh.position_id.push(old.mesh.position_id[local as usize]);
        }
        mesh.stars.push(Star::default());
        number
    }

    fn add_own(&mut self, group: u32) {
        let (old, local) = self.home(group);
        let number = self.add_group(group);
        self.groups.get_or_insert(group, number);
        let new = &mut self.new;
        new.quadrics.surface.push(old.quadrics.surface[local as usize]);
        if !new.quadrics.border_of.is_empty() {
            new.quadrics.border_of.push(NONE);
        }
        if let Some(&border) = old.quadrics.border(local) {
            new.quadrics.set_border(number, border);
        }
        let choice = old.choices[local as usize];
        // The target's number is that of the whole mesh until all are known.
        let to = old.groups.get(choice.to as usize).copied().unwrap_or(NONE);
        new.choices.push(Choice { to, ..choice });
        new.stamps.push(old.stamps[local as usize]);
        if old.mesh.has(local, LOCKED | STALE) {
            new.mesh.add_flags(number, STALE);
        }
        if self.kept.bare {
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

    fn add_star(&mut self, own: u32) {
        let (old, local) = self.home(self.new.groups[own as usize]);
        let star = old.mesh.star(local);
        let start = self.new.mesh.arena.len();
        let count = self.new.choices.len() as u32;
        let mut locks = false;
        for &corner in star {
            let face = self.add_face(old, corner.face());
            let groups = &self.new.mesh.faces[face as usize].groups;
            locks |= groups.iter().any(|&g| g >= count);
            let ahead = groups[next(corner.at())];
            self.new.mesh.arena.push(Corner::new(face, corner.at(), ahead));
        }
        let mesh = &mut self.new.mesh;
        let len = star.len() as u32;
        mesh.arena.resize(start + (len + SLACK) as usize, Corner::new(0, 0, 0));
        mesh.stars[own as usize] = Star { start: start as u32, len, capacity: len + SLACK };
        if old.mesh.has(local, IS_HUB) {
            mesh.make_hub(own);
        }
        if locks {
            mesh.add_flags(own, LOCKED);
        }
    }

    /// The number of an old region's face, which is added if it is new.
    fn add_face(&mut self, old: &'a Region, face: u32) -> u32 {
        let Face { groups, triangle } = old.mesh.faces[face as usize];
        let number = self.new.mesh.faces.len() as u32;
        let (number, known) = self.faces.get_or_insert(triangle, number);
        if known {
            return number;
        }
        let groups = groups.map(|g| {
            let group = old.groups[g as usize];
            let (number, known) = self.groups.get_or_insert(group, self.new.groups.len() as u32);
            if !known {
                self.add_group(group);
            }
            number
        });
        self.new.mesh.faces.push(Face { groups, triangle });
        self.new.mesh.live_faces += 1;
        if !self.kept.bare {
            let wedges = old.mesh.wedges(face).map(|w| self.add_wedge(old.wedges.wedge(w)));
            if !self.kept.one_wedge_each {
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
            match self.groups.get(choice.to) {
                Some(to) if choice.to != NONE => choice.to = to,
                // A neighbour no more: what a hub has not noticed yet.
                _ => self.new.mesh.flags[own as usize] |= STALE,
            }
        }
    }
}
