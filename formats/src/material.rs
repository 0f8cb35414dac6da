//! Materials of a scene, by name: base colours, and the images that they show.

/// The materials of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    /// All of them, in the order of the document.
    pub list: Vec<Material>,
    /// For every object and submesh the number of its material; none if it has none.
    pub of_submesh: Vec<Vec<Option<usize>>>,
}

/// A material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name; empty if it has none.
    pub name: String,
    /// Linear red, green and blue, and opacity, from 0 to 1.
    pub colour: [f32; 4],
    /// The textures that it shows.
    pub textures: Vec<MaterialTexture>,
}

impl Material {
    /// The image of the base colour, as [`MaterialTexture::image`].
    #[must_use]
    pub fn base_image(&self) -> Option<&str> {
        let is_base = |t: &&MaterialTexture| {
            t.role == "baseColorTexture" || t.role.eq_ignore_ascii_case("map_Kd")
        };
        self.textures.iter().find(is_base).map(|t| &*t.image)
    }
}

/// A texture of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialTexture {
    /// What it is for, as the format calls it: `baseColorTexture`, `normalTexture`, `map_Kd`, ….
    pub role: String,
    /// The path of its image as the document names it. An image inside the file has its name, or
    /// `image0`, `image1`, … without one.
    pub image: String,
}
