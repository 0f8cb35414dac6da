//! Writes Stanford PLY, binary little-endian: one list of vertices, one list of triangles.

use crate::flatten::{Placed, Vertices, component};
use crate::provenance::Provenance;
use crate::{Fault, FormatError, OutputFile};
use lodc_mesh::{Mesh, Semantic};
use lodc_scene::stream;
use std::fmt::Write;
use std::path::Path;

/// Makes the file. Streams that only some submeshes have are zero (colours: white) for the others.
/// `top_left` says that texture coordinates begin at the top.
///
/// # Errors
/// If there are more vertices than a PLY can number.
pub(crate) fn export(
    path: &Path,
    placed: &[Placed<'_>],
    top_left: bool,
    provenance: Option<&Provenance>,
) -> Result<Vec<OutputFile>, FormatError> {
    let vertices: usize = placed.iter().map(|p| p.object.mesh.vertex_count()).sum();
    let triangles: usize = placed.iter().map(|p| p.object.mesh.triangles().len()).sum();
    if i32::try_from(vertices).is_err() {
        return Err(FormatError::new(
            Fault::Unsupported,
            "",
            format!("{vertices} vertices are too many for a PLY"),
        ));
    }
    let columns = Columns::of(placed);
    let mut bytes = columns.header(vertices, triangles, provenance).into_bytes();
    bytes.reserve(vertices * columns.stride() + triangles * 13);
    let (mut first, mut faces) = (0u32, Vec::with_capacity(triangles * 13));
    for p in placed {
        let (mesh, vertices) = (p.object.mesh, p.vertices());
        columns.write(&mut bytes, mesh, &vertices, top_left);
        for &triangle in mesh.triangles() {
            faces.push(3);
            for corner in vertices.corners(triangle) {
                faces.extend_from_slice(&(first + corner).to_le_bytes());
            }
        }
        first += mesh.vertex_count() as u32;
    }
    bytes.extend_from_slice(&faces);
    Ok(vec![OutputFile { path: path.to_owned(), bytes }])
}

/// The properties of vertices; of those besides positions the ones that some submesh has.
struct Columns {
    /// Positions in double precision.
    doubles: bool,
    normals: bool,
    uvs: bool,
    colors: bool,
}

impl Columns {
    fn of(placed: &[Placed<'_>]) -> Self {
        let has = |semantic: Semantic| {
            let mut meshes = placed.iter().map(|p| p.object.mesh);
            meshes.any(|m| (0..m.submeshes().len()).any(|s| stream(m, s, &semantic).is_some()))
        };
        Self {
            doubles: placed.iter().any(Placed::is_far),
            normals: has(Semantic::Normal),
            uvs: has(Semantic::TexCoord(0)),
            colors: has(Semantic::Color(0)),
        }
    }

    fn header(&self, vertices: usize, triangles: usize, provenance: Option<&Provenance>) -> String {
        let comment = provenance.map_or_else(|| "lodc".to_owned(), Provenance::line);
        let mut header = format!(
            "ply\nformat binary_little_endian 1.0\ncomment {comment}\nelement vertex {vertices}\n"
        );
        let mut declare = |kind: &str, names: &[&str]| {
            for name in names {
                writeln!(header, "property {kind} {name}").expect("a String takes everything");
            }
        };
        declare(if self.doubles { "double" } else { "float" }, &["x", "y", "z"]);
        declare("float", if self.normals { &["nx", "ny", "nz"] } else { &[] });
        declare("float", if self.uvs { &["s", "t"] } else { &[] });
        declare("uchar", if self.colors { &["red", "green", "blue"] } else { &[] });
        write!(
            header,
            "element face {triangles}\nproperty list uchar int vertex_indices\nend_header\n"
        )
        .expect("a String takes everything");
        header
    }

    /// Bytes of a vertex.
    fn stride(&self) -> usize {
        12 + usize::from(self.doubles) * 12
            + usize::from(self.normals) * 12
            + usize::from(self.uvs) * 8
            + usize::from(self.colors) * 3
    }

    fn write(&self, bytes: &mut Vec<u8>, mesh: &Mesh, vertices: &Vertices<'_>, top_left: bool) {
        let streams: Vec<_> = (0..mesh.submeshes().len())
            .map(|s| {
                [Semantic::Normal, Semantic::TexCoord(0), Semantic::Color(0)]
                    .map(|x| stream(mesh, s, &x))
            })
            .collect();
        for (vertex, &submesh) in (0..).zip(mesh.vertex_submesh()) {
            let [normal, uv, color] = streams[submesh as usize];
            if self.doubles {
                let position = vertices.exact_position(vertex);
                bytes.extend(position.iter().flat_map(|c| c.to_le_bytes()));
            }
            let mut put = |x: f32| bytes.extend_from_slice(&x.to_le_bytes());
            if !self.doubles {
                vertices.position(vertex).into_iter().for_each(&mut put);
            }
            if self.normals {
                let normal = normal.map_or([0.0; 3], |s| vertices.normal(s, vertex));
                normal.into_iter().for_each(&mut put);
            }
            if self.uvs {
                let uv = uv.map_or([0.0; 2], |s| {
                    let [u, v] = [component(s, vertex, 0), component(s, vertex, 1)];
                    [u, if top_left { 1.0 - v } else { v }]
                });
                uv.into_iter().for_each(&mut put);
            }
            if self.colors {
                let rgb =
                    color.map_or([1.0; 3], |s| std::array::from_fn(|i| component(s, vertex, i)));
                bytes.extend(rgb.map(byte));
            }
        }
    }
}

/// A fraction as a byte, to nearest; what is no number is black.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to the range of a byte"
)]
fn byte(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0).round() as u8
}

#[cfg(test)]
#[path = "write_tests.rs"]
mod tests;
