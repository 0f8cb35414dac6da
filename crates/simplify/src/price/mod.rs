//! The third step: what does every collapse of a group cost? Legality is left aside.
//!
//! The input is a group of a [`Region`]; the output is its cheapest collapse as a [`Choice`], or
//! the prices of all. The quadric prices first, and attributes add their part. A closed fan (a star
//! whose faces form one ring around the group) without seams is by far the most common case: four
//! of its collapses are priced at a time (`one_ring`), and with one seam through it nearly so
//! (`seam_ring`); any other star is priced edge by edge. A metric that judges by pictures, while it
//! is active, prices anew what geometry has priced.

mod attributes;
mod gradients;
mod one_ring;
mod price_lists;
mod ring_attributes;
mod seam_ring;
mod turned;

pub(crate) use attributes::Attributes;
pub(crate) use one_ring::{MAX_LEN, OneRing};
pub(crate) use price_lists::{PriceLists, Priced};

use crate::cut::{
    Choice, EdgeKind, Entry, InMotion, Neighbourhood, OPEN, PosedSurroundings, Quadrics, Region,
    SEAM,
};
use crate::metric::Reevaluate;
use crate::number::{Input, ShapeSet, each_shape};
use crate::options::Options;
use glam::Vec4;
use gradients::{Gradients, WedgeAttributes};
use lodc_mesh::NONE;
use one_ring::{COST_SCALE, NoAttributeCost};
use ring_attributes::RingAttributes;
use seam_ring::SeamRing;

/// Groups with more faces than this are priced without their attributes: the cost of each candidate
/// goes over all wedges, and there may be one for each face. Chosen by hand; the poles of spheres
/// have a few hundred.
const MAX_ATTRIBUTE_FACES: usize = 1024;

/// The data that all regions read.
pub(crate) struct Context<'a> {
    pub(crate) input: &'a Input<'a>,
    pub(crate) options: Options,
    pub(crate) attributes: Attributes,
}

impl Context<'_> {
    /// Returns whether wedges are groups, and nothing about them is compared.
    pub(crate) fn is_bare(&self) -> bool {
        self.input.one_wedge_each() && self.attributes.is_empty()
    }
}

/// Buffers of one thread; `S` are those of the metric.
#[derive(Default)]
pub(crate) struct Scratch<S> {
    around: Neighbourhood,
    /// The same in another shape.
    posed: PosedSurroundings,
    /// The costs of collapses at rest.
    at_rest: Vec<f64>,
    /// What attributes add to them.
    attribute_costs: Vec<f64>,
    gradients: Gradients,
    /// The collapses of one group by the quadric and attributes.
    pub(crate) priced: Vec<Priced>,
    /// Candidates of one group: cost and target.
    pub(crate) candidates: Vec<(f64, u32)>,
    reevaluating: S,
}

/// Edges that a group may move along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Permitted {
    All,
    /// Seams and borders, together called features.
    Features,
    Borders,
}

impl Permitted {
    fn allows(self, kind: EdgeKind) -> bool {
        match self {
            Self::All => true,
            Self::Features => kind != EdgeKind::Smooth,
            Self::Borders => kind == EdgeKind::Border,
        }
    }
}

/// The data that pricing reads.
pub(crate) struct Pricer<'a, M> {
    pub(crate) context: &'a Context<'a>,
    pub(crate) region: &'a Region,
    pub(crate) metric: &'a M,
    /// Borders and seams may be left, and what is locked may move.
    pub(crate) features_may_go: bool,
}

/// A cost as a key of the queue: scaled, in single precision, and finite.
fn scaled(cost: f64) -> f32 {
    (cost * f64::from(COST_SCALE)).min(f64::from(f32::MAX)) as f32
}

impl<M: Reevaluate> Pricer<'_, M> {
    /// The cheapest collapse of a group.
    #[inline]
    pub(crate) fn rank(&self, from: u32, scratch: &mut Scratch<M::ViewScratch>) -> Choice {
        // By far the most common case.
        self.rank_plain(from).unwrap_or_else(|| self.rank_any(from, scratch))
    }

    /// The cheapest collapse of a plain group; none of another.
    #[inline]
    pub(crate) fn rank_plain(&self, from: u32) -> Option<Choice> {
        if !self.is_plain(from) {
            return None;
        }
        let Region { mesh, quadrics, .. } = self.region;
        let quadric = &quadrics.surface[from as usize];
        let in_motion = self.in_motion();
        let Choice { cost, to } = if self.context.attributes.is_empty() {
            one_ring::cheapest(mesh, quadric, from, in_motion, &NoAttributeCost)?
        } else {
            let weight = self.metric.attribute_weight() as f32;
            let attribute_cost = RingAttributes { view: self.attributes(), weight };
            one_ring::cheapest(mesh, quadric, from, in_motion, &attribute_cost)?
        };
        let cost = f64::from(cost) * self.importance(from);
        Some(Choice { cost: cost.clamp(0.0, f64::from(f32::MAX)) as f32, to })
    }

    /// By how much the cost of moving a group is multiplied.
    #[inline]
    fn importance(&self, group: u32) -> f64 {
        self.context.input.importance(self.region.groups[group as usize])
    }

    /// The cost of moving a group as a key of the queue.
    #[inline]
    pub(crate) fn key(&self, from: u32, cost: f64) -> f32 {
        scaled(cost * self.importance(from))
    }

    /// The cheapest collapse of any group.
    pub(crate) fn rank_any(&self, from: u32, scratch: &mut Scratch<M::ViewScratch>) -> Choice {
        let only_cheapest = true;
        self.price_seen(from, only_cheapest, scratch);
        let mut best = (f64::INFINITY, NONE);
        for &(cost, to) in &scratch.candidates {
            if cost < best.0 || cost == best.0 && to < best.1 {
                best = (cost, to);
            }
        }
        if best.1 == NONE {
            Choice::NONE
        } else {
            Choice { cost: self.key(from, best.0), to: best.1 }
        }
    }

    /// The region in motion, if the mesh has other shapes.
    #[inline]
    pub(crate) fn in_motion(&self) -> Option<InMotion<'_>> {
        self.region.in_motion(&self.context.input.shapes)
    }

    /// The attributes of the region's wedges.
    #[inline]
    fn attributes(&self) -> WedgeAttributes<'_> {
        let Region { mesh, wedges, .. } = self.region;
        WedgeAttributes { mesh, wedges, attributes: &self.context.attributes, shape: None }
    }

    /// The shapes in which normals at a group, or next to it, are others than at rest.
    fn turned(&self, group: u32) -> ShapeSet {
        let mesh = &self.region.mesh;
        let view = self.attributes();
        let corners = mesh.star(group).iter().flat_map(|&corner| mesh.wedges_from(corner));
        corners.fold(0, |set, wedge| set | view.turned(wedge))
    }

    /// Returns whether a group has a closed fan of faces, none of them at a border or seam, and one
    /// wedge if attributes are priced.
    #[inline]
    fn is_plain(&self, group: u32) -> bool {
        !self.region.mesh.has(group, OPEN | SEAM)
            && !self.is_locked(group)
            && !self.metric.is_active()
            && (self.context.attributes.is_empty() || self.region.wedges.is_single(group))
    }

    /// Returns whether a group stays until the terminal phase.
    #[inline]
    fn is_locked(&self, group: u32) -> bool {
        self.context.input.is_locked(self.region.groups[group as usize])
    }

    /// Prices all collapses of a group, as the metric sees them.
    pub(crate) fn price_all(&self, from: u32, scratch: &mut Scratch<M::ViewScratch>) {
        let only_cheapest = false;
        self.price_seen(from, only_cheapest, scratch);
    }

    /// Prices all collapses of a group; see [`Reevaluate::reevaluate`].
    fn price_seen(&self, from: u32, only_cheapest: bool, scratch: &mut Scratch<M::ViewScratch>) {
        self.price_geometry(from, scratch);
        let Scratch { priced, candidates, reevaluating, .. } = scratch;
        let Region { mesh, wedges, .. } = self.region;
        candidates.clear();
        candidates.extend(priced.iter().map(|p| (p.cost(mesh), p.to)));
        if self.metric.is_active() {
            self.metric.reevaluate(mesh, wedges, from, candidates, only_cheapest, reevaluating);
        }
    }

    /// Prices all collapses of a group by the quadric and attributes.
    fn price_geometry(&self, from: u32, scratch: &mut Scratch<M::ViewScratch>) {
        scratch.priced.clear();
        if self.is_half_card(from) {
            self.price_half_card(from, scratch);
            return;
        }
        let is_ring = !self.region.mesh.has(from, OPEN) && !self.metric.is_active();
        match self.region.mesh.valence(from) {
            0 => {}
            3..=7 if is_ring => self.price_ring::<2>(from, scratch),
            8..=MAX_LEN if is_ring => self.price_ring::<3>(from, scratch),
            _ => self.price_star(from, scratch),
        }
    }

    /// Returns whether a group is a corner of a card that has lost one of its two faces.
    pub(crate) fn is_half_card(&self, group: u32) -> bool {
        let Region { mesh, groups, .. } = self.region;
        let alone = |g: u32| mesh.valence(g) == 1;
        self.context.input.is_card(groups[group as usize])
            && alone(group)
            && mesh.others(mesh.star(group)[0]).into_iter().all(alone)
    }

    /// Half a card costs nothing more: it goes next, unless it is locked.
    fn price_half_card(&self, from: u32, scratch: &mut Scratch<M::ViewScratch>) {
        let mesh = &self.region.mesh;
        let (borders, seams) = (2, 0);
        if self.permitted(from, borders, seams).is_none() {
            return;
        }
        for to in mesh.others(mesh.star(from)[0]) {
            let target_cost = f64::from(mesh.group_positions[to as usize].target_cost);
            scratch.priced.push(Priced { own_cost: -target_cost, to });
        }
    }

    /// Prices all collapses of any group.
    fn price_star(&self, from: u32, scratch: &mut Scratch<M::ViewScratch>) {
        let Scratch { around, posed, at_rest, attribute_costs, gradients, priced, .. } = scratch;
        let Region { mesh, wedges, quadrics, .. } = self.region;
        let attributes = self.attributes();
        let with_attributes =
            !attributes.attributes.is_empty() && mesh.valence(from) <= MAX_ATTRIBUTE_FACES;
        around.gather(mesh, wedges, from);
        let Some(permitted) = self.permitted(from, around.borders, around.seams) else { return };
        let refitted = quadrics.refit(from, &around.facets, &around.planes);
        let attribute_weight = self.metric.attribute_weight();
        let origin = mesh.position(from);
        let permitted = || around.edges.iter().filter(|e| permitted.allows(e.kind));
        for edge in permitted() {
            let own_cost = refitted.cost(mesh.position(edge.group) - origin);
            priced.push(Priced { own_cost, to: edge.group });
        }
        attribute_costs.clear();
        if with_attributes {
            let position = |g: u32| mesh.group_positions[g as usize].position;
            gradients.fit(attributes, from, position);
            attribute_costs.extend(permitted().map(|edge| {
                let delta = position(edge.group) - position(from);
                attribute_weight * gradients.cost(attributes, delta, around.entries_at(edge))
            }));
        }
        if let Some(view) = self.in_motion().filter(|_| with_attributes) {
            for shape in each_shape(self.turned(from)) {
                let (attributes, position) =
                    (attributes.in_shape(shape), |g: u32| view.position(g, shape));
                gradients.fit(attributes, from, position);
                let weight = view.shapes.weight(shape) * attribute_weight;
                for (attribute_cost, edge) in attribute_costs.iter_mut().zip(permitted()) {
                    let delta = position(edge.group) - position(from);
                    let cost = gradients.cost(attributes, delta, around.entries_at(edge));
                    *attribute_cost = attribute_cost.max(weight * cost);
                }
            }
        }
        if let Some(view) = self.in_motion() {
            at_rest.clear();
            at_rest.extend(priced.iter().map(|p| p.own_cost));
            for shape in each_shape(view.around(from)) {
                let position = |g: u32| view.position(g, shape).as_dvec3();
                around.pose(mesh, wedges, from, position, posed);
                let PosedSurroundings { facets, planes } = &*posed;
                let old = view.quadric(from, shape);
                let refitted = Quadrics::refit_in_motion(&old, facets, planes);
                let (origin, weight) = (position(from), view.shapes.weight(shape));
                for priced in priced.iter_mut() {
                    let cost = weight * refitted.cost(position(priced.to) - origin);
                    priced.own_cost = priced.own_cost.max(cost);
                }
            }
            let weight = self.metric.motion_weight();
            for (priced, at_rest) in priced.iter_mut().zip(&*at_rest) {
                priced.own_cost = at_rest + weight * (priced.own_cost - at_rest);
            }
        }
        for (priced, attribute_cost) in priced.iter_mut().zip(&*attribute_costs) {
            priced.own_cost += attribute_cost;
        }
    }

    /// Prices all collapses of a group with a closed fan of less than `4 N` faces.
    fn price_ring<const N: usize>(&self, from: u32, scratch: &mut Scratch<M::ViewScratch>) {
        let Scratch { around, attribute_costs, gradients, priced, .. } = scratch;
        let Region { mesh, wedges, quadrics, .. } = self.region;
        let star = mesh.star(from);
        let ring = SeamRing::<N>::new(mesh, wedges, from, star);
        let Some(permitted) = self.permitted(from, 0, ring.seams) else { return };
        around.planes.clear();
        ring.add_planes(wedges, &mut around.planes);
        let (weights, area) = ring.ring.weights();
        let refitted = quadrics.refit_features(from, [0.0; 6], f64::from(area), &around.planes);
        let mut by_faces = [Vec4::ZERO; N];
        ring.ring.add_faces(&weights, &mut by_faces);
        let attributes = self.attributes();
        let with_attributes = !attributes.attributes.is_empty();
        let attribute_weight = self.metric.attribute_weight();
        let spokes = ring.ring.spokes();
        let permitted = || ring.edges().filter(|e| permitted.allows(e.1));
        for (i, ..) in permitted() {
            let by_faces = f64::from(by_faces[i / 4][i % 4]);
            let own_cost = by_faces + refitted.cost(spokes[i].as_dvec3());
            priced.push(Priced { own_cost, to: star[i].ahead });
        }
        attribute_costs.clear();
        if with_attributes {
            gradients.fit_ring(attributes, &ring.ring, &ring.corners);
            let cost = |(i, _, faces): (usize, _, &[Entry; 2])| {
                attribute_weight * gradients.cost(attributes, spokes[i], faces)
            };
            attribute_costs.extend(permitted().map(cost));
        }
        if let Some(view) = self.in_motion().filter(|_| with_attributes) {
            for shape in each_shape(self.turned(from)) {
                let moved = OneRing::<N>::in_motion(&view, from, star, shape);
                let (attributes, spokes) = (attributes.in_shape(shape), moved.spokes());
                gradients.fit_ring(attributes, &moved, &ring.corners);
                let weight = view.shapes.weight(shape) * attribute_weight;
                for (attribute_cost, (i, _, faces)) in attribute_costs.iter_mut().zip(permitted()) {
                    let cost = gradients.cost(attributes, spokes[i], faces);
                    *attribute_cost = attribute_cost.max(weight * cost);
                }
            }
        }
        if let Some(view) = self.in_motion() {
            for shape in each_shape(view.around(from)) {
                let moved = OneRing::<N>::in_motion(&view, from, star, shape);
                around.planes.clear();
                ring.add_planes_in(&moved, wedges, &mut around.planes);
                let mut by_faces = [Vec4::ZERO; N];
                moved.add_faces(&moved.weights().0, &mut by_faces);
                let old = view.quadric(from, shape);
                let refitted = Quadrics::refit_in_motion(&old, &[], &around.planes);
                let (spokes, weight) = (moved.spokes(), view.shapes.weight(shape));
                for (priced, (i, ..)) in priced.iter_mut().zip(permitted()) {
                    let by_faces = f64::from(by_faces[i / 4][i % 4]);
                    let cost = weight * (by_faces + refitted.cost(spokes[i].as_dvec3()));
                    priced.own_cost = priced.own_cost.max(cost);
                }
            }
        }
        for (priced, attribute_cost) in priced.iter_mut().zip(&*attribute_costs) {
            priced.own_cost += attribute_cost;
        }
    }

    /// Returns the kinds of edges that a group may move along at the present stage, if any, given
    /// the numbers of borders and seams that end at it. A group on one line of them may follow it;
    /// where several meet (a corner) it may move along any feature, at a price.
    fn permitted(&self, from: u32, borders: u32, seams: u32) -> Option<Permitted> {
        if self.features_may_go {
            return Some(Permitted::All);
        }
        if self.is_locked(from) {
            return None;
        }
        match borders {
            0 if seams < 2 => Some(Permitted::All),
            0 => Some(Permitted::Features),
            _ if self.context.options.lock_border => None,
            2 => Some(Permitted::Borders),
            _ if self.context.options.preserve_topology => None,
            _ => Some(Permitted::Features),
        }
    }

    /// The known choice at its present price; none if it has become dearer, as others may be better
    /// then.
    pub(crate) fn reevaluate_choice(
        &self,
        from: u32,
        known: Choice,
        scratch: &mut Scratch<M::ViewScratch>,
    ) -> Option<Choice> {
        self.price_geometry(from, scratch);
        let Scratch { priced, reevaluating, .. } = scratch;
        let Region { mesh, wedges, .. } = self.region;
        let mut one = [(priced.iter().find(|p| p.to == known.to)?.cost(mesh), known.to)];
        self.metric.reevaluate(mesh, wedges, from, &mut one, false, reevaluating);
        let cost = self.key(from, one[0].0);
        (cost <= known.cost).then_some(Choice { cost, ..known })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::QuadricOnly;
    use crate::number::Input;
    use crate::options::Options;
    use attributes::Attributes;

    /// Calls `test` with the pricer of a mesh.
    fn with_pricer<T>(mesh: &lodc_mesh::Mesh, test: fn(&Pricer<'_, QuadricOnly>) -> T) -> T {
        let input = Input::new(mesh);
        let attributes = Attributes::new(
            mesh,
            &crate::SeenShapes::default(),
            |_| crate::Weights::DEFAULT,
            input.scale,
            input.size,
        );
        let context = Context { input: &input, options: Options::DEFAULT, attributes };
        let region = Region::whole(&input, false);
        test(&Pricer {
            context: &context,
            region: &region,
            metric: &QuadricOnly,
            features_may_go: false,
        })
    }

    /// Prices all plain groups of a mesh, four collapses at a time and one by one. Returns how many
    /// there are.
    fn compare(pricer: &Pricer<'_, QuadricOnly>) -> usize {
        assert!(!pricer.context.attributes.is_empty());
        let region = pricer.region;
        let plain: Vec<u32> =
            (0..region.own_groups() as u32).filter(|&g| pricer.is_plain(g)).collect();
        let mut scratch = Scratch::default();
        for &g in &plain {
            let found = pricer.rank(g, &mut scratch);
            pricer.price_all(g, &mut scratch);
            let cost = |to: u32| scratch.candidates.iter().find(|c| c.1 == to).map(|c| c.0);
            let costs = scratch.candidates.iter().map(|c| c.0);
            let (least, most) =
                (costs.clone().fold(f64::INFINITY, f64::min), costs.fold(0.0, f64::max));
            let at = cost(found.to).expect("a neighbour");
            assert!(at <= least * 1.001 + 1e-6 * most, "{g}: found {at}, least {least}");
            let said = f64::from(found.cost) / f64::from(COST_SCALE);
            assert!((said - at).abs() <= 1e-3 * at + 1e-6 * most, "{g}: {said}, {at}");
        }
        plain.len()
    }

    /// Prices all closed fans of a mesh as rings and as any star. Returns how many have seams.
    fn compare_rings(pricer: &Pricer<'_, QuadricOnly>) -> usize {
        let region = pricer.region;
        let (mut ring, mut star) = (Scratch::default(), Scratch::default());
        let mut seams = 0;
        for g in (0..region.own_groups() as u32).filter(|&g| !region.mesh.has(g, OPEN)) {
            match region.mesh.valence(g) {
                3..=7 => pricer.price_ring::<2>(g, &mut ring),
                8..=MAX_LEN => pricer.price_ring::<3>(g, &mut ring),
                _ => continue,
            }
            pricer.price_star(g, &mut star);
            seams += usize::from(region.mesh.has(g, SEAM));
            assert_eq!(region.mesh.has(g, SEAM), star.around.seams > 0);
            let [found, wanted] = [&mut ring, &mut star].map(|scratch| {
                let mut priced = std::mem::take(&mut scratch.priced);
                priced.sort_by_key(|p| p.to);
                priced
            });
            let targets = |list: &[Priced]| list.iter().map(|p| p.to).collect::<Vec<_>>();
            assert_eq!(targets(&found), targets(&wanted), "{g}");
            let most = wanted.iter().map(|p| p.own_cost).fold(0.0, f64::max);
            for (f, w) in found.iter().zip(&wanted) {
                let close = 1e-3 * w.own_cost + 1e-6 * most;
                assert!(
                    (f.own_cost - w.own_cost).abs() <= close,
                    "{g}: {}, {}",
                    f.own_cost,
                    w.own_cost
                );
            }
        }
        seams
    }

    #[test]
    fn rings_cost_what_any_star_costs() {
        assert!(with_pricer(&lodc_fixtures::uv_sphere(24, 16), compare_rings) >= 14);
        assert!(with_pricer(&lodc_fixtures::machine_part(), compare_rings) > 0);
        with_pricer(&lodc_fixtures::icosphere(3), compare_rings);
    }

    #[test]
    fn attributes_cost_the_same_four_at_a_time_and_one_by_one() {
        assert!(with_pricer(&lodc_fixtures::uv_sphere(24, 16), compare) > 200);
        assert!(with_pricer(&lodc_fixtures::uv_sphere(11, 30), compare) > 200);
    }
}
