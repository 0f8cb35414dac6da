//! Opens a graphics device by the name of its adapter, keeps its first error, and checks sizes
//! against its limits.

use crate::GpuError;
use crate::pipelines::Pipelines;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// The wait for an answer after which a device counts as lost. Chosen by hand: longer than the
/// slowest pass on a software adapter.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(120);

/// The description of an adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adapter {
    /// Its name.
    pub name: String,
    /// Driver and version, as the driver says.
    pub driver: String,
    /// The graphics API that it is reached through.
    pub backend: &'static str,
    /// True if it is software that runs on the processor.
    pub software: bool,
}

impl Adapter {
    fn of(info: &wgpu::AdapterInfo) -> Self {
        Self {
            name: info.name.clone(),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            backend: info.backend.to_str(),
            software: info.device_type == wgpu::DeviceType::Cpu,
        }
    }
}

impl std::fmt::Display for Adapter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({}, {})", self.name, self.backend, self.driver)
    }
}

/// Limits to ask for that are below an adapter's, to see on small meshes what happens to large
/// ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LimitOverrides {
    /// `max_storage_buffer_binding_size`.
    pub binding_bytes: Option<u64>,
    /// `max_compute_workgroups_per_dimension`.
    pub workgroups_per_dimension: Option<u32>,
}

/// An open device. Clones are handles of the same one.
#[derive(Clone)]
pub struct Device {
    adapter: Adapter,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// The first error since the last look.
    error: Arc<Mutex<Option<GpuError>>>,
    pub(crate) pipelines: Pipelines,
}

impl Device {
    /// Opens the adapter with `wanted` in its name (whatever the case), or else the most capable
    /// one. Which graphics APIs are looked at can be limited with the environment variable
    /// `WGPU_BACKEND` (`vulkan`, `metal`, `dx12`).
    ///
    /// # Errors
    /// If there is no such adapter, or it gives no device.
    pub fn open(wanted: Option<&str>) -> Result<Self, GpuError> {
        Self::open_with(wanted, &LimitOverrides::default())
    }

    /// As [`Self::open`], with limits below the adapter's.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_with(wanted: Option<&str>, overrides: &LimitOverrides) -> Result<Self, GpuError> {
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
        if adapters.is_empty() {
            let options = wgpu::RequestAdapterOptions::default();
            let why =
                pollster::block_on(instance.request_adapter(&options)).err().map(|e| e.to_string());
            return Err(GpuError::NoAdapter {
                why: why.unwrap_or_else(|| "none was found".to_owned()),
            });
        }
        // A stable sort: among equals the system's own order decides.
        adapters.sort_by_key(|a| rank(a.get_info().device_type));
        let names: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
        let adapter = match wanted {
            None => adapters.swap_remove(0),
            Some(part) => {
                let lower = part.to_lowercase();
                let found = names.iter().position(|name| name.to_lowercase().contains(&lower));
                let Some(found) = found else {
                    return Err(GpuError::NoMatch { wanted: part.to_owned(), available: names });
                };
                adapters.swap_remove(found)
            }
        };
        Self::of(&adapter, overrides)
    }

    /// The device that a host has already. Its errors stay the host's: wgpu's own handler hears of
    /// them.
    #[must_use]
    pub fn of_host(info: &wgpu::AdapterInfo, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self {
            adapter: Adapter::of(info),
            device,
            queue,
            error: Arc::default(),
            pipelines: Pipelines::default(),
        }
    }

    fn of(adapter: &wgpu::Adapter, overrides: &LimitOverrides) -> Result<Self, GpuError> {
        let described = Adapter::of(&adapter.get_info());
        // Without asking, WebGPU's small defaults apply.
        let mut required_limits = adapter.limits();
        let binding = &mut required_limits.max_storage_buffer_binding_size;
        *binding = overrides.binding_bytes.map_or(*binding, |bytes| bytes.min(*binding));
        let groups = &mut required_limits.max_compute_workgroups_per_dimension;
        *groups = overrides.workgroups_per_dimension.map_or(*groups, |most| most.min(*groups));
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("lodc"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits,
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| {
                GpuError::Refused { adapter: described.name.clone(), why: e.to_string() }
            })?;
        let error = Arc::new(Mutex::new(None));
        let slot = Arc::clone(&error);
        // Left alone, an error would panic. The first one is the cause; what follows are
        // consequences.
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| {
            let gpu_error = match e {
                wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory,
                wgpu::Error::Validation { description, .. }
                | wgpu::Error::Internal { description, .. } => {
                    // Explanations come on several lines.
                    GpuError::Invalid {
                        why: description.split_whitespace().collect::<Vec<_>>().join(" "),
                    }
                }
            };
            slot.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(gpu_error);
        }));
        Ok(Self { adapter: described, device, queue, error, pipelines: Pipelines::default() })
    }

    /// Returns the adapter.
    #[must_use]
    pub fn adapter(&self) -> &Adapter {
        &self.adapter
    }

    /// Returns whether the device can say how long passes take. Software can not, whatever it
    /// claims: Mesa's lavapipe takes the time stamps of a submission when it is over, all at once.
    #[must_use]
    pub fn has_clock(&self) -> bool {
        !self.adapter.software && self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Returns the bytes of the largest buffer that a shader may bind as a whole.
    #[must_use]
    pub fn largest_binding(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    /// Returns the device and the queue themselves.
    #[must_use]
    pub fn host(&self) -> (&wgpu::Device, &wgpu::Queue) {
        (&self.device, &self.queue)
    }

    /// Begins what is submitted next.
    #[must_use]
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Submits it, and does not wait.
    ///
    /// # Errors
    /// If the device has failed.
    pub fn submit(&self, encoder: wgpu::CommandEncoder) -> Result<(), GpuError> {
        self.queue.submit([encoder.finish()]);
        self.check()
    }

    /// Waits until everything submitted is done.
    pub(crate) fn wait(&self) -> Result<(), GpuError> {
        self.wait_for(None)
    }

    /// Waits until a submission is done; all of them if none is given.
    pub(crate) fn wait_for(
        &self,
        submission_index: Option<wgpu::SubmissionIndex>,
    ) -> Result<(), GpuError> {
        let poll = wgpu::PollType::Wait { submission_index, timeout: Some(ANSWER_TIMEOUT) };
        self.device.poll(poll).map_err(|e| GpuError::Lost { why: e.to_string() })?;
        self.check()
    }

    /// The first error since the last look.
    pub(crate) fn check(&self) -> Result<(), GpuError> {
        self.error.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }

    /// Checks that a shader may bind a buffer of `bytes` bytes as a whole.
    pub(crate) fn allows(&self, what: &str, bytes: u64) -> Result<(), GpuError> {
        let limits = self.device.limits();
        let allowed = [
            ("max_storage_buffer_binding_size", limits.max_storage_buffer_binding_size),
            ("max_buffer_size", limits.max_buffer_size),
        ];
        for (limit, allowed) in allowed {
            if bytes > allowed {
                return Err(GpuError::Limit {
                    what: format!("{what} (bytes)"),
                    limit,
                    needed: bytes,
                    allowed,
                });
            }
        }
        Ok(())
    }

    /// Checks that a buffer that no shader binds may have `needed` bytes.
    pub(crate) fn allows_buffer(&self, what: &str, needed: u64) -> Result<(), GpuError> {
        let allowed = self.device.limits().max_buffer_size;
        if needed <= allowed {
            return Ok(());
        }
        Err(GpuError::Limit { what: what.to_owned(), limit: "max_buffer_size", needed, allowed })
    }
}

/// Adapters are preferred by this number, the lowest first: the most capable kind.
fn rank(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Cpu => 3,
        wgpu::DeviceType::Other => 4,
    }
}
