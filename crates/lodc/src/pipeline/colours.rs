//! The colours of a scene's objects, for metrics and pictures.

use lodc_formats::import::ImportOptions;
use lodc_formats::{Assets, Document, FormatError, ObjectInfo, RequestedFiles, Scene, appearance};
use lodc_measure::Pyramid;
use lodc_scene::Appearance;
use lodc_simplify::{MetricKind, Options, SurfaceColours};
use std::path::Path;
use std::sync::Arc;

/// The colours of a scene, read only if a metric uses them.
#[derive(Debug, Default)]
pub(crate) struct MetricColours {
    /// The colours; none if no metric uses them.
    pub(crate) colours: Option<Arc<SceneColours>>,
    /// The image files that were looked for.
    pub(crate) files: RequestedFiles,
    /// One line for each image that could not be read.
    pub(crate) warnings: Vec<String>,
}

impl MetricColours {
    /// Reads the colours of a scene if the metric of an object uses them. `options` are those of
    /// the objects.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub(crate) fn read(
        input: &Path,
        import: &ImportOptions,
        scene: &Scene,
        options: &[Options],
    ) -> Result<Self, FormatError> {
        let uses_colours = |o: &Options| o.attributes && o.metric == MetricKind::Hybrid;
        if !options.iter().any(uses_colours) {
            return Ok(Self::default());
        }
        let infos: Vec<&ObjectInfo> = scene.objects.iter().map(|o| &o.info).collect();
        let (colours, files) = read_colours(input, import, &scene.document, &infos)?;
        let warnings = colours.appearance().warnings.clone();
        Ok(Self { colours: Some(colours), files, warnings })
    }

    /// The colours, if a metric uses them.
    pub(crate) fn scene_colours(&self) -> Option<&SceneColours> {
        self.colours.as_deref()
    }
}

/// Reads the colours of a scene, beside whose file images are looked for; with the files that were.
///
/// # Errors
/// If the document is damaged, or a picture is beyond the limits.
pub fn read_colours(
    input: &Path,
    import: &ImportOptions,
    document: &Document,
    infos: &[&ObjectInfo],
) -> Result<(Arc<SceneColours>, RequestedFiles), FormatError> {
    let mut assets = Assets::new(input, &import.allowed, import.limits);
    let appearance = appearance(document, infos, &mut assets)
        .map_err(|e| e.in_file(&input.display().to_string()))?;
    Ok((Arc::new(SceneColours::new(appearance)), assets.files().clone()))
}

/// Base colours and textures of a scene. The default is none.
#[derive(Debug, Default)]
pub struct SceneColours {
    /// The materials, without images.
    appearance: Appearance,
    /// The images, each with smaller versions of itself.
    images: Arc<[Pyramid]>,
}

impl SceneColours {
    /// Takes over the appearance of a scene, and makes smaller versions of its images.
    #[must_use]
    pub fn new(mut appearance: Appearance) -> Self {
        let images = appearance.images.iter().map(Pyramid::new).collect();
        appearance.images = Vec::new();
        Self { appearance, images }
    }

    /// Returns true if any material has a texture.
    pub fn has_textures(&self) -> bool {
        self.appearance.materials.iter().any(|m| m.texture.is_some())
    }

    /// The materials of the scene, without images.
    pub fn appearance(&self) -> &Appearance {
        &self.appearance
    }

    /// The images.
    pub fn images(&self) -> Arc<[Pyramid]> {
        Arc::clone(&self.images)
    }

    /// The colours of one object of the scene.
    pub fn of_object(&self, object: usize) -> ObjectColours<'_> {
        ObjectColours { colours: self, materials: &self.appearance.of_submesh[object] }
    }
}

/// The colours of one object.
#[derive(Debug)]
pub struct ObjectColours<'a> {
    colours: &'a SceneColours,
    /// By submesh: the index of its material.
    materials: &'a [usize],
}

impl SurfaceColours for ObjectColours<'_> {
    fn set(&self, submesh: u32) -> Option<u32> {
        let material = self.materials[submesh as usize];
        self.colours.appearance.materials[material].texture.map(|t| t.set)
    }

    fn at(&self, submesh: u32, coordinates: [f32; 2], footprint: f32) -> [f32; 3] {
        let material = self.colours.appearance.materials[self.materials[submesh as usize]];
        let [r, g, b, _] = material.colour;
        // Colours are linear, texels are not: a square root approximates sRGB, and gives the same
        // bits on every machine.
        let colour = [r, g, b].map(|c| c.max(0.0).sqrt());
        let Some(texture) = material.texture else { return colour };
        let image = &self.colours.images[texture.image];
        let point = texture.to_image(coordinates).into();
        let texel: [f32; 3] = image.at(point, footprint * image.area(), texture.wrap).into();
        [0, 1, 2].map(|c| colour[c] * texel[c])
    }
}
