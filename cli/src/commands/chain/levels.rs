//! From what was asked for to the LODs of every level.

use crate::exit::{Failure, Outcome};
use crate::report::ChainLevel;
use crate::selector::{SceneLevels, bound};
use clap::Args;
use lodc_formats::lodc::LodObject;
use lodc_mesh::Lod;
use lodc_select::{Selection, Target};
use std::path::Path;

/// The levels, in one of four ways.
#[derive(Args, Clone, Debug)]
pub(super) struct LevelArgs {
    /// Shares (`25%`, `0.25`) or counts (`10k`, `500`) of triangles, finest first
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = size, group = "which")]
    levels: Vec<Target>,
    /// Errors, in mesh units or in percent of the diagonal (`0.5%`), finest first
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = bound, group = "which")]
    errors: Vec<Target>,
    /// For each of --distances the coarsest level whose error is at most P pixels on the screen
    #[arg(long, value_name = "P", value_parser = positive, group = "which", requires = "distances")]
    pixels: Option<f64>,
    /// N levels, each with half of the triangles of the one before; ends early at --max-error
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=32),
          group = "which")]
    auto: Option<u32>,
    /// Distances from the eye, nearest first
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = positive,
          requires = "pixels")]
    distances: Vec<f64>,
    /// Height of the screen in pixels
    #[arg(long, value_name = "PIXELS", default_value = "1080", value_parser = positive)]
    height: f64,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEGREES", default_value = "60", value_parser = field_of_view)]
    fovy: f64,
}

/// One level of a chain.
pub(super) struct Level {
    /// One LOD per object.
    pub(super) lods: Vec<Lod>,
    pub(super) triangles: u64,
    /// Vertices that the level needs, once its files are made.
    pub(super) vertices: u64,
    pub(super) error: f64,
    pub(super) rms: Option<f64>,
    /// Distance that the level was chosen for.
    pub(super) distance: Option<f64>,
}

impl Level {
    pub(super) fn report(&self, level: usize, output: &Path) -> ChainLevel {
        ChainLevel {
            level,
            lod: match self.lods[..] {
                [one] => Some(one.0),
                _ => None,
            },
            triangles: self.triangles,
            vertices: self.vertices,
            error: self.error.is_finite().then_some(self.error),
            rms: self.rms.filter(|rms| rms.is_finite()),
            distance: self.distance,
            output: output.display().to_string(),
        }
    }
}

impl LevelArgs {
    /// Chooses the levels, finest first, none beyond `cap`, and says where a wish was not met.
    ///
    /// # Errors
    /// If the levels do not get coarser.
    pub(super) fn choose(
        &self,
        objects: &[LodObject],
        scene: &SceneLevels<'_>,
        cap: Option<Target>,
    ) -> Outcome<(Vec<Level>, Vec<String>)> {
        let (mut levels, mut warnings): (Vec<Level>, Vec<String>) = Default::default();
        for (target, distance) in self.targets() {
            let chosen = scene.select_capped(target, cap)?;
            let level = level(objects, &chosen, distance);
            let before = levels.last().map(|l| (l.triangles, &l.lods));
            if before.is_some_and(|(triangles, _)| triangles < level.triangles) {
                return Err(Failure::usage(format!(
                    "level {} has more triangles than the one before it: name the finest first",
                    levels.len()
                )));
            }
            if self.auto.is_some() && before.is_some_and(|(_, lods)| *lods == level.lods) {
                break;
            }
            levels.push(level);
            warnings.extend(chosen.warnings);
        }
        warnings.dedup();
        Ok((levels, warnings))
    }

    fn targets(&self) -> Vec<(Target, Option<f64>)> {
        let plain = |targets: &[Target]| targets.iter().map(|&t| (t, None)).collect();
        if let Some(pixels) = self.pixels {
            // Height of the view at distance 1.
            let height = 2.0 * (self.fovy.to_radians() / 2.0).tan();
            let error = |&d: &f64| (Target::Error(pixels * d * height / self.height), Some(d));
            return self.distances.iter().map(error).collect();
        }
        if let Some(n) = self.auto {
            return (0..n).map(|k| (Target::Ratio(0.5f64.powi(k as i32)), None)).collect();
        }
        match (&self.levels[..], &self.errors[..]) {
            ([], []) => plain(&[1.0, 0.5, 0.25, 0.1].map(Target::Ratio)),
            ([], errors) => plain(errors),
            (levels, _) => plain(levels),
        }
    }
}

fn level(objects: &[LodObject], chosen: &Selection, distance: Option<f64>) -> Level {
    let triangles =
        |(o, &lod): (&LodObject, &Lod)| u64::from(o.simplified.collapses().triangles_at(lod));
    Level {
        triangles: objects.iter().zip(&chosen.lods).map(triangles).sum(),
        vertices: 0,
        error: chosen.error,
        rms: chosen.rms,
        lods: chosen.lods.clone(),
        distance,
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
    } else if lower.contains('.') || lower == "1" {
        share(number(&lower)?)
    } else {
        count(number(&lower)?.trunc())
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err(format!("{text}: not a number above 0")),
    }
}

fn field_of_view(text: &str) -> Result<f64, String> {
    positive(text).and_then(|v| if v < 180.0 { Ok(v) } else { Err("below 180 degrees".to_owned()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_shares_or_counts() {
        let cases = [
            ("25%", Target::Ratio(0.25)),
            ("0.25", Target::Ratio(0.25)),
            ("1", Target::Ratio(1.0)),
            ("100%", Target::Ratio(1.0)),
            ("500", Target::Triangles(500)),
            ("10k", Target::Triangles(10_000)),
            ("1.5M", Target::Triangles(1_500_000)),
        ];
        for (text, target) in cases {
            assert_eq!(size(text), Ok(target), "{text}");
        }
        for wrong in ["", "%", "120%", "1.5", "-3", "nan", "k", "ten", "inf"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
