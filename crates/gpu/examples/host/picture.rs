//! One picture off screen: indexed indirect draws of what the shaders have made.

use crate::gpu::Gpu;
use crate::levels::{OnDevice, STRIDE};
use lodc_mesh::Mesh;
use lodc_scene::Image;

pub(crate) use lodc_formats::images::png;

/// Pixels across and down. Rows of 4 × 512 bytes are what a copy to a buffer allows.
const SIZE: u32 = 512;
/// Tangent of half the field of view.
const TANGENT: f32 = 0.4;
const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

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
        let middle: [f32; 3] = std::array::from_fn(|i| f32::midpoint(low[i], high[i]));
        let radius = (mesh.diagonal() / 2.0).max(1e-30) as f32;
        let distance = 1.1 * radius / TANGENT;
        let [x, y, z] = middle;
        Self { eye: [x, y, z + distance], near: distance - radius, far: distance + radius }
    }

    /// Error per distance that covers so many pixels.
    pub(crate) fn slope(&self, pixels: f32) -> f32 {
        pixels * 2.0 * TANGENT / SIZE as f32
    }

    /// From positions to clip space, column by column.
    fn matrix(&self) -> [f32; 16] {
        let ([x, y, z], s) = (self.eye, 1.0 / TANGENT);
        let deep = self.far / (self.far - self.near);
        let mut matrix = [0.0; 16];
        (matrix[0], matrix[5], matrix[10], matrix[11]) = (s, s, -deep, -1.0);
        matrix[12..].copy_from_slice(&[-s * x, -s * y, deep * (z - self.near), z]);
        matrix
    }
}

/// Pipeline and targets of every picture.
pub(crate) struct Picture {
    pipeline: wgpu::RenderPipeline,
    colour: wgpu::Texture,
    depth: wgpu::Texture,
}

impl Picture {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self { pipeline: pipeline(gpu), colour: target(gpu, COLOUR), depth: target(gpu, DEPTH) }
    }

    /// Draws all submeshes, black around them.
    pub(crate) fn draw(&self, gpu: &Gpu, camera: &Camera, drawn: &OnDevice) -> Image {
        let camera = gpu.buffer(bytemuck::cast_slice(&camera.matrix()));
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: camera.as_entire_binding() }],
        });
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.encode(&mut encoder, &group, drawn);
        let pixels = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(4 * SIZE * SIZE),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * SIZE),
            rows_per_image: None,
        };
        let to = wgpu::TexelCopyBufferInfo { buffer: &pixels, layout };
        encoder.copy_texture_to_buffer(self.colour.as_image_copy(), to, extent());
        gpu.queue.submit([encoder.finish()]);
        Image { width: SIZE, height: SIZE, bytes: gpu.read(&pixels) }
    }

    fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        group: &wgpu::BindGroup,
        drawn: &OnDevice,
    ) {
        let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        let (colour, depth) = (view(&self.colour), view(&self.depth));
        let clear = wgpu::LoadOp::Clear(wgpu::Color::BLACK);
        let mut render = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
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
        render.set_pipeline(&self.pipeline);
        render.set_bind_group(0, group, &[]);
        // [draw]
        render.set_vertex_buffer(0, drawn.vertices.slice(..));
        render.set_index_buffer(drawn.indices.slice(..), wgpu::IndexFormat::Uint32);
        for submesh in 0..drawn.submeshes {
            render.draw_indexed_indirect(&drawn.draws, 20 * u64::from(submesh));
        }
        // [/draw]
    }
}

fn extent() -> wgpu::Extent3d {
    wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 }
}

fn target(gpu: &Gpu, format: wgpu::TextureFormat) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
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

fn pipeline(gpu: &Gpu) -> wgpu::RenderPipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("draw"),
        source: wgpu::ShaderSource::Wgsl(include_str!("draw.wgsl").into()),
    });
    let position = wgpu::VertexAttribute {
        format: wgpu::VertexFormat::Float32x3,
        offset: 0,
        shader_location: 0,
    };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("draw"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 4 * u64::from(STRIDE),
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &[position],
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
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
            targets: &[Some(COLOUR.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
