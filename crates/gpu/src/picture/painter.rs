//! The resources that all pictures of one scene share on a device: pipelines, materials and their
//! textures.

use crate::{Device, GpuError};
use lodc_scene::{AlphaMode, Image, Material, Texture, Wrap};

/// Bytes of a material in a buffer: four vectors of four.
const MATERIAL_BYTES: u64 = 64;

/// Draws pictures with the same materials.
pub struct Painter<'d> {
    pub(super) device: &'d Device,
    pub(super) shot_layout: wgpu::BindGroupLayout,
    /// For opaque materials and for blended ones.
    pub(super) pipelines: [wgpu::RenderPipeline; 2],
    pub(super) materials: Vec<wgpu::BindGroup>,
}

/// Samples of a pixel while it is drawn: what every device can.
pub(super) const SAMPLES: u32 = 4;
pub(super) const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

impl<'d> Painter<'d> {
    /// Prepares drawing with some materials. Images that no material uses are left out.
    ///
    /// # Errors
    /// If an image is larger than the device allows, or the device fails.
    ///
    /// # Panics
    /// If a material names an image that is not there, or an image has another number of bytes than
    /// its size says.
    pub fn new(
        device: &'d Device,
        images: &[Image],
        materials: &[Material],
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
        let material_layout = layout(gpu, "material", &[uniform, texture, sampler]);
        let pipelines =
            [false, true].map(|blended| pipeline(gpu, &[&shot_layout, &material_layout], blended));

        let blank = upload(device, Image::filled(1, 1, [255; 4]))?;
        let used = |image| materials.iter().any(|m| m.texture.is_some_and(|t| t.image == image));
        let view = |(number, image): (usize, &Image)| {
            used(number).then(|| upload(device, image.clone())).transpose()
        };
        let views: Vec<Option<wgpu::TextureView>> =
            images.iter().enumerate().map(view).collect::<Result<_, _>>()?;
        let bind = |material: &Material| {
            let view = material.texture.map_or(&blank, |t| {
                views[t.image].as_ref().expect("an image that a material uses is uploaded")
            });
            bind(device, &material_layout, material, view)
        };
        let materials = materials.iter().map(bind).collect();
        device.check()?;
        Ok(Self { device, shot_layout, pipelines, materials })
    }
}

/// Makes the layout of a bind group, whose bindings are numbered in this order.
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

/// Makes the pipeline of opaque or of blended materials.
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
        attributes: &wgpu::vertex_attr_array![
            0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Float32x4
        ],
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
        // Back faces are left out by the shader, which knows their material.
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

fn upload(device: &Device, image: Image) -> Result<wgpu::TextureView, GpuError> {
    let (width, height) = (image.width, image.height);
    device.allows_texture("a texture", width.max(height))?;
    let levels = image.levels();
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
    for (level, Image { width, height, bytes }) in (0..).zip(&levels) {
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
    Ok(on_device.create_view(&wgpu::TextureViewDescriptor::default()))
}

fn sampler(device: &Device, texture: Option<Texture>) -> wgpu::Sampler {
    let nearest = texture.is_some_and(|t| t.nearest);
    let [across, down] = texture.map(|t| t.wrap).unwrap_or_default().map(|wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
        Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
    });
    device.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("texture"),
        address_mode_u: across,
        address_mode_v: down,
        mag_filter: if nearest { wgpu::FilterMode::Nearest } else { wgpu::FilterMode::Linear },
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    })
}

/// Uploads a material and binds it with its texture.
fn bind(
    device: &Device,
    layout: &wgpu::BindGroupLayout,
    material: &Material,
    view: &wgpu::TextureView,
) -> wgpu::BindGroup {
    let row = |r: [f32; 3]| [r[0], r[1], r[2], 0.0];
    let flag = |b: bool| f32::from(u8::from(b));
    let mask = match material.alpha {
        AlphaMode::Mask(cut_off) => cut_off,
        AlphaMode::Opaque | AlphaMode::Blend => -1.0,
    };
    let blended = material.alpha == AlphaMode::Blend;
    let flags = [mask, flag(material.double_sided), flag(material.unlit), flag(blended)];
    let [u, v] = material.texture.map_or(Texture::UNTRANSFORMED, |t| t.transform);
    let buffer = device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("material"),
        size: MATERIAL_BYTES,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let words = [material.colour, row(u), row(v), flags];
    device.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&words));
    let view = wgpu::BindingResource::TextureView(view);
    let sampler = sampler(device, material.texture);
    let sampler = wgpu::BindingResource::Sampler(&sampler);
    device.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("material"),
        layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: view },
            wgpu::BindGroupEntry { binding: 2, resource: sampler },
        ],
    })
}
