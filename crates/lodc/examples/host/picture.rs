//! What every engine has already: a camera, a pipeline, something to draw into.

use lodc::formats::images::png;
use lodc::gpu::{CommandEncoder, Device, RenderPass, stride, wgpu};
use lodc::mesh::Mesh;
use lodc::scene::Image;
use std::error::Error;

/// Pixels across and down. Rows of 4 × 512 bytes are what a copy to a buffer allows.
const PICTURE_SIZE: u32 = 512;
/// Tangent of half the field of view, across and down.
const HALF_VIEW_TANGENT: f32 = 0.4;
const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// An eye that looks along −z at the whole object.
pub(crate) struct Camera {
    pub(crate) eye: [f32; 3],
    near: f32,
    far: f32,
}

impl Camera {
    pub(crate) fn around(mesh: &Mesh) -> Self {
        let bound = |pick: fn(f32, f32) -> f32, from: f32| -> [f32; 3] {
            let points = mesh.positions().iter();
            points.fold([from; 3], |b, p| std::array::from_fn(|i| pick(b[i], p[i])))
        };
        let (low, high) = (bound(f32::min, f32::MAX), bound(f32::max, f32::MIN));
        let centre: [f32; 3] = std::array::from_fn(|i| f32::midpoint(low[i], high[i]));
        let radius = (mesh.diagonal() / 2.0).max(1e-30) as f32;
        let distance = 1.1 * radius / HALF_VIEW_TANGENT;
        let [x, y, z] = centre;
        Self { eye: [x, y, z + distance], near: distance - radius, far: distance + radius }
    }

    /// Error per distance that covers `pixels` pixels.
    pub(crate) fn slope(&self, pixels: f32) -> f32 {
        pixels * 2.0 * HALF_VIEW_TANGENT / PICTURE_SIZE as f32
    }

    /// From positions to clip space, column by column.
    fn matrix(&self) -> [f32; 16] {
        let ([x, y, z], s) = (self.eye, 1.0 / HALF_VIEW_TANGENT);
        let depth_scale = self.far / (self.far - self.near);
        let mut matrix = [0.0; 16];
        (matrix[0], matrix[5], matrix[10], matrix[11]) = (s, s, -depth_scale, -1.0);
        matrix[12..].copy_from_slice(&[-s * x, -s * y, depth_scale * (z - self.near), z]);
        matrix
    }
}

/// A picture to draw into, and a pipeline for records of one length.
pub(crate) struct Picture {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    colour: wgpu::Texture,
    depth: wgpu::Texture,
}

impl Picture {
    pub(crate) fn new(device: &Device, mesh: &Mesh, camera: &Camera) -> Self {
        let (gpu, queue) = device.host();
        let pipeline = pipeline(gpu, stride(mesh));
        let matrix = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&matrix, 0, camera.matrix().map(f32::to_le_bytes).as_flattened());
        let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: matrix.as_entire_binding() }],
        });
        Self {
            pipeline,
            group,
            colour: target(gpu, COLOUR_FORMAT),
            depth: target(gpu, DEPTH_FORMAT),
        }
    }

    /// Begins to draw, black around everything.
    pub(crate) fn begin<'e>(&self, encoder: &'e mut CommandEncoder) -> RenderPass<'e> {
        let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        let (colour, depth) = (view(&self.colour), view(&self.depth));
        let clear = wgpu::LoadOp::Clear(wgpu::Color::BLACK);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &colour,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: clear, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass
    }

    /// Writes what was drawn as a PNG file; the number of pixels that are not black.
    pub(crate) fn write(&self, device: &Device, path: &str) -> Result<usize, Box<dyn Error>> {
        let (gpu, _) = device.host();
        let pixels = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(4 * PICTURE_SIZE * PICTURE_SIZE),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * PICTURE_SIZE),
            rows_per_image: None,
        };
        let mut encoder = device.encoder();
        let to = wgpu::TexelCopyBufferInfo { buffer: &pixels, layout };
        encoder.copy_texture_to_buffer(self.colour.as_image_copy(), to, extent());
        device.submit(encoder)?;
        pixels.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        gpu.poll(wgpu::PollType::wait_indefinitely())?;
        let bytes = pixels.slice(..).get_mapped_range()?.to_vec();
        let covered = bytes.chunks(4).filter(|pixel| pixel[..3] != [0; 3]).count();
        std::fs::write(path, png(&Image { width: PICTURE_SIZE, height: PICTURE_SIZE, bytes }))?;
        Ok(covered)
    }
}

fn extent() -> wgpu::Extent3d {
    wgpu::Extent3d { width: PICTURE_SIZE, height: PICTURE_SIZE, depth_or_array_layers: 1 }
}

fn target(gpu: &wgpu::Device, format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: extent(),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn pipeline(gpu: &wgpu::Device, stride: u64) -> wgpu::RenderPipeline {
    let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("draw"),
        source: wgpu::ShaderSource::Wgsl(include_str!("draw.wgsl").into()),
    });
    let position = wgpu::VertexAttribute {
        format: wgpu::VertexFormat::Float32x3,
        offset: 0,
        shader_location: 0,
    };
    gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("draw"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: stride,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &[position],
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(COLOUR_FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
