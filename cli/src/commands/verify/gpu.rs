//! Replaying models on a graphics device.

use crate::exit::{Failure, Outcome};
use crate::gpu::{self, Device, GpuUse};
use lodc::LodFile;
use lodc_report::CheckReport;
use lodc_verify::Reference;

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
            let message = format!("--gpu needs a usable GPU: {failure}; nothing was verified");
            Err(Failure { message, ..failure })
        }
    }
}

/// The checks of one file. There is a reference for each object.
///
/// # Errors
/// If the device fails, or a limit is reached on a device that was required.
pub(super) fn checks(
    file: &LodFile,
    references: &[Reference<'_>],
    gpu: &Gpu,
    gpu_use: GpuUse,
) -> Outcome<Vec<CheckReport>> {
    match gpu {
        Gpu::Skipped(why) => Ok(vec![CheckReport {
            device: "gpu",
            skipped: Some(why.clone()),
            ..CheckReport::new(None, "all", "replay")
        }]),
        Gpu::Device(device) => on_device(file, references, device, gpu_use),
    }
}

#[cfg(not(feature = "gpu"))]
fn on_device(
    _: &LodFile,
    _: &[Reference<'_>],
    device: &Device,
    _: GpuUse,
) -> Outcome<Vec<CheckReport>> {
    match *device {}
}

#[cfg(feature = "gpu")]
fn on_device(
    file: &LodFile,
    references: &[Reference<'_>],
    device: &Device,
    gpu_use: GpuUse,
) -> Outcome<Vec<CheckReport>> {
    use crate::exit::Status;
    use lodc_gpu::Replays;
    use lodc_model::Model;
    use lodc_plan as plan;

    let adapter = Some(device.adapter().to_string());
    // Plans of all objects, in turn, share submissions.
    let mut replays = Replays::new(device);
    // In the order of plans; those that run have no verdict yet.
    let mut reports: Vec<(CheckReport, Option<&str>)> = Vec::new();
    for (object, reference) in file.objects.iter().zip(references) {
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
            let plans = match model.replays(&stops, reference) {
                Ok(plans) => plans,
                Err(e) => {
                    let failure = Failure::new(Status::Limit, e.to_string());
                    reports.push((skipped_or_failed(failure, "replay")?, None));
                    continue;
                }
            };
            for plan in plans {
                let check = plan.name;
                reports.push(match replays.add(plan) {
                    Ok(()) => (report(check), Some(model.name())),
                    Err(e) => (skipped_or_failed(gpu::failure(&e), check)?, None),
                });
            }
        }
    }
    let mut replayed = replays.finish().map_err(|e| gpu::failure(&e))?.into_iter();
    let judged = reports.into_iter().map(|(report, running)| {
        let Some(model) = running else { return report };
        let done = replayed.next().expect("a result for each plan that runs");
        let check = report.check;
        report.of(done.lods, done.difference.map(|d| format!("{model}, {check}: {d}")))
    });
    Ok(judged.collect())
}
