//! What pictures of one scene share on a device: pipelines, paints and their textures.

use super::mips;
use crate::{Device, GpuError};

/// What a triangle is painted with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paint {
    /// Linear colour and opacity.
    pub colour: [f32; 4],
    /// Index of its texture among those given to [`Painter::new`], multiplied with the colour.
    pub texture: Option<usize>,
    /// From the corners' texture coordinates to those of the texture: two rows of factors and a
    /// shift.
    pub uv: [[f32; 3]; 2],
    /// Whether triangles that turn their back are drawn.
    pub double_sided: bool,
    /// Opacity below which nothing is drawn.
    pub cut_off: Option<f32>,
    /// Whether what is behind shines through; otherwise opacity counts for the cut-off only.
    pub blended: bool,
    /// Whether light does not matter.
    pub unlit: bool,
}

impl Default for Paint {
    fn default() -> Self {
        Self {
            colour: [1.0; 4],
            texture: None,
            uv: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            double_sided: true,
            cut_off: None,
            blended: false,
            unlit: false,
        }
    }
}

/// How a texture goes on beyond its edges, and what is between texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampling {
    /// Beyond the edges across and down.
    pub wrap: [Wrap; 2],
    /// Whether texels stay visible as squares near by.
    pub nearest: bool,
}

/// How a texture goes on beyond an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// From the start again.
    #[default]
    Repeat,
    /// Backwards.
    Mirror,
    /// With its last texels.
    Clamp,
}

/// A picture that triangles are covered with.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Texels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// sRGB and opacity, four bytes for each texel, rows from the top.
    pub bytes: Vec<u8>,
    /// How it is read.
    pub sampling: Sampling,
}

/// Bytes of a paint in a buffer: four vectors of four.
const PAINT_BYTES: u64 = 64;

/// Draws pictures with the same paints.
pub struct Painter<'d> {
    pub(super) device: &'d Device,
    pub(super) shot_layout: wgpu::BindGroupLayout,
    /// For what hides all behind it, and for what does not.
    pub(super) pipelines: [wgpu::RenderPipeline; 2],
    pub(super) paints: Vec<wgpu::BindGroup>,
}

pub(super) const SAMPLES: u32 = 4;
pub(super) const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

impl<'d> Painter<'d> {
    /// Makes ready for drawing with these paints.
    ///
    /// # Errors
    /// If a texture is larger than the device allows, or the device fails.
    ///
    /// # Panics
    /// If a paint names a texture that is not there, or a texture has another number of bytes than
    /// its size says.
    pub fn new(
        device: &'d Device,
        textures: Vec<Texture>,
        paints: &[Paint],
    ) -> Result<Self, GpuError> {
        let gpu = &device.device;
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let shot_layout = layout(gpu, "shot", &[uniform]);
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let paint_layout = layout(gpu, "paint", &[uniform, texture, sampler]);
        let pipelines =
            [false, true].map(|blended| pipeline(gpu, &[&shot_layout, &paint_layout], blended));

        let blank =
            Texture { width: 1, height: 1, bytes: vec![255; 4], sampling: Sampling::default() };
        let mut views = Vec::with_capacity(textures.len() + 1);
        for texture in textures.into_iter().chain([blank]) {
            views.push(upload(device, texture)?);
        }
        let bind = |paint: &Paint| {
            let (view, sampler) = &views[paint.texture.unwrap_or(views.len() - 1)];
            bind(device, &paint_layout, paint, view, sampler)
        };
        let paints = paints.iter().map(bind).collect();
        device.check()?;
        Ok(Self { device, shot_layout, pipelines, paints })
    }
}

fn layout(gpu: &wgpu::Device, label: &str, entries: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(entries)
        .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty,
            count: None,
        })
        .collect();
    gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries,
    })
}

fn pipeline(
    gpu: &wgpu::Device,
    layouts: &[&wgpu::BindGroupLayout],
    blended: bool,
) -> wgpu::RenderPipeline {
    let module = gpu.create_shader_module(wgpu::include_wgsl!("picture.wgsl"));
    let layouts: Vec<_> = layouts.iter().map(|l| Some(*l)).collect();
    let layout = gpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("picture"),
        bind_group_layouts: &layouts,
        immediate_size: 0,
    });
    let corners = wgpu::VertexBufferLayout {
        array_stride: size_of::<super::Corner>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Float32x4],
    };
    gpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("picture"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(corners)],
        },
        // Back faces are left out by the shader, which knows their paint.
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(!blended),
            // Of equal depths the first wins, whatever draws them.
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: SAMPLES, ..wgpu::MultisampleState::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: COLOUR,
                blend: blended.then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn upload(
    device: &Device,
    texture: Texture,
) -> Result<(wgpu::TextureView, wgpu::Sampler), GpuError> {
    let Texture { width, height, bytes, sampling } = texture;
    device.allows_texture("a texture", width.max(height))?;
    let levels = mips::levels(width, height, bytes);
    let on_device = device.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("texture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: COLOUR,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (level, (width, height, bytes)) in (0..).zip(&levels) {
        device.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &on_device,
                mip_level: level,
                origin: wgpu::Origin3d::ZERO,
                aspect: wgpu::TextureAspect::All,
            },
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * width),
                rows_per_image: Some(*height),
            },
            wgpu::Extent3d { width: *width, height: *height, depth_or_array_layers: 1 },
        );
    }
    let [across, down] = sampling.wrap.map(|wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
        Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
    });
    let sampler = device.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("texture"),
        address_mode_u: across,
        address_mode_v: down,
        mag_filter: if sampling.nearest {
            wgpu::FilterMode::Nearest
        } else {
            wgpu::FilterMode::Linear
        },
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    });
    Ok((on_device.create_view(&wgpu::TextureViewDescriptor::default()), sampler))
}

fn bind(
    device: &Device,
    layout: &wgpu::BindGroupLayout,
    paint: &Paint,
    view: &wgpu::TextureView,
    sampler: &wgpu::Sampler,
) -> wgpu::BindGroup {
    let row = |r: [f32; 3]| [r[0], r[1], r[2], 0.0];
    let flag = |b: bool| f32::from(u8::from(b));
    let flags = [
        paint.cut_off.unwrap_or(-1.0),
        flag(paint.double_sided),
        flag(paint.unlit),
        flag(paint.blended),
    ];
    let buffer = device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("paint"),
        size: PAINT_BYTES,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    device.queue.write_buffer(
        &buffer,
        0,
        bytemuck::cast_slice(&[paint.colour, row(paint.uv[0]), row(paint.uv[1]), flags]),
    );
    device.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("paint"),
        layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(view) },
            wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(sampler) },
        ],
    })
}
