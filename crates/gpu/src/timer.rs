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
    /// after each of them. By the host's clock if the device has none.
    ///
    /// # Errors
    /// As [`Session::run`].
    pub(crate) fn timed(
        &mut self,
        runs: &[Vec<Pass>],
        canvas: Option<&Canvas>,
        now: Now<'_>,
    ) -> Result<f64, GpuError> {
        let mut nanoseconds = 0.0;
        for batch in runs.chunks(BATCH) {
            nanoseconds += match (self.device.has_clock(), canvas) {
                (true, _) => self.timed_batch(batch, canvas)?,
                (false, None) => self.timed_by_host(batch, now)?,
                (false, Some(canvas)) => self.draws_timed_by_host(batch, canvas, now)?,
            };
        }
        Ok(nanoseconds)
    }

    /// Runs with time stamps around each.
    fn timed_batch(
        &mut self,
        runs: &[Vec<Pass>],
        canvas: Option<&Canvas>,
    ) -> Result<f64, GpuError> {
        let clock = Clock::new(&self.device, 2 * runs.len() as u32);
        let mut encoder =
            self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for (ticks, passes) in (0..).step_by(2).zip(runs) {
            match canvas {
                None => self.encode(&mut encoder, passes, Some((&clock.queries, ticks)))?,
                Some(canvas) => {
                    self.encode(&mut encoder, passes, None)?;
                    canvas.encode(self, &mut encoder, Some((&clock.queries, ticks)));
                }
            }
        }
        clock.resolve(&mut encoder);
        self.device.queue.submit([encoder.finish()]);
        clock.read(&self.device)
    }

    /// All runs in one go, so that submitting counts once.
    fn timed_by_host(&mut self, runs: &[Vec<Pass>], now: Now<'_>) -> Result<f64, GpuError> {
        let mut encoder =
            self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for passes in runs {
            self.encode(&mut encoder, passes, None)?;
        }
        self.device.submitted(encoder, now)
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
            let mut encoder = self
                .device
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
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
