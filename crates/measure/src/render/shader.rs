//! The colour of a point of a triangle: material, texture and vertex colours, lit by lamps that
//! move with the camera, and with the edges of triangles if asked for.

use super::projection::Projection;
use super::{BackFaces, Corner, Style};
use crate::texture::Pyramid;
use glam::{DVec3, Vec2, Vec3};
use lodc_scene::{AlphaMode, Image, Material, to_linear};
use rayon::prelude::*;

/// Linear colour of edges, and by how much it covers that of triangles. Chosen by hand.
const WIRE: Vec3 = Vec3::new(0.01, 0.012, 0.02);
const WIRE_OPACITY: f32 = 0.85;
/// Linear colour of back faces where they are marked. Chosen by hand.
const MARKED_BACK_FACES: Vec3 = Vec3::new(0.9, 0.02, 0.45);
/// Colours are computed this many times in a pixel, across and down.
const CELLS: f32 = 2.0;

/// A linear colour multiplied by its opacity, which is the fourth.
pub(super) type Light = [f32; 4];

/// The images of materials.
pub(super) struct Textures {
    /// By image; none if no material uses it.
    images: Vec<Option<Pyramid>>,
    /// The linear light of every value of a texel.
    linear: [f32; 256],
}

impl Textures {
    pub(super) fn new(images: &[Image], materials: &[Material]) -> Self {
        let is_used = |i: usize| materials.iter().any(|m| m.texture.is_some_and(|t| t.image == i));
        let kept = |i: usize| is_used(i).then(|| Pyramid::new(&images[i]));
        Self {
            images: (0..images.len()).into_par_iter().map(kept).collect(),
            linear: std::array::from_fn(|i| to_linear(i as f32 / 255.0)),
        }
    }
}

/// The camera's lamps and directions: the same for all points of a picture.
pub(super) struct Lamps {
    toward: Vec3,
    eye: Option<Vec3>,
    sky: Vec3,
    key: Vec3,
    fill: Vec3,
}

impl Lamps {
    /// A key lamp at the upper left, a weak one at the right. Chosen by hand.
    pub(super) fn new(projection: &Projection<'_>) -> Self {
        let [right, up, toward] = projection.camera.axes();
        Self {
            toward,
            eye: projection.camera.eye(),
            sky: projection.camera.world_up(),
            key: (0.9 * toward + 0.75 * up - 0.6 * right).normalize_or_zero(),
            fill: (0.6 * toward + 0.05 * up + 0.9 * right).normalize_or_zero(),
        }
    }

    /// A surface's colour in their light, that of the sky and some from the ground, and a faint
    /// highlight. All numbers are chosen by hand.
    fn lit(&self, albedo: Vec3, normal: Vec3, position: Vec3) -> Vec3 {
        let sky = 0.5 + 0.5 * normal.dot(self.sky);
        let (ground_light, sky_light) = (Vec3::new(0.13, 0.12, 0.115), Vec3::new(0.27, 0.28, 0.30));
        let light = ground_light
            + (sky_light - ground_light) * sky
            + 0.62 * normal.dot(self.key).max(0.0)
            + 0.12 * normal.dot(self.fill).max(0.0);
        let toward_eye = self.eye.map_or(self.toward, |eye| (eye - position).normalize_or_zero());
        let half_way = (self.key + toward_eye).normalize_or_zero();
        let mut shine = normal.dot(half_way).max(0.0);
        // To the power of 32.
        for _ in 0..5 {
            shine *= shine;
        }
        albedo * light + 0.03 * shine
    }
}

/// A triangle, ready to say the colours of its points.
pub(super) struct Surface<'a> {
    corners: &'a [Corner; 3],
    material: &'a Material,
    /// Shares of the corners are these times (column, row, 1), divided by their sum: so they are
    /// right in perspective, wherever the triangle was cut.
    shares: [DVec3; 3],
    is_front: bool,
}

/// A point of a triangle.
struct Place {
    /// Shares of its corners.
    shares: Vec3,
    /// Their change from cell to cell, to the right and down.
    change: [Vec3; 2],
}

impl<'a> Surface<'a> {
    /// A triangle; none if back faces are not drawn and this is one, or if it is seen edge-on.
    pub(super) fn new(
        corners: &'a [Corner; 3],
        material: &'a Material,
        projection: &Projection<'_>,
        back_faces: BackFaces,
    ) -> Option<Self> {
        let [a, b, c] = corners.each_ref().map(|corner| {
            let [x, y, w, _] = projection.seen(corner);
            DVec3::new(x, y, w)
        });
        let shares = [b.cross(c), c.cross(a), a.cross(b)];
        let side = a.dot(shares[0]);
        // Rows run downwards, so what is counter-clockwise in space is clockwise here.
        let is_front = side < 0.0;
        let is_drawn = match back_faces {
            BackFaces::AsMaterial => is_front || material.double_sided,
            BackFaces::Shown | BackFaces::Marked => true,
            BackFaces::Hidden => is_front,
        };
        let is_seen = side != 0.0 && side.is_finite();
        (is_drawn && is_seen).then_some(Self { corners, material, shares, is_front })
    }

    fn place(&self, [x, y]: [f32; 2]) -> Place {
        let at = DVec3::new(f64::from(x), f64::from(y), 1.0);
        let values = DVec3::from(self.shares.map(|s| s.dot(at)));
        let sum = values.x + values.y + values.z;
        let exact = values / sum;
        let change = |axis: usize| {
            let of_sum = self.shares[0][axis] + self.shares[1][axis] + self.shares[2][axis];
            let steps = DVec3::from(self.shares.map(|s| s[axis]));
            ((steps - exact * of_sum) / (sum * f64::from(CELLS))).as_vec3()
        };
        // Points are snapped to a grid, so that the picture of a triangle reaches a little beyond
        // it, and far beyond one that is hardly an area.
        let inside = exact.clamp(DVec3::ZERO, DVec3::ONE);
        let all = inside.x + inside.y + inside.z;
        let shares = if all > 0.0 { inside / all } else { DVec3::splat(1.0 / 3.0) };
        Place { shares: shares.as_vec3(), change: [change(0), change(1)] }
    }

    fn mix3(&self, place: &Place, of: impl Fn(&Corner) -> [f32; 3]) -> Vec3 {
        let [a, b, c] = self.corners.each_ref().map(|corner| Vec3::from(of(corner)));
        a * place.shares.x + b * place.shares.y + c * place.shares.z
    }

    /// The colour without light; the fourth is opacity as it stands.
    fn albedo(&self, textures: &Textures, place: &Place) -> Light {
        let [a, b, c] = self.corners.each_ref().map(|corner| corner.colour);
        let s = place.shares;
        let texel = self.material.texture.map_or([1.0; 4], |texture| {
            let [a, b, c] = self.corners.each_ref().map(|c| Vec2::from(texture.to_image(c.uv)));
            let mix = |s: Vec3| a * s.x + b * s.y + c * s.z;
            let image = textures.images[texture.image].as_ref().expect("an image in use is kept");
            let [across, down] = place.change.map(|s| (mix(s) * image.size()).length_squared());
            let texels = across.max(down);
            image.light(mix(s), texels, &texture, &textures.linear)
        });
        std::array::from_fn(|i| {
            self.material.colour[i] * (a[i] * s.x + b[i] * s.y + c[i] * s.z) * texel[i]
        })
    }

    /// Returns whether a point is not cut away by its material's mask.
    pub(super) fn is_solid(&self, textures: &Textures, at: [f32; 2]) -> bool {
        match self.material.alpha {
            AlphaMode::Mask(least) => self.albedo(textures, &self.place(at))[3] >= least,
            AlphaMode::Opaque | AlphaMode::Blend => true,
        }
    }

    /// Returns the light from a point.
    pub(super) fn light(
        &self,
        textures: &Textures,
        lamps: &Lamps,
        style: &Style,
        at: [f32; 2],
    ) -> Light {
        let place = self.place(at);
        let [r, g, b, opacity] = self.albedo(textures, &place);
        let mut albedo = Vec3::new(r, g, b);
        let mut opacity = if self.material.alpha == AlphaMode::Blend { opacity } else { 1.0 };
        if !self.is_front && style.back_faces == BackFaces::Marked {
            (albedo, opacity) = (MARKED_BACK_FACES, 1.0);
        }
        let mut rgb = albedo;
        if !self.material.unlit {
            let normal = self.mix3(&place, |c| c.normal).normalize_or_zero();
            let normal = if self.is_front { normal } else { -normal };
            rgb = lamps.lit(albedo, normal, self.mix3(&place, |c| c.position));
        }
        if style.wire > 0.0 {
            let line = edge(&place, style.wire * CELLS);
            rgb = rgb.lerp(WIRE, line * WIRE_OPACITY);
            opacity = opacity.max(line);
        }
        let rgb = rgb.clamp(Vec3::ZERO, Vec3::ONE) * opacity;
        [rgb.x, rgb.y, rgb.z, opacity]
    }
}

/// How much of a triangle's edges, of a width in cells, is seen at a place, 0 to 1. Where triangles
/// are hardly larger than the line it fades, or dense meshes would be all line. The numbers are
/// chosen by hand.
fn edge(place: &Place, width: f32) -> f32 {
    // Each share falls from 1 at a corner to 0 at the opposite edge.
    let change = place.change[0].abs() + place.change[1].abs();
    let nearest = (place.shares / change.max(Vec3::splat(1e-6))).min_element();
    let half_width = 0.5 * width;
    let t = (nearest - half_width + 0.5).clamp(0.0, 1.0);
    let line = 1.0 - t * t * (3.0 - 2.0 * t);
    line * (1.6 - 2.4 * half_width * change.max_element()).clamp(0.25, 1.0)
}
