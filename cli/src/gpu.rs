//! Options of commands that use a GPU, and opening it; without the Cargo feature `gpu` that is an
//! error.

pub(crate) use lodc_lab::Device;

use crate::exit::{Failure, Status};
use crate::help::DEVICE;
use clap::{Args, ValueEnum};

/// Demand for a graphics device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum GpuUse {
    Auto,
    Require,
}

/// Options of commands that also work on a graphics device.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = DEVICE)]
pub(crate) struct GpuArgs {
    /// Also work on a graphics device; --gpu=auto: if there is one
    ///
    /// --gpu, or --gpu=require, ends with status 6 where none is usable.
    #[arg(
        long,
        value_name = "WHEN",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "require"
    )]
    pub(crate) gpu: Option<GpuUse>,
    /// Graphics device to use, by a part of its name
    #[arg(long, value_name = "NAME", requires = "gpu", hide_short_help = true)]
    pub(crate) adapter: Option<String>,
}

/// Opens the device with `adapter` in its name, or the most capable one.
///
/// # Errors
/// If there is none that can be used: status 6.
#[cfg(feature = "gpu")]
pub(crate) fn open(adapter: Option<&str>) -> Result<Device, Failure> {
    Device::open(adapter).map_err(|e| failure(&e))
}

/// There is none.
///
/// # Errors
/// Always: status 6.
#[cfg(not(feature = "gpu"))]
pub(crate) fn open(_: Option<&str>) -> Result<Device, Failure> {
    Err(Failure::new(Status::NoGpu, "this lodc was built without the feature gpu"))
}

/// A limit of the device is status 5, everything else that it does not do is 6.
#[cfg(feature = "gpu")]
pub(crate) fn failure(error: &lodc_gpu::GpuError) -> Failure {
    use lodc_gpu::GpuError;
    let status =
        if matches!(error, GpuError::Limit { .. }) { Status::Limit } else { Status::NoGpu };
    Failure::new(status, error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(not(feature = "gpu"))]
    #[test]
    fn without_the_feature_it_is_said_so_with_status_6() {
        let Err(refused) = open(None);
        assert!(
            refused.status == Status::NoGpu && refused.message.contains("without the feature gpu")
        );
    }

    #[cfg(feature = "gpu")]
    #[test]
    fn a_limit_of_the_device_is_status_5_and_has_its_name() {
        use lodc_gpu::GpuError;
        let limit = GpuError::Limit {
            what: "vertices (bytes)".to_owned(),
            limit: "max_storage_buffer_binding_size",
            needed: 2,
            allowed: 1,
        };
        let refused = failure(&limit);
        assert_eq!(refused.status, Status::Limit);
        assert!(refused.message.contains("max_storage_buffer_binding_size"), "{}", refused.message);
        assert_eq!(failure(&GpuError::OutOfMemory).status, Status::NoGpu);
    }
}
