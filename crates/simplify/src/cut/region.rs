//! A region: some groups of the mesh with everything that collapsing them needs, with numbers of
//! their own.
//!
//! A region's own groups come first. After them come the groups of other regions that share faces
//! with them: position and cost only. Own groups next to those are locked.

use super::in_motion::{InMotion, MovingQuadrics};
use super::mesh::{
    Corner, Face, GroupPosition, HIGH_VALENCE, LOCKED, OPEN, SEAM, SHARED_POSITION, Star,
    WorkingMesh, next, previous,
};
use super::neighbourhood::{Neighbourhood, PosedSurroundings, has_seams};
use super::quadrics::Quadrics;
use super::table::Table;
use super::wedges::Wedges;
use crate::number::{GroupShapes, Input, each_shape};
use lodc_mesh::NONE;
use prefetch_index::prefetch_index;
use std::ops::Range;

/// The best collapse of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    /// The cost as a key of the queue (`price::scaled`); NaN if there is no collapse.
    pub(crate) cost: f32,
    /// The group to move onto.
    pub(crate) to: u32,
}

impl Choice {
    /// No collapse at all.
    pub(crate) const NONE: Self = Self { cost: f32::NAN, to: NONE };
}

/// Part of the mesh, or all of it.
#[derive(Default)]
pub(crate) struct Region {
    pub(crate) mesh: WorkingMesh,
    pub(crate) wedges: Wedges,
    pub(crate) quadrics: Quadrics,
    /// Accumulated quadrics in other shapes than at rest.
    pub(crate) moving: MovingQuadrics,
    /// The best collapse of each own group.
    pub(crate) choices: Vec<Choice>,
    /// The greatest cost of any collapse so far that touched each own group.
    pub(crate) stamps: Vec<f32>,
    /// The number of each group in the whole mesh: own groups, then those of other regions.
    pub(crate) groups: Vec<u32>,
}

/// Spare corners of each star in the arena: where both groups have six faces, a collapse makes the
/// target's star larger by two.
pub(super) const SLACK: u32 = 2;

impl Region {
    /// The region of consecutive groups, given all triangles with a corner at one of them. `bare`
    /// says that wedges are not listed, as nothing about them is compared.
    pub(crate) fn new(
        input: &Input<'_>,
        range: Range<u32>,
        triangles: impl ExactSizeIterator<Item = u32>,
        bare: bool,
    ) -> Self {
        let own = range.len();
        let mut region = Self { groups: range.clone().collect(), ..Self::default() };
        let mut others = Table::new(own / 4);
        if !bare {
            for wedge in input.wedges_of(range.clone()) {
                region.wedges.push(input.wedge(wedge));
            }
            let first = input.wedges_of(range.start..range.start).start;
            for g in range.clone() {
                let wedges = input.wedges_of(g..g + 1);
                region.wedges.push_group(wedges.start - first..wedges.end - first);
            }
        }
        let mut other_wedges = Table::new(own / 4);
        region.mesh.faces.reserve_exact(triangles.len());
        for triangle in triangles {
            let vertices = input.mesh.triangles()[triangle as usize];
            let groups = vertices.map(|v| {
                let g = input.group_of[v as usize];
                if range.contains(&g) {
                    return g - range.start;
                }
                let (local, known) = others.get_or_insert(g, region.groups.len() as u32);
                if !known {
                    region.groups.push(g);
                }
                local
            });
            region.mesh.faces.push(Face { groups, triangle });
            if !bare {
                let wedges = vertices.map(|v| {
                    region.local_wedge(
                        input,
                        input.wedge_of()[v as usize],
                        &range,
                        &mut other_wedges,
                    )
                });
                if !input.one_wedge_each() {
                    region.mesh.wedges.push(wedges);
                }
            }
        }
        region.set_positions(input);
        region.build_stars(own);
        region.quadrics = Quadrics::new(&region.mesh, own);
        let first = input.planes.partition_point(|p| p.group < range.start);
        for p in input.planes[first..].iter().take_while(|p| p.group < range.end) {
            let quadric = &mut region.quadrics.surface[(p.group - range.start) as usize];
            quadric.add_plane(p.unit_normal, p.area);
        }
        region.classify(input, own);
        region.accumulate_in_motion(&input.shapes, own as u32);
        region.choices = vec![Choice::NONE; own];
        region.stamps = vec![0.0; own];
        region
    }

    /// The whole mesh as one region.
    pub(crate) fn whole(input: &Input<'_>, bare: bool) -> Self {
        let triangles = 0..input.mesh.triangles().len() as u32;
        Self::new(input, 0..input.groups() as u32, triangles, bare)
    }

    /// Empties all lists, which keep their capacity.
    pub(super) fn clear(&mut self) {
        self.mesh.clear();
        self.wedges.clear();
        self.quadrics.clear();
        self.moving.clear();
        self.choices.clear();
        self.stamps.clear();
        self.groups.clear();
    }

    /// What pricing reads of the region in motion; none if it has one shape only.
    #[inline]
    pub(crate) fn in_motion<'a>(&'a self, shapes: &'a GroupShapes) -> Option<InMotion<'a>> {
        let Self { mesh, quadrics, moving, groups, .. } = self;
        (!moving.is_empty()).then_some(InMotion { shapes, mesh, quadrics, moving, groups })
    }

    /// Adds the quadrics in motion of `from` to those of `to`, before those at rest are added.
    pub(crate) fn merge_in_motion(&mut self, shapes: &GroupShapes, from: u32, to: u32) {
        let mut merged = self.moving.take_buffer();
        let Some(view) = self.in_motion(shapes) else { return };
        let set = self.moving.set(from) | self.moving.set(to);
        merged.extend(each_shape(set).map(|shape| view.merged(from, to, shape)));
        self.moving.replace(to, from, set, merged);
    }

    /// Sums up the quadrics in motion of the own groups, of which the first `own` are, over the
    /// input's faces and borders.
    pub(super) fn accumulate_in_motion(&mut self, shapes: &GroupShapes, own: u32) {
        if shapes.is_empty() {
            return;
        }
        let (mut moving, none) = (MovingQuadrics::default(), MovingQuadrics::default());
        let (mut around, mut posed) = (Neighbourhood::default(), PosedSurroundings::default());
        let Self { mesh, wedges, quadrics, groups, .. } = &*self;
        let view = InMotion { shapes, mesh, quadrics, moving: &none, groups };
        for group in 0..own {
            let set = view.around(group);
            let row = moving.push(set);
            if set == 0 {
                continue;
            }
            around.gather(mesh, wedges, group);
            for (shape, quadric) in each_shape(set).zip(row) {
                let position = |g: u32| view.position(g, shape).as_dvec3();
                around.pose(mesh, wedges, group, position, &mut posed);
                posed.facets.iter().for_each(|facet| quadric.add_facet(facet));
                if around.borders > 0 {
                    posed.planes.iter().for_each(|p| quadric.add_plane(p.normal, p.weight));
                }
            }
        }
        self.moving = moving;
    }

    /// Number of own groups.
    pub(crate) fn own_groups(&self) -> usize {
        self.choices.len()
    }

    /// Prefetches the quadric and the corners of a group that is about to be priced.
    #[inline]
    pub(crate) fn prefetch(&self, group: u32) {
        self.mesh.prefetch_star(group);
        prefetch_index(&self.quadrics.surface, group as usize);
        prefetch_index(&self.quadrics.surface, group as usize + 1);
    }

    /// The number of a wedge in the whole mesh.
    #[inline]
    pub(crate) fn wedge_id(&self, wedge: u32) -> u32 {
        let ids = if self.wedges.is_bare() { &self.groups } else { &self.wedges.ids };
        ids[wedge as usize]
    }

    fn local_wedge(
        &mut self,
        input: &Input<'_>,
        wedge: u32,
        range: &Range<u32>,
        others: &mut Table,
    ) -> u32 {
        let own = input.wedges_of(range.clone());
        if own.contains(&wedge) {
            return wedge - own.start;
        }
        let (local, known) = others.get_or_insert(wedge, self.wedges.ids.len() as u32);
        if !known {
            self.wedges.push(input.wedge(wedge));
        }
        local
    }

    fn set_positions(&mut self, input: &Input<'_>) {
        let mesh = &mut self.mesh;
        let position =
            |g: u32| GroupPosition { position: input.group_position(g), target_cost: 0.0 };
        mesh.group_positions = self.groups.iter().map(|&g| position(g)).collect();
        let flag = |g: u32| if input.shares_position(g) { SHARED_POSITION } else { 0 };
        mesh.flags = self.groups.iter().map(|&g| flag(g)).collect();
        if !input.position_id.is_empty() {
            mesh.position_id = self.groups.iter().map(|&g| input.position_id[g as usize]).collect();
        }
    }

    /// Sorts the faces' corners into the stars of the own groups.
    fn build_stars(&mut self, own: usize) {
        let mesh = &mut self.mesh;
        mesh.stars = vec![Star::default(); self.groups.len()];
        for &g in mesh.faces.iter().flat_map(|f| &f.groups).filter(|&&g| (g as usize) < own) {
            mesh.stars[g as usize].capacity += 1;
        }
        let mut start = 0;
        for s in &mut mesh.stars[..own] {
            s.start = start;
            s.capacity += SLACK;
            start += s.capacity;
        }
        // Half as much again for stars that outgrow their room. Chosen by hand; an arena that is
        // full grows by an eighth (`commit::merge`).
        mesh.arena = Vec::with_capacity(start as usize + start as usize / 2);
        mesh.arena.resize(start as usize, Corner::new(0, 0, 0));
        for (f, face) in (0..).zip(&mesh.faces) {
            let locks = face.groups.iter().any(|&g| g as usize >= own);
            for (c, &g) in face.groups.iter().enumerate().filter(|(_, g)| (**g as usize) < own) {
                let s = &mut mesh.stars[g as usize];
                mesh.arena[(s.start + s.len) as usize] = Corner::new(f, c, face.groups[next(c)]);
                s.len += 1;
                if locks {
                    mesh.flags[g as usize] |= LOCKED;
                }
            }
        }
        mesh.live_faces = mesh.faces.len() as u32;
    }

    /// Puts closed fans in order, flags groups with another star as open and groups on seams, and
    /// gives groups at borders their quadrics.
    fn classify(&mut self, input: &Input<'_>, own: usize) {
        let mut around = Neighbourhood::default();
        let mut fan = Vec::new();
        for g in 0..own as u32 {
            let star = self.mesh.stars[g as usize];
            if star.len as usize > HIGH_VALENCE {
                self.mesh.make_high_valence(g);
            } else if !put_in_order(&mut self.mesh, star, &mut fan) {
                self.mesh.add_flags(g, OPEN);
            }
            let seams = if self.mesh.has(g, OPEN) {
                around.gather(&self.mesh, &self.wedges, g);
                self.quadrics.add_border(g, &around);
                around.seams > 0
            } else {
                input.may_have_seams() && has_seams(&self.mesh, &self.wedges, g)
            };
            if seams {
                self.mesh.add_flags(g, SEAM);
            }
        }
    }
}

/// Puts a star into counter-clockwise order if it is a closed fan; false if it is not.
fn put_in_order(mesh: &mut WorkingMesh, star: Star, fan: &mut Vec<(Corner, u32)>) -> bool {
    let range = star.start as usize..(star.start + star.len) as usize;
    let behind = |c: Corner| mesh.faces[c.face() as usize].groups[previous(c.at())];
    fan.clear();
    fan.extend(mesh.arena[range.clone()].iter().map(|&c| (c, behind(c))));
    for i in 0..fan.len() {
        if fan[..i].iter().any(|f| f.0.ahead == fan[i].0.ahead) {
            return false;
        }
        let after = fan[i].1;
        if i + 1 == fan.len() {
            let is_closed = i > 0 && after == fan[0].0.ahead;
            if is_closed {
                for (slot, (corner, _)) in mesh.arena[range].iter_mut().zip(&*fan) {
                    *slot = *corner;
                }
            }
            return is_closed;
        }
        match (i + 1..fan.len()).find(|&j| fan[j].0.ahead == after) {
            Some(j) => fan.swap(i + 1, j),
            None => return false,
        }
    }
    false
}
