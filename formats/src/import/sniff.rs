//! Telling a file's format by its first bytes.

use std::path::Path;

/// Kind that a file seems to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sniffed {
    /// glTF, binary.
    Glb,
    /// glTF, JSON.
    Gltf,
    /// OBJ, or any other text: that has no mark of its own.
    Obj,
    /// Something that is not imported, by its name.
    Other(&'static str),
}

const MAGIC: [(&[u8], Sniffed); 24] = [
    (b"glTF", Sniffed::Glb),
    (b"\x1f\x8b", Sniffed::Other("a gzip file")),
    (b"PK\x03\x04", Sniffed::Other("a zip archive (also usdz, 3mf, docx)")),
    (b"PK\x05\x06", Sniffed::Other("an empty zip archive")),
    (b"\x28\xb5\x2f\xfd", Sniffed::Other("a zstd file")),
    (b"\xfd7zXZ", Sniffed::Other("an xz file")),
    (b"BZh", Sniffed::Other("a bzip2 file")),
    (b"7z\xbc\xaf\x27\x1c", Sniffed::Other("a 7-zip archive")),
    (b"Kaydara FBX Binary", Sniffed::Other("an FBX file")),
    (b"; FBX", Sniffed::Other("an FBX file")),
    (b"BLENDER", Sniffed::Other("a Blender file")),
    (b"ply\n", Sniffed::Other("a PLY file")),
    (b"ply\r", Sniffed::Other("a PLY file")),
    (b"solid ", Sniffed::Other("an STL file")),
    (b"OFF\n", Sniffed::Other("an OFF file")),
    (b"OFF\r", Sniffed::Other("an OFF file")),
    (b"DRACO", Sniffed::Other("a Draco file")),
    (b"PXR-USDC", Sniffed::Other("a USD file")),
    (b"#usda", Sniffed::Other("a USD file")),
    (b"<?xml", Sniffed::Other("an XML file (COLLADA, X3D)")),
    (b"<COLLADA", Sniffed::Other("a COLLADA file")),
    (b"\x89PNG", Sniffed::Other("a PNG picture")),
    (b"\xff\xd8\xff", Sniffed::Other("a JPEG picture")),
    (b"\x89LODC", Sniffed::Other("a file that lodc made: it is not an input; this")),
];

/// Returns the kind that `bytes` seem to be; the extension of `path` decides only for formats
/// without a mark.
pub(super) fn format(bytes: &[u8], path: &Path) -> Sniffed {
    if let Some((_, sniffed)) = MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return *sniffed;
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if text.starts_with(b"{") {
        return Sniffed::Gltf;
    }
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Sniffed::Other("text in UTF-16");
    }
    let extension =
        path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "stl" => Sniffed::Other("an STL file"),
        "ply" => Sniffed::Other("a PLY file"),
        "off" => Sniffed::Other("an OFF file"),
        "fbx" => Sniffed::Other("an FBX file"),
        "3ds" => Sniffed::Other("a 3DS file"),
        "mtl" => Sniffed::Other("a material library by itself"),
        // An empty or broken one of these is reported by its own reader.
        "glb" => Sniffed::Glb,
        "gltf" => Sniffed::Gltf,
        _ => Sniffed::Obj,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_decides_before_the_extension() {
        assert_eq!(format(b"glTF\x02\0\0\0", Path::new("a.obj")), Sniffed::Glb);
        assert_eq!(format(b"\xef\xbb\xbf \n{\"asset\":{}}", Path::new("a.obj")), Sniffed::Gltf);
        assert_eq!(format(b"v 0 0 0\n", Path::new("-")), Sniffed::Obj);
        assert_eq!(format(b"v 0 0 0\n", Path::new("a.txt")), Sniffed::Obj);
        assert_eq!(format(b"", Path::new("a.glb")), Sniffed::Glb);
        assert_eq!(format(b"", Path::new("a.obj")), Sniffed::Obj);
    }

    #[test]
    fn other_formats_are_named() {
        for (bytes, path, name) in [
            (&b"\x1f\x8b\x08"[..], "a.obj", "gzip"),
            (b"PK\x03\x04", "a.glb", "zip"),
            (b"Kaydara FBX Binary  \0", "a.obj", "FBX"),
            (b"ply\nformat", "a.obj", "PLY"),
            (b"solid name", "a.obj", "STL"),
            (b"\0\0\0\0", "a.STL", "STL"),
            (b"\xff\xfev\0", "a.obj", "UTF-16"),
        ] {
            let Sniffed::Other(what) = format(bytes, Path::new(path)) else {
                panic!("{name} not recognised")
            };
            assert!(what.contains(name), "{what}");
        }
    }
}
