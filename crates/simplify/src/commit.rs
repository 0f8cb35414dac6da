//! Committing one collapse: records, wedges, faces, groups that have come to share a position.

use crate::engine::{Engine, Serial};
use crate::legality::Stage;
use crate::metric::Metric;
use crate::plan::Plan;
use crate::working::{OPEN, SEAM, SHARED_POSITION, Working};
use lodc_mesh::Lod;

impl<M: Metric> Engine<'_, M> {
    /// Moves `from` onto `to` and writes it down. Leaves in `serial.stale` the groups whose faces
    /// changed.
    pub(crate) fn commit(
        &mut self,
        from: u32,
        to: u32,
        changes_topology: bool,
        serial: &mut Serial<M::ViewScratch>,
    ) {
        serial.epoch += 1;
        serial.stale.clear();
        serial.first_time(from);
        serial.first_time(to);
        serial.stale.push(to);
        self.mesh.each_neighbour(from, |g| {
            if serial.first_time(g) {
                serial.stale.push(g);
            }
        });
        self.plan(from, to, &mut serial.plan);
        let seam_moves = serial.plan.ambiguous || serial.plan.fakes > 0;
        self.move_wedges(from, to, &mut serial.plan);
        let lod = self.log.order.len() as u32;

        self.set_restricted(from, false);
        self.metric.collapsed(&mut self.mesh, &self.wedges, from, to);
        let death = &mut self.log.death;
        self.mesh.merge(from, to, |triangle| death[triangle as usize] = lod);
        let inherited = self.mesh.flags[from as usize] & (OPEN | SEAM);
        self.mesh.add_flags(to, inherited);
        if changes_topology || seam_moves {
            let flags = if changes_topology { OPEN } else { 0 } | if seam_moves { SEAM } else { 0 };
            self.mesh.add_flags(to, flags);
            for &g in &serial.stale {
                self.mesh.add_flags(g, flags);
            }
        }
        if self.mesh.has(to, SHARED_POSITION) {
            self.unite_position(to, lod, serial);
        }
        let error = self.metric.error(to).max(self.log.step_errors.last().copied().unwrap_or(0.0));
        self.log.step_ends.push(lod);
        self.log.step_errors.push(error);
        self.log.step_triangles.push(self.mesh.live_faces);
        if changes_topology && self.stage == Stage::Legal {
            self.log.topology_changes += 1;
            self.log.first_topology_change.get_or_insert(Lod(lod));
        }
    }

    /// Two corners of one triangle at one position: their groups are one group from now on.
    fn unite_position(&mut self, to: u32, lod: u32, serial: &mut Serial<M::ViewScratch>) {
        let position = self.mesh.position_id[to as usize];
        let twin = |mesh: &Working| {
            mesh.star(to).iter().find_map(|&corner| {
                let groups = mesh.faces[corner.face() as usize].groups;
                groups.into_iter().find(|&g| g != to && mesh.position_id[g as usize] == position)
            })
        };
        while let Some(other) = twin(&self.mesh) {
            for i in 0..self.mesh.star(other).len() {
                for g in self.mesh.faces[self.mesh.star(other)[i].face() as usize].groups {
                    self.mesh.add_flags(g, OPEN | SEAM);
                    if serial.first_time(g) {
                        serial.stale.push(g);
                    }
                }
            }
            self.metric.collapsed(&mut self.mesh, &self.wedges, other, to);
            let death = &mut self.log.death;
            self.mesh.merge(other, to, |triangle| death[triangle as usize] = lod);
            self.wedges.merge_groups(other, to);
            self.mesh.add_flags(to, OPEN | SEAM);
        }
    }

    /// Emits the records of a planned collapse and gives the faces their new wedges.
    fn move_wedges(&mut self, from: u32, to: u32, plan: &mut Plan) {
        // Fakes come last: they take their place from the true edge's target.
        for p in plan.wedges.iter().filter(|p| p.target != u32::MAX) {
            self.log.order.push(p.wedge);
            self.log.targets.push(p.target);
        }
        for i in 0..plan.wedges.len() {
            let wedge = plan.wedges[i].wedge;
            if plan.wedges[i].target != u32::MAX {
                continue;
            }
            // Two wedges that look alike share one fake.
            let mut earlier = plan.wedges[..i].iter().filter(|p| p.fake).take(64);
            let target = match earlier.find(|p| self.wedges.alike(self.input, p.wedge, wedge)) {
                Some(p) => p.target,
                None => self.wedges.add_fake(to, plan.truth, wedge),
            };
            plan.wedges[i].target = target;
            plan.wedges[i].fake = true;
            self.log.order.push(wedge);
            self.log.targets.push(target);
        }
        let corners = if self.mesh.one_wedge_each() { 0 } else { self.mesh.star(from).len() };
        for i in 0..corners {
            let corner = self.mesh.star(from)[i];
            let old = self.mesh.wedges(corner.face())[corner.at()];
            if let Ok(p) = plan.wedges.binary_search_by_key(&old, |p| p.wedge) {
                self.mesh.set_wedge(corner, plan.wedges[p].target);
            }
        }
        self.wedges.clear_group(from);
    }

    /// Joins the points that are left without faces: those of one submesh first, all of them onto
    /// the last one, so that none passes through another.
    pub(crate) fn join_points(&mut self) {
        let mut left: Vec<(u32, u32)> = (0..self.mesh.places.len() as u32)
            .filter_map(|g| {
                self.wedges.of_group(g).next().map(|w| (self.wedges.submesh[w as usize], g))
            })
            .collect();
        left.sort_unstable();
        let Some(survivor) = left.last().and_then(|&(_, g)| self.wedges.of_group(g).last()) else {
            return;
        };
        let error = self.log.step_errors.last().copied().unwrap_or(0.0);
        for &(_, g) in &left {
            let before = self.log.order.len();
            for wedge in self.wedges.of_group(g).filter(|&w| w != survivor) {
                self.log.order.push(wedge);
                self.log.targets.push(survivor);
            }
            if self.log.order.len() > before {
                self.log.step_ends.push(self.log.order.len() as u32);
                self.log.step_errors.push(error);
                self.log.step_triangles.push(0);
            }
        }
        self.log.order.push(survivor);
    }
}
