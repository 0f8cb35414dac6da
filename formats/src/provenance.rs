//! The metadata that an export states about itself (JSON in glTF, a comment line in OBJ and PLY):
//! source hash, level of detail, error, distances at which it morphs.

#[cfg(feature = "export")]
use crate::GENERATOR;
use lodc_mesh::PoseKey;

/// A level of detail as its file states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelFacts {
    /// Its number of records; none if several objects each have their own.
    pub lod: Option<u32>,
    /// Its error, in world units.
    pub error: f64,
    /// Its root mean square distance, in the same units, if it was measured.
    pub rms: Option<f64>,
    /// Where it morphs to the next level; none of a level that does not.
    pub geomorph: Option<GeomorphFacts>,
}

/// The distances from the eye at which a level of a chain is shown and morphs, in the units of
/// errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeomorphFacts {
    /// The distance from which the level suits.
    pub distance: Option<f64>,
    /// The distance from which it moves towards the next level. It arrives at the next level's
    /// distance. None of the last level.
    pub morph_from: Option<f64>,
    /// How far from the next level its vertices are when they have arrived, at most, in the poses
    /// that errors are over; none without skins and morph targets.
    pub pose_error: Option<f64>,
    /// The number of its vertices that stay where they are, as they would spoil a shape in motion.
    pub staying: u64,
}

/// The screen that distances of levels are for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenFacts {
    /// The largest error on the screen, in pixels.
    pub pixels: f64,
    /// Lines of the screen.
    pub height: f64,
    /// The vertical field of view in degrees.
    pub fovy: f64,
}

/// Origin of an export.
#[derive(Clone, Debug, PartialEq)]
pub struct Provenance {
    /// XXH3-128 of the source (`Source::content_hash`).
    pub source: u128,
    /// The levels in the file, the finest first.
    pub levels: Vec<LevelFacts>,
    /// True if vertices were moved to where they fit best.
    pub refitted: bool,
    /// The screen that distances are for, if levels state any.
    pub screen: Option<ScreenFacts>,
    /// The file of the next level, where each has its own and morphs to it.
    pub next: Option<String>,
    /// For each object of the source the poses that its errors are the largest over, besides the
    /// one at rest; none if that is not known.
    pub poses: Option<Vec<Vec<PoseKey>>>,
}

impl Provenance {
    /// One line for text formats.
    #[cfg(feature = "export")]
    pub(crate) fn line(&self) -> String {
        let mut line = GENERATOR.to_owned();
        for l in &self.levels {
            if let Some(lod) = l.lod {
                line += &format!(", LOD {lod}");
            }
            if l.error.is_finite() {
                line += &format!(", error {}", l.error);
            }
            if let Some(rms) = l.rms {
                line += &format!(", rms {rms}");
            }
        }
        if self.refitted {
            line += ", refitted";
        }
        format!("{line}, source {:032x}", self.source)
    }

    /// Reads such a line; none if it is something else.
    #[cfg(feature = "import")]
    pub(crate) fn of_line(line: &str) -> Option<Self> {
        let mut stated = LevelFacts { lod: None, error: f64::INFINITY, rms: None, geomorph: None };
        let (mut source, mut refitted) = (None, false);
        for part in line.strip_prefix("lodc ")?.split(", ").skip(1) {
            match part.split_once(' ') {
                Some(("LOD", lod)) => stated.lod = lod.parse().ok(),
                Some(("error", error)) => stated.error = error.parse().ok()?,
                Some(("rms", rms)) => stated.rms = rms.parse().ok(),
                Some(("source", hash)) => source = u128::from_str_radix(hash, 16).ok(),
                _ => refitted |= part == "refitted",
            }
        }
        let (screen, next, poses) = (None, None, None);
        Some(Self { source: source?, levels: vec![stated], refitted, screen, next, poses })
    }
}
