//! Kinds of image files, by their first bytes.

/// The media type of an image that glTF can hold; none for other bytes.
pub(crate) fn mime_of(bytes: &[u8]) -> Option<&'static str> {
    Some(match bytes {
        [0x89, b'P', b'N', b'G', ..] => "image/png",
        [0xff, 0xd8, 0xff, ..] => "image/jpeg",
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', ..] => "image/ktx2",
        [b'D', b'D', b'S', b' ', ..] => "image/vnd-ms.dds",
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "image/webp",
        [_, _, _, _, b'f', b't', b'y', b'p', b'a', b'v', b'i', b'f', ..] => "image/avif",
        _ => return None,
    })
}

/// The extension of file names for an image, by its first bytes.
pub(crate) fn extension_of(bytes: &[u8]) -> &'static str {
    match mime_of(bytes) {
        Some("image/png") => "png",
        Some("image/jpeg") => "jpg",
        Some("image/ktx2") => "ktx2",
        Some("image/vnd-ms.dds") => "dds",
        Some("image/webp") => "webp",
        Some("image/avif") => "avif",
        _ => "bin",
    }
}
