//! Which collapses are legal (algorithmic rules: Dey et al. for the link condition; thresholds
//! measured).

use crate::engine::Engine;
use crate::metric::Metric;
use crate::plan::Plan;
use crate::working::{Working, next, previous};
use glam::DVec3;

/// The most neighbours a group may get from a legal collapse.
const MAX_VALENCE: usize = 24;
/// A face's normal may turn by at most this cosine in one collapse (75.5°). With zero, flips add up
/// over steps.
const MIN_TURN: f64 = 0.25;
/// A face's area must stay above this share of its longest edge squared.
const MIN_AREA: f64 = 1e-12;
/// What a collapse that changes the topology costs, as a multiple of its geometric cost.
const TOPOLOGY_PRICE: f64 = 16.0;

/// What may still not be broken. Each stage drops one rule; all but the first are the terminal
/// phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Stage {
    /// Every rule holds.
    Legal,
    /// Any valence.
    Valence,
    /// Faces may flip, lose their area, or turn their texture over.
    Flips,
    /// Borders and seams may be left.
    Seams,
    /// Any edge.
    Links,
}

impl Stage {
    pub(crate) const ALL: [Self; 5] =
        [Self::Legal, Self::Valence, Self::Flips, Self::Seams, Self::Links];
}

/// A legal collapse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Verdict {
    /// The cost is multiplied by this, at least 1.
    pub(crate) price: f64,
    /// It closes a handle, joins sheets or takes a component away.
    pub(crate) changes_topology: bool,
}

/// Marks of groups, used again without being cleared.
#[derive(Default)]
pub(crate) struct Buffers {
    marks: Vec<u32>,
    epoch: u32,
}

impl<M: Metric> Engine<'_, M> {
    /// Whether `from` may move onto its neighbour `to` at the present stage.
    pub(crate) fn judge(&self, from: u32, to: u32, buffers: &mut Buffers) -> Option<Verdict> {
        let mesh = &self.mesh;
        let link = Link::new(mesh, from, to, buffers);
        if link.shared_faces == 0 {
            // A hub's ranking may be older than its star.
            return None;
        }
        let changes_topology = !link.holds;
        if changes_topology && self.stage < Stage::Links && self.options.preserve_topology {
            return None;
        }
        if self.stage < Stage::Valence {
            let (at_from, at_to) = (mesh.star(from).len(), mesh.star(to).len());
            let valence = (at_from + at_to).saturating_sub(2 * link.shared_faces);
            if valence > MAX_VALENCE && valence > at_to {
                return None;
            }
        }
        if self.stage < Stage::Flips && !keeps_orientation(mesh, from, to) {
            return None;
        }
        Some(Verdict {
            price: if changes_topology { TOPOLOGY_PRICE } else { 1.0 },
            changes_topology,
        })
    }
}

impl<M: Metric> Engine<'_, M> {
    /// No face around `from` turns its texture over when `from` moves to `to` as planned.
    pub(crate) fn keeps_texture(&self, from: u32, to: u32, plan: &Plan) -> bool {
        let Some(column) = self.attributes.texture else { return true };
        let at = |wedge: u32| {
            let row = self.attributes.row(self.wedges.attributes_of[wedge as usize]);
            [f64::from(row[column]), f64::from(row[column + 1])]
        };
        self.mesh.star(from).iter().all(|&corner| {
            if self.mesh.others(corner).contains(&to) {
                return true;
            }
            let wedges = self.mesh.wedges(corner.face());
            let here = wedges[corner.at()];
            let Ok(target) = plan.wedges.binary_search_by_key(&here, |p| p.wedge) else {
                return true;
            };
            let target = plan.wedges[target].target;
            if target == u32::MAX {
                return true;
            }
            let (b, c) = (at(wedges[next(corner.at())]), at(wedges[previous(corner.at())]));
            let area = |a: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            area(at(here)) * area(at(target)) >= 0.0
        })
    }
}

/// No face around `from` turns too far or loses its area when `from` moves to where `to` is.
fn keeps_orientation(mesh: &Working, from: u32, to: u32) -> bool {
    let there = mesh.position(to);
    mesh.star(from).iter().all(|&corner| {
        let f = &mesh.faces[corner.face() as usize];
        let (g, h) = (f.groups[next(corner.at())], f.groups[previous(corner.at())]);
        if g == to || h == to {
            return true;
        }
        let (ahead, behind) = (mesh.position(g) - there, mesh.position(h) - there);
        let n = ahead.cross(behind);
        let old = f.normal.as_dvec3();
        if old == DVec3::ZERO {
            return true;
        }
        let longest = ahead
            .length_squared()
            .max(behind.length_squared())
            .max((ahead - behind).length_squared());
        // Squared throughout: n is twice the area long.
        let (turn, area) = (n.dot(old), n.length_squared());
        turn > 0.0
            && turn * turn > MIN_TURN * MIN_TURN * area
            && area > (2.0 * MIN_AREA * longest).powi(2)
    })
}

/// The link condition: collapsing the edge keeps the surface's topology exactly if the groups next
/// to both ends are those opposite the edge, and no face would come to lie on another.
struct Link {
    holds: bool,
    shared_faces: usize,
}

impl Link {
    fn new(mesh: &Working, from: u32, to: u32, buffers: &mut Buffers) -> Self {
        if buffers.marks.len() < mesh.places.len() {
            buffers.marks.resize(mesh.places.len(), 0);
        }
        if buffers.epoch > u32::MAX - 4 {
            buffers.marks.fill(0);
            buffers.epoch = 0;
        }
        buffers.epoch += 2;
        let (near, common) = (buffers.epoch, buffers.epoch + 1);
        let marks = &mut buffers.marks;
        let star = mesh.star(from);
        let others = |corner| mesh.others(corner);
        let mut shared_faces = 0;
        let (mut apexes, mut apex) = (0, [u32::MAX; 2]);
        for &corner in star {
            let [g, h] = others(corner);
            marks[g as usize] = near;
            marks[h as usize] = near;
            if g == to || h == to {
                shared_faces += 1;
                let opposite = if g == to { h } else { g };
                if !apex.contains(&opposite) {
                    apex[apexes.min(1)] = opposite;
                    apexes += 1;
                }
            }
        }
        let mut in_both = 0;
        let mut meet = |marks: &mut Vec<u32>, g: u32| {
            if marks[g as usize] == near {
                marks[g as usize] = common;
                in_both += 1;
            }
        };
        if mesh.star(to).len() <= 64 + 8 * star.len() {
            mesh.each_neighbour(to, |g| meet(marks, g));
        } else {
            // A hub: asking the few neighbours of `from` is shorter than asking its many.
            for g in star.iter().flat_map(|&c| others(c)) {
                if g != to && mesh.star(g).iter().any(|&c| others(c).contains(&to)) {
                    meet(marks, g);
                }
            }
        }
        let manifold =
            (1..=2).contains(&shared_faces) && in_both == apexes && apexes == shared_faces;
        let vanishes = star.len() == shared_faces && mesh.star(to).len() == shared_faces;
        let doubles = || {
            star.iter().any(|&corner| {
                let [g, h] = others(corner);
                marks[g as usize] == common
                    && marks[h as usize] == common
                    && mesh
                        .star(g)
                        .iter()
                        .any(|&c| others(c).contains(&h) && others(c).contains(&to))
            })
        };
        Self { holds: manifold && !vanishes && !doubles(), shared_faces }
    }
}
