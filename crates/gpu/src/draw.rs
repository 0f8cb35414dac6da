//! Draws what kernels have written, as an engine does it: indexed indirect draws of flat-shaded
//! triangles or strips, for timing and for tests.

use crate::{GpuError, Session};
use lodc_plan::DrawInput;
use std::num::NonZeroU64;

/// Pixels across and down. Chosen by hand.
pub(crate) const SIZE: u32 = 512;
/// Bytes of `Scene` in `draw.wgsl`: a centre and a scale.
const SCENE_BYTES: u64 = 16;
const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A picture that is drawn over and over.
pub(crate) struct Canvas {
    drawn: DrawInput,
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    targets: Targets,
}

/// The textures that are drawn into.
pub(crate) struct Targets {
    #[cfg(test)]
    pub(crate) picture: wgpu::Texture,
    colour: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl Canvas {
    /// Prepares drawing, seen from one fixed side.
    ///
    /// # Errors
    /// If the device refuses.
    pub(crate) fn new(session: &Session, drawn: &DrawInput) -> Result<Self, GpuError> {
        let gpu = &session.device.device;
        let position = wgpu::VertexBufferLayout {
            array_stride: 4 * drawn.stride as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3],
        };
        let shader = include_str!("draw.wgsl");
        let pipeline = pipeline(gpu, shader, &[Some(position)], drawn.strips);
        let scene = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: SCENE_BYTES,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let (low, high) = drawn.bounds;
        let centre: [f32; 3] = std::array::from_fn(|i| f32::midpoint(low[i], high[i]));
        let radius = (0..3).map(|i| (high[i] - low[i]).powi(2)).sum::<f32>().sqrt() / 2.0;
        let words = [centre[0], centre[1], centre[2], 1.0 / radius.max(1e-20)];
        session.device.queue.write_buffer(&scene, 0, bytemuck::cast_slice(&words));
        let resource =
            wgpu::BufferBinding { buffer: &scene, offset: 0, size: NonZeroU64::new(SCENE_BYTES) };
        let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::Buffer(resource),
            }],
        });
        session.device.check()?;
        Ok(Self { drawn: *drawn, pipeline, group, targets: Targets::new(gpu) })
    }

    /// Draws into a fresh picture, between two time stamps if there is room for them: the set, and
    /// the first of the two.
    pub(crate) fn encode(
        &self,
        session: &Session,
        encoder: &mut wgpu::CommandEncoder,
        clock: Option<(&wgpu::QuerySet, u32)>,
    ) {
        let mut pass = self.targets.pass(encoder, clock);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        session.draw(&mut pass, &self.drawn);
    }
}

impl Targets {
    pub(crate) fn new(gpu: &wgpu::Device) -> Self {
        let target = |format, usage| {
            gpu.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let picture = target(COLOUR, wgpu::TextureUsages::COPY_SRC);
        let depth = view(&target(DEPTH, wgpu::TextureUsages::empty()));
        let colour = view(&picture);
        Self {
            #[cfg(test)]
            picture,
            colour,
            depth,
        }
    }

    /// A pass over a fresh picture, between two time stamps if there is room for them: the set, and
    /// the first of the two.
    pub(crate) fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        clock: Option<(&wgpu::QuerySet, u32)>,
    ) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.colour,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: clock.map(|(query_set, first)| wgpu::RenderPassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(first),
                end_of_pass_write_index: Some(first + 1),
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }
}

/// Makes a pipeline that draws triangles or strips with depth.
pub(crate) fn pipeline(
    gpu: &wgpu::Device,
    shader: &'static str,
    buffers: &[Option<wgpu::VertexBufferLayout<'_>>],
    strips: bool,
) -> wgpu::RenderPipeline {
    let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("draw"),
        source: wgpu::ShaderSource::Wgsl(shader.into()),
    });
    gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("draw"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: if strips {
                wgpu::PrimitiveTopology::TriangleStrip
            } else {
                wgpu::PrimitiveTopology::TriangleList
            },
            strip_index_format: strips.then_some(wgpu::IndexFormat::Uint32),
            ..wgpu::PrimitiveState::default()
        },
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
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(COLOUR.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
