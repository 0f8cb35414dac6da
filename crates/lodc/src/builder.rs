//! All stages from a mesh file to a file with every level of it.

use crate::pipeline::{DEFAULT_POSES, Importance, Painted};
use crate::{Asset, Error, Errors, File, Simplify, Source};
use lodc_formats::import::{ImportOptions, import, import_bytes, import_parts};
use lodc_formats::lodc::Layout;
use lodc_lod::ModelKind;
use lodc_simplify::{MetricKind, Options};
use lodc_strip::StripOptions;

/// Options of building a file from a mesh.
///
/// ```
/// use lodc::{Metric, Select};
/// use lodc::models::ModelKind;
///
/// let file = lodc::build("../../fixtures/machine_part.glb")
///     .metric(Metric::Quadric)
///     .models(&[ModelKind::Interactive]) // none by default: levels need none
///     .run()?;
/// assert_eq!(file.level(Select::Ratio(0.25))?.triangles(), 120);
/// # Ok::<(), lodc::Error>(())
/// ```
#[derive(Debug)]
pub struct Builder<'a> {
    source: Source<'a>,
    options: Options,
    import: ImportOptions,
    kinds: Vec<ModelKind>,
    layout: Layout,
    poses: usize,
    painted: Option<Painted>,
}

impl<'a> Builder<'a> {
    pub(crate) fn new(source: Source<'a>) -> Self {
        Self {
            source,
            options: Options::DEFAULT,
            import: ImportOptions::default(),
            kinds: Vec::new(),
            layout: Layout::default(),
            poses: DEFAULT_POSES,
            painted: None,
        }
    }

    /// The metric that decides the order of collapses; the quadric by default.
    #[must_use]
    pub fn metric(mut self, metric: MetricKind) -> Self {
        self.options.metric = metric;
        self
    }

    /// All options of simplification, the metric among them.
    #[must_use]
    pub fn options(mut self, options: Options) -> Self {
        self.options = options;
        self
    }

    /// Limits, folders that may be read, and welding.
    #[must_use]
    pub fn import(mut self, import: ImportOptions) -> Self {
        self.import = import;
        self
    }

    /// The structures to make besides the collapse sequence, which is enough to take levels out;
    /// none by default.
    #[must_use]
    pub fn models(mut self, kinds: &[ModelKind]) -> Self {
        self.kinds = ModelKind::ALL.into_iter().filter(|kind| kinds.contains(kind)).collect();
        self
    }

    /// The width of indices in the file.
    #[must_use]
    pub fn layout(mut self, layout: Layout) -> Self {
        self.layout = layout;
        self
    }

    /// How many poses errors hold in at most besides the one at rest; 8 by default.
    #[must_use]
    pub fn poses(mut self, count: usize) -> Self {
        self.poses = count;
        self
    }

    /// Where importance is painted: what matters keeps more of its triangles. Nowhere by default.
    ///
    /// ```
    /// use lodc::pipeline::Painted;
    ///
    /// let painted = Painted::Attribute("COLOR_0".to_owned());
    /// let file = lodc::build("../../fixtures/coloured_cube.glb").importance(painted).run()?;
    /// assert_eq!(file.level(lodc::Select::Ratio(1.0))?.triangles(), 48);
    /// # Ok::<(), lodc::Error>(())
    /// ```
    #[must_use]
    pub fn importance(mut self, painted: Painted) -> Self {
        self.painted = Some(painted);
        self
    }

    /// Reads the mesh, simplifies it and measures every level, on all cores.
    ///
    /// # Errors
    /// If the mesh cannot be read or is larger than the limits.
    pub fn run(self) -> Result<File, Error> {
        let path = self.source.path();
        let scene = match self.source {
            Source::Path(path) => import(&path, &self.import),
            Source::Mesh(parts) => import_parts(*parts, &self.import),
            other => import_bytes(other.bytes()?.into_owned(), &self.import),
        }?;
        let options = vec![self.options; scene.objects.len()];
        let mut importance = Importance::default();
        if let Some(painted) = &self.painted {
            importance.painted = painted.read(&path, &self.import, &scene)?;
        }
        let how = Simplify { options: &options, importance: &importance, poses: self.poses };
        let asset = Asset::simplified(&path, scene, &self.import, &how, Errors::Curve, &())?;
        let mut asset = asset.with_models(&self.kinds, StripOptions::default(), &())?;
        let warnings = std::mem::take(&mut asset.warnings);
        Ok(File::new(asset.into_file(self.layout, None), &path, warnings))
    }
}
