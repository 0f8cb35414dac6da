//! Draws a picture, in bands of rows that know nothing of each other.

use super::projection::Projection;
use super::shader::{Lamps, Light, Surface, Textures};
use super::{Camera, Corner, Style};
use lodc_raster::{Fragment, Point, SUBPIXELS, Window, scan};
use lodc_scene::{AlphaMode, Image, Material, to_linear, to_srgb};
use rayon::prelude::*;

/// Rows of a band. Chosen by hand: few enough that a band's samples stay near the processor.
const ROWS: usize = 8;
/// A triangle over more bands than this is looked at by all. Chosen by hand: bounds the memory.
const MAX_BANDS: usize = 4;

/// Where a pixel's samples are, in sixteenths from its left and upper edge: one in each row, in
/// each column, and in each of 4 by 4 squares (Hammersley's points), quarter by quarter.
const SAMPLES: [[i32; 2]; 16] = [
    [0, 0],
    [2, 4],
    [4, 2],
    [6, 6],
    [8, 1],
    [10, 5],
    [12, 3],
    [14, 7],
    [1, 8],
    [3, 12],
    [5, 10],
    [7, 14],
    [9, 9],
    [11, 13],
    [13, 11],
    [15, 15],
];
/// Samples of a quarter of a pixel, which has one colour for each triangle.
const QUARTER: usize = 4;

/// Some triangles of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The number of the material.
    pub material: usize,
    /// Three for a triangle.
    pub corners: Vec<Corner>,
}

/// Draws pictures with the same materials.
pub struct Painter {
    materials: Vec<Material>,
    textures: Textures,
}

/// The triangles of a picture.
struct Triangles<'a> {
    runs: &'a [Run],
    /// The number of the first triangle of each run.
    starts: Vec<u32>,
}

impl<'a> Triangles<'a> {
    /// # Panics
    /// If there are more than 2^32.
    fn new(runs: &'a [Run]) -> Self {
        let mut next = 0;
        let start = |run: &Run| {
            let start = u32::try_from(next).expect("fewer than 2^32 triangles");
            next += run.corners.len() / 3;
            start
        };
        let starts = runs.iter().map(start).collect();
        Self { runs, starts }
    }

    /// The material and the corners of a triangle.
    fn get(&self, number: u32) -> (usize, &'a [Corner; 3]) {
        let run = self.starts.partition_point(|&start| start <= number) - 1;
        let (run, start) = (&self.runs[run], self.starts[run]);
        (run.material, &run.corners.as_chunks().0[(number - start) as usize])
    }
}

/// A visible part of a triangle.
#[derive(Clone, Copy)]
struct Piece {
    points: [Point; 3],
    triangle: u32,
}

impl Painter {
    /// Prepares drawing with some materials. Images that no material uses are left out.
    ///
    /// # Panics
    /// If a material names an image that is not there.
    #[must_use]
    pub fn new(images: &[Image], materials: Vec<Material>) -> Self {
        Self { textures: Textures::new(images, &materials), materials }
    }

    pub(super) fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Draws triangles. Of surfaces at one depth the first is seen; a blended one hides nothing
    /// that comes after it, so that those come last and from far to near.
    ///
    /// # Panics
    /// If there is no such material, or no pixel.
    #[must_use]
    pub fn draw(&self, camera: &Camera, style: &Style, runs: &[Run]) -> Image {
        let [width, height] = style.size.map(|s| s as usize);
        assert!(width > 0 && height > 0, "a picture has pixels");
        let triangles = Triangles::new(runs);
        let projection = Projection::new(camera, style.size);
        let pieces = self.pieces(&triangles, &projection, style);
        let bands = Bands::new(&pieces, height);
        let shot =
            Shot { painter: self, style, triangles, lamps: Lamps::new(&projection), projection };
        let mut bytes = vec![0; 4 * width * height];
        bytes.par_chunks_mut(4 * width * ROWS).enumerate().for_each(|(band, bytes)| {
            let list = bands.list(band);
            Band::new(&shot, band * ROWS, bytes.len() / 4 / width).draw(&pieces, &list, bytes);
        });
        Image { width: style.size[0], height: style.size[1], bytes }
    }

    /// The visible parts of all triangles, in their order.
    fn pieces(
        &self,
        triangles: &Triangles<'_>,
        projection: &Projection<'_>,
        style: &Style,
    ) -> Vec<Piece> {
        let mut pieces = Vec::new();
        for (run, &start) in triangles.runs.iter().zip(&triangles.starts) {
            let material = &self.materials[run.material];
            let of_triangle = |(i, corners): (usize, &[Corner; 3])| {
                let mut found = Vec::new();
                let triangle = start + i as u32;
                if Surface::new(corners, material, projection, style.back_faces).is_some() {
                    projection.pieces(corners, |points| found.push(Piece { points, triangle }));
                }
                found
            };
            let corners = run.corners.as_chunks().0;
            pieces.par_extend(corners.par_iter().enumerate().flat_map_iter(of_triangle));
        }
        pieces
    }
}

/// Which pieces each band has to look at.
struct Bands {
    /// By band, those of few bands.
    small: Vec<Vec<u32>>,
    /// The others, each with its first and its last band.
    large: Vec<(u32, usize, usize)>,
}

impl Bands {
    fn new(pieces: &[Piece], height: usize) -> Self {
        let count = height.div_ceil(ROWS);
        let mut bands = Self { small: vec![Vec::new(); count], large: Vec::new() };
        let last_row = height as i32 - 1;
        for (i, piece) in (0..).zip(pieces) {
            let rows = piece.points.map(|p| p.y.div_euclid(SUBPIXELS));
            let (top, bottom) = (rows.into_iter().min(), rows.into_iter().max());
            let (Some(top), Some(bottom)) = (top, bottom) else { continue };
            if bottom < 0 || top > last_row {
                continue;
            }
            let first = top.max(0) as usize / ROWS;
            let last = bottom.min(last_row) as usize / ROWS;
            if last - first < MAX_BANDS {
                bands.small[first..=last].iter_mut().for_each(|list| list.push(i));
            } else {
                bands.large.push((i, first, last));
            }
        }
        bands
    }

    /// The pieces of a band, in their order.
    fn list(&self, band: usize) -> Vec<u32> {
        let mut list = self.small[band].clone();
        let here =
            |&(i, first, last): &(u32, usize, usize)| (first <= band && band <= last).then_some(i);
        list.extend(self.large.iter().filter_map(here));
        list.sort_unstable();
        list
    }
}

/// What all bands of a picture share.
struct Shot<'a> {
    painter: &'a Painter,
    style: &'a Style,
    triangles: Triangles<'a>,
    projection: Projection<'a>,
    lamps: Lamps,
}

impl<'a> Shot<'a> {
    fn surface(&self, triangle: u32) -> Surface<'a> {
        let (material, corners) = self.triangles.get(triangle);
        let material = &self.painter.materials[material];
        let back_faces = self.style.back_faces;
        Surface::new(corners, material, &self.projection, back_faces).expect("it is drawn")
    }

    fn light(&self, surface: &Surface<'_>, at: [f32; 2]) -> Light {
        surface.light(&self.painter.textures, &self.lamps, self.style, at)
    }
}

/// Some rows of a picture while they are drawn.
struct Band<'a> {
    shot: &'a Shot<'a>,
    window: Window,
    width: usize,
    /// The nearest triangle, by sample and pixel.
    seen: Vec<Fragment>,
    /// The samples of each pixel that the triangle at hand covers, a bit for each; between
    /// triangles none.
    covered: Vec<u16>,
    /// The pixels for which there are some.
    touched: Vec<usize>,
}

impl<'a> Band<'a> {
    fn new(shot: &'a Shot<'a>, top: usize, rows: usize) -> Self {
        let width = shot.style.size[0] as usize;
        let window =
            Window { left: 0, top: top as i32, right: width as i32, bottom: (top + rows) as i32 };
        Self {
            shot,
            window,
            width,
            seen: vec![Fragment::NOTHING; SAMPLES.len() * width * rows],
            covered: vec![0; width * rows],
            touched: Vec::new(),
        }
    }

    fn draw(mut self, pieces: &[Piece], list: &[u32], bytes: &mut [u8]) {
        let alpha = |triangle: u32| {
            let (material, _) = self.shot.triangles.get(triangle);
            self.shot.painter.materials[material].alpha
        };
        let mut blended = Vec::new();
        let list: Vec<_> = list.iter().map(|&i| &pieces[i as usize]).collect();
        let list: Vec<_> = list.into_iter().map(|piece| (piece, alpha(piece.triangle))).collect();
        for (piece, alpha) in list {
            let only_covered = alpha != AlphaMode::Opaque;
            match alpha {
                AlphaMode::Opaque => self.hide(piece, only_covered),
                AlphaMode::Mask(_) => {
                    self.cover(piece);
                    self.cut_away(piece.triangle);
                    self.hide(piece, only_covered);
                    self.forget();
                }
                AlphaMode::Blend => blended.push(piece),
            }
        }
        let mut samples = self.colours();
        for piece in blended {
            self.cover(piece);
            self.blend(piece.triangle, &mut samples);
            self.forget();
        }
        for (pixel, samples) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(samples) {
            *pixel = mean(&samples);
        }
    }

    /// Calls `visit(sample, pixel, depth)` for all samples of a piece.
    fn visit(&self, piece: &Piece, mut visit: impl FnMut(usize, usize, i32)) {
        for (sample, [x, y]) in SAMPLES.into_iter().enumerate() {
            // Moved so that the sample is in the middle of the pixel.
            let shift = |v: i32| SUBPIXELS / 2 - (v * SUBPIXELS / 16 + SUBPIXELS / 32);
            let (dx, dy) = (shift(x), shift(y));
            let points = piece.points.map(|p| Point { x: p.x + dx, y: p.y + dy, z: p.z });
            scan(points, self.window, |x, y, depth| {
                visit(sample, (y - self.window.top) as usize * self.width + x as usize, depth);
            });
        }
    }

    /// Hides what is behind a piece; only at covered samples, or at all.
    fn hide(&mut self, piece: &Piece, only_covered: bool) {
        let pixels = self.covered.len();
        let mut seen = std::mem::take(&mut self.seen);
        self.visit(piece, |sample, pixel, depth| {
            if !only_covered || self.covered[pixel] >> sample & 1 == 1 {
                let nearest = &mut seen[sample * pixels + pixel];
                *nearest = Fragment::new(piece.triangle, depth).min(*nearest);
            }
        });
        self.seen = seen;
    }

    /// Notes which samples of a piece are not hidden.
    fn cover(&mut self, piece: &Piece) {
        let pixels = self.covered.len();
        let mut covered = std::mem::take(&mut self.covered);
        let mut touched = std::mem::take(&mut self.touched);
        self.visit(piece, |sample, pixel, depth| {
            if Fragment::new(piece.triangle, depth) < self.seen[sample * pixels + pixel] {
                if covered[pixel] == 0 {
                    touched.push(pixel);
                }
                covered[pixel] |= 1 << sample;
            }
        });
        (self.covered, self.touched) = (covered, touched);
    }

    fn forget(&mut self) {
        for pixel in self.touched.drain(..) {
            self.covered[pixel] = 0;
        }
    }

    /// Takes covered samples away where the material's mask does.
    fn cut_away(&mut self, triangle: u32) {
        let surface = self.shot.surface(triangle);
        for &pixel in &self.touched {
            for first in (0..SAMPLES.len()).step_by(QUARTER) {
                let bits = quarter(self.covered[pixel], first);
                if bits != 0
                    && !surface.is_solid(&self.shot.painter.textures, self.middle(pixel, bits))
                {
                    self.covered[pixel] &= !bits;
                }
            }
        }
    }

    /// Blends a triangle over the covered samples.
    fn blend(&self, triangle: u32, samples: &mut [[Light; 16]]) {
        let surface = self.shot.surface(triangle);
        for &pixel in &self.touched {
            for first in (0..SAMPLES.len()).step_by(QUARTER) {
                let bits = quarter(self.covered[pixel], first);
                if bits == 0 {
                    continue;
                }
                let light = self.shot.light(&surface, self.middle(pixel, bits));
                for sample in (first..first + QUARTER).filter(|s| bits >> s & 1 == 1) {
                    let below = &mut samples[pixel][sample];
                    *below = std::array::from_fn(|c| light[c] + below[c] * (1.0 - light[3]));
                }
            }
        }
    }

    /// The colours of all samples where nothing is blended.
    fn colours(&self) -> Vec<[Light; 16]> {
        let [r, g, b, a] = self.shot.style.background;
        let background = [to_linear(r) * a, to_linear(g) * a, to_linear(b) * a, a];
        let pixels = self.covered.len();
        let mut last: Option<(u32, Surface<'_>)> = None;
        let mut colours = vec![[background; 16]; pixels];
        for (pixel, samples) in colours.iter_mut().enumerate() {
            let seen: [u32; 16] =
                std::array::from_fn(|sample| self.seen[sample * pixels + pixel].item());
            let with_triangle = (0..16).filter(|&s| seen[s] != Fragment::NOTHING.item());
            let mut left: u16 = with_triangle.fold(0, |bits, s| bits | 1 << s);
            while left != 0 {
                let first = left.trailing_zeros() as usize;
                let triangle = seen[first];
                let is_same = |s: &usize| seen[*s] == triangle;
                let end = first / QUARTER * QUARTER + QUARTER;
                let bits = (first..end).filter(is_same).fold(0, |bits, s| bits | 1 << s);
                left &= !bits;
                let surface = match last.take() {
                    Some((number, surface)) if number == triangle => surface,
                    _ => self.shot.surface(triangle),
                };
                let light = self.shot.light(&surface, self.middle(pixel, bits));
                last = Some((triangle, surface));
                for sample in (first..end).filter(|s| bits >> s & 1 == 1) {
                    samples[sample] = light;
                }
            }
        }
        colours
    }

    /// The column and row in the middle of some samples of a pixel: a point of whatever they see.
    fn middle(&self, pixel: usize, bits: u16) -> [f32; 2] {
        let sum = SAMPLES.iter().enumerate().filter(|(s, _)| bits >> s & 1 == 1);
        let [x, y] = sum.fold([0, 0], |[x, y], (_, at)| [x + at[0], y + at[1]]);
        let share = |sum: i32| (sum as f32 / bits.count_ones() as f32 + 0.5) / 16.0;
        let (column, row) = (pixel % self.width, pixel / self.width + self.window.top as usize);
        [column as f32 + share(x), row as f32 + share(y)]
    }
}

/// The bits of a quarter of a pixel, from sample `first` on.
fn quarter(bits: u16, first: usize) -> u16 {
    bits & 0b1111 << first
}

/// The pixel of some samples: their mean in linear light, not multiplied by opacity any more.
fn mean(samples: &[Light; 16]) -> [u8; 4] {
    let sum = |c: usize| samples.iter().map(|s| s[c]).sum::<f32>();
    let opacity = sum(3) / 16.0;
    let [r, g, b] =
        [0, 1, 2].map(|c| if opacity > 0.0 { to_srgb(sum(c) / 16.0 / opacity) } else { 0 });
    [r, g, b, (opacity * 255.0 + 0.5) as u8]
}
