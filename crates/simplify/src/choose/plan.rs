//! Decides for every wedge of a group that collapses which wedge of the target it becomes: the one
//! along the collapsed edge (true), one beside it (twin), one that exists there already (reuse), or
//! a new vertex (fake) (thesis 4.2.1).

use crate::cut::{SEAM, Wedges, WorkingMesh, next, previous};
use crate::number::Input;
use crate::price::Attributes;
use lodc_mesh::NONE;

/// A wedge without an edge to the target takes an existing wedge there if their attributes differ
/// by less than this share of the mesh's size: a normal off by about 12°, half a pixel of a picture
/// of 256 across. Chosen by hand; not tuned.
const MAX_REUSE_DISTANCE: f64 = 2e-3;

/// The most wedges of a group that are compared with one that needs a target. Chosen by hand: real
/// meshes have a handful at a position, artificial ones may have all of theirs there.
const MAX_REUSED: usize = 1024;

/// The most wedges with an edge to the target that are compared with one of another submesh.
/// Chosen by hand: an edge of real meshes has two.
const MAX_ACROSS: usize = 64;

/// One wedge of the moving group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlannedWedge {
    pub(crate) wedge: u32,
    /// Its target; [`NONE`] for a fake that the commit has yet to make.
    pub(crate) target: u32,
    /// True once the target is a fake.
    pub(crate) is_fake: bool,
    /// The wedge whose attributes a fake has.
    pub(crate) attributes: u32,
    /// True if it has faces that outlive the collapse.
    has_faces: bool,
}

/// The targets of all wedges of one group.
#[derive(Default)]
pub(crate) struct WedgePlan {
    /// In order of their numbers.
    pub(crate) wedges: Vec<PlannedWedge>,
    /// The target of the true edge.
    pub(crate) true_target: u32,
    /// For each wedge with an edge to the target its class (equal for equal attributes) and the
    /// wedge at the other end of that edge; sorted by class.
    twins: Vec<(u32, u32)>,
    /// The first wedges with an edge to the target, each with the wedge at the other end.
    across: Vec<(u32, u32)>,
    /// Number of fakes that it takes.
    pub(crate) fakes: u32,
    /// Number of those that make a seam: the attributes that count are at no wedge of the target.
    pub(crate) costly_fakes: u32,
    /// A wedge had edges to several wedges of the target: a seam ends here.
    pub(crate) ambiguous: bool,
}

impl WedgePlan {
    pub(crate) fn clear(&mut self) {
        self.wedges.clear();
        (self.fakes, self.costly_fakes) = (0, 0);
        self.ambiguous = false;
    }

    /// Returns the target of a wedge of the moving group; `NONE` means a fake.
    pub(crate) fn target(&self, wedge: u32) -> Option<u32> {
        let at = self.wedges.binary_search_by_key(&wedge, |p| p.wedge).ok()?;
        Some(self.wedges[at].target)
    }
}

/// The data that planning reads.
#[derive(Clone, Copy)]
pub(crate) struct Planner<'a> {
    pub(crate) input: &'a Input<'a>,
    pub(crate) mesh: &'a WorkingMesh,
    pub(crate) wedges: &'a Wedges,
    pub(crate) attributes: &'a Attributes,
    /// A wedge without an edge to the target takes any wedge there of its submesh, not a fake.
    pub(crate) reuses_any: bool,
    /// The mesh's diagonal in working units.
    pub(crate) size: f64,
}

impl Planner<'_> {
    /// Plans the collapse of `from` onto its neighbour `to`.
    pub(crate) fn plan(&self, from: u32, to: u32, plan: &mut WedgePlan) {
        plan.clear();
        if self.mesh.one_wedge_each() || !self.mesh.has(from, SEAM) && self.wedges.is_single(from) {
            self.plan_smooth(from, to, plan);
            return;
        }
        for &corner in self.mesh.star(from) {
            let groups = &self.mesh.faces[corner.face() as usize].groups;
            let wedges = self.mesh.wedges(corner.face());
            let end = [next(corner.at()), previous(corner.at())]
                .into_iter()
                .find(|&end| groups[end] == to);
            let wedge = wedges[corner.at()];
            plan.wedges.push(PlannedWedge {
                wedge,
                target: end.map_or(NONE, |end| wedges[end]),
                is_fake: false,
                attributes: wedge,
                has_faces: end.is_none(),
            });
        }
        // One entry for each wedge, in order of their numbers.
        plan.wedges.sort_by_key(|p| (p.wedge, p.target));
        let mut distinct = 0;
        for i in 0..plan.wedges.len() {
            let p = plan.wedges[i];
            if distinct > 0 && plan.wedges[distinct - 1].wedge == p.wedge {
                let known = plan.wedges[distinct - 1];
                let class = |w: u32| self.wedges.class(w);
                if known.target != NONE
                    && p.target != NONE
                    && class(known.target) != class(p.target)
                {
                    plan.ambiguous = true;
                }
                plan.wedges[distinct - 1].target = self.nearer(p.wedge, known.target, p.target);
                plan.wedges[distinct - 1].has_faces |= p.has_faces;
            } else {
                plan.wedges[distinct] = p;
                distinct += 1;
            }
        }
        plan.wedges.truncate(distinct);
        if plan.wedges.len() == 1 && self.wedges.is_single(from) {
            plan.true_target = plan.wedges[0].target;
            return;
        }
        self.find_other_targets(from, to, plan);
    }

    /// One wedge, and no seam near it: the first shared face has the answer.
    fn plan_smooth(&self, from: u32, to: u32, plan: &mut WedgePlan) {
        let shared = || {
            self.mesh.star(from).iter().find_map(|&corner| {
                let end =
                    self.mesh.faces[corner.face() as usize].groups.iter().position(|&g| g == to)?;
                let wedges = self.mesh.wedges(corner.face());
                Some((wedges[corner.at()], wedges[end]))
            })
        };
        let (wedge, target) = if self.mesh.one_wedge_each() {
            (from, to)
        } else {
            shared().expect("a collapse follows an edge")
        };
        let (is_fake, has_faces) = (false, true);
        plan.wedges.push(PlannedWedge { wedge, target, is_fake, attributes: wedge, has_faces });
        plan.true_target = target;
    }

    /// The one of two wedges (one may be `NONE`) whose attributes are closer to `wedge`'s, ties to
    /// the smaller index.
    fn nearer(&self, wedge: u32, a: u32, b: u32) -> u32 {
        if a == NONE || a == b {
            return b;
        }
        if b == NONE {
            return a;
        }
        let distance = |t: u32| self.attribute_distance(wedge, t);
        let (x, y) = (distance(a), distance(b));
        match x.total_cmp(&y).then(a.cmp(&b)) {
            std::cmp::Ordering::Greater => b,
            _ => a,
        }
    }

    /// The squared distance of two wedges' attributes, in squared working units.
    fn attribute_distance(&self, a: u32, b: u32) -> f64 {
        let row = |w: u32| self.wedges.attribute_source[w as usize];
        self.attributes.distance_squared(row(a), row(b))
    }

    /// Finds targets for the wedges that have no edge to `to`.
    fn find_other_targets(&self, from: u32, to: u32, plan: &mut WedgePlan) {
        // The true edge's target: that of the first wedge that has one. Every collapse follows an
        // edge, so there is one.
        plan.true_target = plan.wedges.iter().find(|p| p.target != NONE).map_or(NONE, |p| p.target);
        plan.twins.clear();
        let class = |w: u32| self.wedges.class(w);
        plan.twins.extend(
            plan.wedges.iter().filter(|p| p.target != NONE).map(|p| (class(p.wedge), p.target)),
        );
        plan.twins.sort_by_key(|twin| twin.0);
        plan.across.clear();
        if self.input.has_formats_in_common() {
            let with_edge = plan.wedges.iter().filter(|p| p.target != NONE).take(MAX_ACROSS);
            plan.across.extend(with_edge.map(|p| (p.wedge, p.target)));
        }
        for p in plan.wedges.iter_mut().filter(|p| p.target == NONE) {
            let first = plan.twins.partition_point(|twin| twin.0 < class(p.wedge));
            let mut across = None;
            let target = match plan.twins.get(first) {
                Some(twin) if twin.0 == class(p.wedge) => Some(twin.1),
                _ if !p.has_faces => Some(plan.true_target),
                _ => {
                    across = self.across(p.wedge, &plan.across);
                    let same = |target| self.same_in_submesh(p.wedge, target, to);
                    across.and_then(same).or_else(|| self.reusable(p.wedge, to))
                }
            };
            let keeps_flat = |target: &u32| !p.has_faces || self.keeps_flat(p.wedge, *target);
            p.target = target.filter(keeps_flat).unwrap_or(NONE);
            across = across.filter(keeps_flat);
            if p.target == NONE {
                plan.fakes += 1;
                p.attributes = across.unwrap_or(p.wedge);
                let makes_seam = target.is_none()
                    && across.is_none()
                    && (!self.input.ignores_attributes()
                        || self.wedges.meets_smoothly(self.input, p.wedge, to).is_none());
                plan.costly_fakes += u32::from(makes_seam);
            }
        }
        let known = plan.wedges.len();
        for wedge in self.wedges.of_group(from) {
            if plan.wedges[..known].binary_search_by_key(&wedge, |p| p.wedge).is_err() {
                plan.wedges.push(PlannedWedge {
                    wedge,
                    target: plan.true_target,
                    is_fake: false,
                    attributes: wedge,
                    has_faces: false,
                });
            }
        }
        plan.wedges.sort_unstable_by_key(|p| p.wedge);
    }

    /// The wedge that one of another submesh becomes whose attributes are the same as `wedge`'s:
    /// where materials meet in the middle of a surface, attributes go on from one to the other.
    fn across(&self, wedge: u32, with_edge: &[(u32, u32)]) -> Option<u32> {
        let same = |(other, _): &&(u32, u32)| self.wedges.alike_across(self.input, wedge, *other);
        with_edge.iter().find(same).map(|&(_, target)| target)
    }

    /// A wedge at `to` with the attributes of `other`, in the submesh of `wedge`.
    fn same_in_submesh(&self, wedge: u32, other: u32, to: u32) -> Option<u32> {
        self.candidates(wedge, to).find(|&t| self.wedges.alike_across(self.input, t, other))
    }

    /// The wedges at `to` that are in the submesh of `wedge`.
    fn candidates(&self, wedge: u32, to: u32) -> impl Iterator<Item = u32> {
        let submesh = self.wedges.submesh(wedge);
        let all = self.wedges.of_group(to).take(MAX_REUSED);
        all.filter(move |&t| self.wedges.submesh(t) == submesh)
    }

    /// Returns whether faces that are flat stay so when a wedge becomes another.
    fn keeps_flat(&self, wedge: u32, target: u32) -> bool {
        let source = |w: u32| self.wedges.attribute_source[w as usize];
        self.input.keeps_flat(source(wedge), source(target))
    }

    /// A wedge at `to` that `wedge` may become although they share no face: same submesh, and the
    /// same attributes, nearly the same, or in the last stages the most similar ones.
    fn reusable(&self, wedge: u32, to: u32) -> Option<u32> {
        let mut best: Option<(f64, u32)> = None;
        for t in self.candidates(wedge, to) {
            if self.wedges.alike(self.input.mesh, wedge, t) {
                return Some(t);
            }
            let distance = self.attribute_distance(wedge, t);
            if best.is_none_or(|(d, u)| (distance, t) < (d, u)) {
                best = Some((distance, t));
            }
        }
        let limit =
            if self.reuses_any { f64::INFINITY } else { (MAX_REUSE_DISTANCE * self.size).powi(2) };
        best.filter(|&(d, _)| d <= limit && !self.attributes.is_empty()).map(|(_, t)| t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::Region;

    /// Plans all collapses of groups on the seam of a sphere: (target is on the seam, wedges,
    /// distinct targets, fakes).
    fn plans() -> Vec<(bool, usize, usize, u32)> {
        let sphere = lodc_fixtures::uv_sphere(16, 8);
        let input = Input::new(&sphere);
        let region = Region::whole(&input, false);
        let Region { mesh, wedges, .. } = &region;
        let attributes = Attributes::new(
            &sphere,
            &crate::SeenShapes::default(),
            |_| crate::Weights::DEFAULT,
            input.scale,
            input.size,
        );
        let planner = Planner {
            input: &input,
            mesh,
            wedges,
            attributes: &attributes,
            reuses_any: false,
            size: input.size,
        };
        let count = |g: u32| wedges.of_group(g).count();
        let mut found = Vec::new();
        for from in (0..region.own_groups() as u32).filter(|&g| count(g) == 2) {
            mesh.each_neighbour(from, |to| {
                let mut plan = WedgePlan::default();
                planner.plan(from, to, &mut plan);
                let mut targets: Vec<u32> = plan.wedges.iter().map(|p| p.target).collect();
                targets.sort_unstable();
                targets.dedup();
                // Poles have a wedge for every triangle.
                if count(to) <= 2 {
                    found.push((count(to) == 2, plan.wedges.len(), targets.len(), plan.fakes));
                }
            });
        }
        found
    }

    #[test]
    fn along_a_seam_every_wedge_has_its_own_target() {
        let along: Vec<_> = plans().into_iter().filter(|p| p.0).collect();
        assert!(along.len() >= 8);
        assert!(
            along.iter().all(|&(_, wedges, targets, fakes)| (wedges, targets, fakes) == (2, 2, 0))
        );
    }

    #[test]
    fn off_a_seam_the_wedge_without_an_edge_becomes_a_fake() {
        let off: Vec<_> = plans().into_iter().filter(|p| !p.0).collect();
        assert!(off.len() >= 16);
        assert!(off.iter().all(|&(_, wedges, _, fakes)| (wedges, fakes) == (2, 1)));
    }
}
