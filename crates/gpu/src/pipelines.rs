//! Pipelines of kernels, made once for a device, however many programs have them.

use crate::GpuError;
use lodc_plan::Kernel;
use std::sync::{Arc, Mutex, PoisonError};

/// Bytes between the parameters of two passes in one uniform buffer: what every device accepts as
/// an offset.
pub(crate) const PARAMETER_SLOT: u64 = 256;

/// A pipeline, and what its passes bind.
#[derive(Clone)]
pub(crate) struct Pipeline {
    pub(crate) compute: wgpu::ComputePipeline,
    /// Binding 0 takes an offset: the slot of a pass's parameters.
    pub(crate) layout: wgpu::BindGroupLayout,
}

/// The pipelines of a device, by kernel: some tens. Clones are handles of the same ones.
#[derive(Clone, Default)]
pub(crate) struct Pipelines(Arc<Mutex<Vec<(Kernel, Pipeline)>>>);

impl Pipelines {
    /// The pipeline of a kernel, made when it is first asked for. `check` says whether the device
    /// took what was made.
    ///
    /// # Errors
    /// If the kernel is not accepted, or binds more than the device allows.
    pub(crate) fn get(
        &self,
        gpu: &wgpu::Device,
        kernel: &Kernel,
        check: impl FnOnce() -> Result<(), GpuError>,
    ) -> Result<Pipeline, GpuError> {
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, pipeline)) = known().iter().find(|(other, _)| other == kernel) {
            return Ok(pipeline.clone());
        }
        let made = Pipeline::new(gpu, kernel)?;
        check()?;
        known().push((kernel.clone(), made.clone()));
        Ok(made)
    }
}

impl Pipeline {
    fn new(gpu: &wgpu::Device, kernel: &Kernel) -> Result<Self, GpuError> {
        let allowed = gpu.limits().max_storage_buffers_per_shader_stage;
        let needed = kernel.wgsl.matches("var<storage").count() as u64;
        if needed > u64::from(allowed) {
            return Err(GpuError::Limit {
                what: format!("the kernel {} (storage buffers)", kernel.name),
                limit: "max_storage_buffers_per_shader_stage",
                needed,
                allowed: u64::from(allowed),
            });
        }
        let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(kernel.name),
            source: wgpu::ShaderSource::Wgsl(kernel.wgsl.as_str().into()),
        });
        let layout = gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(kernel.name),
            entries: &bindings(&kernel.wgsl),
        });
        let pipeline_layout = gpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(kernel.name),
            bind_group_layouts: &[Some(&layout)],
            ..wgpu::PipelineLayoutDescriptor::default()
        });
        let constants: Vec<(&str, f64)> =
            kernel.constants.iter().map(|&(name, value)| (name, f64::from(value))).collect();
        let compute = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(kernel.name),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                ..wgpu::PipelineCompilationOptions::default()
            },
            cache: None,
        });
        Ok(Self { compute, layout })
    }
}

/// What a kernel's text declares, in the form of all kernels: `@binding(0) var<uniform> …;`, then
/// `@binding(1) var<storage, read> …;` or `var<storage, read_write>`, and so on.
fn bindings(wgsl: &str) -> Vec<wgpu::BindGroupLayoutEntry> {
    let declared = wgsl.split("@binding(").skip(1).filter_map(|rest| {
        let (number, rest) = rest.split_once(')')?;
        let (declaration, _) = rest.split_once(';')?;
        let is_uniform = declaration.contains("var<uniform>");
        let read_only = !declaration.contains("read_write");
        let ty = if is_uniform {
            wgpu::BufferBindingType::Uniform
        } else {
            wgpu::BufferBindingType::Storage { read_only }
        };
        Some(wgpu::BindGroupLayoutEntry {
            binding: number.trim().parse().ok()?,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: is_uniform,
                min_binding_size: None,
            },
            count: None,
        })
    });
    declared.collect()
}
