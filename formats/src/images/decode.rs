//! Decodes PNG and JPEG images of untrusted files: their pixels are counted against a limit before
//! they are allocated.

use crate::{Fault, FormatError};
use lodc_scene::Image;
use std::io::Cursor;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Largest number of pixels of a side: what most graphics devices take. Chosen by hand.
const MAX_SIDE: usize = 1 << 14;
/// Largest number of pixels: 256 MiB when decoded. Chosen by hand.
const MAX_PIXELS: u64 = 1 << 26;

/// Decodes a PNG or JPEG, recognised by their first bytes. Colour profiles and orientation are
/// ignored, as glTF demands; values of 16 bits lose the lower half.
///
/// # Errors
/// If it is neither, damaged, or larger than 16384 pixels on a side or 64 million in all.
pub fn decode(bytes: &[u8]) -> Result<Image, FormatError> {
    decode_if(bytes, |_| Ok(()))
}

/// Decodes a PNG or JPEG as [`decode`] does, if `allowed` accepts its number of pixels.
///
/// # Errors
/// As [`decode`], and the error of `allowed`.
pub(crate) fn decode_if(
    bytes: &[u8],
    allowed: impl FnOnce(u64) -> Result<(), FormatError>,
) -> Result<Image, FormatError> {
    if bytes.starts_with(b"\x89PNG") {
        decode_png(bytes, allowed)
    } else if bytes.starts_with(b"\xff\xd8\xff") {
        decode_jpeg(bytes, allowed)
    } else {
        let other_kinds = [
            (&b"\xabKTX 2"[..], "a KTX2 texture"),
            (b"RIFF", "a WebP picture"),
            (b"DDS ", "a DDS texture"),
            (b"GIF8", "a GIF picture"),
            (b"BM", "a BMP picture"),
        ];
        let kind = other_kinds.iter().find(|(magic, _)| bytes.starts_with(magic));
        let kind = kind.map_or("of an unknown format", |(_, kind)| kind);
        let problem = format!("is {kind}; PNG and JPEG can be read");
        Err(FormatError::new(Fault::Unsupported, "", problem))
    }
}

fn check_size(
    width: usize,
    height: usize,
    allowed: impl FnOnce(u64) -> Result<(), FormatError>,
) -> Result<(), FormatError> {
    if width == 0 || height == 0 {
        return Err(FormatError::new(Fault::Malformed, "", "has no pixels"));
    }
    if width > MAX_SIDE || height > MAX_SIDE || (width as u64) * (height as u64) > MAX_PIXELS {
        let problem = format!(
            "has {width} x {height} pixels, more than {MAX_SIDE} on a side or {MAX_PIXELS} in all"
        );
        return Err(FormatError::new(Fault::Limit, "", problem));
    }
    allowed((width as u64) * (height as u64))
}

fn decode_png(
    bytes: &[u8],
    allowed: impl FnOnce(u64) -> Result<(), FormatError>,
) -> Result<Image, FormatError> {
    let damaged = |e: png::DecodingError| match e {
        png::DecodingError::LimitsExceeded => {
            FormatError::new(Fault::Limit, "", "takes too much memory")
        }
        e => FormatError::new(Fault::Malformed, "", format!("is a damaged PNG: {e}")),
    };
    // Room for one row and its neighbour, and for text and profiles, which are not used.
    let limits = png::Limits { bytes: 16 << 20 };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(damaged)?;
    let (width, height) = (reader.info().width, reader.info().height);
    check_size(width as usize, height as usize, allowed)?;
    let size = reader.output_buffer_size();
    let size = size.ok_or_else(|| FormatError::new(Fault::Limit, "", "takes too much memory"))?;
    let mut raw = vec![0; size];
    let info = reader.next_frame(&mut raw).map_err(damaged)?;
    raw.truncate(info.buffer_size());
    Ok(Image { width, height, bytes: expanded(raw, info.color_type.samples()) })
}

fn decode_jpeg(
    bytes: &[u8],
    allowed: impl FnOnce(u64) -> Result<(), FormatError>,
) -> Result<Image, FormatError> {
    let damaged = |e: zune_jpeg::errors::DecodeErrors| {
        FormatError::new(Fault::Malformed, "", format!("is a damaged JPEG: {e:?}"))
    };
    // The decoder's own limits would call a large picture damaged: `check_size` judges it.
    let options = DecoderOptions::default()
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX))
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(damaged)?;
    let (width, height) = decoder.dimensions().unwrap_or_default();
    check_size(width, height, allowed)?;
    let raw = decoder.decode().map_err(damaged)?;
    let samples = raw.len() / (width * height);
    Ok(Image { width: width as u32, height: height as u32, bytes: expanded(raw, samples) })
}

/// Grey, grey and opacity, or red, green and blue, as four bytes for each pixel.
fn expanded(raw: Vec<u8>, samples: usize) -> Vec<u8> {
    match samples {
        1 => raw.iter().flat_map(|&g| [g, g, g, 255]).collect(),
        2 => raw.as_chunks().0.iter().flat_map(|&[g, a]| [g, g, g, a]).collect(),
        3 => raw.as_chunks().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect(),
        _ => raw,
    }
}
