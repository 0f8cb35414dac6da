//! Replaying models on a graphics device.

use crate::exit::{Failure, Outcome};
use crate::gpu::{self, Device, GpuUse};
use lodc::LodFile;
use lodc_report::CheckReport;

/// The graphics device to replay models on, or why there is none.
pub(super) enum Gpu {
    Device(Box<Device>),
    Skipped(String),
}

/// Opens a device, if one was asked for.
///
/// # Errors
/// If one is required and none can be used.
pub(super) fn open(gpu_use: Option<GpuUse>, adapter: Option<&str>) -> Outcome<Option<Gpu>> {
    let Some(gpu_use) = gpu_use else { return Ok(None) };
    match gpu::open(adapter) {
        Ok(device) => Ok(Some(Gpu::Device(Box::new(device)))),
        Err(failure) if gpu_use == GpuUse::Auto => Ok(Some(Gpu::Skipped(failure.message))),
        Err(failure) => {
            let message = format!(
                "a GPU was required, and there is none to use: {failure}; nothing was verified"
            );
            Err(Failure { message, ..failure })
        }
    }
}

/// The checks of one file.
///
/// # Errors
/// If the device fails, or a limit is reached on a device that was required.
pub(super) fn checks(file: &LodFile, gpu: &Gpu, gpu_use: GpuUse) -> Outcome<Vec<CheckReport>> {
    match gpu {
        Gpu::Skipped(why) => Ok(vec![CheckReport {
            device: "gpu",
            skipped: Some(why.clone()),
            ..CheckReport::new(None, "all", "replay")
        }]),
        Gpu::Device(device) => on_device(file, device, gpu_use),
    }
}

#[cfg(not(feature = "gpu"))]
fn on_device(_: &LodFile, device: &Device, _: GpuUse) -> Outcome<Vec<CheckReport>> {
    match *device {}
}

#[cfg(feature = "gpu")]
fn on_device(file: &LodFile, device: &Device, gpu_use: GpuUse) -> Outcome<Vec<CheckReport>> {
    use crate::exit::Status;
    use lodc_gpu::replay;
    use lodc_model::Model;
    use lodc_plan as plan;

    let adapter = Some(device.adapter().to_string());
    let mut reports = Vec::new();
    for object in &file.objects {
        let name = &object.info.name;
        let stops = plan::stops(&object.simplified);
        for model in &object.models {
            let report = |check| CheckReport {
                device: "gpu",
                adapter: adapter.clone(),
                ..CheckReport::new(Some(name), model.name(), check)
            };
            // With --gpu=auto, a check that the device is too small for is reported as skipped.
            let skipped_or_failed = |failure: Failure, check| match gpu_use {
                GpuUse::Auto if failure.status == Status::Limit => {
                    Ok(CheckReport { skipped: Some(failure.message), ..report(check) })
                }
                _ => Err(Failure { message: format!("{name}: {failure}"), ..failure }),
            };
            let plans = match model.replays(&stops) {
                Ok(plans) => plans,
                Err(e) => {
                    reports.push(skipped_or_failed(
                        Failure::new(Status::Limit, e.to_string()),
                        "replay",
                    )?);
                    continue;
                }
            };
            for plan in plans {
                let check = plan.name;
                reports.push(match replay(device, plan) {
                    Ok(done) => {
                        let differs = |d| format!("{}, {check}: {d}", model.name());
                        report(check).of(done.lods, done.difference.map(differs))
                    }
                    Err(e) => skipped_or_failed(gpu::failure(&e), check)?,
                });
            }
        }
    }
    Ok(reports)
}
