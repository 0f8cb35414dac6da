//! The look of the input: the normals, texture coordinates and colours of vertices that renderers
//! read, and the colours behind them.

use super::vectors::mix;
use crate::cut::Wedges;
use glam::Vec3;
use lodc_mesh::{Attribute, Mesh, Semantic};

/// Colours of the submeshes of one mesh, by texture coordinates.
pub trait SurfaceColours: Sync {
    /// The set of texture coordinates that a submesh is coloured by, if any.
    fn set(&self, submesh: u32) -> Option<u32>;

    /// The colour of a submesh at texture coordinates, averaged over a `footprint` in squared units
    /// of texture space. Red, green and blue as shown, 0 to 1.
    fn at(&self, submesh: u32, coordinates: [f32; 2], footprint: f32) -> [f32; 3];
}

/// Squares of the checkerboard in a unit of texture coordinates, each way. Chosen by hand.
const SQUARES: f32 = 16.0;
/// The shade of dark squares; the others are 1. Chosen by hand.
const DARK: f32 = 0.5;

/// Colours for meshes whose textures are not known: a checkerboard, on which slipping texture
/// coordinates are seen, or white if some submesh has no texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checkerboard {
    is_shown: bool,
}

impl Checkerboard {
    /// A checkerboard if every submesh with triangles has texture coordinates.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let mut shown = mesh.submeshes().iter().filter(|s| !s.triangles().is_empty());
        let has = |a: &u32| {
            let a = &mesh.attributes()[*a as usize];
            a.semantic == Semantic::TexCoord(0) && a.morph_target.is_none()
        };
        Self { is_shown: shown.all(|s| s.attributes.iter().any(has)) }
    }
}

impl SurfaceColours for Checkerboard {
    fn set(&self, _submesh: u32) -> Option<u32> {
        self.is_shown.then_some(0)
    }

    fn at(&self, _submesh: u32, coordinates: [f32; 2], footprint: f32) -> [f32; 3] {
        if !self.is_shown {
            return [1.0; 3];
        }
        // The mean over a footprint: a triangle wave is the integral of light and dark stripes.
        let width = (footprint.sqrt() * SQUARES).clamp(1e-3, 16.0);
        let wave = |x: f32| {
            let x = x * 0.5;
            ((x - lodc_mesh::floor(x)) * 2.0 - 1.0).abs()
        };
        let stripes = coordinates.map(|x| {
            let x = if x.is_finite() { x * SQUARES } else { 0.0 };
            (wave(x + 0.5 * width) - wave(x - 0.5 * width)) / width
        });
        let light = 0.5 + 0.5 * stripes[0] * stripes[1];
        [DARK + (1.0 - DARK) * light; 3]
    }
}

/// Normals, texture coordinates and colours of every vertex of the input, and the colours behind
/// them.
pub(super) struct Appearance<'a> {
    /// Empty if the mesh is shaded with the normals of its triangles.
    normals: Vec<Vec3>,
    /// Empty if no submesh is coloured by texture coordinates.
    texture: Vec<[f32; 2]>,
    /// Linear colours of the vertices, by which others are multiplied; empty if no submesh has any.
    painted: Vec<Vec3>,
    colours: Option<&'a dyn SurfaceColours>,
    /// Submeshes differ in colour, or the colour of one varies.
    is_coloured: bool,
}

impl<'a> Appearance<'a> {
    /// The look of a shape alone: white, with the normals of its triangles.
    pub(super) fn of_shape() -> Self {
        let (normals, texture, painted) = (Vec::new(), Vec::new(), Vec::new());
        Self { normals, texture, painted, colours: None, is_coloured: false }
    }

    /// Reads normals, if every submesh with triangles has them, for each submesh the texture
    /// coordinates that its colours are read with, and the colours of vertices.
    pub(super) fn new(mesh: &Mesh, colours: &'a dyn SurfaceColours) -> Self {
        let stream = |submesh: u32, semantic: &Semantic| -> Option<&Attribute> {
            let found = mesh.submeshes()[submesh as usize].attributes.iter();
            found
                .map(|&a| &mesh.attributes()[a as usize])
                .find(|a| a.semantic == *semantic && a.morph_target.is_none())
        };
        let shown = || {
            (0..mesh.submeshes().len() as u32)
                .filter(|&s| !mesh.submeshes()[s as usize].triangles().is_empty())
        };
        let vertices = || (0u32..).zip(mesh.vertex_submesh());
        let has_normals =
            shown().all(|s| stream(s, &Semantic::Normal).is_some_and(|a| a.components >= 3));
        let normal = |(v, &s): (u32, &u32)| {
            stream(s, &Semantic::Normal).map_or(Vec3::ZERO, |a| {
                let n = Vec3::from([0, 1, 2].map(|c| a.value(v, c)));
                if n.is_finite() { n.normalize_or_zero() } else { Vec3::ZERO }
            })
        };
        let coordinates: Vec<Option<&Attribute>> = (0..mesh.submeshes().len() as u32)
            .map(|s| stream(s, &Semantic::TexCoord(colours.set(s)?)).filter(|a| a.components >= 2))
            .collect();
        let uv = |(v, &s): (u32, &u32)| {
            coordinates[s as usize].map_or([0.0; 2], |a| {
                [0, 1].map(|c| a.value(v, c)).map(|x| if x.is_finite() { x } else { 0.0 })
            })
        };
        let colour = |(v, &s): (u32, &u32)| {
            let stream = stream(s, &Semantic::Color(0)).filter(|a| a.components >= 3);
            let colour = stream.map_or(Vec3::ONE, |a| Vec3::from([0, 1, 2].map(|c| a.value(v, c))));
            if colour.is_finite() { colour.clamp(Vec3::ZERO, Vec3::ONE) } else { Vec3::ONE }
        };
        let is_painted = shown().any(|s| stream(s, &Semantic::Color(0)).is_some());
        let is_textured = coordinates.iter().any(Option::is_some);
        let colour_of = |submesh: u32| Colour::new(colours.at(submesh, [0.0; 2], 0.0));
        let is_coloured = is_textured || is_painted || {
            let mut all = shown().map(colour_of);
            all.next().is_some_and(|first| all.any(|other| other != first))
        };
        Self {
            normals: if has_normals { vertices().map(normal).collect() } else { Vec::new() },
            texture: if is_textured { vertices().map(uv).collect() } else { Vec::new() },
            painted: if is_painted { vertices().map(colour).collect() } else { Vec::new() },
            colours: Some(colours),
            is_coloured,
        }
    }

    /// Returns whether shading reads normals of vertices, not of faces.
    pub(super) fn has_normals(&self) -> bool {
        !self.normals.is_empty()
    }

    /// The unit normal of a vertex, or zero if it has none.
    pub(super) fn normal(&self, vertex: u32) -> Vec3 {
        self.normals[vertex as usize]
    }

    /// The texture coordinates of a vertex.
    pub(super) fn coordinates(&self, vertex: u32) -> [f32; 2] {
        self.texture.get(vertex as usize).copied().unwrap_or_default()
    }

    /// The linear colour of a vertex, by which that of its surface is multiplied.
    pub(super) fn vertex_colour(&self, vertex: u32) -> Vec3 {
        self.painted.get(vertex as usize).copied().unwrap_or(Vec3::ONE)
    }

    /// Returns whether colours vary: with texture coordinates, or between vertices or submeshes.
    pub(super) fn is_coloured(&self) -> bool {
        self.is_coloured
    }

    /// The colour of a submesh at shares of the second and third of three vertices and at texture
    /// coordinates, averaged over an area of texture space.
    pub(super) fn colour(
        &self,
        submesh: u32,
        vertices: [u32; 3],
        shares: [f32; 2],
        at: [f32; 2],
        footprint: f32,
    ) -> Colour {
        let behind = self.colours.map_or([1.0; 3], |c| c.at(submesh, at, footprint));
        if self.painted.is_empty() {
            return Colour::new(behind);
        }
        // A square root approximates sRGB's curve, and gives the same bits on every machine.
        let painted = mix(&vertices.map(|v| self.vertex_colour(v)), shares).map(f32::sqrt);
        Colour::new((painted * Vec3::from(behind)).into())
    }
}

/// The vertex of the input whose attributes a wedge has. Bare wedges have none to be read.
pub(super) fn attribute_vertex(wedges: &Wedges, wedge: u32) -> u32 {
    if wedges.is_bare() { 0 } else { wedges.wedge(wedge).attribute_source }
}

/// Red, green and blue as shown, in 255ths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Colour([u8; 3]);

impl Colour {
    /// Rounds channels from 0 to 1; others are clamped.
    pub(super) fn new(shares: [f32; 3]) -> Self {
        Self(shares.map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8))
    }

    /// The channels, 0 to 1.
    pub(super) fn channels(self) -> [f32; 3] {
        self.0.map(|c| f32::from(c) * (1.0 / 255.0))
    }

    /// The mean square of the channels.
    pub(super) fn power(self) -> f32 {
        let squares = self.0.map(|c| u32::from(c) * u32::from(c));
        squares.iter().sum::<u32>() as f32 * (1.0 / (3.0 * 255.0 * 255.0))
    }
}
