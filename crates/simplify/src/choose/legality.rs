//! The rules for a legal collapse: limited valence (number of faces around a group), no face turned
//! over, unchanged topology (link condition, Dey et al. 1999), no texture turned over. The legal
//! phase of a simplification keeps all of them; the terminal phase drops them one after another.
//!
//! The thresholds were chosen by hand on a few models; they were not measured one by one.

use super::link::{Link, Marks};
use super::plan::WedgePlan;
use crate::cut::{Corner, InMotion, OPEN, Wedges, WorkingMesh};
use crate::number::each_shape;
use crate::price::{Attributes, MAX_LEN, OneRing};
use glam::DVec3;
use lodc_mesh::NONE;

/// The most faces that a group may get from a legal collapse. Without a limit one vertex of a flat
/// part, where all collapses cost nothing, may swallow all others and leave needles.
const MAX_VALENCE: usize = 24;
/// The least cosine of the angle by which a face's normal may turn in one collapse (75.5°). With
/// zero no face flips in one step, but turns of nearly 90° in two steps add up to a flip.
const MIN_TURN: f64 = 0.25;
/// The same where single precision decides: more by twice its error, which is below 0.005.
const SURE_MIN_TURN: f32 = 0.26;
/// A face's area must stay above this share of its longest edge squared; below, it is a line. The
/// area itself, in double precision, is off by about 1e-16 of that square.
const MIN_AREA: f64 = 1e-12;
/// Factor of the cost of a collapse that changes the topology: four times the distance, as costs
/// are squared distances. A hole or handle that is that much smaller than other details is noise.
const TOPOLOGY_FACTOR: f64 = 16.0;

/// The rules that may not be broken. Each stage drops one rule; all but the first are the terminal
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

/// What the rules say of a legal collapse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Verdict {
    /// The cost is multiplied by this, at least 1.
    pub(super) factor: f64,
    /// It closes a handle, joins sheets or takes a component away.
    pub(super) changes_topology: bool,
    /// It takes the last faces around both groups away.
    pub(super) vanishes: bool,
}

/// The rules that hold at present.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules {
    pub(crate) stage: Stage,
    /// No topology change before the last stage.
    pub(crate) preserve_topology: bool,
    /// Groups that come to share a position and a face may be united. False in rounds of several
    /// regions, as the groups may have neighbours in another one.
    pub(crate) may_unite_groups: bool,
}

impl Rules {
    /// Returns the verdict on moving `from` onto its neighbour `to`; none if that is illegal.
    pub(super) fn check(
        self,
        (mesh, in_motion): (&WorkingMesh, Option<InMotion<'_>>),
        from: u32,
        to: u32,
        marks: &mut Marks,
    ) -> Option<Verdict> {
        let keeps_in_motion = || keeps_orientation_in_motion(in_motion, from, to);
        let keeps = || keeps_orientation(mesh, from, to) && keeps_in_motion();
        self.check_with(mesh, from, to, marks, keeps)
    }

    /// The same for a group whose faces have been gathered, to be checked for many neighbours.
    pub(super) fn check_gathered(
        self,
        (mesh, in_motion): (&WorkingMesh, Option<InMotion<'_>>),
        from: u32,
        to: u32,
        marks: &mut Marks,
        faces: &MovingFaces,
    ) -> Option<Verdict> {
        let keeps_in_motion = || keeps_orientation_in_motion(in_motion, from, to);
        let keeps = || faces.keep_orientation(mesh, to) && keeps_in_motion();
        self.check_with(mesh, from, to, marks, keeps)
    }

    fn check_with(
        self,
        mesh: &WorkingMesh,
        from: u32,
        to: u32,
        marks: &mut Marks,
        keeps_orientation: impl FnOnce() -> bool,
    ) -> Option<Verdict> {
        if self.stage < Stage::Valence && is_overcrowded(mesh, from, to) {
            return None;
        }
        // Before the link, which takes longer: where much is refused, the first few faces show it.
        if self.stage < Stage::Flips && !keeps_orientation() {
            return None;
        }
        let link = Link::new(mesh, from, to, marks);
        if link.shared_faces == 0 {
            // No neighbour any more: choices of high-valence groups are renewed only now and then.
            return None;
        }
        let changes_topology = !link.holds;
        if changes_topology && self.stage < Stage::Links && self.preserve_topology {
            return None;
        }
        if self.stage < Stage::Valence {
            let (valence_from, valence_to) = (mesh.valence(from), mesh.valence(to));
            let valence = (valence_from + valence_to).saturating_sub(2 * link.shared_faces);
            if valence > MAX_VALENCE && valence > valence_to {
                return None;
            }
        }
        if !self.may_unite_groups && mesh.twins(from, to).next().is_some() {
            return None;
        }
        let factor = if changes_topology { TOPOLOGY_FACTOR } else { 1.0 };
        Some(Verdict { factor, changes_topology, vanishes: link.vanishes })
    }
}

/// Returns whether `from` has too many faces for `to`, whichever of them die: these are at most as
/// many as `to` has. Quicker than the link, which would take quadratic time for fans.
fn is_overcrowded(mesh: &WorkingMesh, from: u32, to: u32) -> bool {
    let valence_to = mesh.valence(to);
    mesh.valence(from).saturating_sub(valence_to) > valence_to.max(MAX_VALENCE)
}

/// Returns whether no face around `from` turns its texture over in the planned collapse.
pub(super) fn keeps_texture(
    mesh: &WorkingMesh,
    wedges: &Wedges,
    attributes: &Attributes,
    from: u32,
    to: u32,
    plan: &WedgePlan,
) -> bool {
    let Some(column) = attributes.texture else { return true };
    let at = |wedge: u32| {
        let row = attributes.row(wedges.attribute_source[wedge as usize]);
        [f64::from(row[column]), f64::from(row[column + 1])]
    };
    mesh.star(from).iter().all(|&corner| {
        if mesh.others(corner).contains(&to) {
            return true;
        }
        let [wedge, next_wedge, previous_wedge] = mesh.wedges_from(corner);
        let Some(target) = plan.target(wedge).filter(|&t| t != NONE) else { return true };
        let (b, c) = (at(next_wedge), at(previous_wedge));
        let area = |a: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        area(at(wedge)) * area(at(target)) >= 0.0
    })
}

/// A face around a group that may move.
struct MovingFace {
    others: [u32; 2],
    ahead: DVec3,
    behind: DVec3,
    /// Normal, twice the area long.
    normal: DVec3,
}

impl MovingFace {
    /// The face at a corner of a group at this position.
    #[inline]
    fn new(mesh: &WorkingMesh, corner: Corner, position: DVec3) -> Self {
        let others = mesh.others(corner);
        let [ahead, behind] = others.map(|g| mesh.position(g));
        Self { others, ahead, behind, normal: (ahead - position).cross(behind - position) }
    }

    /// Returns whether it neither turns too far nor loses its area, or dies, when the group moves
    /// onto `to`, at `target`.
    #[inline]
    fn keeps_orientation(&self, to: u32, target: DVec3) -> bool {
        self.others.contains(&to) || stays_upright(self.normal, target, self.ahead, self.behind)
    }
}

/// The faces around a group, gathered once for all collapses of it that are checked.
#[derive(Default)]
pub(super) struct MovingFaces(Vec<MovingFace>);

impl MovingFaces {
    /// Gathers the faces around a group.
    pub(super) fn gather(&mut self, mesh: &WorkingMesh, from: u32) {
        let position = mesh.position(from);
        self.0.clear();
        let faces = mesh.star(from).iter().map(|&corner| MovingFace::new(mesh, corner, position));
        self.0.extend(faces);
    }

    /// Returns whether none of the faces turns too far or loses its area when the group moves to
    /// the position of `to`.
    fn keep_orientation(&self, mesh: &WorkingMesh, to: u32) -> bool {
        let target = mesh.position(to);
        self.0.iter().all(|face| face.keeps_orientation(to, target))
    }
}

/// Returns whether no face around `from` turns too far or loses its area when `from` moves to the
/// position of `to`.
fn keeps_orientation(mesh: &WorkingMesh, from: u32, to: u32) -> bool {
    surely_keeps_orientation(mesh, from, to) || keeps_orientation_exactly(mesh, from, to)
}

/// The same, if four faces at a time in single precision leave no doubt.
fn surely_keeps_orientation(mesh: &WorkingMesh, from: u32, to: u32) -> bool {
    if mesh.has(from, OPEN) {
        return false;
    }
    let star = mesh.star(from);
    let Some(spoke) = star.iter().position(|c| c.ahead == to) else { return false };
    match star.len() {
        3..=7 => OneRing::<2>::new(mesh, from, star).surely_turns_less(spoke, SURE_MIN_TURN),
        8..=MAX_LEN => OneRing::<3>::new(mesh, from, star).surely_turns_less(spoke, SURE_MIN_TURN),
        _ => false,
    }
}

fn keeps_orientation_exactly(mesh: &WorkingMesh, from: u32, to: u32) -> bool {
    let (position, target) = (mesh.position(from), mesh.position(to));
    if !mesh.has(from, OPEN) {
        // The next corner leads to the group behind.
        let star = mesh.star(from);
        let Some(mut ahead) = star.last().map(|c| c.ahead) else { return true };
        let mut ahead_position = mesh.position(ahead);
        return star.iter().map(|corner| corner.ahead).all(|behind| {
            let behind_position = mesh.position(behind);
            let dies = ahead == to || behind == to;
            let normal = || (ahead_position - position).cross(behind_position - position);
            let stays = dies || stays_upright(normal(), target, ahead_position, behind_position);
            (ahead, ahead_position) = (behind, behind_position);
            stays
        });
    }
    let mut faces = mesh.star(from).iter().map(|&corner| MovingFace::new(mesh, corner, position));
    faces.all(|face| face.keeps_orientation(to, target))
}

/// Returns whether no face around `from` turns over in a shape in motion when `from` moves onto
/// `to`. Faces may turn farther there than at rest, since poses squeeze some of them as it is.
fn keeps_orientation_in_motion(in_motion: Option<InMotion<'_>>, from: u32, to: u32) -> bool {
    let Some(view) = in_motion else { return true };
    let mesh = view.mesh;
    each_shape(view.around(from)).all(|shape| {
        let at = |group: u32| view.position(group, shape).as_dvec3();
        let (position, target) = (at(from), at(to));
        mesh.star(from).iter().all(|&corner| {
            let others = mesh.others(corner);
            let [ahead, behind] = others.map(at);
            let old = (ahead - position).cross(behind - position);
            let new = (ahead - target).cross(behind - target);
            others.contains(&to) || old.dot(new) >= 0.0
        })
    })
}

/// Returns whether the triangle of a moving corner, `ahead` and `behind` keeps the orientation of
/// its normal `old` and its area.
#[inline]
fn stays_upright(old: DVec3, target: DVec3, ahead: DVec3, behind: DVec3) -> bool {
    let old_squared = old.length_squared();
    if old_squared == 0.0 {
        return true;
    }
    let (ahead, behind) = (ahead - target, behind - target);
    let new = ahead.cross(behind);
    let longest =
        ahead.length_squared().max(behind.length_squared()).max((ahead - behind).length_squared());
    // Squared throughout: both vectors are twice the area long.
    let (turn, area) = (new.dot(old), new.length_squared());
    turn > 0.0
        && turn * turn > (MIN_TURN * MIN_TURN) * (area * old_squared)
        && area > (2.0 * MIN_AREA * longest).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::Region;
    use crate::number::Input;

    #[test]
    fn single_precision_permits_only_what_double_precision_permits() {
        let (mut sure, mut refused) = (0, 0);
        for mesh in [lodc_fixtures::icosphere(3), lodc_fixtures::machine_part()] {
            let region = Region::whole(&Input::new(&mesh), true);
            for from in (0..region.own_groups() as u32).filter(|&g| !region.mesh.has(g, OPEN)) {
                let star = region.mesh.star(from);
                for to in star.iter().map(|c| c.ahead) {
                    let keeps = keeps_orientation_exactly(&region.mesh, from, to);
                    let surely = surely_keeps_orientation(&region.mesh, from, to);
                    assert!(keeps || !surely, "{from} onto {to}");
                    sure += usize::from(surely);
                    refused += usize::from(!keeps);
                }
            }
        }
        assert!(sure > 1000 && refused > 10, "{sure}, {refused}");
    }
}
