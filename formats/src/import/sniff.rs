//! Recognises a file's format by its first bytes.

use crate::stl::read as stl;
use crate::words::without_mark;
use std::path::Path;

/// Kind that a file seems to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sniffed {
    /// glTF, binary.
    Glb,
    /// glTF, JSON.
    Gltf,
    /// OBJ, or any other text: an OBJ has no magic bytes.
    Obj,
    /// Stanford PLY.
    Ply,
    /// STL, ASCII or binary.
    Stl,
    /// What this program has made.
    Made,
    /// Something that is not imported, by its name.
    Other(&'static str),
}

/// First bytes of formats.
const MAGIC: [(&[u8], Sniffed); 27] = [
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
    (b"ply\n", Sniffed::Ply),
    (b"ply\r", Sniffed::Ply),
    (b"solid ", Sniffed::Stl),
    (b"solid\n", Sniffed::Stl),
    (b"solid\r", Sniffed::Stl),
    (b"OFF\n", Sniffed::Other("an OFF file")),
    (b"OFF\r", Sniffed::Other("an OFF file")),
    (b"DRACO", Sniffed::Other("a Draco file")),
    (b"PXR-USDC", Sniffed::Other("a USD file")),
    (b"#usda", Sniffed::Other("a USD file")),
    (b"<?xml", Sniffed::Other("an XML file (COLLADA, X3D)")),
    (b"<COLLADA", Sniffed::Other("a COLLADA file")),
    (b"\x89PNG", Sniffed::Other("a PNG picture")),
    (b"\xff\xd8\xff", Sniffed::Other("a JPEG picture")),
    (b"\x89LODC", Sniffed::Made),
    (b"\x89LODS", Sniffed::Made),
];

/// Returns the kind that `bytes` seem to be; the extension of `path` decides only for formats
/// without magic bytes.
pub(super) fn format(bytes: &[u8], path: &Path) -> Sniffed {
    if let Some((_, sniffed)) = MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return *sniffed;
    }
    let text = without_mark(bytes).trim_ascii_start();
    if text.starts_with(b"{") {
        return Sniffed::Gltf;
    }
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Sniffed::Other("text in UTF-16");
    }
    if stl::is_binary(bytes) {
        return Sniffed::Stl;
    }
    let extension =
        path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "stl" => Sniffed::Stl,
        "ply" => Sniffed::Ply,
        "off" => Sniffed::Other("an OFF file"),
        "fbx" => Sniffed::Other("an FBX file"),
        "3ds" => Sniffed::Other("a 3DS file"),
        "mtl" => Sniffed::Other("a material library by itself"),
        // An empty or broken one of these is reported by its own reader.
        "glb" | "vrm" => Sniffed::Glb,
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
        assert_eq!(format(b"ply\nformat", Path::new("a.obj")), Sniffed::Ply);
        assert_eq!(format(b"solid name", Path::new("-")), Sniffed::Stl);
        assert_eq!(format(b"\x89LODC\r\n", Path::new("a.obj")), Sniffed::Made);
        assert_eq!(format(b"\x89LODS\r\n", Path::new("a.obj")), Sniffed::Made);
        assert_eq!(format(b"\0\0\0\0", Path::new("a.STL")), Sniffed::Stl);
        let mut binary = vec![b' '; 134];
        binary[80..84].copy_from_slice(&1u32.to_le_bytes());
        assert_eq!(format(&binary, Path::new("-")), Sniffed::Stl);
        assert_eq!(format(&binary[..133], Path::new("-")), Sniffed::Obj);
    }

    #[test]
    fn other_formats_are_named() {
        for (bytes, path, name) in [
            (&b"\x1f\x8b\x08"[..], "a.obj", "gzip"),
            (b"PK\x03\x04", "a.glb", "zip"),
            (b"Kaydara FBX Binary  \0", "a.obj", "FBX"),
            (b"\xff\xfev\0", "a.obj", "UTF-16"),
        ] {
            let Sniffed::Other(problem) = format(bytes, Path::new(path)) else {
                panic!("{name} not recognised")
            };
            assert!(problem.contains(name), "{problem}");
        }
    }
}
