//! Helpers of tests on a device.

#![expect(clippy::print_stderr, reason = "a test that is left out says so aloud")]

use lodc_gpu::{Device, GpuError};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::Simplified;
use lodc_strip::{StripOptions, StripPool};
use lodc_verify::Reference;
use std::sync::Arc;

/// A device, or none said aloud. Where all tests are asked for there must be one.
pub(crate) fn device() -> Option<Device> {
    match Device::open(None) {
        Ok(device) => Some(device),
        Err(GpuError::NoAdapter { why }) if !lodc_fixtures::all_asked() => {
            eprintln!("SKIPPED: no graphics adapter: {why}");
            None
        }
        Err(e) => panic!("{e}"),
    }
}

/// What models of this version are compared with.
pub(crate) fn reference(simplified: &Simplified) -> Reference<'_> {
    Reference::new(simplified).expect("a small sequence")
}

/// Every model of this version.
pub(crate) fn models(simplified: Simplified) -> Vec<AnyModel> {
    let simplified = Arc::new(simplified);
    let mut strips = StripPool::new(&simplified, StripOptions::default());
    ModelKind::ALL
        .into_iter()
        .map(|kind| AnyModel::build(kind, &mut strips).expect("a valid sequence"))
        .collect()
}
