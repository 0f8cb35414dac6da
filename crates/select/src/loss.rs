//! What a scene loses with every step of every object, in one unit for all objects, so that
//! triangles can be taken where they matter least.

use crate::quadric::accumulated_error;
use crate::visibility::{Part, seen_areas};
use glam::DVec3;
use lodc_mesh::{PositionIds, Simplified};
use lodc_scene::{Arrangement, Placement, placement_scales, posed_positions};
use rayon::prelude::*;

/// Weight of the area of a face that is not seen. Chosen by hand.
const HIDDEN: f64 = 0.03;
/// With more triangles than this, instances counted, no pictures are taken and all count as seen.
/// Chosen by hand.
const MAX_TRIANGLES: usize = 1 << 24;

/// Returns for each object the loss after each of its steps, never falling.
///
/// The loss of a level is `G · (W / G)^(3/4)` in world units: `G` the weight of all faces and `W`
/// the accumulated quadric error ([`accumulated_error`]); an area times the 3/2th power of its mean
/// distance. A face weighs 3 % of its area and 97 % of what is seen of it in pictures of the whole
/// scene from all sides. Instances count by their scales.
#[must_use]
pub fn losses(objects: &[&Simplified], scene: &Arrangement) -> Vec<Vec<f64>> {
    Visibility::new(objects, scene).losses(objects)
}

/// Objects with all their placements, and what is seen of each in pictures of the whole scene from
/// all sides.
#[derive(Debug)]
pub(crate) struct Visibility {
    shown: Vec<PlacedObject>,
    /// By object, placement and triangle the area that is seen. Nothing of an object that the scene
    /// does not show, and of a scene too large to look at: it counts with its whole area.
    areas: Vec<Vec<Vec<f64>>>,
}

impl Visibility {
    pub(crate) fn new(objects: &[&Simplified], scene: &Arrangement) -> Self {
        let of_placement = |p: &Placement| objects[p.object].mesh().triangles().len();
        let triangles = scene.placements().iter().map(of_placement).fold(0, usize::saturating_add);
        let visible = triangles <= MAX_TRIANGLES;
        let shown: Vec<PlacedObject> = objects
            .par_iter()
            .enumerate()
            .map(|(o, s)| place_object(o, s, scene, visible))
            .collect();
        let mut parts = Vec::new();
        for (simplified, shown) in objects.iter().zip(&shown) {
            let triangles = simplified.mesh().triangles();
            parts.extend(shown.visible().iter().map(|positions| Part { positions, triangles }));
        }
        let mut areas = seen_areas(&parts).into_iter();
        let areas =
            shown.iter().map(|s| areas.by_ref().take(s.visible().len()).collect()).collect();
        Self { shown, areas }
    }

    /// The loss of each object after each of its steps, never falling: [`losses`].
    pub(crate) fn losses(&self, objects: &[&Simplified]) -> Vec<Vec<f64>> {
        let loss =
            |((simplified, shown), areas): ((&&Simplified, &PlacedObject), &Vec<Vec<f64>>)| {
                shown.loss(simplified, areas)
            };
        objects.par_iter().zip(&self.shown).zip(&self.areas).map(loss).collect()
    }

    /// For each object the area of each triangle that is seen, in world units, instances together.
    pub(crate) fn areas(&self, objects: &[&Simplified]) -> Vec<Vec<f64>> {
        let of_object = |((simplified, shown), seen): ((&&Simplified, &PlacedObject), &Vec<_>)| {
            let squares = shown.squares();
            let area = |(t, tri)| squares * shown.area(t, tri, seen, 0.0);
            simplified.mesh().triangles().iter().enumerate().map(area).collect()
        };
        objects.par_iter().zip(&self.shown).zip(&self.areas).map(of_object).collect()
    }
}

/// An object with all its placements.
#[derive(Debug)]
struct PlacedObject {
    /// The vertices of each placement; only of that of largest scale if there are no pictures.
    placed: Vec<Vec<DVec3>>,
    is_visible: bool,
    /// World units per mesh unit of each placement.
    scales: Vec<f64>,
    /// The placement of largest scale.
    largest: usize,
}

/// Places an object where the scene shows it, or as it was modelled.
fn place_object(
    object: usize,
    simplified: &Simplified,
    scene: &Arrangement,
    visible: bool,
) -> PlacedObject {
    let mesh = simplified.mesh();
    let usable = |s: f64| s.is_finite() && s > 0.0;
    let as_modelled = Placement::as_modelled(object);
    let mut placed = placement_scales(mesh, object, scene);
    placed.retain(|(_, scale)| usable(*scale));
    let hidden = placed.is_empty();
    if hidden {
        placed.push((&as_modelled, 1.0));
    }
    let mut largest = 0;
    for (i, (_, scale)) in placed.iter().enumerate() {
        if *scale > placed[largest].1 {
            largest = i;
        }
    }
    let scales = placed.iter().map(|p| p.1).collect();
    // An object that nothing shows hides nothing.
    let is_visible = visible && !hidden;
    if !is_visible {
        placed = vec![placed[largest]];
    }
    let placed = placed.iter().map(|(placement, _)| posed_positions(mesh, placement)).collect();
    PlacedObject { placed, is_visible, scales, largest }
}

impl PlacedObject {
    /// The vertices of the placements that are in pictures.
    fn visible(&self) -> &[Vec<DVec3>] {
        if self.is_visible { &self.placed } else { &[] }
    }

    /// Vertices of the placement of largest scale.
    fn positions(&self) -> &[DVec3] {
        &self.placed[if self.is_visible { self.largest } else { 0 }]
    }

    /// Scales of the placements, of the largest.
    fn ratios(&self) -> impl Iterator<Item = f64> {
        self.scales.iter().map(|s| s / self.scales[self.largest])
    }

    /// The area of all placements, in areas of the largest.
    fn squares(&self) -> f64 {
        self.ratios().map(|r| r * r).sum()
    }

    /// What is seen of a triangle of the largest placement, on the mean of all, and a share
    /// `hidden` of the rest of its area; all of it where nothing was looked at.
    fn area(&self, t: usize, triangle: &[u32; 3], seen: &[Vec<f64>], hidden: f64) -> f64 {
        let [a, b, c] = triangle.map(|v| self.positions()[v as usize]);
        let area = 0.5 * (b - a).cross(c - a).length();
        if seen.is_empty() {
            return area;
        }
        let seen = seen.iter().map(|part| part[t]).sum::<f64>() / self.squares();
        hidden * area + (1.0 - hidden) * seen.min(area)
    }

    fn loss(&self, simplified: &Simplified, seen: &[Vec<f64>]) -> Vec<f64> {
        let mesh = simplified.mesh();
        let weight = |(t, tri)| self.area(t, tri, seen, HIDDEN);
        let weights: Vec<f64> = mesh.triangles().iter().enumerate().map(weight).collect();
        let total: f64 = weights.iter().sum();
        let ids = PositionIds::new(mesh.positions());
        let error = accumulated_error(
            mesh.triangles(),
            self.positions(),
            &ids,
            &weights,
            simplified.collapses(),
        );
        // Scale to the power of 2 + 3/2 for each instance.
        let instances: f64 = self.ratios().map(|r| r * r * r * r.sqrt()).sum();
        let power =
            |w: f64| if total > 0.0 { (w / total).sqrt() * (w / total).sqrt().sqrt() } else { 0.0 };
        error.into_iter().map(|w| instances * total * power(w)).collect()
    }
}
