//! Which collapses are legal (algorithmic rules: Dey et al. for the link condition; thresholds measured).

use crate::engine::{Engine, Stage};
use crate::metric::Metric;
use crate::working::{Working, next, previous};
use glam::DVec3;

/// The most neighbours a group may get from a legal collapse.
const MAX_VALENCE: usize = 24;
/// A face's normal may turn by at most this cosine in one collapse (75.5°). With zero, flips add up over steps.
const MIN_TURN: f64 = 0.25;
/// A face's area must stay above this share of its longest edge squared.
const MIN_AREA: f64 = 1e-12;
/// What a collapse that changes the topology costs, as a multiple of its geometric cost.
const TOPOLOGY_PRICE: f64 = 16.0;

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
        Some(Verdict { price: if changes_topology { TOPOLOGY_PRICE } else { 1.0 }, changes_topology })
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
        let length = n.length();
        if old == DVec3::ZERO {
            return true;
        }
        let longest = ahead.length_squared().max(behind.length_squared()).max((ahead - behind).length_squared());
        n.dot(old) > MIN_TURN * length && length > 2.0 * MIN_AREA * longest
    })
}

/// The link condition: collapsing the edge keeps the surface's topology exactly if the groups next to both ends are
/// those opposite the edge, and no face would come to lie on another.
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
        let others = |corner: crate::working::Corner| {
            let groups = &mesh.faces[corner.face() as usize].groups;
            [groups[next(corner.at())], groups[previous(corner.at())]]
        };
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
            for &corner in mesh.star(to) {
                for g in others(corner) {
                    meet(marks, g);
                }
            }
        } else {
            // A hub: asking the few neighbours of `from` is shorter than asking its many.
            for g in star.iter().flat_map(|&c| others(c)) {
                if g != to && mesh.star(g).iter().any(|&c| others(c).contains(&to)) {
                    meet(marks, g);
                }
            }
        }
        let manifold = (1..=2).contains(&shared_faces) && in_both == apexes && apexes == shared_faces;
        let vanishes = star.len() == shared_faces && mesh.star(to).len() == shared_faces;
        let doubles = || {
            star.iter().any(|&corner| {
                let [g, h] = others(corner);
                marks[g as usize] == common
                    && marks[h as usize] == common
                    && mesh.star(g).iter().any(|&c| others(c).contains(&h) && others(c).contains(&to))
            })
        };
        Self { holds: manifold && !vanishes && !doubles(), shared_faces }
    }
}
