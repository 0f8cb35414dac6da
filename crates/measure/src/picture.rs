//! Pictures of surfaces for comparison: grey or with materials, with a light at the camera, from
//! cameras spread evenly around; and the difference of two sets of pictures.

use crate::surface::Surface;
use glam::{DVec3, Vec2, Vec3};
use lodc_mesh::{PositionIds, floor};
use lodc_raster::{Camera, Fragment, Point, SUBPIXELS, Window, scan, spread_cameras};
use lodc_scene::smooth_normals;
use rayon::prelude::*;

/// Ambient light as a share of white. Chosen by hand, as are the following.
const AMBIENT: f32 = 0.15;
/// The most that the lamp at the camera adds, as a share of white.
const LAMP: f32 = 0.85;
/// Squares of the checkerboard in a unit of texture coordinates, both ways.
const SQUARES: f32 = 16.0;
/// Brightness of the dark squares as a share of white.
const DARK: f32 = 0.5;

/// How pictures are shaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadingOptions {
    /// Shade with the surface's own normals, not with those of its triangles.
    pub own_normals: bool,
    /// Paint a checkerboard by texture coordinates: it shows where a texture is stretched or has
    /// slipped.
    pub checkerboard: bool,
    /// Show the surface's materials, with their textures; else it is white.
    pub materials: bool,
    /// Multiply by the colours of vertices.
    pub vertex_colours: bool,
}

/// The number and size of pictures, taken from all sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Viewing {
    /// Number of cameras, spread evenly.
    pub views: u32,
    /// Pixels across and down.
    pub size: u32,
}

impl Viewing {
    /// 24 pictures of 512 × 512 pixels.
    pub const DEFAULT: Self = Self { views: 24, size: 512 };

    /// Cameras around the middle of a surface's bounding box, as far away as its farthest corner.
    #[must_use]
    pub fn cameras(&self, surface: &Surface) -> Vec<Camera> {
        let (lo, hi) = surface.bounds();
        let center = 0.5 * (lo + hi);
        let corners =
            surface.triangles.iter().flatten().map(|&v| surface.positions[v as usize].as_dvec3());
        let radius = corners.map(|p| p.distance(center)).fold(0.0, f64::max);
        spread_cameras(self.views, center, radius, self.size)
    }
}

/// One picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across and down.
    pub size: u32,
    /// Red, green and blue, 0 to 255, row by row from the top; negative where nothing is shown.
    pub colours: Vec<[f32; 3]>,
    /// The point that each pixel shows, where there is one; empty if they were not asked for.
    pub points: Vec<DVec3>,
}

/// The difference of two surfaces in pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageError {
    /// Root mean square difference of colours (0 to 255 each) over all pixels that either covers; 0
    /// if none.
    pub rmse: f64,
    /// The share of those pixels that only one covers.
    pub silhouette: f64,
}

/// Takes a picture from every camera.
#[must_use]
pub fn pictures(surface: &Surface, cameras: &[Camera], shading: ShadingOptions) -> Vec<Picture> {
    let shaded = ShadedSurface::new(surface, &[shading]);
    cameras.par_iter().map(|camera| shaded.picture_with_points(camera)).collect()
}

/// A surface with the normals that it is shaded by.
pub(crate) struct ShadedSurface<'a> {
    surface: &'a Surface,
    /// The normals at the corners of each triangle.
    normals: Vec<[Vec3; 3]>,
    kinds: Vec<ShadingOptions>,
}

impl<'a> ShadedSurface<'a> {
    /// A surface for pictures of some kinds, at least one. The first says which normals all have.
    pub(crate) fn new(surface: &'a Surface, kinds: &[ShadingOptions]) -> Self {
        let has_own_normals = kinds[0].own_normals && !surface.normals.is_empty();
        let normals = if has_own_normals {
            surface.triangles.iter().map(|t| t.map(|v| surface.normals[v as usize])).collect()
        } else {
            smoothed_normals(surface)
        };
        let possible = |shading: &ShadingOptions| ShadingOptions {
            checkerboard: shading.checkerboard && !surface.texture.is_empty(),
            materials: shading.materials && !surface.material_of.is_empty(),
            vertex_colours: shading.vertex_colours && !surface.colours.is_empty(),
            ..*shading
        };
        Self { surface, normals, kinds: kinds.iter().map(possible).collect() }
    }

    /// Takes a picture of the first kind, without points.
    pub(crate) fn picture(&self, camera: &Camera) -> Picture {
        take_pictures(self, &self.kinds[..1], camera, false).swap_remove(0)
    }

    /// Takes a picture of the first kind, with the points that it shows.
    fn picture_with_points(&self, camera: &Camera) -> Picture {
        take_pictures(self, &self.kinds[..1], camera, true).swap_remove(0)
    }

    /// Takes a picture of each kind, without points.
    pub(crate) fn kinds(&self, camera: &Camera) -> Vec<Picture> {
        take_pictures(self, &self.kinds, camera, false)
    }
}

/// Smooth normals of all corners. Vertices at one position count as one.
fn smoothed_normals(surface: &Surface) -> Vec<[Vec3; 3]> {
    let single: Vec<[f32; 3]> = surface.positions.iter().map(|p| p.to_array()).collect();
    let positions: Vec<DVec3> = surface.positions.iter().map(|p| p.as_dvec3()).collect();
    smooth_normals(&surface.triangles, &positions, &PositionIds::new(&single))
}

/// Compares pictures taken by the same cameras.
#[must_use]
pub fn compare_pictures(a: &[Picture], b: &[Picture]) -> ImageError {
    image_error(a.iter().zip(b).map(|(a, b)| Difference::new(a, b)))
}

/// The difference of two pictures by the same camera, or of several.
#[derive(Clone, Copy, Debug, Default)]
pub struct Difference {
    /// Pixels that either picture covers.
    pixels: u64,
    /// Pixels that only one of them covers.
    covered_once: u64,
    /// Sum over pixels of the mean squared difference of their channels.
    squared: f64,
}

impl Difference {
    pub(crate) fn new(a: &Picture, b: &Picture) -> Self {
        let mut all = Self::default();
        for (x, y) in a.colours.iter().zip(&b.colours) {
            let is_covered = [x, y].map(|colour| colour[0] >= 0.0);
            if is_covered[0] || is_covered[1] {
                all.pixels += 1;
                all.covered_once += u64::from(is_covered[0] != is_covered[1]);
                // Pixels that are not covered count as black.
                let square = |c: usize| f64::from(x[c].max(0.0) - y[c].max(0.0)).powi(2);
                all.squared += (square(0) + square(1) + square(2)) / 3.0;
            }
        }
        all
    }

    /// The difference of the pictures of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            covered_once: self.covered_once + other.covered_once,
            squared: self.squared + other.squared,
        }
    }

    /// The image error over the pictures.
    #[must_use]
    pub fn error(self) -> ImageError {
        if self.pixels == 0 {
            return ImageError { rmse: 0.0, silhouette: 0.0 };
        }
        let pixels = self.pixels as f64;
        ImageError {
            rmse: (self.squared / pixels).sqrt(),
            silhouette: self.covered_once as f64 / pixels,
        }
    }
}

/// The image error over some pictures.
pub(crate) fn image_error(pictures: impl Iterator<Item = Difference>) -> ImageError {
    pictures.fold(Difference::default(), Difference::and).error()
}

/// Takes pictures of some kinds by one camera: what each pixel shows is found once for all.
fn take_pictures(
    ShadedSurface { surface, normals, .. }: &ShadedSurface<'_>,
    kinds: &[ShadingOptions],
    camera: &Camera,
    with_points: bool,
) -> Vec<Picture> {
    let size = camera.size;
    let points: Vec<Point> =
        surface.positions.iter().map(|p| camera.project(p.as_dvec3())).collect();
    let mut nearest_fragments = vec![Fragment::NOTHING; (size * size) as usize];
    for (t, triangle) in (0..).zip(&surface.triangles) {
        scan(triangle.map(|v| points[v as usize]), Window::whole(size), |column, row, depth| {
            let nearest = &mut nearest_fragments[(row * size as i32 + column) as usize];
            *nearest = Fragment::new(t, depth).min(*nearest);
        });
    }
    let mut colours = vec![vec![[-1.0; 3]; nearest_fragments.len()]; kinds.len()];
    let mut shown_points = vec![DVec3::ZERO; if with_points { nearest_fragments.len() } else { 0 }];
    for (i, fragment) in
        nearest_fragments.into_iter().enumerate().filter(|(_, f)| *f != Fragment::NOTHING)
    {
        let triangle = surface.triangles[fragment.item() as usize];
        let corners = triangle.map(|v| points[v as usize]);
        let (column, row) = (i as u32 % size, i as u32 / size);
        let (shares, area) = shares(corners, column, row);
        let mix = |values: [Vec3; 3]| {
            values[0] * shares[0] + values[1] * shares[1] + values[2] * shares[2]
        };
        let normal = mix(normals[fragment.item() as usize]).normalize_or_zero();
        // Back faces are lit from behind. Rows run downwards, so triangles that are
        // counter-clockwise in space are clockwise here.
        let cosine = normal.dot(camera.toward.as_vec3()) * if area < 0.0 { 1.0 } else { -1.0 };
        let light = (AMBIENT + LAMP * cosine.max(0.0)).min(1.0);
        for (shading, colours) in kinds.iter().zip(&mut colours) {
            let behind = if shading.materials {
                material_colour(surface, fragment.item() as usize, shares, area)
            } else if shading.checkerboard
                && is_dark(texture_coordinates(surface, triangle, shares) * SQUARES)
            {
                Vec3::splat(DARK)
            } else {
                Vec3::ONE
            };
            let colour = if shading.vertex_colours {
                behind * as_shown(mix(triangle.map(|v| surface.colours[v as usize])))
            } else {
                behind
            };
            colours[i] = (colour * light * 255.0).into();
        }
        if let Some(point) = shown_points.get_mut(i) {
            *point = mix(triangle.map(|v| surface.positions[v as usize])).as_dvec3();
        }
    }
    let picture = |colours| Picture { size, colours, points: shown_points.clone() };
    colours.into_iter().map(picture).collect()
}

/// Texture coordinates at shares of a triangle's corners.
fn texture_coordinates(surface: &Surface, triangle: [u32; 3], shares: [f32; 3]) -> Vec2 {
    let at = |c: usize| surface.texture[triangle[c] as usize] * shares[c];
    at(0) + at(1) + at(2)
}

/// The colour of a triangle at shares of its corners. `area` is twice that of its picture, in
/// squared subpixels.
fn material_colour(surface: &Surface, t: usize, shares: [f32; 3], area: f64) -> Vec3 {
    let material = &surface.materials[surface.material_of[t] as usize];
    let [r, g, b, _] = material.colour;
    let colour = as_shown(Vec3::new(r, g, b));
    let Some(texture) = material.texture else { return colour };
    let image = &surface.images[texture.image];
    let transformed = |uv: Vec2| Vec2::from(texture.to_image(uv.into()));
    let triangle = surface.triangles[t];
    let [a, b, c] = triangle.map(|v| transformed(surface.texture[v as usize]));
    let pixels = (area.abs() / f64::from(SUBPIXELS * SUBPIXELS)) as f32;
    let texels_per_pixel =
        (b - a).perp_dot(c - a).abs() * image.area() / pixels.max(f32::MIN_POSITIVE);
    colour
        * image.at(
            transformed(texture_coordinates(surface, triangle, shares)),
            texels_per_pixel,
            texture.wrap,
        )
}

/// A linear colour as texels have it, in sRGB. A square root is close to its curve, and the same on
/// every machine.
fn as_shown(linear: Vec3) -> Vec3 {
    linear.max(Vec3::ZERO).map(f32::sqrt)
}

/// Returns whether a point, in squares of the checkerboard, is in a dark one.
fn is_dark(point: Vec2) -> bool {
    let is_odd = |x: f32| floor(x).rem_euclid(2.0) >= 1.0;
    is_odd(point.x) != is_odd(point.y)
}

/// A pixel centre's shares of a triangle's corners (barycentric coordinates), and twice the
/// triangle's area in squared subpixels.
fn shares(corners: [Point; 3], column: u32, row: u32) -> ([f32; 3], f64) {
    let center = |pixel: u32| f64::from(pixel) * f64::from(SUBPIXELS) + f64::from(SUBPIXELS / 2);
    let (x, y) = (center(column), center(row));
    let [a, b, c] = corners.map(|p| (f64::from(p.x), f64::from(p.y)));
    let area = (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    let share_b = ((x - a.0) * (c.1 - a.1) - (y - a.1) * (c.0 - a.0)) / area;
    let share_c = ((b.0 - a.0) * (y - a.1) - (b.1 - a.1) * (x - a.0)) / area;
    ([(1.0 - share_b - share_c) as f32, share_b as f32, share_c as f32], area)
}
