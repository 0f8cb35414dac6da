//! What a collapse does to every wedge of the group: true and twin edges, reuse, and fakes (thesis 4.2.1).

use crate::engine::Engine;
use crate::legality::Stage;
use crate::metric::Metric;
use crate::working::{SEAM, next, previous};

const NONE: u32 = u32::MAX;
/// A wedge without an edge to the target takes an existing wedge there if their attributes differ by less than this
/// share of the mesh's size.
const ALIKE: f64 = 2e-3;

/// One wedge of the moving group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlannedWedge {
    pub(crate) wedge: u32,
    /// What it becomes; `u32::MAX` means a fake.
    pub(crate) target: u32,
    /// Whether that is a fake.
    pub(crate) fake: bool,
    /// Whether it has faces that stay.
    live: bool,
}

/// What becomes of all wedges of one group.
#[derive(Default)]
pub(crate) struct Plan {
    pub(crate) wedges: Vec<PlannedWedge>,
    /// How many fakes it takes.
    pub(crate) fakes: u32,
    /// A wedge had edges to several wedges of the target: a seam ends here.
    pub(crate) ambiguous: bool,
}

impl<M: Metric> Engine<'_, M> {
    /// Plans the collapse of `from` onto its neighbour `to`.
    pub(crate) fn plan(&self, from: u32, to: u32, plan: &mut Plan) {
        plan.wedges.clear();
        plan.fakes = 0;
        plan.ambiguous = false;
        if self.mesh.one_wedge_each() || !self.mesh.has(from, SEAM) && self.wedges.is_single(from) {
            self.plan_smooth(from, to, plan);
            return;
        }
        for &corner in self.mesh.star(from) {
            let groups = &self.mesh.faces[corner.face() as usize].groups;
            let wedges = self.mesh.wedges(corner.face());
            let wedge = wedges[corner.at()];
            let i = plan.wedges.iter().rposition(|p| p.wedge == wedge).unwrap_or_else(|| {
                plan.wedges.push(PlannedWedge { wedge, target: NONE, fake: false, live: false });
                plan.wedges.len() - 1
            });
            let mut dies = false;
            for end in [next(corner.at()), previous(corner.at())] {
                if groups[end] == to {
                    dies = true;
                    let target = wedges[end];
                    let known = plan.wedges[i].target;
                    if known != NONE && self.wedges.class[known as usize] != self.wedges.class[target as usize] {
                        plan.ambiguous = true;
                    }
                    plan.wedges[i].target = self.nearer(wedge, known, target);
                }
            }
            plan.wedges[i].live |= !dies;
        }
        if plan.wedges.len() == 1 && self.wedges.is_single(from) {
            return;
        }
        self.find_other_targets(from, to, plan);
    }

    /// One wedge, and no seam near it: the first shared face has the answer.
    fn plan_smooth(&self, from: u32, to: u32, plan: &mut Plan) {
        let shared = || {
            self.mesh.star(from).iter().find_map(|&corner| {
                let end = self.mesh.faces[corner.face() as usize].groups.iter().position(|&g| g == to)?;
                let wedges = self.mesh.wedges(corner.face());
                Some((wedges[corner.at()], wedges[end]))
            })
        };
        let (wedge, target) =
            if self.mesh.one_wedge_each() { (from, to) } else { shared().expect("a collapse follows an edge") };
        plan.wedges.push(PlannedWedge { wedge, target, fake: false, live: true });
    }

    /// The one of two wedges (one may be `NONE`) whose attributes are closer to `wedge`'s, ties to the smaller index.
    fn nearer(&self, wedge: u32, a: u32, b: u32) -> u32 {
        if a == NONE || a == b {
            return b;
        }
        let distance = |t: u32| self.attribute_distance(wedge, t);
        let (x, y) = (distance(a), distance(b));
        match x.total_cmp(&y).then(a.cmp(&b)) {
            std::cmp::Ordering::Greater => b,
            _ => a,
        }
    }

    /// Squared, in working units.
    pub(crate) fn attribute_distance(&self, a: u32, b: u32) -> f64 {
        let row = |w: u32| self.wedges.attributes_of[w as usize];
        self.attributes.distance_squared(row(a), row(b))
    }

    fn find_other_targets(&self, from: u32, to: u32, plan: &mut Plan) {
        // The true edge's target: the first wedge that has one. Every collapse follows an edge, so there is one.
        let truth = plan.wedges.iter().find(|p| p.target != NONE).map_or(NONE, |p| p.target);
        for i in 0..plan.wedges.len() {
            let PlannedWedge { wedge, target, live, .. } = plan.wedges[i];
            if target != NONE {
                continue;
            }
            let class = self.wedges.class[wedge as usize];
            let twin = plan.wedges.iter().find(|p| p.target != NONE && self.wedges.class[p.wedge as usize] == class);
            plan.wedges[i].target = match twin {
                Some(twin) => twin.target,
                None if !live => truth,
                None => self.reusable(wedge, to).unwrap_or(NONE),
            };
            plan.fakes += u32::from(plan.wedges[i].target == NONE);
        }
        for wedge in self.wedges.of_group(from) {
            if !plan.wedges.iter().any(|p| p.wedge == wedge) {
                plan.wedges.push(PlannedWedge { wedge, target: truth, fake: false, live: false });
            }
        }
        // Targets first, so that the fakes can take their places from one of them.
        plan.wedges.sort_by_key(|p| p.target == NONE);
    }

    /// A wedge at `to` that can stand for `wedge` although they share no face: same submesh, and the same attributes,
    /// nearly the same, or in the last stages the most similar ones.
    fn reusable(&self, wedge: u32, to: u32) -> Option<u32> {
        let submesh = self.wedges.submesh[wedge as usize];
        let mut best: Option<(f64, u32)> = None;
        for t in self.wedges.of_group(to).filter(|&t| self.wedges.submesh[t as usize] == submesh) {
            if self.wedges.alike(self.input, wedge, t) {
                return Some(t);
            }
            let distance = self.attribute_distance(wedge, t);
            if best.is_none_or(|(d, u)| (distance, t) < (d, u)) {
                best = Some((distance, t));
            }
        }
        let limit = if self.stage < Stage::Seams { (ALIKE * self.size).powi(2) } else { f64::INFINITY };
        best.filter(|&(d, _)| d <= limit && !self.attributes.is_empty()).map(|(_, t)| t)
    }
}
