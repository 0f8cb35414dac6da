//! From what a person asks for (a record, a share, a count, an error) to one LOD per object.

use crate::exit::{Failure, Outcome};
use crate::help::{LEVEL, SEEN};
use clap::Args;
use lodc_formats::lodc::LodObject;
use lodc_formats::{Document, Limits, ObjectInfo, scene_graph};
use lodc_mesh::Simplified;
use lodc_scene::{Arrangement, Graph};
use lodc_select::{Candidate, Selection, Target, View, losses, select};
use std::sync::OnceLock;

/// At most one of these says which level of detail is wanted.
#[derive(Args, Clone, Debug)]
pub(crate) struct SelectorArgs {
    #[command(flatten)]
    target: TargetArgs,
    /// Distance of the eye for --pixels, in the units of errors
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
    #[arg(long, value_name = "R", value_parser = share)]
    ratio: Option<f64>,
    /// At most N triangles: 500, 10k, 2m
    ///
    /// The finest level that has no more. Of several objects, triangles go first where least is lost
    /// by it. An object never comes back empty: the selection stops at its last level that has a
    /// triangle, with a warning (as with every selector but --lod).
    #[arg(long, value_name = "N", value_parser = count)]
    triangles: Option<u64>,
    /// At most this far from the input, in its units; E% of its diagonal
    ///
    /// The coarsest level whose error is at most E. The error is the largest distance between the
    /// surfaces of level and input, measured from both. Of several objects it is met by each, in
    /// world units; the diagonal is that of the largest object's bounding box as the scene shows it.
    #[arg(long, value_name = "E", value_parser = bound)]
    error: Option<Target>,
    /// The same for the root mean square distance
    #[arg(long, value_name = "E", value_parser = rms_bound, hide_short_help = true)]
    rms: Option<Target>,
    /// An error of at most P pixels on the screen, seen from --distance
    #[arg(long, value_name = "P", value_parser = positive)]
    pixels: Option<f64>,
    /// The level after N collapse records (0: the input; larger is coarser)
    ///
    /// Rounded down to a whole step; numbers past the last mean the last.
    #[arg(long, value_name = "N", hide_short_help = true)]
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
    /// Returns a camera at a place with this screen.
    pub(crate) fn view(&self, eye: [f32; 3]) -> View {
        View::new(eye, self.degrees() as f32, self.height as f32)
    }
    /// Returns the error that takes up so many pixels at a distance.
    pub(crate) fn error(&self, pixels: f64, distance: f64) -> Target {
        Target::Error(distance * self.slope(pixels))
    }
    /// Returns the same at distance 1.
    pub(crate) fn slope(&self, pixels: f64) -> f64 {
        let height = 2.0 * (self.degrees().to_radians() / 2.0).tan();
        pixels * height / self.height
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
    /// Returns the error per distance that takes up so many pixels.
    pub(crate) fn slope(&self, pixels: f64) -> f64 {
        self.screen.slope(pixels)
    }
    /// Returns the vertical field of view that was given, in degrees.
    pub(crate) fn field_of_view(&self) -> Option<f64> {
        self.screen.fovy
    }
    /// Returns the vertical field of view of an eye, in degrees.
    #[cfg(feature = "gpu")]
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
    /// Returns the level asked for, if any.
    pub(crate) fn target(&self) -> Option<Target> {
        let t = &self.target;
        let seen = t.pixels.zip(self.distance).map(|(p, d)| self.screen.error(p, d));
        let chosen = t.lod.map(Target::Lod).or(t.ratio.map(Target::Ratio));
        chosen.or(t.triangles.map(Target::Triangles)).or(t.error).or(t.rms).or(seen)
    }
}

/// Objects to choose levels of detail for, and the scene that shows them.
pub(crate) struct SceneLevels<'a> {
    objects: &'a [LodObject],
    scene: Arrangement,
    losses: OnceLock<Vec<Vec<f64>>>,
}

impl<'a> SceneLevels<'a> {
    /// # Errors
    /// If the stored document is damaged.
    pub(crate) fn new(
        objects: &'a [LodObject],
        document: &Document,
        limits: &Limits,
    ) -> Outcome<Self> {
        let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
        let graph = match objects {
            // Only what several objects lose depends on where they stand.
            [] | [_] => Graph::of_objects(objects.len() as u32),
            _ => scene_graph(document, &infos, limits)?,
        };
        let scene = Arrangement::new(&graph, &graph.rest_pose(), objects.len());
        Ok(Self { objects, scene, losses: OnceLock::new() })
    }

    /// Returns the objects.
    pub(crate) fn objects(&self) -> &'a [LodObject] {
        self.objects
    }

    /// Objects as they are selected from.
    pub(crate) fn candidates(&self) -> Vec<Candidate<'a>> {
        let candidate = |o: &'a LodObject| Candidate {
            name: &o.info.name,
            collapses: o.simplified.collapses(),
            scale: o.info.world_scale,
            diagonal: o.simplified.mesh().diagonal(),
        };
        self.objects.iter().map(candidate).collect()
    }

    /// Chooses one level of detail per object.
    ///
    /// # Errors
    /// If a record number is asked of several objects at once, or a root mean square distance where
    /// none was measured.
    pub(crate) fn select(&self, target: Target, per_object: bool) -> Outcome<Selection> {
        self.check_measured(target)?;
        let losses = || {
            self.losses.get_or_init(|| {
                let objects: Vec<&Simplified> =
                    self.objects.iter().map(|o| &*o.simplified).collect();
                losses(&objects, &self.scene)
            })
        };
        select(&self.candidates(), target, per_object, losses).map_err(|e| {
            Failure::usage(format!(
                "--lod counts the records of one object, and there are {}: add --per-object, or \
                 use --ratio, --triangles or --error",
                e.objects
            ))
        })
    }

    /// Chooses as [`Self::select`] does, but no level coarser than `cap`, an error, allows. Objects
    /// for which `own` has a target by their name have their level by themselves.
    ///
    /// # Errors
    /// As [`Self::select`].
    pub(crate) fn select_capped(
        &self,
        target: Target,
        own: impl Fn(&str) -> Option<Target>,
        cap: Option<Target>,
        per_object: bool,
    ) -> Outcome<Selection> {
        let mut chosen = self.select(target, per_object)?;
        let objects = self.objects.iter().enumerate();
        let own: Vec<_> = objects.filter_map(|(i, o)| Some((i, own(&o.info.name)?))).collect();
        if !own.is_empty() {
            chosen.put(&self.candidates(), own.into_iter());
        }
        if let Some(cap) = cap {
            chosen.cap(&self.candidates(), &self.select(cap, per_object)?);
        }
        Ok(chosen)
    }

    /// Refuses to choose by a distance that was not measured.
    fn check_measured(&self, target: Target) -> Outcome<()> {
        let by_rms = matches!(target, Target::Rms(_) | Target::RmsShare(_));
        let estimate = |o: &&LodObject| !o.simplified.collapses().is_measured();
        match self.objects.iter().find(|o| by_rms && estimate(o)) {
            Some(o) => Err(Failure::usage(format!(
                "{}: has errors that are estimates, and no root mean square distances: build it \
                 again for --rms, or use --error",
                o.info.name
            ))),
            None => Ok(()),
        }
    }
}

/// A share of triangles: `25%`, `0.25`, `1`.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    match size(text) {
        Ok(Target::Ratio(share)) => Ok(share),
        Ok(_) if text == "0" => Ok(0.0),
        Ok(_) => {
            Err("a share from 0 to 1, for example 0.25 or 25% (--triangles takes counts)"
                .to_owned())
        }
        Err(e) => Err(e),
    }
}

/// A number of triangles: `500`, `10k`, `2m`.
fn count(text: &str) -> Result<u64, String> {
    match size(text) {
        Ok(Target::Triangles(count)) => Ok(count),
        Ok(_) if text == "1" => Ok(1),
        Ok(_) => Err("a count, for example 500 or 10k (--ratio takes shares)".to_owned()),
        Err(e) => Err(e),
    }
}

/// `25%`, `0.25`, `1` (all), `500`, `10k` or `2m`.
pub(crate) fn size(text: &str) -> Result<Target, String> {
    let wrong = || format!("{text}: not a share (25%, 0.25) or a count (500, 10k)");
    let number = |digits: &str| -> Result<f64, String> {
        let value: f64 = digits.parse().map_err(|_| wrong())?;
        if value.is_finite() && value >= 0.0 { Ok(value) } else { Err(wrong()) }
    };
    let share = |value: f64| {
        if value <= 1.0 { Ok(Target::Ratio(value)) } else { Err(format!("{text}: above 100 %")) }
    };
    let count = |value: f64| Ok(Target::Triangles(value as u64));
    let lower = text.to_lowercase();
    if let Some(percent) = lower.strip_suffix('%') {
        share(number(percent)? / 100.0)
    } else if let Some(thousands) = lower.strip_suffix('k') {
        count(number(thousands)? * 1e3)
    } else if let Some(millions) = lower.strip_suffix('m') {
        count(number(millions)? * 1e6)
    } else if lower.contains(['.', 'e']) || lower == "1" {
        share(number(&lower)?)
    } else {
        count(number(&lower)?.trunc())
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

/// A distance in mesh units or in percent of the diagonal.
pub(crate) fn bound(text: &str) -> Result<Target, String> {
    let (number, percent) = text.strip_suffix('%').map_or((text, false), |number| (number, true));
    let value: f64 = number.trim().parse().map_err(|e| format!("{e}"))?;
    if !value.is_finite() || value < 0.0 {
        return Err("a distance of at least 0, or a percentage such as 0.5%".to_owned());
    }
    Ok(if percent { Target::ErrorShare(value / 100.0) } else { Target::Error(value) })
}

/// A bound of the root mean square distance.
fn rms_bound(text: &str) -> Result<Target, String> {
    Ok(match bound(text)? {
        Target::ErrorShare(share) => Target::RmsShare(share),
        Target::Error(rms) => Target::Rms(rms),
        other => other,
    })
}

#[cfg(test)]
#[path = "selector_tests.rs"]
mod tests;
