//! Loads `.lodc` files and decodes the models that they store.

use lodc_formats::lodc::{self, StoredModel};
use lodc_formats::{FormatError, lodc::Layout};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::Simplified;
use lodc_model::Model;
use std::sync::Arc;

/// A `.lodc` file in memory.
pub type LodFile = lodc::LodFile<AnyModel>;
/// One object of a `.lodc` file: its mesh in collapse order, the sequence, and its models.
pub type LodObject = lodc::LodObject<AnyModel>;

/// Reads a file. Models that this version does not know are left out, with a line in
/// [`left_out`](lodc::LodFile::left_out). [`open`](crate::open) gives a file with levels to take.
///
/// ```
/// let bytes = std::fs::read("../../fixtures/golden/v1/two_parts.lodc").expect("it is there");
/// let file = lodc::read(&bytes)?;
/// assert!(file.objects.iter().all(|object| object.simplified.collapses().records() > 0));
/// # Ok::<(), lodc::formats::FormatError>(())
/// ```
///
/// # Errors
/// If a checksum, count, offset or index is wrong, or the file needs a newer program.
pub fn read(bytes: &[u8]) -> Result<LodFile, FormatError> {
    lodc::read(bytes, &ModelKind::ALL.map(ModelKind::name))?.with_models(
        |simplified: &Arc<Simplified>, stored: StoredModel| {
            let kind = stored.name.parse().expect("only known kinds are read");
            AnyModel::load(kind, simplified, &stored.arrays).map_err(|e| e.to_string())
        },
    )
}

/// Returns the bytes of a file. Equal contents give equal bytes.
#[must_use]
pub fn write(file: &LodFile) -> Vec<u8> {
    lodc::write(file, store)
}

/// Returns how many bytes of a file a model needs in a layout: those that every model of the object
/// needs ([`lodc::geometry_bytes`]), and its own arrays.
#[must_use]
pub fn stored_bytes(model: &AnyModel, layout: Layout) -> u64 {
    lodc::geometry_bytes(model.simplified(), layout) + store(model, layout).bytes()
}

/// The name and the arrays of a model, as a file stores them.
fn store(model: &AnyModel, layout: Layout) -> StoredModel {
    StoredModel { name: model.name().to_owned(), arrays: model.arrays(layout) }
}
