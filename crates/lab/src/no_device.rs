//! Stands in for the GPU measurements (`device.rs`) where the feature `gpu` is off.

use crate::error::LabError;
use crate::primitives::Primitive;
use crate::report::GpuReport;
use crate::structures::Measured;
use lodc::LodObject;
use lodc_mesh::Lod;

/// A graphics device that cannot be there.
#[derive(Debug)]
pub enum Device {}

/// There is no device.
#[must_use]
pub fn most_triangles(device: &Device) -> u64 {
    match *device {}
}

/// There is no device.
pub(crate) fn measure(
    device: &Device,
    _: &LodObject,
    _: [Vec<Primitive>; 2],
    _: &mut [Measured<'_>],
    _: &[Lod],
    _: u32,
) -> Result<Option<GpuReport>, LabError> {
    match *device {}
}
