//! Times runs of passes or draws: many are submitted at once, each between two time stamps of the
//! device, or by the host's clock.

use crate::draw::Canvas;
use crate::{Device, GpuError, Session};
use lodc_plan::Pass;
use std::time::Duration;

/// The host's clock, from any start.
pub(crate) type Now<'n> = &'n dyn Fn() -> Duration;

/// Runs that are submitted at once: submitting takes longer than a small run does. Chosen by hand.
const BATCH: usize = 256;

impl Session {
    /// Nanoseconds that the device worked on the passes of all runs, or, with a canvas, on drawing
    /// after each of them. By the host's clock if the device has none. Passes `before` runs are not
    /// timed; there are some for each run or for none.
    ///
    /// # Errors
    /// As [`Session::run`].
    pub(crate) fn timed(
        &mut self,
        before: &[Vec<Pass>],
        runs: &[Vec<Pass>],
        canvas: Option<&Canvas>,
        now: Now<'_>,
    ) -> Result<f64, GpuError> {
        let mut nanoseconds = 0.0;
        let mut leads = before.chunks(BATCH);
        for batch in runs.chunks(BATCH) {
            let before = leads.next().unwrap_or_default();
            nanoseconds += match (self.device.has_clock(), canvas) {
                (true, _) => self.timed_batch(before, batch, canvas)?,
                (false, None) if before.is_empty() => self.timed_by_host(batch, now)?,
                (false, None) => self.runs_timed_by_host(before, batch, now)?,
                (false, Some(canvas)) => self.draws_timed_by_host(batch, canvas, now)?,
            };
        }
        Ok(nanoseconds)
    }

    /// Runs with time stamps around each.
    fn timed_batch(
        &mut self,
        before: &[Vec<Pass>],
        runs: &[Vec<Pass>],
        canvas: Option<&Canvas>,
    ) -> Result<f64, GpuError> {
        let clock = Clock::new(&self.device, 2 * runs.len() as u32);
        let mut encoder = self.device.encoder();
        let leads = before.iter().map(Vec::as_slice).chain(std::iter::repeat(&[][..]));
        let all = || leads.clone().zip(runs);
        self.send_parameters(&mut encoder, all().flat_map(|(lead, run)| lead.iter().chain(run)));
        let mut slot = 0;
        for (first_stamp, (lead, passes)) in (0..).step_by(2).zip(all()) {
            self.dispatch(&mut encoder, lead, slot, None)?;
            slot += lead.len();
            let stamps = Some((&clock.queries, first_stamp));
            self.dispatch(&mut encoder, passes, slot, stamps.filter(|_| canvas.is_none()))?;
            slot += passes.len();
            if let Some(canvas) = canvas {
                canvas.encode(self, &mut encoder, stamps);
            }
        }
        clock.resolve(&mut encoder);
        self.device.queue.submit([encoder.finish()]);
        clock.read(&self.device)
    }

    /// All runs in one go, so that submitting counts once.
    fn timed_by_host(&mut self, runs: &[Vec<Pass>], now: Now<'_>) -> Result<f64, GpuError> {
        let mut encoder = self.device.encoder();
        self.send_parameters(&mut encoder, runs.iter().flatten());
        let mut slot = 0;
        for passes in runs {
            self.dispatch(&mut encoder, passes, slot, None)?;
            slot += passes.len();
        }
        self.device.submitted(encoder, now)
    }

    /// Every run by itself, after what leads to it: of large meshes, which take longer than
    /// submitting.
    fn runs_timed_by_host(
        &mut self,
        before: &[Vec<Pass>],
        runs: &[Vec<Pass>],
        now: Now<'_>,
    ) -> Result<f64, GpuError> {
        let mut nanoseconds = 0.0;
        for (lead, passes) in before.iter().zip(runs) {
            self.run(lead)?;
            let mut encoder = self.device.encoder();
            self.encode_passes(&mut encoder, passes)?;
            nanoseconds += self.device.submitted(encoder, now)?;
        }
        Ok(nanoseconds)
    }

    fn draws_timed_by_host(
        &mut self,
        runs: &[Vec<Pass>],
        canvas: &Canvas,
        now: Now<'_>,
    ) -> Result<f64, GpuError> {
        let mut nanoseconds = 0.0;
        for passes in runs {
            self.run(passes)?;
            let mut encoder = self.device.encoder();
            canvas.encode(self, &mut encoder, None);
            nanoseconds += self.device.submitted(encoder, now)?;
        }
        Ok(nanoseconds)
    }
}

impl Device {
    /// Submits commands. Returns the nanoseconds from submitting to being done.
    pub(crate) fn submitted(
        &self,
        encoder: wgpu::CommandEncoder,
        now: Now<'_>,
    ) -> Result<f64, GpuError> {
        let commands = encoder.finish();
        // Uploads are not what is timed.
        self.queue.submit([]);
        self.wait()?;
        let start = now();
        self.queue.submit([commands]);
        self.wait()?;
        Ok(now().saturating_sub(start).as_nanos() as f64)
    }
}

/// Time stamps of the device, in pairs: before and after something.
pub(crate) struct Clock {
    pub(crate) queries: wgpu::QuerySet,
    count: u32,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
}

impl Clock {
    pub(crate) fn new(device: &Device, count: u32) -> Self {
        let gpu = &device.device;
        let make = |usage| {
            let size = 8 * u64::from(count);
            gpu.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        Self {
            queries: gpu.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            count,
            resolved: make(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            readable: make(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
        }
    }

    /// Copies the time stamps to where they can be read, once all are taken.
    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..self.count, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(
            &self.resolved,
            0,
            &self.readable,
            0,
            8 * u64::from(self.count),
        );
    }

    /// Nanoseconds of all pairs together.
    pub(crate) fn read(&self, device: &Device) -> Result<f64, GpuError> {
        let mut sum = 0;
        device.map(&self.readable, 8 * u64::from(self.count), |bytes| {
            let ticks: &[[u64; 2]] = bytemuck::cast_slice(bytes);
            sum = ticks.iter().map(|[start, end]| end.saturating_sub(*start)).sum();
        })?;
        Ok(sum as f64 * f64::from(device.queue.get_timestamp_period()))
    }
}
