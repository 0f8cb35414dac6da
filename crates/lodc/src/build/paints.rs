//! The colours of a scene's objects, for all that sees them.

use lodc_formats::import::ImportOptions;
use lodc_formats::{Assets, FormatError, ObjectInfo, RequestedFiles, Scene, appearance};
use lodc_measure::Pyramid;
use lodc_scene::Appearance;
use lodc_simplify::{MetricKind, Options, SurfaceColours};
use std::path::Path;
use std::sync::Arc;

/// The colours of a scene, if a metric sees them.
#[derive(Debug, Default)]
pub struct ScenePaints {
    /// The colours.
    pub paints: Option<Arc<Paints>>,
    /// The image files that were looked for.
    pub files: RequestedFiles,
    /// One line for each image that could not be read.
    pub warnings: Vec<String>,
}

impl ScenePaints {
    /// Reads the colours of a scene, if the metric of an object sees them. `options` are those of
    /// the objects.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub fn read(
        input: &Path,
        import: &ImportOptions,
        scene: &Scene,
        options: &[Options],
    ) -> Result<Self, FormatError> {
        let sees = |o: &Options| o.attributes && o.metric == MetricKind::Hybrid;
        if !options.iter().any(sees) {
            return Ok(Self::default());
        }
        let infos: Vec<&ObjectInfo> = scene.objects.iter().map(|o| &o.info).collect();
        let mut assets = Assets::new(input, &import.allowed, import.limits);
        let looks = appearance(&scene.document, &infos, &mut assets)
            .map_err(|e| e.in_file(&input.display().to_string()))?;
        let warnings = looks.warnings.clone();
        let files = assets.files().clone();
        Ok(Self { paints: Some(Arc::new(Paints::new(looks))), files, warnings })
    }

    /// The colours, if a metric sees them.
    #[must_use]
    pub fn shown(&self) -> Option<&Paints> {
        self.paints.as_deref()
    }
}

/// Base colours and textures of a scene. The default is none.
#[derive(Debug, Default)]
pub struct Paints {
    looks: Appearance,
    /// The images of the scene, ready to be read at any size.
    images: Arc<[Pyramid]>,
}

impl Paints {
    /// Makes the images of a scene ready to be read.
    #[must_use]
    pub fn new(mut looks: Appearance) -> Self {
        let images = looks.images.iter().map(Pyramid::new).collect();
        looks.images = Vec::new();
        Self { looks, images }
    }

    /// Returns true if any material has a texture.
    pub fn has_textures(&self) -> bool {
        self.looks.materials.iter().any(|m| m.texture.is_some())
    }

    /// The materials of the scene, without images.
    pub fn looks(&self) -> &Appearance {
        &self.looks
    }

    /// The images.
    pub fn images(&self) -> Arc<[Pyramid]> {
        Arc::clone(&self.images)
    }

    /// The colours of one object of the scene.
    pub fn of_object(&self, object: usize) -> ObjectColours<'_> {
        ObjectColours { paints: self, materials: &self.looks.of_submesh[object] }
    }
}

/// Colours of one object by its submeshes.
#[derive(Debug)]
pub struct ObjectColours<'a> {
    paints: &'a Paints,
    materials: &'a [usize],
}

impl SurfaceColours for ObjectColours<'_> {
    fn set(&self, submesh: u32) -> Option<u32> {
        let material = self.materials[submesh as usize];
        self.paints.looks.materials[material].texture.map(|t| t.set)
    }

    fn at(&self, submesh: u32, coordinates: [f32; 2], footprint: f32) -> [f32; 3] {
        let material = self.paints.looks.materials[self.materials[submesh as usize]];
        let [r, g, b, _] = material.colour;
        // Colours are linear, texels are not: a root is near enough to sRGB, and the same on every
        // machine.
        let colour = [r, g, b].map(|c| c.max(0.0).sqrt());
        let Some(texture) = material.texture else { return colour };
        let image = &self.paints.images[texture.image];
        let place = texture.place(coordinates).into();
        let shown: [f32; 3] = image.at(place, footprint * image.area(), texture.wrap).into();
        [0, 1, 2].map(|c| colour[c] * shown[c])
    }
}
