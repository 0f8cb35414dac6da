//! What `compare` says: numbers for scripts and for people, and which limits they exceed.

use super::CompareArgs;
use crate::report::SCHEMA_VERSION;
use crate::text::{count, distance};
use lodc_measure::{Distances, ImageError, Looks, Viewing};
use serde::Serialize;

/// `compare --json`. Lengths are in A's unit.
#[derive(Debug, Serialize)]
pub(super) struct CompareReport {
    schema_version: u32,
    /// No limit is exceeded.
    pub(super) ok: bool,
    /// Of A's bounding box.
    diagonal: f64,
    triangles: TriangleCounts,
    hausdorff: BothWays,
    rms: BothWays,
    /// Null with `--views 0`.
    image: Option<ImageReport>,
    /// One line for each limit that is.
    pub(super) exceeded: Vec<String>,
}

#[derive(Debug, Serialize)]
struct TriangleCounts {
    a: usize,
    b: usize,
}

#[derive(Debug, Serialize)]
struct BothWays {
    a_to_b: f64,
    b_to_a: f64,
    max: f64,
    /// Root of the mean of both squares.
    mean: f64,
}

impl BothWays {
    fn new([a_to_b, b_to_a]: [f64; 2]) -> Self {
        let mean = f64::midpoint(a_to_b * a_to_b, b_to_a * b_to_a).sqrt();
        Self { a_to_b, b_to_a, max: a_to_b.max(b_to_a), mean }
    }
}

/// How different two meshes look.
#[derive(Debug, Serialize)]
pub(super) struct ImageReport {
    views: u32,
    size: u32,
    /// Of red, green and blue (0 to 255), over the pixels that either mesh covers.
    rmse: f64,
    /// The share of those pixels that only one covers.
    silhouette: f64,
    /// Both meshes were shaded with normals of their own.
    normals: bool,
    /// Both meshes wore a checkerboard by their texture coordinates, having no textures.
    texture: bool,
    /// Both meshes wore their materials' colours and textures.
    textures: bool,
}

impl ImageReport {
    pub(super) fn new(viewing: Viewing, looks: Looks, error: ImageError) -> Self {
        Self {
            views: viewing.views,
            size: viewing.size,
            rmse: error.rmse,
            silhouette: error.silhouette,
            normals: looks.own_normals,
            texture: looks.checkerboard,
            textures: looks.materials,
        }
    }
}

impl CompareReport {
    pub(super) fn new(
        diagonal: f64,
        [a, b]: [usize; 2],
        space: Distances,
        image: Option<ImageReport>,
    ) -> Self {
        Self {
            schema_version: SCHEMA_VERSION,
            ok: true,
            diagonal,
            triangles: TriangleCounts { a, b },
            hausdorff: BothWays::new(space.hausdorff),
            rms: BothWays::new(space.rms),
            image,
            exceeded: Vec::new(),
        }
    }

    /// Compares with the limits given.
    pub(super) fn check(&mut self, args: &CompareArgs) {
        let lengths = [
            ("rms", self.rms.max, args.max_rms),
            ("hausdorff", self.hausdorff.max, args.max_hausdorff),
        ];
        for (name, found, limit) in lengths {
            if let Some(limit) = limit.map(|l| l.resolve(self.diagonal))
                && found > limit
            {
                self.exceeded.push(format!(
                    "{name} distance {} is more than {}",
                    distance(found),
                    distance(limit)
                ));
            }
        }
        if let (Some(image), Some(limit)) = (&self.image, args.max_image_rmse)
            && image.rmse > limit
        {
            self.exceeded.push(format!("image RMSE {:.3} is more than {limit}", image.rmse));
        }
        self.ok = self.exceeded.is_empty();
    }

    /// A few lines for people.
    pub(super) fn text(&self) -> String {
        let share = |x: f64| if self.diagonal > 0.0 { 100.0 * x / self.diagonal } else { 0.0 };
        let line = |name: &str, d: &BothWays| {
            format!(
                "{name:<10}{:>12} to B {:>12} back   {:.4} % of the diagonal\n",
                distance(d.a_to_b),
                distance(d.b_to_a),
                share(d.max)
            )
        };
        let (a, b) = (self.triangles.a as u64, self.triangles.b as u64);
        let mut text = format!(
            "A: {}, diagonal {}; B: {}\n",
            count(a, "triangle"),
            distance(self.diagonal),
            count(b, "triangle")
        );
        text += &line("rms", &self.rms);
        text += &line("hausdorff", &self.hausdorff);
        if let Some(image) = &self.image {
            text += &format!(
                "image     RMSE {:.2} of 255, silhouette {:.3} % of the pixels; {}, {}{}\n",
                image.rmse,
                100.0 * image.silhouette,
                count(u64::from(image.views), "view"),
                if image.normals { "own normals" } else { "smooth normals" },
                match (image.textures, image.texture) {
                    (true, _) => ", textures",
                    (_, true) => ", checkerboard",
                    _ => "",
                }
            );
        }
        text
    }
}
