//! Poses: a scene at a moment of one of its animations.

use crate::exit::{Failure, Outcome};
use crate::help::SEEN;
use clap::Args;
use lodc_formats::{Document, Limits, animation, animation_names};
use lodc_scene::{Graph, Pose};
use std::path::Path;

/// The moment at which a scene is looked at.
#[derive(Args, Clone, Debug)]
pub(crate) struct PoseArgs {
    /// Moment of an animation: 0@1.5, Walk@0.3 [default: at rest]
    ///
    /// The animation's number (from 0) or name, and seconds; without seconds its first moment.
    /// Skins, nodes and morph targets are as the animation says. An animation that is not there
    /// ends with status 2 and a list of those that are.
    #[arg(long, value_name = "NAME@SECONDS", value_parser = moment, help_heading = SEEN,
          hide_short_help = true)]
    pose: Option<Moment>,
}

/// A moment of an animation.
#[derive(Clone, Debug, PartialEq)]
struct Moment {
    animation: String,
    seconds: f64,
}

/// Reads `Walk@1.5`; without seconds it is the animation's first moment.
fn moment(text: &str) -> Result<Moment, String> {
    let (animation, seconds) = text.rsplit_once('@').unwrap_or((text, "0"));
    match seconds.parse::<f64>() {
        Ok(seconds) if seconds.is_finite() && seconds >= 0.0 && !animation.is_empty() => {
            Ok(Moment { animation: animation.to_owned(), seconds })
        }
        _ => Err("an animation and seconds, for example 0@1.5 or Walk@0.3".to_owned()),
    }
}

impl PoseArgs {
    /// Returns whether a pose is asked for.
    pub(crate) fn is_given(&self) -> bool {
        self.pose.is_some()
    }

    /// Returns the pose asked for, or the one at rest.
    ///
    /// # Errors
    /// If the file has no such animation, or it is damaged.
    pub(crate) fn of(
        &self,
        input: &Path,
        document: &Document,
        graph: &Graph,
        limits: &Limits,
    ) -> Outcome<Pose> {
        let Some(Moment { animation: wanted, seconds }) = &self.pose else {
            return Ok(graph.rest_pose());
        };
        let input = input.display().to_string();
        let names = animation_names(document, limits).map_err(|e| e.in_file(&input))?;
        // A name that is a number comes before the number.
        let by_number = || wanted.parse().ok().filter(|&number: &usize| number < names.len());
        let Some(number) = names.iter().position(|name| name == wanted).or_else(by_number) else {
            let numbered: Vec<String> =
                names.iter().enumerate().map(|(i, name)| format!("{i} {name}")).collect();
            let list = if numbered.is_empty() { "none".to_owned() } else { numbered.join(", ") };
            let what = format!("{input}: has no animation {wanted} (it has: {})", list.trim_end());
            return Err(Failure::usage(what));
        };
        let found = animation(document, number, limits).map_err(|e| e.in_file(&input))?;
        Ok(found.pose(graph, *seconds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_read_and_nonsense_is_refused() {
        let at = |animation: &str, seconds| Ok(Moment { animation: animation.to_owned(), seconds });
        assert_eq!(moment("0@1.5"), at("0", 1.5));
        assert_eq!(moment("a@b@2"), at("a@b", 2.0));
        assert_eq!(moment("Walk"), at("Walk", 0.0));
        for wrong in ["", "@1", "Walk@", "Walk@-1", "Walk@soon", "0@NaN"] {
            assert!(moment(wrong).is_err(), "{wrong}");
        }
    }
}
