//! The parts that every engine has already: a device, buffers, one compute shader after the other.

use lodc_lod::ModelKind;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Threads of a workgroup of every shader, and words that a workgroup of `scan.wgsl` sums.
const WORKGROUP: usize = 256;
const BLOCK: usize = 1024;
/// Workgroups in one dimension: WebGPU's default limit.
const ROW: u32 = 65_535;

/// A graphics device with WebGPU's default limits.
pub(crate) struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
}

impl Gpu {
    /// Opens a device; none if there is none.
    pub(crate) fn open() -> Option<Self> {
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let options = wgpu::RequestAdapterOptions::default();
        let adapter = pollster::block_on(instance.request_adapter(&options)).ok()?;
        let device = adapter.request_device(&wgpu::DeviceDescriptor::default());
        let (device, queue) = pollster::block_on(device).ok()?;
        Some(Self { device, queue })
    }

    /// A buffer of these bytes: whole words, such as a section of the gpu layout.
    pub(crate) fn buffer(&self, contents: &[u8]) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::INDEX
            | wgpu::BufferUsages::VERTEX
            | wgpu::BufferUsages::INDIRECT
            | wgpu::BufferUsages::UNIFORM
            | wgpu::BufferUsages::COPY_SRC;
        // No binding is empty.
        let contents = if contents.is_empty() { &[0; 16] } else { contents };
        self.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
    }

    pub(crate) fn words(&self, words: &[u32]) -> wgpu::Buffer {
        self.buffer(bytemuck::cast_slice(words))
    }

    pub(crate) fn zeros(&self, count: usize) -> wgpu::Buffer {
        self.words(&vec![0; count])
    }

    /// Runs a shader of `lodc shaders` over a number of threads.
    pub(crate) fn run(
        &self,
        name: &str,
        constants: &[(&str, f64)],
        threads: usize,
        parameters: &[u32],
        buffers: &[&wgpu::Buffer],
    ) {
        let pipeline = self.pipeline(name, constants);
        let mut padded = parameters.to_vec();
        padded.resize(parameters.len().next_multiple_of(4), 0);
        let parameters = self.words(&padded);
        let bound = std::iter::once(&parameters).chain(buffers.iter().copied()).zip(0..);
        let entries: Vec<_> = bound
            .map(|(b, binding)| wgpu::BindGroupEntry { binding, resource: b.as_entire_binding() })
            .collect();
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder =
            self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        let groups = threads.div_ceil(WORKGROUP) as u32;
        let rows = groups.div_ceil(ROW).max(1);
        pass.dispatch_workgroups(groups.div_ceil(rows), rows, 1);
        drop(pass);
        self.queue.submit([encoder.finish()]);
    }

    /// An engine makes each pipeline once; a test makes it when it is needed.
    fn pipeline(&self, name: &str, constants: &[(&str, f64)]) -> wgpu::ComputePipeline {
        let shaders = ModelKind::Interactive.shaders();
        let text = shaders.iter().find(|s| s.name == name).expect("a shader's name").text();
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let compilation_options =
            wgpu::PipelineCompilationOptions { constants, ..Default::default() };
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options,
            cache: None,
        })
    }

    /// Turns the first `count` words into the sums of those before them.
    pub(crate) fn scan(&self, data: &wgpu::Buffer, count: usize) {
        let blocks = count.div_ceil(BLOCK);
        let sums = self.zeros(blocks.max(4));
        self.run("scan", &[], count.div_ceil(4), &[count as u32], &[data, &sums]);
        if blocks > 1 {
            self.scan(&sums, blocks);
            self.run("scan_add", &[], count, &[count as u32], &[data, &sums]);
        }
    }

    /// Reads a buffer back. Only tests do.
    pub(crate) fn read(&self, buffer: &wgpu::Buffer) -> Vec<u8> {
        let size = buffer.size();
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let descriptor =
            wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        let readable = self.device.create_buffer(&descriptor);
        let mut encoder =
            self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &readable, 0, size);
        self.queue.submit([encoder.finish()]);
        readable.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.device.poll(wgpu::PollType::wait_indefinitely()).expect("the device answers");
        readable.slice(..).get_mapped_range().expect("it is mapped").to_vec()
    }
}
