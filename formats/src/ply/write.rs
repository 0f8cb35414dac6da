//! Writes Stanford PLY, binary little-endian: one list of vertices, one list of triangles. Names of
//! textures are comments, as MeshLab and others write them.

use crate::colours::SrgbValues;
use crate::far::single;
use crate::flatten::{Placed, component};
use crate::loose::Loose;
use crate::obj::write::Library;
use crate::provenance::Provenance;
use crate::{Fault, FormatError, OutputFile};
use lodc_mesh::Semantic;
use lodc_scene::stream;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

/// Bytes of a face at most: the number of corners, three corners, the number of a texture.
const FACE_BYTES: usize = 17;

/// Makes the file. Streams that only some submeshes have are zero (colours: white) for the others.
///
/// # Errors
/// If there are more vertices than a PLY can number.
pub(crate) fn export(
    path: &Path,
    placed: &[Placed<'_>],
    library: &Library,
    loose: &Loose,
    provenance: Option<&Provenance>,
) -> Result<Vec<OutputFile>, FormatError> {
    let of_triangles: usize = placed.iter().map(|p| p.object.mesh.vertex_count()).sum();
    // Points are vertices that nothing uses: one that is the end of a line, too, is there twice.
    let edges: Vec<[u32; 2]> = loose.segments().collect();
    let ends: BTreeSet<u32> = edges.iter().flatten().copied().collect();
    let again: Vec<u32> = loose.points.iter().copied().filter(|p| ends.contains(p)).collect();
    let vertices = of_triangles + loose.positions.len() + again.len();
    let triangles: usize = placed.iter().map(|p| p.object.mesh.triangles().len()).sum();
    if i32::try_from(vertices).is_err() {
        return Err(FormatError::new(
            Fault::Unsupported,
            "",
            format!("{vertices} vertices are too many for a PLY"),
        ));
    }
    let (mut columns, textures) = (Columns::of(placed), Textures::of(placed, library));
    if !loose.colors.is_empty() {
        columns.colors = columns.colors.max(3);
    }
    let counts = [vertices, triangles, edges.len()];
    let mut bytes = columns.header(counts, &textures, provenance).into_bytes();
    bytes.reserve(vertices * columns.stride() + triangles * FACE_BYTES);
    let (mut first, mut faces) = (0u32, Vec::with_capacity(triangles * FACE_BYTES));
    for p in placed {
        columns.write(&mut bytes, p);
        let (mesh, vertices) = (p.object.mesh, p.vertices());
        for (submesh, info) in mesh.submeshes().iter().zip(&p.object.info.submeshes) {
            let texture = textures.number(library.texture(p.object.info.document_mesh, info));
            for &triangle in &mesh.triangles()[submesh.triangles()] {
                faces.push(3);
                for corner in vertices.corners(triangle) {
                    faces.extend_from_slice(&(first + corner).to_le_bytes());
                }
                if textures.numbered {
                    faces.extend_from_slice(&texture.to_le_bytes());
                }
            }
        }
        first += mesh.vertex_count() as u32;
    }
    let all = (0..loose.positions.len()).chain(again.iter().map(|&v| v as usize));
    all.for_each(|v| columns.write_loose(&mut bytes, loose, v));
    bytes.extend_from_slice(&faces);
    for end in edges.as_flattened() {
        bytes.extend_from_slice(&(of_triangles as u32 + end).to_le_bytes());
    }
    Ok(vec![OutputFile { path: path.to_owned(), bytes }])
}

/// The base colour textures of all submeshes.
struct Textures {
    /// Their numbers by the names of their files.
    numbers: BTreeMap<String, i32>,
    /// The names in the order of the numbers.
    names: Vec<String>,
    /// True if faces say which one they have: they do not all have the same.
    numbered: bool,
}

impl Textures {
    fn of(placed: &[Placed<'_>], library: &Library) -> Self {
        let mut textures = Self { numbers: BTreeMap::new(), names: Vec::new(), numbered: false };
        let mut has_bare = false;
        for object in placed.iter().map(|p| p.object) {
            for (submesh, info) in object.mesh.submeshes().iter().zip(&object.info.submeshes) {
                let Some(name) = library.texture(object.info.document_mesh, info) else {
                    has_bare |= submesh.triangle_count > 0;
                    continue;
                };
                if !textures.numbers.contains_key(name) {
                    textures.numbers.insert(name.to_owned(), textures.names.len() as i32);
                    textures.names.push(name.to_owned());
                }
            }
        }
        textures.numbered = textures.names.len() > usize::from(!has_bare);
        textures
    }

    /// The number of a texture; −1 for none.
    fn number(&self, name: Option<&str>) -> i32 {
        name.and_then(|name| self.numbers.get(name)).copied().unwrap_or(-1)
    }
}

/// The properties of vertices; of those besides positions the ones that some submesh has.
struct Columns {
    /// Positions in double precision.
    doubles: bool,
    normals: bool,
    uvs: bool,
    /// Components of colours: 0, 3 or, with opacity, 4.
    colors: usize,
}

impl Columns {
    fn of(placed: &[Placed<'_>]) -> Self {
        let doubles = placed.iter().any(Placed::is_far);
        let mut columns = Self { doubles, normals: false, uvs: false, colors: 0 };
        for p in placed {
            let mesh = p.object.mesh;
            for submesh in 0..mesh.submeshes().len() {
                let stream = |semantic| stream(mesh, submesh, &semantic);
                columns.normals |= stream(Semantic::Normal).is_some();
                columns.uvs |= stream(Semantic::TexCoord(p.coordinates(submesh).set)).is_some();
                let components = |c: &lodc_mesh::Attribute| usize::from(c.components).clamp(3, 4);
                let colors = stream(Semantic::Color(0)).map_or(0, components);
                columns.colors = columns.colors.max(colors);
            }
        }
        columns
    }

    fn header(
        &self,
        [vertices, triangles, edges]: [usize; 3],
        textures: &Textures,
        provenance: Option<&Provenance>,
    ) -> String {
        let comment = provenance.map_or_else(|| "lodc".to_owned(), Provenance::line);
        let mut header = format!("ply\nformat binary_little_endian 1.0\ncomment {comment}\n");
        let mut put = |line: String| {
            writeln!(header, "{line}").expect("a String takes everything");
        };
        textures.names.iter().for_each(|name| put(format!("comment TextureFile {name}")));
        put(format!("element vertex {vertices}"));
        let mut declare = |kind: &str, names: &[&str]| {
            names.iter().for_each(|name| put(format!("property {kind} {name}")));
        };
        declare(if self.doubles { "double" } else { "float" }, &["x", "y", "z"]);
        declare("float", if self.normals { &["nx", "ny", "nz"] } else { &[] });
        declare("float", if self.uvs { &["s", "t"] } else { &[] });
        declare("uchar", &["red", "green", "blue", "alpha"][..self.colors]);
        put(format!("element face {triangles}\nproperty list uchar int vertex_indices"));
        if textures.numbered {
            put("property int texnumber".to_owned());
        }
        if edges > 0 {
            put(format!("element edge {edges}\nproperty int vertex1\nproperty int vertex2"));
        }
        put("end_header".to_owned());
        header
    }

    /// Bytes of a vertex.
    fn stride(&self) -> usize {
        12 + usize::from(self.doubles) * 12
            + usize::from(self.normals) * 12
            + usize::from(self.uvs) * 8
            + self.colors
    }

    /// Writes a vertex of points and lines; all but its position and colour is zero.
    fn write_loose(&self, bytes: &mut Vec<u8>, loose: &Loose, v: usize) {
        let position = loose.positions[v];
        if self.doubles {
            position.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        } else {
            position.iter().for_each(|&c| bytes.extend(single(c).to_le_bytes()));
        }
        let of_position = if self.doubles { 24 } else { 12 };
        let zeros = self.stride() - of_position - self.colors;
        bytes.resize(bytes.len() + zeros, 0);
        let rgb = loose.colors.get(v).copied().unwrap_or([1.0; 3]);
        let rgba = [rgb[0], rgb[1], rgb[2], 1.0];
        rgba[..self.colors].iter().for_each(|c| bytes.push(byte(*c)));
    }

    fn write(&self, bytes: &mut Vec<u8>, placed: &Placed<'_>) {
        let (mesh, vertices) = (placed.object.mesh, placed.vertices());
        let streams: Vec<_> = (0..mesh.submeshes().len())
            .map(|s| {
                let coordinates = placed.coordinates(s);
                let wanted =
                    [Semantic::Normal, Semantic::TexCoord(coordinates.set), Semantic::Color(0)];
                (wanted.map(|x| stream(mesh, s, &x)), coordinates)
            })
            .collect();
        let mut srgb = SrgbValues::default();
        for (vertex, &submesh) in (0..).zip(mesh.vertex_submesh()) {
            let ([normal, uv, color], coordinates) = streams[submesh as usize];
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
                let [u, v, _] = uv.map_or([0.0; 3], |s| coordinates.at(s, vertex));
                [u, v].into_iter().for_each(&mut put);
            }
            let mut channel = |i| match color {
                Some(c) if i < 3 => srgb.of(c, vertex, i),
                Some(c) if i < usize::from(c.components) => component(c, vertex, i),
                _ => 1.0,
            };
            (0..self.colors).for_each(|i| bytes.push(byte(channel(i))));
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
