//! Results of `compare`: numbers for scripts and for people, and the limits that they exceed.

use crate::SCHEMA_VERSION;
use crate::text::{count, distance};
use lodc_measure::{Distances, ImageError, Numbers, Regression, ShadingOptions, Viewing};
use serde::Serialize;

/// `compare --json` of two files. Lengths are in A's unit.
#[derive(Debug, Serialize)]
pub struct PairReport {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// No limit is exceeded.
    pub ok: bool,
    /// B again, under the key that reports of other commands have.
    pub input: String,
    /// The mesh that was compared with.
    pub a: String,
    /// The mesh that was judged.
    pub b: String,
    /// The diagonal of A's bounding box.
    pub diagonal: f64,
    /// One comparison or several.
    #[serde(flatten)]
    pub content: Content,
}

/// One comparison, or one for each level that was asked for.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Content {
    /// The comparison of the only level.
    Single(Comparison),
    /// The comparisons of several levels.
    Levels {
        /// One for each level.
        levels: Vec<LevelComparison>,
        /// The lines of all levels about exceeded limits.
        exceeded: Vec<String>,
    },
}

/// The comparison of a level.
#[derive(Debug, Serialize)]
pub struct LevelComparison {
    /// As it was asked for.
    pub level: String,
    /// Its differences.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// Differences between A and a level of B.
#[derive(Debug, Serialize)]
pub struct Comparison {
    /// Triangles of both meshes.
    pub triangles: TriangleCounts,
    /// Largest distances.
    pub hausdorff: BothWays,
    /// Root mean square distances.
    pub rms: BothWays,
    /// Differences of pictures; null with `--views 0`.
    pub image: Option<ImageReport>,
    /// The recorded numbers; only with `--baseline`, null if there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline: Option<Option<Numbers>>,
    /// One line for each limit that is exceeded.
    pub exceeded: Vec<String>,
}

/// Triangles of two meshes.
#[derive(Debug, Serialize)]
pub struct TriangleCounts {
    /// Triangles of A.
    pub a: usize,
    /// Triangles of B.
    pub b: usize,
}

/// A distance from A to B and back.
#[derive(Debug, Serialize)]
pub struct BothWays {
    /// From A to B.
    pub a_to_b: f64,
    /// From B to A.
    pub b_to_a: f64,
    /// The greater of both.
    pub max: f64,
    /// Root of the mean of both squares.
    pub mean: f64,
}

impl BothWays {
    fn new([a_to_b, b_to_a]: [f64; 2]) -> Self {
        let mean = f64::midpoint(a_to_b * a_to_b, b_to_a * b_to_a).sqrt();
        Self { a_to_b, b_to_a, max: a_to_b.max(b_to_a), mean }
    }
}

/// Image differences between two meshes.
#[derive(Debug, Serialize)]
pub struct ImageReport {
    /// Pictures of each mesh.
    pub views: u32,
    /// Pixels across each.
    pub size: u32,
    /// Root mean square difference of red, green and blue (0 to 255), over the pixels that either
    /// mesh covers.
    pub rmse: f64,
    /// The share of those pixels that only one covers.
    pub silhouette: f64,
    /// Both meshes were shaded with normals of their own.
    pub normals: bool,
    /// Both meshes wore a checkerboard by their texture coordinates, having no textures.
    pub texture: bool,
    /// Both meshes wore their materials' colours and textures.
    pub textures: bool,
    /// Both meshes wore the colours of their vertices.
    pub vertex_colors: bool,
}

impl ImageReport {
    /// The difference of pictures, and how they were taken.
    #[must_use]
    pub fn new(viewing: Viewing, shading: ShadingOptions, error: ImageError) -> Self {
        Self {
            views: viewing.views,
            size: viewing.size,
            rmse: error.rmse,
            silhouette: error.silhouette,
            normals: shading.own_normals,
            texture: shading.checkerboard,
            textures: shading.materials,
            vertex_colors: shading.vertex_colours,
        }
    }
}

/// A length, possibly as a share of A's diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Length {
    /// In A's unit, or percent.
    pub value: f64,
    /// True if it is a share of the diagonal in percent.
    pub of_diagonal: bool,
}

impl Length {
    fn resolve(self, diagonal: f64) -> f64 {
        if self.of_diagonal { self.value / 100.0 * diagonal } else { self.value }
    }
}

/// Limits of a comparison; none where anything is allowed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ComparisonLimits {
    /// Root mean square distance, either way.
    pub rms: Option<Length>,
    /// Largest distance, either way.
    pub hausdorff: Option<Length>,
    /// Root mean square difference of pictures, 0 to 255.
    pub image_rmse: Option<f64>,
}

impl Comparison {
    /// The comparison of two meshes with these numbers of triangles; limits are checked later.
    #[must_use]
    pub fn new([a, b]: [usize; 2], distances: Distances, image: Option<ImageReport>) -> Self {
        Self {
            triangles: TriangleCounts { a, b },
            hausdorff: BothWays::new(distances.hausdorff),
            rms: BothWays::new(distances.rms),
            image,
            baseline: None,
            exceeded: Vec::new(),
        }
    }

    /// The numbers to record: distances are the greater of both ways.
    #[must_use]
    pub fn numbers(&self) -> Numbers {
        Numbers {
            triangles: self.triangles.b,
            rms: self.rms.max,
            hausdorff: self.hausdorff.max,
            image_rmse: self.image.as_ref().map(|image| image.rmse),
        }
    }

    /// Adds a line for each limit that is exceeded.
    pub fn check(&mut self, limits: &ComparisonLimits, diagonal: f64) {
        let lengths = [
            ("rms", self.rms.max, limits.rms),
            ("hausdorff", self.hausdorff.max, limits.hausdorff),
        ];
        for (name, measured, limit) in lengths {
            if let Some(limit) = limit.map(|l| l.resolve(diagonal))
                && measured > limit
            {
                self.exceeded.push(format!(
                    "{name} distance {} is more than {}",
                    distance(measured),
                    distance(limit)
                ));
            }
        }
        if let (Some(image), Some(limit)) = (&self.image, limits.image_rmse)
            && image.rmse > limit
        {
            self.exceeded.push(format!("image RMSE {:.3} is more than {limit}", image.rmse));
        }
    }

    /// Adds the recorded numbers, if there are any, and a line for each that is worse now by more
    /// than the share `tolerance`.
    pub fn check_baseline(&mut self, recorded: Option<&Numbers>, tolerance: f64, diagonal: f64) {
        let worse =
            recorded.map(|recorded| self.numbers().worse_than(recorded, tolerance, diagonal));
        let line = |Regression { name, now, then }| {
            format!("{name} {} is worse than {} of the baseline", distance(now), distance(then))
        };
        self.exceeded.extend(worse.into_iter().flatten().map(line));
        self.baseline = Some(recorded.copied());
    }
}

impl PairReport {
    /// The document of two files. Levels have the names by which they were asked for; a single
    /// comparison may have none.
    #[must_use]
    pub fn new(
        [a, b]: [String; 2],
        diagonal: f64,
        mut levels: Vec<(Option<String>, Comparison)>,
    ) -> Self {
        let ok = levels.iter().all(|(_, c)| c.exceeded.is_empty());
        let content = match levels.pop() {
            Some((None, single)) if levels.is_empty() => Content::Single(single),
            last => {
                levels.extend(last);
                let named = levels.into_iter().map(|(level, comparison)| LevelComparison {
                    level: level.unwrap_or_default(),
                    comparison,
                });
                let levels: Vec<LevelComparison> = named.collect();
                let lines = levels.iter().flat_map(|l| {
                    l.comparison.exceeded.iter().map(|what| format!("{}: {what}", l.level))
                });
                Content::Levels { exceeded: lines.collect(), levels }
            }
        };
        Self { schema_version: SCHEMA_VERSION, ok, input: b.clone(), a, b, diagonal, content }
    }

    /// One line for each limit that is exceeded.
    #[must_use]
    pub fn exceeded(&self) -> &[String] {
        match &self.content {
            Content::Single(Comparison { exceeded, .. }) | Content::Levels { exceeded, .. } => {
                exceeded
            }
        }
    }

    /// Every comparison, with the name of its level.
    #[must_use]
    pub fn comparisons(&self) -> Vec<(Option<&str>, &Comparison)> {
        match &self.content {
            Content::Single(comparison) => vec![(None, comparison)],
            Content::Levels { levels, .. } => {
                levels.iter().map(|l| (Some(l.level.as_str()), &l.comparison)).collect()
            }
        }
    }

    /// A few lines for people, or with `brief` a line for each level.
    #[must_use]
    pub fn text(&self, brief: bool) -> String {
        match &self.content {
            Content::Single(comparison) if !brief => self.lines(comparison),
            _ => {
                let line = |(level, c): (Option<&str>, &Comparison)| self.line(level, c);
                self.comparisons().into_iter().map(line).collect()
            }
        }
    }

    /// A distance in percent of the diagonal.
    fn share(&self, x: f64) -> f64 {
        if self.diagonal > 0.0 { 100.0 * x / self.diagonal } else { 0.0 }
    }

    fn line(&self, level: Option<&str>, c: &Comparison) -> String {
        let level = level.map(|level| format!(" at {level}")).unwrap_or_default();
        let image = c.image.as_ref().map(|image| format!(", image RMSE {:.2}", image.rmse));
        format!(
            "{}{level}: {}, rms {:.4} %, hausdorff {:.4} %{}: {}\n",
            self.b,
            count(c.triangles.b as u64, "triangle"),
            self.share(c.rms.max),
            self.share(c.hausdorff.max),
            image.unwrap_or_default(),
            if c.exceeded.is_empty() { "ok" } else { "EXCEEDED" }
        )
    }

    fn lines(&self, c: &Comparison) -> String {
        let line = |name: &str, d: &BothWays| {
            format!(
                "{name:<10}{:>12} to B {:>12} back   {:.4} % of the diagonal\n",
                distance(d.a_to_b),
                distance(d.b_to_a),
                self.share(d.max)
            )
        };
        let mut text = format!(
            "A: {}, diagonal {}; B: {}\n",
            count(c.triangles.a as u64, "triangle"),
            distance(self.diagonal),
            count(c.triangles.b as u64, "triangle")
        );
        text += &line("rms", &c.rms);
        text += &line("hausdorff", &c.hausdorff);
        if let Some(image) = &c.image {
            text += &format!(
                "image     RMSE {:.2} of 255, silhouette {:.3} % of the pixels; {}, {}{}{}\n",
                image.rmse,
                100.0 * image.silhouette,
                count(u64::from(image.views), "view"),
                if image.normals { "own normals" } else { "smooth normals" },
                match (image.textures, image.texture) {
                    (true, _) => ", materials",
                    (_, true) => ", checkerboard",
                    _ => "",
                },
                if image.vertex_colors { ", vertex colors" } else { "" }
            );
        }
        text
    }
}
