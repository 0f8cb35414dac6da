//! Times frames in which many instances of a few meshes are drawn, instances with the same
//! triangles by one draw.

use crate::draw::{Targets, pipeline};
use crate::timer::{Clock, Now};
use crate::{Device, GpuError};
use std::ops::Range;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Where an instance is: its mesh rotated about the second axis, then moved.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Instance {
    /// The origin of the mesh, relative to the camera's centre.
    pub origin: [f32; 3],
    /// Cosine and sine of the rotation about the second axis.
    pub rotation: [f32; 2],
}

/// One draw: some instances of some triangles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InstancedDraw {
    /// The mesh whose vertices the indices mean.
    pub mesh: usize,
    /// Indices of the frame.
    pub indices: Range<u32>,
    /// Instances of the frame.
    pub instances: Range<u32>,
}

/// Everything that is sent and drawn for one frame.
#[derive(Clone, Debug, Default)]
pub struct InstancedFrame {
    /// The indices of all draws, three for a triangle.
    pub indices: Vec<u32>,
    /// True if indices are those of strips instead, `u32::MAX` after each.
    pub strips: bool,
    /// The instances of all draws.
    pub instances: Vec<Instance>,
    /// In the order in which they are drawn.
    pub draws: Vec<InstancedDraw>,
}

/// Meshes on a device, with a camera.
pub struct Instanced<'d> {
    device: &'d Device,
    /// For triangles and for strips, each with the camera.
    pipelines: [(wgpu::RenderPipeline, wgpu::BindGroup); 2],
    targets: Targets,
    meshes: Vec<wgpu::Buffer>,
}

impl<'d> Instanced<'d> {
    /// Sends the positions of meshes. `matrix` leads from positions to clip space, column by
    /// column.
    ///
    /// # Errors
    /// If one is larger than the device allows, or the device fails.
    pub fn new(
        device: &'d Device,
        meshes: &[Vec<[f32; 3]>],
        matrix: [[f32; 4]; 4],
    ) -> Result<Self, GpuError> {
        let gpu = &device.device;
        let layout = |step_mode, attributes, array_stride| {
            Some(wgpu::VertexBufferLayout { array_stride, step_mode, attributes })
        };
        let position = &wgpu::vertex_attr_array![0 => Float32x3];
        let instance = &wgpu::vertex_attr_array![1 => Float32x3, 2 => Float32x2];
        let buffers = [
            layout(wgpu::VertexStepMode::Vertex, position, 12),
            layout(wgpu::VertexStepMode::Instance, instance, size_of::<Instance>() as u64),
        ];
        let uniform = buffer(device, wgpu::BufferUsages::UNIFORM, bytemuck::cast_slice(&matrix))?;
        let pipelines = [false, true].map(|strips| {
            let pipeline = pipeline(gpu, include_str!("instanced.wgsl"), &buffers, strips);
            let resource = uniform.as_entire_binding();
            let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("camera"),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry { binding: 0, resource }],
            });
            (pipeline, group)
        });
        let vertices = |positions: &Vec<[f32; 3]>| {
            buffer(device, wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(positions))
        };
        let meshes = meshes.iter().map(vertices).collect::<Result<_, _>>()?;
        device.check()?;
        Ok(Self { device, pipelines, targets: Targets::new(gpu), meshes })
    }

    /// Nanoseconds that the device takes to draw a frame, by its own clock or, if it has none, by
    /// the host's `now` from submitting to being done. Sending the frame is no part of it.
    ///
    /// # Errors
    /// If the frame is larger than the device allows, or the device fails.
    pub fn timed(&self, frame: &InstancedFrame, now: Now<'_>) -> Result<f64, GpuError> {
        let device = self.device;
        let indices = bytemuck::cast_slice(&frame.indices);
        let indices = buffer(device, wgpu::BufferUsages::INDEX, indices)?;
        let instances = bytemuck::cast_slice(&frame.instances);
        let instances = buffer(device, wgpu::BufferUsages::VERTEX, instances)?;
        let clock = device.has_clock().then(|| Clock::new(device, 2));
        let mut encoder =
            device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass =
            self.targets.pass(&mut encoder, clock.as_ref().map(|clock| (&clock.queries, 0)));
        let (pipeline, group) = &self.pipelines[usize::from(frame.strips)];
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.set_vertex_buffer(1, instances.slice(..));
        for draw in &frame.draws {
            pass.set_vertex_buffer(0, self.meshes[draw.mesh].slice(..));
            pass.draw_indexed(draw.indices.clone(), 0, draw.instances.clone());
        }
        drop(pass);
        match clock {
            None => device.submitted(encoder, now),
            Some(clock) => {
                clock.resolve(&mut encoder);
                device.queue.submit([encoder.finish()]);
                clock.read(device)
            }
        }
    }

    /// Nanoseconds from submitting an upload of `bytes` bytes to its end, by the host's clock.
    ///
    /// # Errors
    /// If the device fails, or allows no such buffer.
    pub fn upload(&self, bytes: u64, now: Now<'_>) -> Result<f64, GpuError> {
        let zeros = vec![0; bytes.next_multiple_of(4) as usize];
        let sent = buffer(self.device, wgpu::BufferUsages::COPY_DST, &zeros)?;
        self.device.queue.submit([]);
        self.device.wait()?;
        let start = now();
        self.device.queue.write_buffer(&sent, 0, &zeros);
        self.device.queue.submit([]);
        self.device.wait()?;
        Ok(now().saturating_sub(start).as_nanos() as f64)
    }
}

/// Makes a buffer with these bytes; of 64 zeros if there are none, since no buffer may be empty.
fn buffer(
    device: &Device,
    usage: wgpu::BufferUsages,
    bytes: &[u8],
) -> Result<wgpu::Buffer, GpuError> {
    device.allows_buffer("a buffer of a crowd (bytes)", bytes.len() as u64)?;
    let contents = if bytes.is_empty() { &[0; 64] } else { bytes };
    let created =
        device.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage });
    device.check().map(|()| created)
}

#[cfg(test)]
#[path = "instanced_tests.rs"]
mod tests;
