//! The list of what is measured: models and baselines, each with a cursor, behind one interface.

use crate::baseline::Baseline;
use crate::error::LabError;
use lodc::{LodObject, stored_bytes};
use lodc_formats::lodc::Layout;
use lodc_lod::AnyModel;
use lodc_mesh::{Lod, Simplified};
use lodc_model::{Model, StorageCost, Traffic};
use lodc_strip::{StripSet, Strips};
use std::sync::Arc;

/// A model with a cursor on it, whatever its kind.
pub(crate) trait Runner {
    /// Moves the cursor; changes are ignored.
    fn seek(&mut self, lod: Lod) -> Traffic;
    /// Moves it, and says how many bytes that sends to a GPU besides.
    fn send(&mut self, lod: Lod) -> (Traffic, u64);
    /// Indices drawn where the cursor is.
    fn drawn(&self) -> u64;
    /// Indices as a device draws them where the cursor is: of strips, each followed by
    /// [`NONE`](lodc_mesh::NONE), and true; else of triangles, and false.
    #[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "nothing is drawn"))]
    fn indices(&self) -> (Vec<u32>, bool);
}

/// A [`Runner`] of any model.
struct Run<'a, M: Model> {
    model: &'a M,
    cursor: M::Cursor,
}

impl<M: Model> Runner for Run<'_, M> {
    fn seek(&mut self, lod: Lod) -> Traffic {
        self.model.seek(&mut self.cursor, lod, &mut ())
    }
    fn send(&mut self, lod: Lod) -> (Traffic, u64) {
        let from = self.model.lod(&self.cursor);
        let traffic = self.seek(lod);
        (traffic, self.model.sent(from, self.model.lod(&self.cursor), traffic))
    }
    fn drawn(&self) -> u64 {
        self.model.drawn(&self.cursor)
    }
    fn indices(&self) -> (Vec<u32>, bool) {
        let list = || self.model.triangles(&self.cursor).iter().flat_map(|t| t.corners).collect();
        let strips = self.model.strip_list(&self.cursor);
        let is_strips = strips.is_some();
        (strips.unwrap_or_else(list), is_strips)
    }
}

/// A model or baseline that is measured: one row of the tables.
pub(crate) struct Measured<'a> {
    pub(crate) name: &'static str,
    /// True if it is a baseline: for comparison only, never stored.
    pub(crate) baseline: bool,
    /// True if it shows every LOD.
    pub(crate) continuous: bool,
    /// All LODs, and those down to 95 % of them (thesis eq. 5.5).
    pub(crate) storage: [StorageCost; 2],
    /// Bytes in a file; none for baselines.
    pub(crate) file_bytes: Option<u64>,
    /// Bytes that a baseline really holds, where the thesis counts them differently.
    pub(crate) tight_bytes: Option<u64>,
    /// Of Speed Strips the share of the strips' degenerate triangles that is taken out.
    pub(crate) degenerates_removed: Option<f64>,
    /// Of Speed Strips the share of the records that change the length of a strip.
    pub(crate) length_changes: Option<f64>,
    /// A cursor on it.
    pub(crate) runner: Box<dyn Runner + 'a>,
}

impl Measured<'_> {
    /// Returns whether it sends whole strips: Speed Strips do.
    pub(crate) fn sends_strips(&self) -> bool {
        self.length_changes.is_some()
    }
}

/// The LOD at which eq. 5.5 of the thesis stops.
fn lod_at_95_percent(model: &impl Model) -> Lod {
    let collapses = model.simplified().collapses();
    collapses.floor(Lod((u64::from(collapses.records()) * 95 / 100) as u32))
}

/// What is measured of every model and baseline; the rest is left out.
fn measured<'a, M: Model>(model: &'a M) -> Measured<'a>
where
    M::Cursor: 'a,
{
    Measured {
        name: model.name(),
        baseline: false,
        continuous: true,
        storage: [model.storage(), model.storage_to(lod_at_95_percent(model))],
        file_bytes: None,
        tight_bytes: None,
        degenerates_removed: None,
        length_changes: None,
        runner: Box::new(Run { model, cursor: model.cursor() }),
    }
}

/// Everything that has levels of detail: the models of an object, then the baselines.
pub(crate) fn all_measured<'a>(
    object: &'a LodObject,
    baselines: &'a [Baseline],
) -> Vec<Measured<'a>> {
    let models = object.models.iter().map(|m| Measured {
        file_bytes: Some(stored_bytes(m, Layout::Packed)),
        degenerates_removed: match m {
            AnyModel::Speed(speed) => Some(speed.degenerates_removed()),
            _ => None,
        },
        length_changes: match m {
            AnyModel::Speed(speed) => Some(speed.length_changes()),
            _ => None,
        },
        ..measured(m)
    });
    let baselines = baselines.iter().map(|b| Measured {
        baseline: true,
        continuous: b.continuous(),
        tight_bytes: b.tight_bytes(),
        ..measured(b)
    });
    models.chain(baselines).collect()
}

/// A structure that shows every LOD.
pub(crate) enum Structure<'a> {
    Model(&'a AnyModel),
    Baseline(&'a Baseline),
}

impl<'a> Structure<'a> {
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Model(model) => model.name(),
            Self::Baseline(baseline) => baseline.name(),
        }
    }
    /// Returns a new cursor at LOD 0.
    pub(crate) fn runner(&self) -> Box<dyn Runner + 'a> {
        match *self {
            Self::Model(model) => Box::new(Run { model, cursor: model.cursor() }),
            Self::Baseline(model) => Box::new(Run { model, cursor: model.cursor() }),
        }
    }
}

/// The models of an object, then the baselines that show every LOD.
pub(crate) fn structures<'a>(
    object: &'a LodObject,
    baselines: &'a [Baseline],
) -> Vec<Structure<'a>> {
    let baselines = baselines.iter().filter(|b| b.continuous()).map(Structure::Baseline);
    object.models.iter().map(Structure::Model).chain(baselines).collect()
}

/// Returns the storage without levels of detail: plain triangles, and plain strips drawn one by
/// one.
#[must_use]
pub fn plain(simplified: &Simplified, strips: &StripSet) -> [(&'static str, StorageCost); 2] {
    [
        ("triangles", StorageCost::of_triangles(simplified)),
        ("strips", StorageCost::of_strips(simplified, strips.separate_indices())),
    ]
}

/// Returns the baselines of an object, over strips of its mesh.
///
/// # Errors
/// If one cannot be made of the sequence: a bug.
pub fn baselines(object: &LodObject, strips: &Arc<Strips>) -> Result<Vec<Baseline>, LabError> {
    Baseline::all(&object.simplified, strips)
        .map_err(|e| LabError::Bug(format!("{}: {e}", object.info.name)))
}
