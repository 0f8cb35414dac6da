//! Estimates triangles and vertices of a mesh file from its header, or by counting lines of OBJ
//! text, without reading its geometry.

use super::sniff::{Sniffed, format};
use crate::options::ImportOptions;
use crate::scene::Counted;
use crate::{Assets, FormatError, gltf};
use std::path::Path;

/// Counts what a mesh file holds. Files that it names are not looked for.
///
/// # Errors
/// If it cannot be read, or its header is malformed.
pub fn count(path: &Path, options: &ImportOptions) -> Result<Counted, FormatError> {
    let mut assets = Assets::new(path, &options.allowed, options.limits);
    let bytes = assets.read_main()?;
    let mut counted = match format(&bytes, path) {
        Sniffed::Glb | Sniffed::Gltf => gltf::read::counted(&bytes, options),
        Sniffed::Obj => Ok(obj(&bytes)),
        Sniffed::Ply => Ok(ply(&bytes)),
        Sniffed::Stl => {
            let triangles = crate::stl::read::counted(&bytes);
            Ok(Counted { triangles, vertices: triangles, bytes: 0 })
        }
        // The import says why it is refused.
        Sniffed::Other(_) | Sniffed::Made => {
            super::read(bytes, path, &mut assets, options).map(|_| Counted::default())
        }
    }
    .map_err(|e| e.in_file(&assets.main_name()))?;
    counted.bytes += path.metadata().map_or(0, |m| m.len());
    Ok(counted)
}

/// Counts faces, and as vertices the largest of the numbers of positions, texture coordinates and
/// normals.
fn obj(bytes: &[u8]) -> Counted {
    let (mut triangles, mut counts) = (0, [0; 3]);
    for line in bytes.split(|&b| b == b'\n') {
        let line = line.trim_ascii_start();
        let (word, arguments) =
            line.split_at(line.iter().position(u8::is_ascii_whitespace).unwrap_or(0));
        match word {
            b"f" => {
                let corners =
                    arguments.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).count();
                triangles += corners.saturating_sub(2) as u64;
            }
            b"v" => counts[0] += 1,
            b"vt" => counts[1] += 1,
            b"vn" => counts[2] += 1,
            _ => {}
        }
    }
    let vertices = counts.into_iter().max().unwrap_or(0).min(3 * triangles);
    Counted { triangles, vertices, bytes: 0 }
}

/// Faces are taken for triangles, which they are in nearly all files.
fn ply(bytes: &[u8]) -> Counted {
    let mut counted = Counted::default();
    for line in bytes.split(|&b| b == b'\n').take_while(|line| !line.starts_with(b"end_header")) {
        let mut words =
            line.split(u8::is_ascii_whitespace).map(|w| str::from_utf8(w).unwrap_or(""));
        if words.next() != Some("element") {
            continue;
        }
        let (name, number) = (words.next(), words.next().and_then(|n| n.parse().ok()).unwrap_or(0));
        match name {
            Some("vertex") => counted.vertices = number,
            Some("face") => counted.triangles = number,
            // The lengths of strips are in the data: a mesh has about two triangles per vertex.
            Some("tristrips") => counted.triangles = 2 * counted.vertices,
            _ => {}
        }
    }
    counted
}
