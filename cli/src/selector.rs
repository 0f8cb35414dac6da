//! From what a person asks for (a record, a share, a count, an error) to one LOD per object.

use crate::exit::{Failure, Outcome};
use clap::{ArgMatches, Args, Command, FromArgMatches};
use lodc_mesh::{CollapseSequence, Lod};

/// Exactly one of these says which level of detail is wanted.
#[derive(Args, Clone, Debug)]
pub(crate) struct SelectorArgs {
    #[command(flatten)]
    target: TargetArgs,
    /// Apply the selection to each object by itself instead of to the scene as a whole
    #[arg(long)]
    per_object: bool,
}

#[derive(Args, Clone, Debug)]
#[group(required = true, multiple = false)]
struct TargetArgs {
    /// The LOD after N records, rounded down to a step (0: the input; larger is coarser)
    #[arg(long, value_name = "N")]
    lod: Option<u32>,
    /// At most floor(R x input triangles), 0 to 1
    #[arg(long, value_name = "R", value_parser = ratio)]
    ratio: Option<f64>,
    /// The finest LOD with at most N triangles
    #[arg(long, value_name = "N")]
    triangles: Option<u64>,
    /// The coarsest LOD whose error is at most E, in the mesh's units (E%: of the bounding box's
    /// diagonal)
    #[arg(long, value_name = "E", value_parser = bound)]
    error: Option<Target>,
}

/// The same, and none of them has to be there.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "what it is for needs a device"))]
pub(crate) struct OptionalSelector {
    target: TargetArgs,
    per_object: bool,
}

#[cfg(feature = "gpu")]
impl OptionalSelector {
    pub(crate) fn per_object(&self) -> bool {
        self.per_object
    }
    /// Returns the level asked for, if any.
    pub(crate) fn target(&self) -> Option<Target> {
        self.target.chosen()
    }
}

impl FromArgMatches for OptionalSelector {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self {
            target: TargetArgs::from_arg_matches(matches)?,
            per_object: matches.get_flag("per_object"),
        })
    }
    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for OptionalSelector {
    fn augment_args(command: Command) -> Command {
        SelectorArgs::augment_args(command).mut_group("TargetArgs", |group| group.required(false))
    }
    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl TargetArgs {
    fn chosen(&self) -> Option<Target> {
        let chosen = self.lod.map(Target::Lod).or(self.ratio.map(Target::Ratio));
        chosen.or(self.triangles.map(Target::Triangles)).or(self.error)
    }
}

impl SelectorArgs {
    pub(crate) fn per_object(&self) -> bool {
        self.per_object
    }
    /// Returns the level asked for.
    pub(crate) fn target(&self) -> Target {
        self.target.chosen().expect("clap demands exactly one of the group")
    }
}

/// The level of detail that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Target {
    /// This many records applied.
    Lod(u32),
    /// At most this share of the input's triangles.
    Ratio(f64),
    /// At most this many triangles.
    Triangles(u64),
    /// At most this error, in mesh units (one object) or world units (a scene).
    Error(f64),
    /// At most this share of the bounding box's diagonal.
    ErrorShare(f64),
}

/// An object to choose a LOD for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate<'a> {
    pub(crate) name: &'a str,
    pub(crate) collapses: &'a CollapseSequence,
    /// World units per mesh unit.
    pub(crate) scale: f64,
    /// Of its bounding box, in mesh units.
    pub(crate) diagonal: f64,
}

/// The LODs that were chosen.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Selection {
    /// One per object; always the end of a step.
    pub(crate) lods: Vec<Lod>,
    /// The largest error of an object: in mesh units for one object, in world units for several.
    pub(crate) error: f64,
    /// The parts of the request that could not be met in full.
    pub(crate) warnings: Vec<String>,
}

/// Chooses one LOD per object. Several objects are met by one threshold in world units, unless
/// `per_object`.
///
/// # Errors
/// If a record number is asked of several objects at once.
pub(crate) fn select(
    objects: &[Candidate<'_>],
    target: Target,
    per_object: bool,
) -> Outcome<Selection> {
    let mut chosen = Selection::default();
    if objects.len() <= 1 || per_object {
        for object in objects {
            let lod = alone(object, target, &mut chosen.warnings);
            chosen.lods.push(lod);
        }
    } else {
        together(objects, target, &mut chosen)?;
    }
    let world = objects.len() > 1;
    let errors = objects
        .iter()
        .zip(&chosen.lods)
        .map(|(o, &lod)| decimal(o.collapses.error_at(lod)) * if world { scale(o) } else { 1.0 });
    chosen.error = errors.fold(0.0, f64::max);
    Ok(chosen)
}

fn alone(object: &Candidate<'_>, target: Target, warnings: &mut Vec<String>) -> Lod {
    let c = object.collapses;
    let wanted = match target {
        Target::Lod(n) => {
            if n > c.last().0 {
                warnings.push(format!(
                    "{}: there are {} records, fewer than {n}: took the last LOD",
                    object.name,
                    c.last().0
                ));
            }
            return c.floor(Lod(n.min(c.last().0)));
        }
        Target::Ratio(r) => c.lod_for_triangles(share(r, u64::from(c.parts().triangles))),
        Target::Triangles(n) => c.lod_for_triangles(u32::try_from(n).unwrap_or(u32::MAX)),
        Target::Error(e) => c.lod_for_error(threshold(e)),
        Target::ErrorShare(s) => c.lod_for_error(threshold(s * object.diagonal)),
    };
    let visible = c.last_visible();
    if wanted > visible {
        warnings.push(format!(
            "{}: stopped at LOD {}, the last that has a triangle",
            object.name, visible.0
        ));
    }
    wanted.min(visible)
}

fn together(objects: &[Candidate<'_>], target: Target, chosen: &mut Selection) -> Outcome<()> {
    let all: u64 = objects.iter().map(|o| u64::from(o.collapses.parts().triangles)).sum();
    match target {
        Target::Lod(_) => {
            return Err(Failure::usage(format!(
                "--lod counts the records of one object, and there are {}: add --per-object, \
                 or use --ratio, --triangles or --error",
                objects.len()
            )));
        }
        Target::Error(e) => within_error(objects, e, chosen),
        Target::ErrorShare(s) => within_error(objects, s * scene_diagonal(objects), chosen),
        Target::Ratio(r) => within_triangles(objects, u64::from(share(r, all)), chosen),
        Target::Triangles(n) => within_triangles(objects, n, chosen),
    }
    Ok(())
}

/// The diagonal that percentages refer to: an object's own for one object, that of the largest as
/// the scene shows it for several.
pub(crate) fn scene_diagonal(objects: &[Candidate<'_>]) -> f64 {
    match objects {
        [one] => one.diagonal,
        several => several.iter().map(|o| o.diagonal * scale(o)).fold(0.0, f64::max),
    }
}

fn within_error(objects: &[Candidate<'_>], error: f64, chosen: &mut Selection) {
    let mut stopped = 0;
    for o in objects {
        let wanted = o.collapses.lod_for_error(threshold(error / scale(o)));
        let visible = o.collapses.last_visible();
        stopped += usize::from(wanted > visible);
        chosen.lods.push(wanted.min(visible));
    }
    warn_of_stopped(stopped, objects.len(), chosen);
}

/// The finest state of the scene, walking the steps of all objects in order of their world error,
/// that has at most `budget` triangles. Among steps of one error, those of earlier objects come
/// first.
fn within_triangles(objects: &[Candidate<'_>], budget: u64, chosen: &mut Selection) {
    let at = |error: Option<f64>| -> Vec<Lod> {
        objects.iter().map(|o| visible_lod(o, error)).collect()
    };
    let total = |lods: &[Lod]| -> u64 {
        objects.iter().zip(lods).map(|(o, &lod)| u64::from(o.collapses.triangles_at(lod))).sum()
    };
    chosen.lods = at(None);
    if total(&chosen.lods) <= budget {
        return;
    }
    // Non-negative floats sort like their bits, so the smallest sufficient error is found in 64
    // halvings.
    let (mut low, mut high) = (0, f64::INFINITY.to_bits());
    while low < high {
        let middle = low + (high - low) / 2;
        if total(&at(Some(f64::from_bits(middle)))) <= budget {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    let error = f64::from_bits(low);
    chosen.lods = at((low > 0).then(|| f64::from_bits(low - 1)));
    for (o, lod) in objects.iter().zip(0..) {
        let excess = total(&chosen.lods).saturating_sub(budget);
        if excess == 0 {
            break;
        }
        let live = u64::from(o.collapses.triangles_at(chosen.lods[lod]));
        let enough = o
            .collapses
            .lod_for_triangles(u32::try_from(live.saturating_sub(excess)).unwrap_or(u32::MAX));
        chosen.lods[lod] = enough.min(visible_lod(o, Some(error)));
    }
    let left = total(&chosen.lods);
    if left > budget {
        chosen.warnings.push(format!(
            "{budget} triangles cannot be reached: every object stopped at its last LOD that has a \
             triangle, {left} in all"
        ));
        return;
    }
    let stopped = objects.iter().zip(&chosen.lods).filter(|&(o, &lod)| {
        let c = o.collapses;
        let next = c.steps_at(lod);
        lod == c.last_visible() && next < c.steps() && world_error(o, c.step(next).error) <= error
    });
    warn_of_stopped(stopped.count(), objects.len(), chosen);
}

fn warn_of_stopped(stopped: usize, of: usize, chosen: &mut Selection) {
    if stopped > 0 {
        chosen.warnings.push(format!(
            "{stopped} of {of} objects stopped at their last LOD that has a triangle"
        ));
    }
}

/// The coarsest LOD of an object whose world error is at most `error` and that is still visible;
/// LOD 0 without a bound.
fn visible_lod(o: &Candidate<'_>, error: Option<f64>) -> Lod {
    let Some(error) = error else { return Lod(0) };
    let parts = o.collapses.parts();
    match parts.step_errors.partition_point(|&e| world_error(o, e) <= error) {
        0 => Lod(0),
        steps => Lod(parts.step_ends[steps - 1]).min(o.collapses.last_visible()),
    }
}

fn world_error(o: &Candidate<'_>, error: f32) -> f64 {
    f64::from(error) * scale(o)
}

fn scale(o: &Candidate<'_>) -> f64 {
    if o.scale.is_finite() { o.scale.abs() } else { 1.0 }
}

fn share(ratio: f64, triangles: u64) -> u32 {
    // Counts stay below 2^53, where f64 is exact; the cast truncates, which is the floor of the
    // contract.
    (ratio * triangles as f64) as u32
}

/// An error as the number that its shortest decimal form stands for: what reports print and people
/// type.
pub(crate) fn decimal(error: f32) -> f64 {
    error.to_string().parse().unwrap_or_else(|_| f64::from(error))
}

/// The largest stored error that, printed, is at most `error`.
fn threshold(error: f64) -> f32 {
    let nearest = error as f32;
    if decimal(nearest) > error { nearest.next_down() } else { nearest }
}

/// A share from 0 to 1.
pub(crate) fn ratio(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    if (0.0..=1.0).contains(&value) {
        Ok(value)
    } else {
        Err("a share from 0 to 1, for example 0.25".to_owned())
    }
}

fn bound(text: &str) -> Result<Target, String> {
    let (number, percent) = text.strip_suffix('%').map_or((text, false), |number| (number, true));
    let value: f64 = number.trim().parse().map_err(|e| format!("{e}"))?;
    if !value.is_finite() || value < 0.0 {
        return Err("a distance of at least 0, or a percentage such as 0.5%".to_owned());
    }
    Ok(if percent { Target::ErrorShare(value / 100.0) } else { Target::Error(value) })
}

#[cfg(test)]
#[path = "selector_tests.rs"]
mod tests;
