//! The loss of a scene with every step of every object, in one unit for all objects, so that
//! triangles can be removed where they matter least.

use crate::quadric::accumulated_error;
use crate::visibility::{Part, visible_areas};
use glam::DVec3;
use lodc_mesh::{PositionIds, Simplified};
use lodc_scene::{Arrangement, Placement, placement_scales, posed_positions};
use rayon::prelude::*;

/// Weight of the area of a face that is not visible. Chosen by hand: small, but not nothing, since
/// pictures from outside do not show what a camera inside sees.
const HIDDEN_WEIGHT: f64 = 0.03;
/// With more triangles than this, instances counted, no pictures are taken and all count as
/// visible. Chosen by hand.
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
    /// The visible area by object, placement and triangle. An object that the scene does not show,
    /// or of a scene too large for pictures, has no entries: it counts with its whole area.
    areas: Vec<Vec<Vec<f64>>>,
}

impl Visibility {
    pub(crate) fn new(objects: &[&Simplified], scene: &Arrangement) -> Self {
        let triangles = |p: &Placement| objects[p.object].mesh().triangles().len();
        let triangles = scene.placements().iter().map(triangles).fold(0, usize::saturating_add);
        let with_pictures = triangles <= MAX_TRIANGLES;
        let placed: Vec<PlacedObject> = objects
            .par_iter()
            .enumerate()
            .map(|(o, s)| place_object(o, s, scene, with_pictures))
            .collect();
        let mut parts = Vec::new();
        for (simplified, placed) in objects.iter().zip(&placed) {
            let triangles = simplified.mesh().triangles();
            parts.extend(placed.pictured().iter().map(|positions| Part { positions, triangles }));
        }
        let mut areas = visible_areas(&parts).into_iter();
        let areas =
            placed.iter().map(|p| areas.by_ref().take(p.pictured().len()).collect()).collect();
        Self { placed, areas }
    }

    /// The loss of each object after each of its steps, never falling: [`losses`].
    pub(crate) fn losses(&self, objects: &[&Simplified]) -> Vec<Vec<f64>> {
        let loss =
            |((simplified, placed), areas): ((&&Simplified, &PlacedObject), &Vec<Vec<f64>>)| {
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
    /// The vertices of each placement; only of that of largest scale if it is in no pictures.
    vertices: Vec<Vec<DVec3>>,
    /// True if it is in the pictures.
    is_pictured: bool,
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
    with_pictures: bool,
) -> PlacedObject {
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
    let scales = placed.iter().map(|p| p.1).collect();
    // An object that the scene does not show must not hide others in the pictures.
    let is_pictured = with_pictures && is_in_scene;
    if !is_pictured {
        placed = vec![placed[largest]];
    }
    let vertices = placed.iter().map(|(placement, _)| posed_positions(mesh, placement)).collect();
    PlacedObject { vertices, is_pictured, scales, largest }
}

impl PlacedObject {
    /// The vertices of the placements that are in pictures.
    fn pictured(&self) -> &[Vec<DVec3>] {
        if self.is_pictured { &self.vertices } else { &[] }
    }

    /// Vertices of the placement of largest scale.
    fn positions(&self) -> &[DVec3] {
        &self.vertices[if self.is_pictured { self.largest } else { 0 }]
    }

    /// Scales of the placements, relative to the largest.
    fn relative_scales(&self) -> impl Iterator<Item = f64> {
        self.scales.iter().map(|s| s / self.scales[self.largest])
    }

    /// The area of all placements together, relative to that of the largest.
    fn squared_scales(&self) -> f64 {
        self.relative_scales().map(|r| r * r).sum()
    }

    /// The visible area of a triangle in the placement of largest scale, averaged over all
    /// placements (`visible`, empty without pictures: then all of it), and the rest of its area
    /// weighted by `hidden_weight`.
    fn area(&self, t: usize, triangle: &[u32; 3], visible: &[Vec<f64>], hidden_weight: f64) -> f64 {
        let [a, b, c] = triangle.map(|v| self.positions()[v as usize]);
        let area = 0.5 * (b - a).cross(c - a).length();
        if visible.is_empty() {
            return area;
        }
        let visible = visible.iter().map(|part| part[t]).sum::<f64>() / self.squared_scales();
        hidden_weight * area + (1.0 - hidden_weight) * visible.min(area)
    }

    /// The loss after each step: [`losses`].
    fn loss(&self, simplified: &Simplified, visible: &[Vec<f64>]) -> Vec<f64> {
        let mesh = simplified.mesh();
        let weight = |(t, tri)| self.area(t, tri, visible, HIDDEN_WEIGHT);
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
        // An area times the power 3/2 of a distance: each instance counts by its scale to the power
        // 2 + 3/2.
        let instances: f64 = self.relative_scales().map(|r| r * r * r * r.sqrt()).sum();
        // The power 3/4 by square roots, which are the same on every machine.
        let power =
            |w: f64| if total > 0.0 { (w / total).sqrt() * (w / total).sqrt().sqrt() } else { 0.0 };
        error.into_iter().map(|w| instances * total * power(w)).collect()
    }
}
