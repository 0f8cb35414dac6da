//! Samples of the input on a mesh that the quadric has simplified already: each with the nearest
//! face.

use super::appearance::{Appearance, attribute_vertex};
use super::energy::{geometric_error, shown_at};
use super::lanes::{Four, Shaded4};
use super::placed::Placed;
use super::samples::{CREASE, MAX_AVERAGED, Samples, mix_coordinates};
use crate::cut::{DEAD, Wedges, WorkingMesh};
use glam::{DVec3, Vec3};
use lodc_mesh::{Csr, NONE};
use lodc_nearest::TriangleTree;
use rayon::prelude::*;

/// Gives every sample to the live face that is nearest, and stores the energy of every face.
/// `distance_weight` is the energy of a squared distance of one.
pub(super) fn place(
    mesh: &WorkingMesh,
    wedges: &Wedges,
    appearance: &Appearance<'_>,
    samples: &mut Samples,
    distance_weight: f32,
    energy: &mut [f64],
) {
    let live = live_faces(mesh);
    let corners: Vec<[DVec3; 3]> =
        live.iter().map(|&f| mesh.faces[f as usize].groups.map(|g| mesh.position(g))).collect();
    let tree = TriangleTree::new(&corners);
    let nearest: Vec<u32> = (0..samples.count() as u32)
        .into_par_iter()
        .with_min_len(256)
        .map(|s| {
            tree.nearest(samples.get(s).position.as_dvec3(), NONE).map_or(NONE, |n| n.triangle)
        })
        .collect();
    let of_face = Csr::new(
        live.len(),
        nearest.iter().zip(0..).filter(|(face, _)| **face != NONE).map(|(&face, s)| (face, s)),
    );
    (0..mesh.faces.len() as u32).for_each(|face| samples.clear(face));
    let mut lanes = Vec::new();
    for (i, &face) in (0..).zip(&live) {
        let shown = Shown::new(mesh, wedges, appearance, face);
        for ids in of_face.row(i).chunks(4) {
            shown.put(ids, appearance, samples, distance_weight);
        }
        samples.thin(face);
        lanes.clear();
        Shaded4::gather(face, samples, &mut lanes);
        energy[face as usize] = lanes.iter().map(|four| four.energy(&shown.shading)).sum();
    }
}

/// The faces that are left, in the order of their groups.
fn live_faces(mesh: &WorkingMesh) -> Vec<u32> {
    let groups = (0..mesh.places.len() as u32).filter(|&g| !mesh.has(g, DEAD));
    let first = |g: u32| mesh.star(g).iter().filter(|c| c.at() == 0).map(|c| c.face());
    groups.flat_map(first).collect()
}

/// A face as it is shown.
struct Shown {
    face: u32,
    placed: Placed,
    normal: Vec3,
    /// Normals and texture coordinates of its corners.
    shading: [Vec3; 3],
    texture: [[f32; 2]; 3],
    submesh: u32,
}

impl Shown {
    fn new(mesh: &WorkingMesh, wedges: &Wedges, appearance: &Appearance<'_>, face: u32) -> Self {
        let groups = mesh.faces[face as usize].groups;
        let (placed, normal) = Placed::new(groups.map(|g| mesh.places[g as usize].position));
        let corners = mesh.wedges(face);
        let vertices = corners.map(|w| attribute_vertex(wedges, w));
        let smooth = |g: u32| {
            let faces = mesh.star(g).iter().take(MAX_AVERAGED);
            let normals = faces.map(|c| mesh.normal(c.face()));
            normals.filter(|n| n.dot(normal) > CREASE).sum::<Vec3>().normalize_or_zero()
        };
        let shading = if appearance.has_normals() {
            vertices.map(|v| appearance.normal(v))
        } else {
            groups.map(smooth)
        };
        let texture = vertices.map(|v| appearance.coordinates(v));
        Self { face, placed, normal, shading, texture, submesh: wedges.submesh(corners[0]) }
    }

    /// Gives one to four samples to the face.
    fn put(
        &self,
        ids: &[u32],
        appearance: &Appearance<'_>,
        samples: &mut Samples,
        distance_weight: f32,
    ) {
        let four = Four::new(ids, samples);
        let places = four.nearest(std::iter::once((self.placed, self.normal)));
        let geometric = four.weight * geometric_error(&four, &places, distance_weight);
        for (i, &s) in ids.iter().enumerate() {
            let at = places.at.map(|lane| lane[i]);
            let sample = samples.get(s);
            let shading = if appearance.is_textured() {
                let coordinates = mix_coordinates(&self.texture, at);
                shown_at(sample, appearance, self.submesh, coordinates)
            } else {
                sample.shading
            };
            samples.put(s, self.face, at, geometric[i], shading);
        }
    }
}
