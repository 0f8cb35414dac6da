//! Families of criteria, ordered from fine to coarse by one number, so that a number of triangles
//! can be met by bisection.

use super::Criterion;
use lodc_mesh::Lod;

/// LODs that the criteria of a family lie between, from fine to coarse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LodRange {
    /// Shown where detail is wanted.
    pub fine: Lod,
    /// Shown elsewhere.
    pub coarse: Lod,
    /// The coarsest of all.
    pub last: Lod,
}

/// Criteria of one kind; a setting, a number from 0 to [`Self::coarsest`], picks one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Family {
    /// [`Criterion::Silhouette`] from a viewpoint. First what faces the eye grows coarser, from
    /// `fine` to `coarse`: then all is as the thesis says. From there on the width shrinks to 0,
    /// then outlines grow coarser to `coarse`, then everything to `last`.
    Silhouette {
        /// The viewpoint.
        eye: [f32; 3],
    },
    /// [`Criterion::ScreenError`] from a viewpoint; the setting is the bits of the slope.
    ScreenError {
        /// The viewpoint.
        eye: [f32; 3],
        /// Slope of the given criterion.
        slope: f32,
        /// Slopes are multiplied by this: objects of one scene may be in different units.
        unit: f32,
    },
    /// [`Criterion::Sphere`]. First the outside grows coarser, from `fine` to `coarse`, then the
    /// inside, then everything to `last`.
    Sphere {
        /// Its centre.
        centre: [f32; 3],
        /// Its radius.
        radius: f32,
    },
    /// [`Criterion::Region`], in the same order.
    Region {
        /// Its lowest corner.
        low: [f32; 3],
        /// Its highest corner.
        high: [f32; 3],
    },
    /// [`Criterion::Frustum`], in the same order.
    Frustum {
        /// The viewpoint.
        eye: [f32; 3],
        /// The point in the middle of the screen.
        target: [f32; 3],
        /// Tangents of half the screen's angles, across and upwards.
        tangents: [f32; 2],
    },
}

/// Settings of one stage of a family: fine enough that bisection meets a number of triangles.
/// Chosen by hand.
const SETTINGS_PER_STAGE: u32 = 1 << 26;

impl Family {
    /// Returns the setting of the criterion as it was given, with detail from `fine` to `coarse`.
    #[must_use]
    pub fn given_setting(&self) -> u32 {
        match self {
            Self::ScreenError { slope, .. } => slope.to_bits(),
            _ => SETTINGS_PER_STAGE,
        }
    }

    /// Returns the largest setting, with which everything is at `last`.
    #[must_use]
    pub fn coarsest(&self) -> u32 {
        match self {
            Self::Silhouette { .. } => 4 * SETTINGS_PER_STAGE,
            Self::ScreenError { .. } => 1e30f32.to_bits(),
            Self::Sphere { .. } | Self::Region { .. } | Self::Frustum { .. } => {
                3 * SETTINGS_PER_STAGE
            }
        }
    }

    /// Returns the criterion of a setting. A larger one is nowhere finer.
    #[must_use]
    pub fn criterion(&self, setting: u32, lods: &LodRange) -> Criterion {
        let inside_outside = || stage_lods(lods, setting);
        match *self {
            Self::Silhouette { eye } => {
                // The second stage is that of the width: LODs stay as the first one leaves them.
                let width = 1.0
                    - (f64::from(setting) / f64::from(SETTINGS_PER_STAGE) - 1.0).clamp(0.0, 1.0);
                let lod_setting = if setting < SETTINGS_PER_STAGE {
                    setting
                } else {
                    (setting - SETTINGS_PER_STAGE).max(SETTINGS_PER_STAGE)
                };
                let [edge, face] = stage_lods(lods, lod_setting);
                Criterion::Silhouette { eye, edge, face, width: width as f32 }
            }
            Self::ScreenError { eye, unit, .. } => {
                Criterion::ScreenError { eye, slope: f32::from_bits(setting) * unit }
            }
            Self::Sphere { centre, radius } => {
                let [inside, outside] = inside_outside();
                Criterion::Sphere { centre, radius, inside, outside }
            }
            Self::Region { low, high } => {
                let [inside, outside] = inside_outside();
                Criterion::Region { low, high, inside, outside }
            }
            Self::Frustum { eye, target, tangents } => {
                let [inside, outside] = inside_outside();
                Criterion::Frustum { eye, target, tangents, inside, outside }
            }
        }
    }
}

/// Returns the finer and the coarser LOD of a setting: the coarser one goes from `fine` to
/// `coarse`, the finer one follows, both go on to `last`.
fn stage_lods(lods: &LodRange, setting: u32) -> [Lod; 2] {
    let share = f64::from(setting % SETTINGS_PER_STAGE) / f64::from(SETTINGS_PER_STAGE);
    let between =
        |a: Lod, b: Lod| Lod((f64::from(a.0) + (f64::from(b.0) - f64::from(a.0)) * share) as u32);
    let &LodRange { fine, coarse, last } = lods;
    match setting / SETTINGS_PER_STAGE {
        0 => [fine, between(fine, coarse)],
        1 => [between(fine, coarse), coarse],
        2 => [between(coarse, last); 2],
        _ => [last; 2],
    }
}

/// Returns the smallest setting up to `coarsest` that bisection finds to have at most
/// `max_triangles` triangles: it does, and the one before it does not. `coarsest` if nothing has so
/// few. `count` returns the triangles of a setting; they need not fall everywhere.
pub fn finest_within(max_triangles: u64, coarsest: u32, mut count: impl FnMut(u32) -> u64) -> u32 {
    if count(0) <= max_triangles {
        return 0;
    }
    let (mut too_many, mut within) = (0, coarsest);
    while within - too_many > 1 {
        let middle = too_many + (within - too_many) / 2;
        if count(middle) <= max_triangles { within = middle } else { too_many = middle }
    }
    within
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interactive::view::{Selector, drawn_triangles};

    fn families() -> [Family; 5] {
        [
            Family::Silhouette { eye: [0.0, 0.0, 5.0] },
            Family::ScreenError { eye: [0.0, 0.0, 5.0], slope: 0.01, unit: 1.0 },
            Family::Sphere { centre: [1.0, 0.0, 0.0], radius: 0.7 },
            Family::Region { low: [-2.0, -2.0, 0.0], high: [2.0; 3] },
            Family::Frustum { eye: [0.5, 0.3, 0.2], target: [2.0, 0.0, 0.0], tangents: [0.8, 0.5] },
        ]
    }

    #[test]
    fn every_family_runs_from_fine_to_the_last_lod_and_is_never_finer_at_a_larger_setting() {
        let simplified = lodc_fixtures::random_collapse(&lodc_fixtures::icosphere(2), 1);
        let last = simplified.collapses().last_visible();
        let range = LodRange { fine: Lod(0), coarse: Lod(last.0 * 3 / 4), last };
        let selector = Selector::new(&simplified);
        for family in families() {
            let lods = |setting| selector.lods_at(&family, setting, &range);
            assert!(lods(0).iter().all(|&lod| lod == 0), "{family:?}");
            assert!(lods(family.coarsest()).iter().all(|&lod| lod == last.0), "{family:?}");
            let mut before = lods(0);
            let settings = (1..=400).map(|i| family.coarsest() / 400 * i);
            for setting in settings.chain([family.coarsest()]) {
                let now = lods(setting);
                assert!(now.iter().zip(&before).all(|(a, b)| a >= b), "{family:?} at {setting}");
                before = now;
            }
        }
    }

    #[test]
    fn the_given_setting_is_the_rule_of_the_thesis() {
        let range = LodRange { fine: Lod(2), coarse: Lod(70), last: Lod(90) };
        let [silhouette, screen, sphere, ..] = families();
        let eye = [0.0, 0.0, 5.0];
        assert_eq!(
            silhouette.criterion(silhouette.given_setting(), &range),
            Criterion::Silhouette { eye, edge: Lod(2), face: Lod(70), width: 1.0 }
        );
        assert_eq!(
            screen.criterion(screen.given_setting(), &range),
            Criterion::ScreenError { eye, slope: 0.01 }
        );
        assert!(matches!(
            sphere.criterion(sphere.given_setting(), &range),
            Criterion::Sphere { inside: Lod(2), outside: Lod(70), .. }
        ));
    }

    #[test]
    fn bisection_meets_a_number_of_triangles() {
        let simplified = lodc_fixtures::random_collapse(&lodc_fixtures::icosphere(3), 1);
        let last = simplified.collapses().last_visible();
        let range = LodRange { fine: Lod(0), coarse: Lod(last.0 / 2), last };
        let (selector, positions) = (Selector::new(&simplified), simplified.mesh().position_ids());
        for family in families() {
            let count = |setting| {
                let lods = selector.lods_at(&family, setting, &range);
                drawn_triangles(&simplified, &positions, &selector.states(&lods, false))
            };
            for max_triangles in [1200, 900, 300, 40] {
                let found = count(finest_within(max_triangles, family.coarsest(), count));
                assert!(
                    found <= max_triangles && found * 10 >= max_triangles * 8,
                    "{family:?} {max_triangles}: {found}"
                );
            }
            let fewest = count(family.coarsest());
            assert_eq!(count(finest_within(0, family.coarsest(), count)), fewest);
            assert_eq!(finest_within(1280, family.coarsest(), count), 0);
        }
    }
}
