//! The place of a graphics device where the feature `gpu` is off.

use crate::error::LabError;
use crate::prepared::Prepared;
use crate::report::GpuReport;
use crate::subject::Subject;
use lodc_mesh::Lod;

/// A graphics device that cannot be there.
#[derive(Debug)]
pub enum Device {}

/// There is no device.
pub(crate) fn measure(
    device: &Device,
    _: &Prepared,
    _: &mut [Subject<'_>],
    _: &[Lod],
    _: u32,
) -> Result<Option<GpuReport>, LabError> {
    match *device {}
}
