//! A program on a device: creates its buffers and pipelines, runs passes, and reads words back.

use crate::{Device, GpuError};
use lodc_plan::{BufferId, Contents, DrawInput, Kernel, KernelId, Pass, Program, WORKGROUP};
use std::sync::OnceLock;

/// Bytes between the parameters of two passes in the one uniform buffer: what every device accepts
/// as an offset.
const PARAMETER_SLOT: u64 = 256;
/// Bytes that are read back at once. Chosen by hand.
const STAGING_BYTES: u64 = 32 << 20;

/// A range of a buffer that is read back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WordRange {
    pub(crate) buffer: BufferId,
    /// The first word.
    pub(crate) first: usize,
    /// Number of words.
    pub(crate) count: usize,
}

/// A program on a device.
pub struct Session {
    pub(crate) device: Device,
    /// By buffer, for messages.
    names: Vec<&'static str>,
    pub(crate) buffers: Vec<wgpu::Buffer>,
    /// Number of words of each buffer.
    lengths: Vec<usize>,
    kernels: Vec<Kernel>,
    /// Made when they are first used.
    pipelines: Vec<OnceLock<wgpu::ComputePipeline>>,
    /// What is read back is copied here first.
    staging: wgpu::Buffer,
}

impl Session {
    /// Makes buffers.
    ///
    /// # Errors
    /// If a buffer is larger than the device allows, or memory runs out.
    pub fn new(device: &Device, program: &Program) -> Result<Self, GpuError> {
        for b in &program.buffers {
            device.allows(b.name, bytes_of(&b.contents))?;
        }
        let buffers: Vec<_> =
            program.buffers.iter().map(|b| upload(device, b.name, &b.contents)).collect();
        device.check()?;
        let largest = program.buffers.iter().map(|b| bytes_of(&b.contents)).max().unwrap_or(16);
        let staging = device.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("staging"),
            size: largest.min(STAGING_BYTES),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        device.check()?;
        Ok(Self {
            device: device.clone(),
            names: program.buffers.iter().map(|b| b.name).collect(),
            lengths: program.buffers.iter().map(|b| b.contents.len()).collect(),
            buffers,
            kernels: program.kernels.clone(),
            pipelines: program.kernels.iter().map(|_| OnceLock::new()).collect(),
            staging,
        })
    }

    /// Returns the same program once more: with its own copies of some buffers, all others shared.
    ///
    /// # Errors
    /// If memory runs out.
    pub fn sharing(&self, copied: &[BufferId]) -> Result<Self, GpuError> {
        let device = self.device.clone();
        let mut buffers = self.buffers.clone();
        let mut encoder = device.encoder();
        for &id in copied {
            let (from, size) = (&self.buffers[id.0], self.buffers[id.0].size());
            buffers[id.0] = empty(&device, self.names[id.0], size);
            encoder.copy_buffer_to_buffer(from, 0, &buffers[id.0], 0, size);
        }
        device.submit(encoder)?;
        Ok(Self {
            device,
            names: self.names.clone(),
            buffers,
            lengths: self.lengths.clone(),
            kernels: self.kernels.clone(),
            pipelines: self.pipelines.clone(),
            staging: self.staging.clone(),
        })
    }

    /// Adds passes to what is submitted next, one after the other.
    ///
    /// # Errors
    /// If a pass needs more than the device allows, or a kernel is not accepted.
    pub fn encode_passes(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: &[Pass],
    ) -> Result<(), GpuError> {
        self.encode(encoder, passes, None)
    }

    /// Draws what passes have made, with the pipeline that is set: vertex buffer 0, the index
    /// buffer, an indirect draw for each submesh.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, drawn: &DrawInput) {
        pass.set_vertex_buffer(0, self.buffers[drawn.vertices.0].slice(..));
        pass.set_index_buffer(self.buffers[drawn.indices.0].slice(..), wgpu::IndexFormat::Uint32);
        for draw in 0..drawn.count {
            pass.draw_indexed_indirect(&self.buffers[drawn.draws.0], 20 * draw as u64);
        }
    }

    /// The name of a buffer.
    #[must_use]
    pub fn name(&self, buffer: BufferId) -> &'static str {
        self.names[buffer.0]
    }

    /// Runs passes, one after the other, and waits for them.
    ///
    /// # Errors
    /// If a pass needs more than the device allows, a kernel is not accepted, or the device fails.
    pub fn run(&mut self, passes: &[Pass]) -> Result<(), GpuError> {
        self.submit(passes)?;
        self.device.wait()
    }

    fn submit(&mut self, passes: &[Pass]) -> Result<(), GpuError> {
        let mut encoder = self.device.encoder();
        self.encode(&mut encoder, passes, None)?;
        self.device.submit(encoder)
    }

    /// Adds passes to what is submitted next, between two time stamps if there is room for them:
    /// the set, and the first of the two.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: &[Pass],
        clock: Option<(&wgpu::QuerySet, u32)>,
    ) -> Result<(), GpuError> {
        let gpu = &self.device.device;
        let parameters = self.parameters(passes);
        let timestamp_writes = clock.map(|(query_set, first)| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        });
        let mut compute = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
        for (i, pass) in passes.iter().enumerate() {
            let Some((x, y)) = self.workgroups(pass)? else { continue };
            let pipeline = self.pipeline(pass.kernel)?;
            let uniform = wgpu::BufferBinding {
                buffer: &parameters,
                offset: PARAMETER_SLOT * i as u64,
                size: std::num::NonZeroU64::new(PARAMETER_SLOT),
            };
            let mut entries = vec![wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::Buffer(uniform),
            }];
            entries.extend(pass.buffers.iter().zip(1..).map(|(b, binding)| wgpu::BindGroupEntry {
                binding,
                resource: self.buffers[b.0].as_entire_binding(),
            }));
            let layout = pipeline.get_bind_group_layout(0);
            let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &layout,
                entries: &entries,
            });
            compute.set_pipeline(pipeline);
            compute.set_bind_group(0, &group, &[]);
            compute.dispatch_workgroups(x, y, 1);
        }
        Ok(())
    }

    fn pipeline(&self, kernel: KernelId) -> Result<&wgpu::ComputePipeline, GpuError> {
        let cell = &self.pipelines[kernel.0];
        if let Some(created) = cell.get() {
            return Ok(created);
        }
        let created = pipeline(&self.device, &self.kernels[kernel.0])?;
        Ok(cell.get_or_init(|| created))
    }

    /// The parameters of all passes, each in a slot of its own.
    fn parameters(&self, passes: &[Pass]) -> wgpu::Buffer {
        let mut words = vec![0u32; PARAMETER_SLOT as usize / 4 * passes.len().max(1)];
        for (slot, pass) in words.chunks_mut(PARAMETER_SLOT as usize / 4).zip(passes) {
            debug_assert!(
                pass.parameters.len() <= Pass::MAX_PARAMETERS,
                "a pass has too many parameters"
            );
            slot[..pass.parameters.len()].copy_from_slice(&pass.parameters);
        }
        let buffer = self.device.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("parameters"),
            size: 4 * words.len() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.device.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&words));
        buffer
    }

    /// Workgroups across and down, since one row has a limited number; none if there is nothing to
    /// do.
    fn workgroups(&self, pass: &Pass) -> Result<Option<(u32, u32)>, GpuError> {
        let groups = pass.threads.div_ceil(WORKGROUP);
        let max_groups = self.device.device.limits().max_compute_workgroups_per_dimension;
        let rows = groups.div_ceil(max_groups);
        if rows > max_groups {
            return Err(GpuError::Limit {
                what: "a pass (workgroups)".to_owned(),
                limit: "max_compute_workgroups_per_dimension",
                needed: u64::from(groups),
                allowed: u64::from(max_groups) * u64::from(max_groups),
            });
        }
        Ok((groups > 0).then(|| (groups.div_ceil(rows), rows)))
    }

    /// Writes words into a buffer.
    ///
    /// # Errors
    /// If the device fails.
    pub fn write(&mut self, buffer: BufferId, first: usize, words: &[u32]) -> Result<(), GpuError> {
        self.device.queue.write_buffer(
            &self.buffers[buffer.0],
            4 * first as u64,
            bytemuck::cast_slice(words),
        );
        self.device.check()
    }

    /// Reads a whole buffer back.
    ///
    /// # Errors
    /// If the device fails.
    pub fn read(&mut self, buffer: BufferId) -> Result<Vec<u32>, GpuError> {
        let mut words = Vec::with_capacity(self.lengths[buffer.0]);
        let whole = WordRange { buffer, first: 0, count: self.lengths[buffer.0] };
        self.read_ranges(&[whole], |_, _, part| {
            words.extend_from_slice(part);
            true
        })?;
        Ok(words)
    }

    /// The positions of the corners of all triangles that [`Self::draw`] draws, of triangle lists.
    ///
    /// # Errors
    /// If the device fails.
    pub fn drawn_triangles(&mut self, drawn: &DrawInput) -> Result<Vec<[[f32; 3]; 3]>, GpuError> {
        let [records, indices, draws] =
            [self.read(drawn.vertices)?, self.read(drawn.indices)?, self.read(drawn.draws)?];
        let corner = |&v: &u32| -> [f32; 3] {
            std::array::from_fn(|i| f32::from_bits(records[v as usize * drawn.stride + i]))
        };
        let indices_of_draw = |draw: &[u32; 5]| &indices[draw[2] as usize..][..draw[0] as usize];
        let corners = draws.as_chunks::<5>().0.iter().flat_map(indices_of_draw);
        let corners: Vec<[f32; 3]> = corners.map(corner).collect();
        Ok(corners.as_chunks::<3>().0.to_vec())
    }

    /// Reads ranges of buffers piece by piece, several at once where they fit. `see` gets the
    /// number of the range, the word in the range at which the piece starts, and the piece; if it
    /// returns false, reading ends.
    ///
    /// # Errors
    /// If the device fails.
    pub(crate) fn read_ranges(
        &mut self,
        ranges: &[WordRange],
        mut see: impl FnMut(usize, usize, &[u32]) -> bool,
    ) -> Result<(), GpuError> {
        let capacity = (self.staging.size() / 4) as usize;
        // The number of the range, the word in it at which the piece starts, and its words.
        let mut pieces: Vec<(usize, usize, usize)> = Vec::new();
        for (range, &WordRange { count, .. }) in ranges.iter().enumerate() {
            pieces.extend(
                (0..count)
                    .step_by(capacity)
                    .map(|start| (range, start, capacity.min(count - start))),
            );
        }
        let mut pending = pieces.as_slice();
        while !pending.is_empty() {
            let (mut used, mut batch) = (0, 0);
            let mut encoder = self.device.encoder();
            while batch < pending.len() && used + pending[batch].2 <= capacity {
                let (range, start, words) = pending[batch];
                let WordRange { buffer, first, .. } = ranges[range];
                let from = 4 * (first + start) as u64;
                let (from_buffer, size) = (&self.buffers[buffer.0], 4 * words as u64);
                encoder.copy_buffer_to_buffer(
                    from_buffer,
                    from,
                    &self.staging,
                    4 * used as u64,
                    size,
                );
                used += words;
                batch += 1;
            }
            self.device.queue.submit([encoder.finish()]);
            let mut continues = true;
            self.device.map(&self.staging, 4 * used as u64, |bytes| {
                let mut words: &[u32] = bytemuck::cast_slice(bytes);
                for &(range, start, len) in &pending[..batch] {
                    let (piece, further) = words.split_at(len);
                    words = further;
                    continues = continues && see(range, start, piece);
                }
            })?;
            if !continues {
                return Ok(());
            }
            pending = &pending[batch..];
        }
        Ok(())
    }
}

impl Device {
    /// Waits until everything submitted is done, then passes the first `bytes` bytes of a mappable
    /// buffer to `see`.
    pub(crate) fn map(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        see: impl FnOnce(&[u8]),
    ) -> Result<(), GpuError> {
        if bytes == 0 {
            return self.wait();
        }
        let slice = buffer.slice(..bytes);
        slice.map_async(wgpu::MapMode::Read, |_| {});
        self.wait()?;
        let view = slice.get_mapped_range().map_err(|e| GpuError::Lost { why: e.to_string() })?;
        see(&view);
        drop(view);
        buffer.unmap();
        self.check()
    }
}

/// Bytes of a buffer on the device: at least a vector of four words, the smallest that every kernel
/// can bind.
fn bytes_of(contents: &Contents) -> u64 {
    4 * contents.len().max(4) as u64
}

fn upload(device: &Device, name: &'static str, contents: &Contents) -> wgpu::Buffer {
    let words = match contents {
        Contents::Words(words) if !words.is_empty() => Some(words),
        _ => None,
    };
    let buffer = empty(device, name, bytes_of(contents));
    if let Some(words) = words {
        device.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(words));
    }
    buffer
}

fn empty(device: &Device, name: &'static str, size: u64) -> wgpu::Buffer {
    device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(name),
        size,
        usage: wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST
            | wgpu::BufferUsages::INDIRECT
            | wgpu::BufferUsages::INDEX
            | wgpu::BufferUsages::VERTEX,
        mapped_at_creation: false,
    })
}

fn pipeline(device: &Device, kernel: &Kernel) -> Result<wgpu::ComputePipeline, GpuError> {
    let allowed = device.device.limits().max_storage_buffers_per_shader_stage;
    let needed = kernel.wgsl.matches("var<storage").count() as u64;
    if needed > u64::from(allowed) {
        return Err(GpuError::Limit {
            what: format!("the kernel {} (storage buffers)", kernel.name),
            limit: "max_storage_buffers_per_shader_stage",
            needed,
            allowed: u64::from(allowed),
        });
    }
    let module = device.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(kernel.name),
        source: wgpu::ShaderSource::Wgsl(kernel.wgsl.as_str().into()),
    });
    let constants: Vec<(&str, f64)> =
        kernel.constants.iter().map(|&(name, value)| (name, f64::from(value))).collect();
    let pipeline = device.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(kernel.name),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &constants,
            ..wgpu::PipelineCompilationOptions::default()
        },
        cache: None,
    });
    device.check().map(|()| pipeline)
}
