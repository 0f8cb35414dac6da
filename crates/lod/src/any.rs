//! The closed list of level-of-detail models, and a model of any kind. No other file names them
//! all.

use crate::{Interactive, Masking, Speed};
use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use lodc_model::{Array, BuildError, Changes, Layout, Model, StorageCost, Traffic};
use lodc_plan::{Benchmark, Plan, PlanError, Shader};
use lodc_strip::{StripKind, StripPool, Strips};
use lodc_verify::{Check, Reference};
use std::{str::FromStr, sync::Arc};

/// The kinds of models.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ModelKind {
    /// Speed Strips (thesis chapter 3).
    Speed,
    /// Masking Strips (thesis chapter 4).
    Masking,
    /// Interactive Meshes (thesis chapter 5).
    Interactive,
}

impl ModelKind {
    /// All kinds, in the order in which files and reports list them.
    pub const ALL: [Self; 3] = [Self::Speed, Self::Masking, Self::Interactive];

    /// The generator whose strips the model is made of unless asked otherwise; none if it is not
    /// made of strips.
    #[must_use]
    pub const fn strips(self) -> Option<StripKind> {
        match self {
            Self::Speed => Some(StripKind::Stripe),
            Self::Masking => Some(StripKind::Cache),
            Self::Interactive => None,
        }
    }

    /// The kernels that an engine needs to show it, in the order of their use.
    #[must_use]
    pub const fn shaders(self) -> &'static [Shader] {
        match self {
            Self::Speed => &crate::speed::SHADERS,
            Self::Masking => &crate::masking::SHADERS,
            Self::Interactive => &crate::interactive::shaders::ALL,
        }
    }

    /// One line of help.
    #[must_use]
    pub const fn help(self) -> &'static str {
        match self {
            Self::Speed => "Speed Strips",
            Self::Masking => "Masking Strips",
            Self::Interactive => "Interactive Meshes",
        }
    }

    /// The name in options, files and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Masking => "masking",
            Self::Interactive => "interactive",
        }
    }
}

impl FromStr for ModelKind {
    type Err = ();

    fn from_str(name: &str) -> Result<Self, ()> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or(())
    }
}

/// What methods panic with if the cursor is of another kind of model.
const OTHER_MODEL: &str = "a cursor of another model";

/// A model of any kind.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum AnyModel {
    /// Speed Strips.
    Speed(Speed),
    /// Masking Strips.
    Masking(Masking),
    /// Interactive Meshes.
    Interactive(Interactive),
}

/// A cursor over an [`AnyModel`]. Methods that take a model and a cursor panic if the cursor is of
/// another kind of model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum AnyCursor {
    /// Over Speed Strips.
    Speed(<Speed as Model>::Cursor),
    /// Over Masking Strips.
    Masking(<Masking as Model>::Cursor),
    /// Over Interactive Meshes.
    Interactive(<Interactive as Model>::Cursor),
}

impl AnyModel {
    /// Builds a model, of strips from the pool if it is made of strips.
    ///
    /// # Errors
    /// If it cannot be made of this sequence.
    pub fn build(kind: ModelKind, strips: &mut StripPool<'_>) -> Result<Self, BuildError> {
        let simplified = strips.simplified();
        let mut own_strips = || {
            let default = kind.strips().expect("the kind is made of strips");
            strips.get(default)
        };
        match kind {
            ModelKind::Speed => Speed::build(simplified, own_strips()).map(Self::Speed),
            ModelKind::Masking => Masking::build(simplified, own_strips()).map(Self::Masking),
            ModelKind::Interactive => Interactive::build(simplified).map(Self::Interactive),
        }
    }

    /// Makes a model of what [`Model::arrays`] gave out.
    ///
    /// # Errors
    /// If the arrays do not fit the sequence.
    pub fn load(
        kind: ModelKind,
        simplified: &Arc<Simplified>,
        arrays: &[Array],
    ) -> Result<Self, BuildError> {
        match kind {
            ModelKind::Speed => Speed::load(simplified, arrays).map(Self::Speed),
            ModelKind::Masking => Masking::load(simplified, arrays).map(Self::Masking),
            ModelKind::Interactive => Interactive::load(simplified, arrays).map(Self::Interactive),
        }
    }

    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> ModelKind {
        match self {
            Self::Speed(_) => ModelKind::Speed,
            Self::Masking(_) => ModelKind::Masking,
            Self::Interactive(_) => ModelKind::Interactive,
        }
    }

    /// The strips that it is made of, if it is.
    #[must_use]
    pub fn strips(&self) -> Option<&Strips> {
        match self {
            Self::Speed(model) => Some(model.strips()),
            Self::Masking(model) => Some(model.strips()),
            Self::Interactive(_) => None,
        }
    }

    /// Compares a few levels that depend on the view with the collapse sequence applied plainly;
    /// none if the model shows only whole LODs.
    #[must_use]
    pub fn verify_views(&self) -> Option<Check> {
        match self {
            Self::Speed(_) | Self::Masking(_) => None,
            Self::Interactive(model) => Some(model.verify_views()),
        }
    }

    /// Its replays on a graphics device, each of which seeks the LODs `stops` in turn; none for a
    /// mesh without vertices. `reference` must have been made of the simplification that the model
    /// was built from.
    ///
    /// # Errors
    /// If the mesh is too large or too deep for any device.
    pub fn replays<'a>(
        &'a self,
        stops: &[Lod],
        reference: &'a Reference<'_>,
    ) -> Result<Vec<Plan<'a>>, PlanError> {
        if self.simplified().mesh().vertex_count() == 0 {
            return Ok(Vec::new());
        }
        match self {
            Self::Speed(model) => Ok(vec![model.replay(stops.to_vec(), reference)?]),
            Self::Masking(model) => Ok(vec![model.replay(stops.to_vec(), reference)?]),
            Self::Interactive(model) => model.replays(stops, reference),
        }
    }

    /// Returns the cases that are timed on a graphics device.
    ///
    /// # Errors
    /// If the mesh is too large or too deep for any device.
    pub fn benchmark(&self) -> Result<Benchmark, PlanError> {
        match self {
            Self::Speed(model) => model.benchmark(),
            Self::Masking(model) => model.benchmark(),
            Self::Interactive(model) => model.benchmark(),
        }
    }

    /// The triangles at the LOD shown for `lod`, by a cursor of its own.
    #[must_use]
    pub fn triangles_at(&self, lod: Lod) -> Vec<OrientedTriangle> {
        let mut cursor = self.cursor();
        self.seek(&mut cursor, lod, &mut ());
        self.triangles(&cursor)
    }
}

impl Model for AnyModel {
    type Cursor = AnyCursor;

    fn name(&self) -> &'static str {
        self.kind().name()
    }
    fn simplified(&self) -> &Arc<Simplified> {
        match self {
            Self::Speed(model) => model.simplified(),
            Self::Masking(model) => model.simplified(),
            Self::Interactive(model) => model.simplified(),
        }
    }
    fn cursor(&self) -> AnyCursor {
        match self {
            Self::Speed(model) => AnyCursor::Speed(model.cursor()),
            Self::Masking(model) => AnyCursor::Masking(model.cursor()),
            Self::Interactive(model) => AnyCursor::Interactive(model.cursor()),
        }
    }
    fn lod(&self, cursor: &AnyCursor) -> Lod {
        match (self, cursor) {
            (Self::Speed(model), AnyCursor::Speed(cursor)) => model.lod(cursor),
            (Self::Masking(model), AnyCursor::Masking(cursor)) => model.lod(cursor),
            (Self::Interactive(model), AnyCursor::Interactive(cursor)) => model.lod(cursor),
            _ => panic!("{OTHER_MODEL}"),
        }
    }
    fn seek(&self, cursor: &mut AnyCursor, lod: Lod, changes: &mut impl Changes) -> Traffic {
        match (self, cursor) {
            (Self::Speed(model), AnyCursor::Speed(cursor)) => model.seek(cursor, lod, changes),
            (Self::Masking(model), AnyCursor::Masking(cursor)) => model.seek(cursor, lod, changes),
            (Self::Interactive(model), AnyCursor::Interactive(cursor)) => {
                model.seek(cursor, lod, changes)
            }
            _ => panic!("{OTHER_MODEL}"),
        }
    }
    fn sent(&self, from: Lod, to: Lod, traffic: Traffic) -> u64 {
        match self {
            Self::Speed(model) => model.sent(from, to, traffic),
            Self::Masking(model) => model.sent(from, to, traffic),
            Self::Interactive(model) => model.sent(from, to, traffic),
        }
    }
    fn for_each_triangle(&self, cursor: &AnyCursor, see: impl FnMut(OrientedTriangle)) {
        match (self, cursor) {
            (Self::Speed(model), AnyCursor::Speed(cursor)) => model.for_each_triangle(cursor, see),
            (Self::Masking(model), AnyCursor::Masking(cursor)) => {
                model.for_each_triangle(cursor, see);
            }
            (Self::Interactive(model), AnyCursor::Interactive(cursor)) => {
                model.for_each_triangle(cursor, see);
            }
            _ => panic!("{OTHER_MODEL}"),
        }
    }
    fn drawn(&self, cursor: &AnyCursor) -> u64 {
        match (self, cursor) {
            (Self::Speed(model), AnyCursor::Speed(cursor)) => model.drawn(cursor),
            (Self::Masking(model), AnyCursor::Masking(cursor)) => model.drawn(cursor),
            (Self::Interactive(model), AnyCursor::Interactive(cursor)) => model.drawn(cursor),
            _ => panic!("{OTHER_MODEL}"),
        }
    }
    fn strip_list(&self, cursor: &AnyCursor) -> Option<Vec<u32>> {
        match (self, cursor) {
            (Self::Speed(model), AnyCursor::Speed(cursor)) => model.strip_list(cursor),
            (Self::Masking(model), AnyCursor::Masking(cursor)) => model.strip_list(cursor),
            (Self::Interactive(_), AnyCursor::Interactive(_)) => None,
            _ => panic!("{OTHER_MODEL}"),
        }
    }
    fn storage_to(&self, lod: Lod) -> StorageCost {
        match self {
            Self::Speed(model) => model.storage_to(lod),
            Self::Masking(model) => model.storage_to(lod),
            Self::Interactive(model) => model.storage_to(lod),
        }
    }
    fn arrays(&self, layout: Layout) -> Vec<Array> {
        match self {
            Self::Speed(model) => model.arrays(layout),
            Self::Masking(model) => model.arrays(layout),
            Self::Interactive(model) => model.arrays(layout),
        }
    }
}
