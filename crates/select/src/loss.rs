//! The loss of a scene with every step of every object, in one unit for all objects, so that
//! triangles can be removed where they matter least.

use crate::quadric::accumulated_error;
use crate::visibility::{Part, visible_areas};
use glam::DVec3;
use lodc_mesh::Simplified;
use lodc_scene::{
    Arrangement, Placement, evenly_spread, placement_scales, posed_positions, share_in_pictures,
};
use rayon::prelude::*;

/// Weight of the area of a face that is not visible. Chosen by hand: small, but not nothing, since
/// pictures from outside do not show what a camera inside sees.
const HIDDEN_WEIGHT: f64 = 0.03;
/// If pictures had to show more triangles than this, none are taken and all count as visible.
/// Chosen by hand.
const MAX_TRIANGLES: usize = 1 << 24;

/// Returns for each object the loss after each of its steps, never falling.
///
/// The loss of a level is `G · (W / G)^(3/4)` in world units: `G` the weight of all faces and `W`
/// the accumulated quadric error ([`accumulated_error`]); an area times the power 3/2 of its mean
/// distance. A face weighs 3 % of its area and 97 % of its visible area in pictures of the whole
/// scene from all sides. Instances count by their scales.
#[must_use]
pub fn losses(objects: &[&Simplified], scene: &Arrangement) -> Vec<Vec<f64>> {
    Visibility::new(objects, scene).losses(objects)
}

/// Objects with all their placements, and their visible areas in pictures of the whole scene from
/// all sides.
#[derive(Debug)]
pub(crate) struct Visibility {
    placed: Vec<PlacedObject>,
    /// The visible area by object and triangle, in the placement of largest scale, averaged over
    /// those in pictures. An object that the scene does not show, or of a scene too large for
    /// pictures, has no entries: it counts with its whole area.
    areas: Vec<Vec<f64>>,
}

impl Visibility {
    pub(crate) fn new(objects: &[&Simplified], scene: &Arrangement) -> Self {
        let triangles = |object: usize| objects[object].mesh().triangles().len();
        let share = share_in_pictures(scene.triangles(triangles));
        let has_pictures = scene.thinned(share).triangles(triangles) <= MAX_TRIANGLES;
        Self::in_pictures(objects, scene, has_pictures.then_some(share))
    }

    /// As [`Self::new`], by pictures of a share of each object's placements; of none without.
    fn in_pictures(objects: &[&Simplified], scene: &Arrangement, share: Option<f64>) -> Self {
        let placed: Vec<PlacedObject> = objects
            .par_iter()
            .enumerate()
            .map(|(o, s)| PlacedObject::new(o, s, scene, share))
            .collect();
        let mut parts = Vec::new();
        for (simplified, placed) in objects.iter().zip(&placed) {
            let triangles = simplified.mesh().triangles();
            let positions = placed.pictured().iter().map(|shown| shown.vertices.as_slice());
            parts.extend(positions.map(|positions| Part { positions, triangles }));
        }
        let by_part = visible_areas(&parts);
        let mut by_part = &by_part[..];
        let areas = |placed: &PlacedObject| {
            let parts = by_part.split_off(..placed.pictured().len()).expect("an entry for each");
            placed.mean_visible_areas(parts)
        };
        let areas = placed.iter().map(areas).collect();
        Self { placed, areas }
    }

    /// The loss of each object after each of its steps, never falling: [`losses`].
    pub(crate) fn losses(&self, objects: &[&Simplified]) -> Vec<Vec<f64>> {
        let loss = |((simplified, placed), areas): ((&&Simplified, &PlacedObject), &Vec<f64>)| {
            placed.loss(simplified, areas)
        };
        objects.par_iter().zip(&self.placed).zip(&self.areas).map(loss).collect()
    }

    /// For each object the visible area of each triangle, in world units, instances together.
    pub(crate) fn areas(&self, objects: &[&Simplified]) -> Vec<Vec<f64>> {
        let areas = |((simplified, placed), visible): ((&&Simplified, &PlacedObject), &Vec<_>)| {
            let squared_scales = placed.squared_scales();
            let area = |(t, tri)| squared_scales * placed.area(t, tri, visible, 0.0);
            simplified.mesh().triangles().iter().enumerate().map(area).collect()
        };
        objects.par_iter().zip(&self.placed).zip(&self.areas).map(areas).collect()
    }
}

/// An object with all its placements.
#[derive(Debug)]
struct PlacedObject {
    /// World units per mesh unit of each placement.
    scales: Vec<f64>,
    /// The placements that are shown in pictures, and that of largest scale.
    shown: Vec<ShownPlacement>,
    /// The index in `shown` of that of largest scale.
    largest: usize,
    /// True if it is in the pictures.
    is_pictured: bool,
}

#[derive(Debug)]
struct ShownPlacement {
    vertices: Vec<DVec3>,
    /// World units per mesh unit.
    scale: f64,
}

impl PlacedObject {
    /// Places an object where the scene shows it, or as it was modelled; in the pictures a `share`
    /// of its placements, if there are pictures.
    fn new(
        object: usize,
        simplified: &Simplified,
        scene: &Arrangement,
        share: Option<f64>,
    ) -> Self {
        let mesh = simplified.mesh();
        let usable = |s: f64| s.is_finite() && s > 0.0;
        let as_modelled = Placement::as_modelled(object);
        let mut placed = placement_scales(mesh, object, scene);
        placed.retain(|(_, scale)| usable(*scale));
        let is_in_scene = !placed.is_empty();
        if !is_in_scene {
            placed.push((&as_modelled, 1.0));
        }
        let mut largest = 0;
        for (i, (_, scale)) in placed.iter().enumerate() {
            if *scale > placed[largest].1 {
                largest = i;
            }
        }
        // An object that the scene does not show must not hide others in the pictures.
        let share = share.filter(|_| is_in_scene);
        let mut shown: Vec<usize> =
            share.map_or(vec![], |share| evenly_spread(placed.len(), share).collect());
        let largest_shown = shown.binary_search(&largest).unwrap_or_else(|place| {
            shown.insert(place, largest);
            place
        });
        let show = |&i: &usize| {
            let (placement, scale) = placed[i];
            ShownPlacement { vertices: posed_positions(mesh, placement), scale }
        };
        Self {
            scales: placed.iter().map(|p| p.1).collect(),
            shown: shown.iter().map(show).collect(),
            largest: largest_shown,
            is_pictured: share.is_some(),
        }
    }

    /// The placements that are in pictures.
    fn pictured(&self) -> &[ShownPlacement] {
        if self.is_pictured { &self.shown } else { &[] }
    }

    /// Vertices of the placement of largest scale.
    fn positions(&self) -> &[DVec3] {
        &self.shown[self.largest].vertices
    }

    /// Scales of the placements, relative to the largest.
    fn relative_scales(&self) -> impl Iterator<Item = f64> {
        self.scales.iter().map(|s| s / self.shown[self.largest].scale)
    }

    /// The area of all placements together, relative to that of the largest.
    fn squared_scales(&self) -> f64 {
        self.relative_scales().map(|r| r * r).sum()
    }

    /// The visible area of each triangle in the placement of largest scale, averaged over those in
    /// pictures, from the areas in each of these; nothing without pictures.
    fn mean_visible_areas(&self, by_placement: &[Vec<f64>]) -> Vec<f64> {
        let largest_scale = self.shown[self.largest].scale;
        let squared_scales: f64 =
            self.pictured().iter().map(|p| (p.scale / largest_scale).powi(2)).sum();
        let mean = |t| by_placement.iter().map(|areas| areas[t]).sum::<f64>() / squared_scales;
        (0..by_placement.first().map_or(0, Vec::len)).map(mean).collect()
    }

    /// The visible area of a triangle in the placement of largest scale (`visible` has those of
    /// all; empty without pictures: then all of it), and the rest of its area weighted by
    /// `hidden_weight`.
    fn area(&self, t: usize, triangle: &[u32; 3], visible: &[f64], hidden_weight: f64) -> f64 {
        let [a, b, c] = triangle.map(|v| self.positions()[v as usize]);
        let area = 0.5 * (b - a).cross(c - a).length();
        if visible.is_empty() {
            return area;
        }
        hidden_weight * area + (1.0 - hidden_weight) * visible[t].min(area)
    }

    /// The loss after each step: [`losses`].
    fn loss(&self, simplified: &Simplified, visible: &[f64]) -> Vec<f64> {
        let mesh = simplified.mesh();
        let weight = |(t, tri)| self.area(t, tri, visible, HIDDEN_WEIGHT);
        let weights: Vec<f64> = mesh.triangles().iter().enumerate().map(weight).collect();
        let total: f64 = weights.iter().sum();
        let ids = mesh.position_ids();
        let error = accumulated_error(
            mesh.triangles(),
            self.positions(),
            &ids,
            &weights,
            simplified.collapses(),
        );
        // An area times the power 3/2 of a distance: each instance counts by its scale to the power
        // 2 + 3/2.
        let instances: f64 = self.relative_scales().map(|r| r * r * r * r.sqrt()).sum();
        // The power 3/4 by square roots, which are the same on every machine.
        let power =
            |w: f64| if total > 0.0 { (w / total).sqrt() * (w / total).sqrt().sqrt() } else { 0.0 };
        error.into_iter().map(|w| instances * total * power(w)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Visibility;
    use glam::DVec3;
    use lodc_scene::{Arrangement, Graph, LocalTransform, Node, Transform};

    /// Ten cubes in two rows, and a sphere apart.
    #[test]
    fn a_share_of_the_instances_tells_what_is_seen_of_all() {
        let simplified = ["cube", "icosphere"].map(|name| {
            let mesh = lodc_fixtures::named(name).expect("a shape");
            lodc_simplify::simplify(&mesh, &lodc_simplify::Options::default(), &|_, _| ())
        });
        let objects = [&simplified[0], &simplified[1]];
        let node = |object: u32, x: i32, y: i32| Node {
            local: LocalTransform::Matrix(Transform::from_translation(
                4.0 * DVec3::new(x.into(), y.into(), 0.0),
            )),
            objects: vec![object],
            ..Node::default()
        };
        let mut nodes: Vec<Node> = (0..10).map(|i| node(0, i / 2, i % 2)).collect();
        nodes.push(node(1, 2, 3));
        let graph = Graph { roots: (0..11).collect(), nodes, skins: Vec::new() };
        let scene = Arrangement::new(&graph, &graph.rest_pose(), 2);
        let seen = |share| -> Vec<f64> {
            let areas = Visibility::in_pictures(&objects, &scene, share).areas(&objects);
            areas.iter().map(|areas| areas.iter().sum()).collect()
        };
        let (all, some, whole) = (seen(Some(1.0)), seen(Some(0.2)), seen(None));
        for object in 0..2 {
            assert!((some[object] / all[object] - 1.0).abs() < 0.05, "{all:?} {some:?}");
            assert!(all[object] > 0.8 * whole[object], "{all:?} {whole:?}");
        }
    }
}
