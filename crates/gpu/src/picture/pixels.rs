//! Reads finished pictures back from the device, and halves them in linear light.

use crate::{Device, GpuError};
use lodc_scene::{Image, to_linear, to_srgb};

/// Halves a picture of premultiplied colours, whose width and height are even, in linear light; the
/// result is not premultiplied any more.
pub(super) fn halved(width: u32, height: u32, rows: &[u8]) -> Image {
    let linear: [f32; 256] = std::array::from_fn(|i| to_linear(i as f32 / 255.0));
    let (w, h) = (width as usize / 2, height as usize / 2);
    let mut bytes = Vec::with_capacity(4 * w * h);
    for y in 0..h {
        for x in 0..w {
            let mut sum = [0.0f32; 4];
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let start = 4 * ((2 * y + dy) * width as usize + 2 * x + dx);
                let texel = &rows[start..start + 4];
                for c in 0..3 {
                    sum[c] += linear[usize::from(texel[c])];
                }
                sum[3] += f32::from(texel[3]) / 255.0;
            }
            let opacity = sum[3] / 4.0;
            for c in &sum[..3] {
                bytes.push(if opacity > 0.0 { to_srgb(c / 4.0 / opacity) } else { 0 });
            }
            bytes.push((opacity * 255.0 + 0.5) as u8);
        }
    }
    Image { width: w as u32, height: h as u32, bytes }
}

/// Reads a texture of four bytes a pixel, row by row from the top.
///
/// # Errors
/// If the device fails or is lost.
pub(crate) fn read_back(
    device: &Device,
    texture: &wgpu::Texture,
    [width, height]: [u32; 2],
) -> Result<Vec<u8>, GpuError> {
    let row = row_bytes(width);
    let bytes = u64::from(row) * u64::from(height);
    let buffer = device.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("pixels"),
        size: bytes,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder =
        device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
    device.queue.submit([encoder.finish()]);
    let mut tight = Vec::new();
    device.map(&buffer, bytes, |rows| {
        let rows = rows.chunks_exact(row as usize);
        tight = rows.flat_map(|r| &r[..4 * width as usize]).copied().collect();
    })?;
    Ok(tight)
}

/// Bytes from row to row in a buffer that a texture is copied to.
pub(super) fn row_bytes(width: u32) -> u32 {
    (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_mixes_light_and_keeps_the_colour_of_half_covered_pixels() {
        // Black and white in equal parts are brighter than the number between them.
        let grey = halved(2, 2, &[[0, 0, 0, 255], [255; 4], [255; 4], [0, 0, 0, 255]].concat());
        assert_eq!((grey.width, grey.height, grey.at(0, 0)), (1, 1, [188, 188, 188, 255]));
        let red = halved(2, 2, &[[255, 0, 0, 255], [0; 4], [0; 4], [0; 4]].concat());
        assert_eq!(red.at(0, 0), [255, 0, 0, 64]);
    }
}
