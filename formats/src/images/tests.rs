use super::*;
use crate::Fault;
use lodc_scene::Image;

/// A picture in which every pixel is different.
fn coloured(width: u32, height: u32, opaque: bool) -> Image {
    let pixel = |i: u32| {
        [(i * 7) as u8, (i * 31) as u8, (i * 101) as u8, if opaque { 255 } else { (i * 3) as u8 }]
    };
    Image { width, height, bytes: (0..width * height).flat_map(pixel).collect() }
}

#[test]
fn a_png_comes_back_as_it_was() {
    for opaque in [true, false] {
        for (w, h) in [(1, 1), (5, 3), (64, 2)] {
            let picture = coloured(w, h, opaque);
            assert_eq!(decode(&png(&picture)), Ok(picture));
        }
    }
}

#[test]
fn every_kind_of_png_is_read() {
    for (colour, depth, data, wanted) in [
        (
            ::png::ColorType::Grayscale,
            ::png::BitDepth::One,
            vec![0b1000_0000],
            [[255, 255, 255, 255], [0, 0, 0, 255]],
        ),
        (
            ::png::ColorType::GrayscaleAlpha,
            ::png::BitDepth::Eight,
            vec![9, 8, 7, 6],
            [[9, 9, 9, 8], [7, 7, 7, 6]],
        ),
        (
            ::png::ColorType::Rgb,
            ::png::BitDepth::Sixteen,
            vec![1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0],
            [[1, 2, 3, 255], [4, 5, 6, 255]],
        ),
    ] {
        let mut bytes = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        encoder.write_header().and_then(|mut w| w.write_image_data(&data)).expect("a PNG");
        assert_eq!(decode(&bytes).map(|p| p.bytes), Ok(wanted.concat()), "{colour:?}");
    }
}

#[test]
fn damage_and_other_kinds_are_refused_and_nothing_panics() {
    let whole = png(&coloured(20, 20, false));
    for cut in 0..whole.len() {
        // Pixels may be complete before the file is.
        assert!(decode(&whole[..cut]).is_err() || cut > whole.len() / 2, "cut at {cut}");
    }
    for i in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[i] ^= 0x55;
        let _ = decode(&bytes);
    }
    for (bytes, word) in
        [(&b"\xabKTX 20"[..], "KTX2"), (b"RIFFxxxxWEBP", "WebP"), (b"", "an unknown format")]
    {
        let error = decode(bytes).expect_err("no picture");
        assert!(error.fault == Fault::Unsupported && error.problem.contains(word), "{error}");
    }
    assert_eq!(decode(b"\xff\xd8\xff\xe0").map_err(|e| e.fault), Err(Fault::Malformed));
}

#[test]
fn a_picture_of_huge_size_is_refused_before_memory_is_taken() {
    let mut bytes = png(&coloured(1, 1, true));
    // The header of a PNG stands at byte 16; its checksum must fit.
    let mut encoder_bytes = Vec::new();
    ::png::Encoder::new(&mut encoder_bytes, 60_000, 60_000).write_header().map(drop).ok();
    bytes[8..33].copy_from_slice(&encoder_bytes[8..33]);
    assert_eq!(decode(&bytes).map_err(|e| e.fault), Err(Fault::Limit));
}

#[test]
fn a_jpeg_of_huge_size_is_too_large_and_not_damaged() {
    for [width, height] in [[16_385u16, 1], [1, 65_535]] {
        let mut bytes = b"\xff\xd8\xff\xc0\x00\x0b\x08".to_vec();
        bytes.extend([height, width].iter().flat_map(|side| side.to_be_bytes()));
        bytes.extend(b"\x01\x01\x11\x00\xff\xda\x00\x08\x01\x01\x00\x00\x3f\x00\xff\xd9");
        assert_eq!(decode(&bytes).map_err(|e| e.fault), Err(Fault::Limit), "{width} x {height}");
    }
}
