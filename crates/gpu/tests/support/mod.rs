//! Helpers of tests on a device.

#![allow(dead_code, reason = "every test program uses a part of this")]

use lodc_gpu::{Device, GpuError};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::Simplified;
use lodc_strip::{StripOptions, StripPool};
use std::sync::Arc;

/// A device, or none said aloud. Where CI is set there must be one.
pub(crate) fn device() -> Option<Device> {
    match Device::open(None) {
        Ok(device) => Some(device),
        Err(GpuError::NoAdapter { why }) if std::env::var_os("CI").is_none() => {
            eprintln!("SKIPPED: no graphics adapter: {why}");
            None
        }
        Err(e) => panic!("{e}"),
    }
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
