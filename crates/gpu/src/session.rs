//! A program on a device: creates its buffers, runs passes, and reads words back.

use crate::pipelines::{PARAMETER_SLOT, Pipeline};
use crate::{Device, GpuError};
use lodc_plan::{BufferId, Contents, DrawInput, Kernel, KernelId, Pass, Program, WORKGROUP};
use std::sync::{Mutex, OnceLock, PoisonError};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Bytes that are read back at once. Chosen by hand.
pub(crate) const STAGING_BYTES: u64 = 32 << 20;

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
    pipelines: Vec<OnceLock<Pipeline>>,
    bound: Mutex<Bound>,
    /// What is read back is copied here first. Made when something is.
    staging: OnceLock<wgpu::Buffer>,
}

/// Parameters of passes on the device, and what passes bind together with them.
#[derive(Default)]
struct Bound {
    /// A slot for each pass that is encoded at once; none before the first.
    parameters: Option<wgpu::Buffer>,
    /// By kernel and buffers; a pass's slot is an offset into the parameters.
    groups: Vec<(KernelId, Vec<BufferId>, wgpu::BindGroup)>,
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
        Ok(Self {
            device: device.clone(),
            names: program.buffers.iter().map(|b| b.name).collect(),
            lengths: program.buffers.iter().map(|b| b.contents.len()).collect(),
            buffers,
            kernels: program.kernels.clone(),
            pipelines: program.kernels.iter().map(|_| OnceLock::new()).collect(),
            bound: Mutex::default(),
            staging: OnceLock::new(),
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
            bound: Mutex::default(),
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
        self.send_parameters(encoder, passes);
        self.dispatch(encoder, passes, 0, None)
    }

    /// Adds a write of words to the start of a buffer to what is submitted next: passes that were
    /// encoded before do not see it.
    pub fn encode_words(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffer: BufferId,
        words: &[u32],
    ) {
        if words.is_empty() {
            return;
        }
        let sent = self.device.device.create_buffer_init(&BufferInitDescriptor {
            label: Some("words that are sent"),
            contents: bytemuck::cast_slice(words),
            usage: wgpu::BufferUsages::COPY_SRC,
        });
        encoder.copy_buffer_to_buffer(&sent, 0, &self.buffers[buffer.0], 0, sent.size());
    }

    /// Fills a buffer with copies of another one.
    ///
    /// # Errors
    /// If the device fails.
    pub fn repeat(&mut self, from: BufferId, to: BufferId) -> Result<(), GpuError> {
        let size = 4 * self.lengths[from.0] as u64;
        let copies = self.lengths[to.0].checked_div(self.lengths[from.0]).unwrap_or(0) as u64;
        let mut encoder = self.device.encoder();
        let [from, to] = [from, to].map(|id| &self.buffers[id.0]);
        (0..copies).for_each(|i| encoder.copy_buffer_to_buffer(from, 0, to, i * size, size));
        self.device.submit(encoder)
    }

    /// Draws what passes have made, with the pipeline that is set: vertex buffer 0, the index
    /// buffer, an indirect draw for each submesh.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, drawn: &DrawInput) {
        pass.set_vertex_buffer(0, self.buffers[drawn.vertices.0].slice(..));
        pass.set_index_buffer(self.buffers[drawn.indices.0].slice(..), wgpu::IndexFormat::Uint32);
        for draw in drawn.first..drawn.first + drawn.count {
            // The arguments of a draw are five words.
            pass.draw_indexed_indirect(&self.buffers[drawn.draws.0], 4 * 5 * draw as u64);
        }
    }

    /// Draws one of the draws of an input, as [`Self::draw`] does.
    ///
    /// # Panics
    /// If there are fewer.
    pub fn draw_one(&self, pass: &mut wgpu::RenderPass<'_>, drawn: &DrawInput, number: usize) {
        assert!(number < drawn.count, "there are {} draws, not {number}", drawn.count);
        self.draw(pass, &DrawInput { first: drawn.first + number, count: 1, ..*drawn });
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
        self.encode_passes(&mut encoder, passes)?;
        self.device.submit(encoder)
    }

    /// Adds passes to what is submitted next, whose parameters [`Self::send_parameters`] has sent:
    /// the first one's are in slot `slot`. Between two time stamps if there is room for them: the
    /// set, and the first of the two.
    pub(crate) fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: &[Pass],
        slot: usize,
        clock: Option<(&wgpu::QuerySet, u32)>,
    ) -> Result<(), GpuError> {
        if passes.is_empty() && clock.is_none() {
            return Ok(());
        }
        let timestamp_writes = clock.map(|(query_set, first)| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        });
        let mut compute = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
        for (pass, slot) in passes.iter().zip(slot..) {
            self.dispatch_one(&mut compute, pass, slot)?;
        }
        Ok(())
    }

    /// One pass of [`Self::dispatch`].
    pub(crate) fn dispatch_one(
        &self,
        compute: &mut wgpu::ComputePass<'_>,
        pass: &Pass,
        slot: usize,
    ) -> Result<(), GpuError> {
        let Some((x, y)) = self.workgroups(pass)? else { return Ok(()) };
        let pipeline = self.pipeline(pass.kernel)?;
        let mut bound = self.bound.lock().unwrap_or_else(PoisonError::into_inner);
        let known =
            bound.groups.iter().position(|(k, b, _)| *k == pass.kernel && *b == pass.buffers);
        let group = known.unwrap_or_else(|| {
            let parameters = bound.parameters.as_ref().expect("parameters are sent before passes");
            let group = self.group(pipeline, parameters, &pass.buffers);
            bound.groups.push((pass.kernel, pass.buffers.clone(), group));
            bound.groups.len() - 1
        });
        compute.set_pipeline(&pipeline.compute);
        compute.set_bind_group(0, &bound.groups[group].2, &[(PARAMETER_SLOT * slot as u64) as u32]);
        compute.dispatch_workgroups(x, y, 1);
        Ok(())
    }

    fn group(
        &self,
        pipeline: &Pipeline,
        parameters: &wgpu::Buffer,
        buffers: &[BufferId],
    ) -> wgpu::BindGroup {
        let uniform = wgpu::BufferBinding {
            buffer: parameters,
            offset: 0,
            size: std::num::NonZeroU64::new(PARAMETER_SLOT),
        };
        let uniform = wgpu::BindingResource::Buffer(uniform);
        let words = buffers.iter().map(|b| self.buffers[b.0].as_entire_binding());
        let resources = std::iter::once(uniform).chain(words).zip(0..);
        let entries: Vec<_> = resources
            .map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        self.device.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.layout,
            entries: &entries,
        })
    }

    fn pipeline(&self, kernel: KernelId) -> Result<&Pipeline, GpuError> {
        let cell = &self.pipelines[kernel.0];
        if let Some(created) = cell.get() {
            return Ok(created);
        }
        let Device { pipelines, device, .. } = &self.device;
        let created = pipelines.get(device, &self.kernels[kernel.0], || self.device.check())?;
        Ok(cell.get_or_init(|| created))
    }

    /// Sends the parameters of passes to the slots from 0 on, by a copy in what is submitted next:
    /// what was encoded before keeps its own.
    pub(crate) fn send_parameters<'p>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: impl IntoIterator<Item = &'p Pass>,
    ) {
        let mut words: Vec<u32> = Vec::new();
        for pass in passes {
            debug_assert!(
                pass.parameters.len() <= Pass::MAX_PARAMETERS,
                "a pass has too many parameters"
            );
            let next = words.len() + PARAMETER_SLOT as usize / 4;
            words.extend_from_slice(&pass.parameters);
            words.resize(next, 0);
        }
        if words.is_empty() {
            return;
        }
        let gpu = &self.device.device;
        let sent = gpu.create_buffer_init(&BufferInitDescriptor {
            label: Some("parameters that are sent"),
            contents: bytemuck::cast_slice(&words),
            usage: wgpu::BufferUsages::COPY_SRC,
        });
        let mut bound = self.bound.lock().unwrap_or_else(PoisonError::into_inner);
        if bound.parameters.as_ref().is_none_or(|there| there.size() < sent.size()) {
            bound.groups.clear();
            bound.parameters = Some(gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some("parameters"),
                size: sent.size().next_power_of_two(),
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }));
        }
        let parameters = bound.parameters.as_ref().expect("just made");
        encoder.copy_buffer_to_buffer(&sent, 0, parameters, 0, sent.size());
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
        let corner = |v: u32| -> [f32; 3] {
            std::array::from_fn(|i| f32::from_bits(records[v as usize * drawn.stride + i]))
        };
        let corners_of_draw = |&[count, _, first, base, _]: &[u32; 5]| {
            indices[first as usize..][..count as usize].iter().map(move |v| corner(base + v))
        };
        let draws = draws.as_chunks::<5>().0;
        let corners: Vec<[f32; 3]> =
            draws[drawn.first..][..drawn.count].iter().flat_map(corners_of_draw).collect();
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
        let largest = self.buffers.iter().map(wgpu::Buffer::size).max().unwrap_or(16);
        let staging = self.staging.get_or_init(|| self.device.staging(largest.min(STAGING_BYTES)));
        let capacity = (staging.size() / 4) as usize;
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
                let (range, start, count) = pending[batch];
                let WordRange { buffer, first, .. } = ranges[range];
                self.copy(
                    &mut encoder,
                    WordRange { buffer, first: first + start, count },
                    staging,
                    used,
                );
                used += count;
                batch += 1;
            }
            self.device.queue.submit([encoder.finish()]);
            let mut continues = true;
            self.device.map(staging, 4 * used as u64, |bytes| {
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

impl Session {
    /// Copies a range to the word `to` of a buffer that can be read, in what is submitted next.
    pub(crate) fn copy(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        WordRange { buffer, first, count }: WordRange,
        readable: &wgpu::Buffer,
        to: usize,
    ) {
        let [from, to, size] = [first, to, count].map(|words| 4 * words as u64);
        encoder.copy_buffer_to_buffer(&self.buffers[buffer.0], from, readable, to, size);
    }
}

impl Device {
    /// A buffer that what is read back is copied to.
    pub(crate) fn staging(&self, size: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("staging"),
            size,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// Waits until everything submitted is done, then passes the first `bytes` bytes of a mappable
    /// buffer to `see`.
    pub(crate) fn map(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        see: impl FnOnce(&[u8]),
    ) -> Result<(), GpuError> {
        self.map_when(None, buffer, bytes, see)
    }

    /// Does the same once one submission is done; all of them if none is given.
    pub(crate) fn map_when(
        &self,
        submission: Option<wgpu::SubmissionIndex>,
        buffer: &wgpu::Buffer,
        bytes: u64,
        see: impl FnOnce(&[u8]),
    ) -> Result<(), GpuError> {
        if bytes == 0 {
            return self.wait_for(submission);
        }
        let slice = buffer.slice(..bytes);
        slice.map_async(wgpu::MapMode::Read, |_| {});
        self.wait_for(submission)?;
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
