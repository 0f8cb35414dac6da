//! Encodes PNG images, without opacity if all pixels are opaque.

use lodc_scene::Image;

/// A picture as a PNG file. Equal pictures give equal bytes.
///
/// # Panics
/// If it has no pixel, or another number of bytes than its size says.
#[must_use]
pub fn png(picture: &Image) -> Vec<u8> {
    let opaque = picture.bytes.as_chunks::<4>().0.iter().all(|p| p[3] == 255);
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_color(if opaque { ::png::ColorType::Rgb } else { ::png::ColorType::Rgba });
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_source_srgb(::png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer =
        encoder.write_header().expect("a picture has pixels, and memory takes what is written");
    let data: Vec<u8> = if opaque {
        picture.bytes.as_chunks::<4>().0.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect()
    } else {
        picture.bytes.clone()
    };
    writer.write_image_data(&data).expect("the bytes fit the size");
    writer.finish().expect("memory takes what is written");
    bytes
}
