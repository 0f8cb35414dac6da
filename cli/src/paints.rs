//! The colours of a scene's submeshes, for pictures of it and for the metric that sees them.

use lodc_formats::appearance::{self, Appearance, TextureUse};
use lodc_measure::{Paint, Texture, Wrap};
use lodc_simplify::SurfaceColours;

/// Base colours and textures of every material of a scene.
pub(crate) struct Paints {
    /// One for each material.
    pub(crate) paints: Vec<Paint>,
    /// Pictures as materials read them.
    pub(crate) textures: Vec<Texture>,
    /// How each material reads its texture.
    uses: Vec<Option<TextureUse>>,
    /// The material of every object's submeshes.
    of_submesh: Vec<Vec<usize>>,
}

impl Paints {
    pub(crate) fn new(looks: &Appearance) -> Self {
        // A picture may be read in several ways; each is a texture.
        let mut distinct: Vec<TextureUse> = Vec::new();
        let mut paint = |m: &appearance::Material| {
            let texture = m.texture.map(|wanted| {
                let same = |u: &TextureUse| (u.picture, u.wrap) == (wanted.picture, wanted.wrap);
                distinct.iter().position(same).unwrap_or_else(|| {
                    distinct.push(wanted);
                    distinct.len() - 1
                })
            });
            let [r, g, b, _] = m.colour;
            // Colours are linear, texels are not: a root is near enough to sRGB, and the same on
            // every machine.
            Paint { colour: [r, g, b].map(f32::sqrt).into(), texture }
        };
        let paints = looks.materials.iter().map(&mut paint).collect();
        let texture = |u: &TextureUse| {
            let picture = &looks.pictures[u.picture];
            let texels =
                picture.bytes.as_chunks::<4>().0.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
            Texture::new(picture.width as usize, texels, u.wrap.map(wrap))
        };
        Self {
            paints,
            textures: distinct.iter().map(texture).collect(),
            uses: looks.materials.iter().map(|m| m.texture).collect(),
            of_submesh: looks.of_submesh.clone(),
        }
    }

    /// Whether any material has a texture.
    pub(crate) fn has_textures(&self) -> bool {
        !self.textures.is_empty()
    }

    /// The colours of one object of the scene.
    pub(crate) fn of_object(&self, object: usize) -> ObjectColours<'_> {
        ObjectColours { paints: self, materials: &self.of_submesh[object] }
    }
}

fn wrap(wrap: appearance::Wrap) -> Wrap {
    match wrap {
        appearance::Wrap::Repeat => Wrap::Repeat,
        appearance::Wrap::Mirror => Wrap::Mirror,
        appearance::Wrap::Clamp => Wrap::Clamp,
    }
}

/// Colours of one object by its submeshes.
pub(crate) struct ObjectColours<'a> {
    paints: &'a Paints,
    materials: &'a [usize],
}

impl SurfaceColours for ObjectColours<'_> {
    fn set(&self, submesh: u32) -> Option<u32> {
        self.paints.uses[self.materials[submesh as usize]].map(|u| u.set)
    }

    fn at(&self, submesh: u32, coordinates: [f32; 2], footprint: f32) -> [f32; 3] {
        let material = self.materials[submesh as usize];
        let paint = self.paints.paints[material];
        let (Some(texture), Some(read)) = (paint.texture, self.paints.uses[material]) else {
            return paint.colour.into();
        };
        let texture = &self.paints.textures[texture];
        let [u, v] = coordinates;
        let place = read.transform.map(|[x, y, shift]| x * u + y * v + shift);
        (paint.colour * texture.at(place.into(), footprint * texture.area())).into()
    }
}
