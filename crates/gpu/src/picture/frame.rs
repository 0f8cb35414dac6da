//! One picture while it is drawn: triangles are added material by material, then the finished
//! pixels are read back.

use super::painter::{COLOUR, DEPTH, Painter, SAMPLES};
use super::pixels::{halved, read_back, row_bytes};
use super::{BackFaces, Camera, Corner, Style};
use crate::GpuError;
use lodc_scene::{Image, to_linear};

/// Triangles that go to the device at once. Chosen by hand.
const TRIANGLES_PER_DRAW: usize = 1 << 20;

/// Pixels drawn for each one of the result, across and down.
const OVERSAMPLING: u32 = 2;

/// Linear colour of edges. Chosen by hand.
const WIRE: [f32; 3] = [0.01, 0.012, 0.02];
/// Linear colour of back faces where they are marked. Chosen by hand.
const MARKED_BACK_FACES: [f32; 3] = [0.9, 0.02, 0.45];

/// A picture that is being drawn.
pub struct Frame<'p> {
    painter: &'p Painter<'p>,
    size: [u32; 2],
    colour: wgpu::TextureView,
    depth: wgpu::TextureView,
    /// The picture with one sample for each pixel, once it is finished.
    resolved: wgpu::Texture,
    /// Camera and style.
    shot: wgpu::BindGroup,
    background: wgpu::Color,
    is_empty: bool,
}

impl<'p> Frame<'p> {
    /// A picture with nothing but its background.
    ///
    /// # Errors
    /// If it is larger than the device allows.
    ///
    /// # Panics
    /// If it has no pixel.
    pub fn new(painter: &'p Painter<'p>, camera: &Camera, style: &Style) -> Result<Self, GpuError> {
        let size = style.size.map(|s| s.saturating_mul(OVERSAMPLING));
        assert!(size.iter().all(|&s| s > 0), "a picture has pixels");
        painter.device.allows_texture("twice the picture's longer side", size[0].max(size[1]))?;
        painter.device.allows_buffer(
            "the picture (bytes)",
            u64::from(row_bytes(size[0])) * u64::from(size[1]),
        )?;
        let target = |label, format, samples, usage| {
            painter.device.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: extent(size),
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let colour = view(&target("colour", COLOUR, SAMPLES, drawn));
        let depth = view(&target("depth", DEPTH, SAMPLES, drawn));
        let resolved = target("picture", COLOUR, 1, drawn | wgpu::TextureUsages::COPY_SRC);
        let [r, g, b, a] = style.background;
        // Targets hold premultiplied colours.
        let light = |v: f32| f64::from(to_linear(v) * a);
        let background = wgpu::Color { r: light(r), g: light(g), b: light(b), a: f64::from(a) };
        let shot = shot(painter, camera, style);
        painter.device.check()?;
        Ok(Self { painter, size, colour, depth, resolved, shot, background, is_empty: true })
    }

    /// Draws triangles of a material over what is drawn already. Of surfaces at one depth the one
    /// drawn first stays; a `blended` one hides nothing that comes after it, so that those are
    /// drawn last and from far to near.
    ///
    /// # Errors
    /// If the device fails.
    ///
    /// # Panics
    /// If the painter has no such material.
    pub fn draw(
        &mut self,
        material: usize,
        blended: bool,
        corners: &[Corner],
    ) -> Result<(), GpuError> {
        for part in corners.chunks(3 * TRIANGLES_PER_DRAW) {
            let gpu = &self.painter.device.device;
            let bytes: &[u8] = bytemuck::cast_slice(part);
            let buffer = gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some("corners"),
                size: bytes.len() as u64,
                usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            self.painter.device.queue.write_buffer(&buffer, 0, bytes);
            self.pass(false, |pass, frame| {
                pass.set_pipeline(&frame.painter.pipelines[usize::from(blended)]);
                pass.set_bind_group(0, &frame.shot, &[]);
                pass.set_bind_group(1, &frame.painter.materials[material], &[]);
                pass.set_vertex_buffer(0, buffer.slice(..));
                pass.draw(0..part.len() as u32, 0..1);
            });
            if part.len() == 3 * TRIANGLES_PER_DRAW {
                // Large scenes wait, so that the device does not hold all of them at once.
                self.painter.device.wait()?;
            }
        }
        self.painter.device.check()
    }

    /// The finished picture.
    ///
    /// # Errors
    /// If the device fails or is lost.
    pub fn finish(mut self) -> Result<Image, GpuError> {
        self.pass(true, |_, _| ());
        let [width, height] = self.size;
        let pixels = read_back(self.painter.device, &self.resolved, self.size)?;
        Ok(halved(width, height, &pixels))
    }

    /// One pass over the targets; the last one leaves a picture with one sample for each pixel.
    fn pass(&mut self, last: bool, draw: impl FnOnce(&mut wgpu::RenderPass<'_>, &Self)) {
        let is_empty = std::mem::replace(&mut self.is_empty, false);
        let device = self.painter.device;
        let resolved = self.resolved.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder =
            device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let colour = wgpu::RenderPassColorAttachment {
            view: &self.colour,
            depth_slice: None,
            resolve_target: last.then_some(&resolved),
            ops: wgpu::Operations {
                load: if is_empty {
                    wgpu::LoadOp::Clear(self.background)
                } else {
                    wgpu::LoadOp::Load
                },
                store: wgpu::StoreOp::Store,
            },
        };
        let depth = wgpu::RenderPassDepthStencilAttachment {
            view: &self.depth,
            depth_ops: Some(wgpu::Operations {
                load: if is_empty { wgpu::LoadOp::Clear(1.0) } else { wgpu::LoadOp::Load },
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(colour)],
            depth_stencil_attachment: Some(depth),
            ..wgpu::RenderPassDescriptor::default()
        });
        draw(&mut pass, self);
        drop(pass);
        device.queue.submit([encoder.finish()]);
    }
}

fn extent([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers: 1 }
}

/// The uniform `Shot` of the shader: camera and style.
fn shot(painter: &Painter<'_>, camera: &Camera, style: &Style) -> wgpu::BindGroup {
    let with = |v: [f32; 3], w: f32| [v[0], v[1], v[2], w];
    let [right, up, toward] = camera.axes();
    let back = match style.back_faces {
        BackFaces::AsMaterial => 0.0,
        BackFaces::Shown => 1.0,
        BackFaces::Hidden => 2.0,
        BackFaces::Marked => 3.0,
    };
    let mut words: Vec<[f32; 4]> = camera.matrix().to_vec();
    words.extend([
        with(right, 0.0),
        with(up, 0.0),
        with(toward, f32::from(u8::from(camera.has_perspective()))),
        with(camera.eye(), 1.0),
        with(camera.world_up(), 0.0),
        with(WIRE, style.wire * OVERSAMPLING as f32),
        with(MARKED_BACK_FACES, back),
    ]);
    let bytes: &[u8] = bytemuck::cast_slice(&words);
    let buffer = painter.device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("shot"),
        size: bytes.len() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    painter.device.queue.write_buffer(&buffer, 0, bytes);
    painter.device.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("shot"),
        layout: &painter.shot_layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
    })
}
