//! Options that choose a level (record, share, triangle count or error), resolved to one LOD for
//! each object.

use crate::exit::{Failure, Outcome, Status};
use crate::help::{LEVEL, SEEN};
use crate::numbers::whole;
use crate::rounding::Asked;
use clap::Args;
use lodc_select::parse::{count, rms_bound};
use lodc_select::{RecordError, SelectError, Target, View};

pub(crate) use lodc_select::parse::{bound, share, size};

/// At most one of these says which level of detail is wanted.
#[derive(Args, Clone, Debug)]
pub(crate) struct SelectorArgs {
    #[command(flatten)]
    target: TargetArgs,
    /// Distance of the eye for --pixels, in world units
    #[arg(long, value_name = "D", value_parser = positive, requires = "pixels",
          help_heading = LEVEL)]
    distance: Option<f64>,
    /// Choose the level of each object by itself, in its own units
    ///
    /// Without it the objects of a scene are treated as a whole. --lod needs it where there are
    /// several.
    #[arg(long, help_heading = LEVEL, hide_short_help = true)]
    per_object: bool,
    #[command(flatten)]
    screen: ScreenArgs,
}

#[derive(Args, Clone, Debug)]
#[group(multiple = false)]
#[command(next_help_heading = LEVEL)]
struct TargetArgs {
    /// At most this share of the triangles: 0.25 or 25%
    ///
    /// As --triangles with R times the input's triangles, rounded down.
    #[arg(long, value_name = "R", value_parser = share, allow_negative_numbers = true)]
    ratio: Option<f64>,
    /// At most N triangles: 500, 10k, 2m
    ///
    /// The finest level that has no more. Of several objects, triangles go first where the error is
    /// least. An object never comes back empty: the selection stops at its last level that has
    /// a triangle, with a warning (as with every selector but --lod).
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    triangles: Option<u64>,
    /// Error of at most E, in world units, or E%
    ///
    /// The coarsest level whose error is at most E. The error is the largest distance between the
    /// surfaces of level and input, measured from both, wherever the scene shows them; a percentage
    /// is of the diagonal of the largest object's bounding box as the scene shows it. Several
    /// objects meet it each.
    #[arg(long, value_name = "E", value_parser = bound, allow_negative_numbers = true)]
    error: Option<Target>,
    /// The same for the root mean square distance
    #[arg(long, value_name = "E", value_parser = rms_bound, allow_negative_numbers = true,
          hide_short_help = true)]
    rms: Option<Target>,
    /// At most P pixels of error, seen from --distance
    #[arg(long, value_name = "P", value_parser = positive)]
    pixels: Option<f64>,
    /// The level after N collapse records (0: the input; larger is coarser)
    ///
    /// Rounded down to a whole step; numbers past the last mean the last.
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..), hide_short_help = true)]
    lod: Option<u32>,
}

/// The screen that a mesh is seen on.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = SEEN)]
pub(crate) struct ScreenArgs {
    /// Height of the screen in pixels
    #[arg(long, value_name = "PIXELS", default_value = "1080", value_parser = positive,
          hide_short_help = true)]
    height: f64,
    /// Vertical field of view in degrees, below 180 [default: 60]
    #[arg(long, value_name = "DEGREES", value_parser = field_of_view, hide_short_help = true)]
    fovy: Option<f64>,
}

impl ScreenArgs {
    /// Returns a camera at a point with this screen.
    pub(crate) fn view(&self, eye: [f32; 3]) -> View {
        View::new(eye, self.degrees() as f32, self.height as f32)
    }
    /// Returns the error that takes up `pixels` pixels at a distance.
    pub(crate) fn error(&self, pixels: f64, distance: f64) -> Target {
        Target::Error(distance * self.slope(pixels))
    }
    /// Returns the error per distance that takes up `pixels` pixels.
    pub(crate) fn slope(&self, pixels: f64) -> f64 {
        let height_at_distance_1 = 2.0 * (self.degrees().to_radians() / 2.0).tan();
        pixels * height_at_distance_1 / self.height
    }
    /// Returns the height of the screen in pixels and its vertical field of view in degrees.
    pub(crate) fn size(&self) -> (f64, f64) {
        (self.height, self.degrees())
    }
    fn degrees(&self) -> f64 {
        self.fovy.unwrap_or(60.0)
    }
}

impl SelectorArgs {
    pub(crate) fn per_object(&self) -> bool {
        self.per_object
    }
    /// Returns the pixels asked for.
    pub(crate) fn pixels(&self) -> Option<f64> {
        self.target.pixels
    }
    /// Returns the error per distance that takes up `pixels` pixels.
    pub(crate) fn slope(&self, pixels: f64) -> f64 {
        self.screen.slope(pixels)
    }
    /// Returns the tangent of half the vertical field of view.
    pub(crate) fn tangent(&self) -> f64 {
        (self.screen.degrees().to_radians() / 2.0).tan()
    }
    /// Returns the vertical field of view that was given, in degrees.
    pub(crate) fn field_of_view(&self) -> Option<f64> {
        self.screen.fovy
    }
    /// Returns the vertical field of view of an eye, in degrees.
    pub(crate) fn field_of_view_of_eye(&self) -> f64 {
        self.screen.degrees()
    }
    /// Refuses pixels without a distance.
    ///
    /// # Errors
    /// If `--distance` is missing.
    pub(crate) fn check_distance(&self) -> Outcome<()> {
        match (self.target.pixels, self.distance) {
            (Some(_), None) => Err(Failure::usage("--pixels needs --distance D, or a --criterion")),
            _ => Ok(()),
        }
    }
    /// Returns the largest distance asked for, if any.
    pub(crate) fn largest_distance(&self) -> Option<Asked> {
        let option = match self.target()? {
            Target::Error(_) if self.target.pixels.is_some() => "--pixels",
            Target::Error(_) | Target::ErrorShare(_) => "--error",
            Target::Rms(_) | Target::RmsShare(_) => "--rms",
            Target::Lod(_) | Target::Ratio(_) | Target::Triangles(_) => return None,
        };
        let per_object = self.per_object;
        self.target().map(|target| Asked { option, target, per_object })
    }
    /// Returns the level asked for, if any.
    pub(crate) fn target(&self) -> Option<Target> {
        let t = &self.target;
        let by_pixels = t.pixels.zip(self.distance).map(|(p, d)| self.screen.error(p, d));
        let chosen = t.lod.map(Target::Lod).or(t.ratio.map(Target::Ratio));
        chosen.or(t.triangles.map(Target::Triangles)).or(t.error).or(t.rms).or(by_pixels)
    }
}

impl From<SelectError> for Failure {
    fn from(error: SelectError) -> Self {
        match error {
            SelectError::Record(RecordError::OfScene { objects }) => Self::usage(format!(
                "--lod counts the records of one object, and there are {objects}: add \
                 --per-object, or use --ratio, --triangles or --error"
            )),
            SelectError::Record(RecordError::Unlocks { .. }) => {
                Self::usage(format!("--lod: {error}"))
            }
            SelectError::NotMeasured { .. } => {
                Self::usage(format!("{error}: build it again for --rms, or use --error"))
            }
            SelectError::TooManyVertices { .. } => Self::new(Status::Limit, error.to_string()),
            SelectError::NoMesh { .. } => Self::new(Status::Bug, error.to_string()),
        }
    }
}

/// A number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err(format!("{text}: not a number above 0")),
    }
}

fn field_of_view(text: &str) -> Result<f64, String> {
    positive(text).and_then(|v| if v < 180.0 { Ok(v) } else { Err("below 180 degrees".to_owned()) })
}
