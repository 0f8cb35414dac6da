//! From indexed polygons (OBJ, PLY, STL) to submeshes: polygons are triangulated, corners with
//! equal position, texture coordinates and normal become one vertex, and each material gets a
//! submesh.

use super::triangulate::{Triangulator, newell};
use super::unique::{Unique, first_equal};
use super::{Faces, NONE};
use crate::{SubmeshInfo, colours};
use lodc_mesh::{Attribute, Component, MeshParts, Semantic, Submesh};
use std::collections::BTreeSet;

/// The mesh made of the faces, and counts of repairs.
#[derive(Debug, Default)]
pub(crate) struct Assembled {
    pub(crate) parts: MeshParts,
    /// The file's position that each vertex has.
    pub(crate) source_positions: Vec<u32>,
    pub(crate) submeshes: Vec<SubmeshInfo>,
    /// Faces with more than three corners.
    pub(crate) polygons: u64,
    /// Polygons that cross themselves or have no inside.
    pub(crate) imperfect_polygons: u64,
    /// Corners without texture coordinates beside others that have them.
    pub(crate) filled_texcoords: u64,
    /// Faces without normals beside others that have them.
    pub(crate) filled_normals: u64,
    /// True if colours were numbers from 0 to 255.
    pub(crate) byte_colors: bool,
    /// Groups that share their material with another one.
    pub(crate) joined_labels: u64,
}

/// Builds the mesh. `seed` is any number that the file's maker cannot choose.
pub(crate) fn assemble(faces: &Faces, seed: u64) -> Assembled {
    let mut builder = Builder::new(faces, seed);
    for MaterialRuns { material, runs } in runs_by_material(faces) {
        builder.submesh(material, &runs);
    }
    builder.finish()
}

/// The runs of faces that have a material.
struct MaterialRuns {
    /// Index into the materials, or [`NONE`].
    material: u32,
    /// Indices into the runs.
    runs: Vec<u32>,
}

/// Lists the runs of each material that has faces, materials in order of first use.
fn runs_by_material(faces: &Faces) -> Vec<MaterialRuns> {
    let mut submesh_of = vec![NONE; faces.materials.len() + 1];
    let mut submeshes: Vec<MaterialRuns> = Vec::new();
    for (i, run) in faces.runs.iter().enumerate() {
        let slot = if run.material == NONE { faces.materials.len() } else { run.material as usize };
        if submesh_of[slot] == NONE {
            submesh_of[slot] = submeshes.len() as u32;
            submeshes.push(MaterialRuns { material: run.material, runs: Vec::new() });
        }
        submeshes[submesh_of[slot] as usize].runs.push(i as u32);
    }
    submeshes
}

struct Builder<'a> {
    faces: &'a Faces,
    out: Assembled,
    /// For each texture coordinate and normal, the first with the same bits.
    first_texcoord: Vec<u32>,
    first_normal: Vec<u32>,
    /// Position, texture coordinates and normal of each vertex made so far.
    vertices: Vec<[u32; 3]>,
    /// Normals made for faces without; numbered after those of the file.
    made_normals: Vec<[f32; 3]>,
    /// The first vertex made at each position; of an earlier submesh if below `first_vertex`.
    first_at: Vec<u32>,
    /// The submesh's first vertex.
    first_vertex: u32,
    /// The submesh's further vertices at positions that have one already: few, on most meshes none.
    unique: Unique,
    triangulator: Triangulator,
    /// Whether any submesh has texture coordinates, and normals.
    uses: [bool; 2],
}

impl<'a> Builder<'a> {
    fn new(faces: &'a Faces, seed: u64) -> Self {
        let first_texcoord = first_equal(
            if faces.corner_t.is_empty() { 0 } else { faces.texcoords.len() },
            seed,
            |i| {
                let i = i as usize;
                let [u, v] = faces.texcoords[i].map(f32::to_bits);
                [u, v, faces.texcoords_w.get(i).map_or(0, |w| w.to_bits())]
            },
        );
        let normals = if faces.corner_n.is_empty() { 0 } else { faces.normals.len() };
        let first_normal =
            first_equal(normals, seed, |i| faces.normals[i as usize].map(f32::to_bits));
        Self {
            faces,
            out: Assembled::default(),
            first_texcoord,
            first_normal,
            vertices: Vec::new(),
            made_normals: Vec::new(),
            first_at: vec![NONE; faces.positions.len()],
            first_vertex: 0,
            unique: Unique::new(seed),
            triangulator: Triangulator::default(),
            uses: [false; 2],
        }
    }

    /// The numbers of a run's faces.
    fn faces_of(&self, run: u32) -> std::ops::Range<usize> {
        let runs = &self.faces.runs;
        let end = runs
            .get(run as usize + 1)
            .map_or(self.faces.face_ends.len(), |next| next.first_face as usize);
        runs[run as usize].first_face as usize..end
    }

    /// The numbers of a face's corners.
    fn corners_of(&self, face: usize) -> std::ops::Range<usize> {
        let ends = &self.faces.face_ends;
        let start = if face == 0 { 0 } else { ends[face - 1] as usize };
        start..ends[face] as usize
    }

    /// Adds the submesh of a material.
    fn submesh(&mut self, material: u32, runs: &[u32]) {
        let first_triangle = self.out.parts.triangles.len() as u32;
        let has = |list: &[u32]| {
            !list.is_empty()
                && runs.iter().any(|&r| {
                    self.faces_of(r).any(|f| list[self.corners_of(f)].iter().any(|&i| i != NONE))
                })
        };
        let (has_texcoords, has_normals) = (has(&self.faces.corner_t), has(&self.faces.corner_n));
        self.unique.clear();
        self.first_vertex = self.vertices.len() as u32;
        let (mut polygon, mut vertices) = (Vec::new(), Vec::new());
        for &run in runs {
            for face in self.faces_of(run) {
                self.face(face, [has_texcoords, has_normals], &mut polygon, &mut vertices);
            }
        }
        let submesh = self.out.parts.submeshes.len() as u32;
        self.out.parts.vertex_submesh.resize(self.vertices.len(), submesh);
        self.uses = [self.uses[0] | has_texcoords, self.uses[1] | has_normals];
        self.out.parts.submeshes.push(Submesh {
            first_triangle,
            triangle_count: self.out.parts.triangles.len() as u32 - first_triangle,
            // 1 if it has texture coordinates, and normals, until `finish` puts the streams'
            // numbers here.
            attributes: [has_texcoords, has_normals].map(u32::from).to_vec(),
        });
        let name = self.label(runs);
        let material = self.faces.materials.get(material as usize).cloned();
        self.out.submeshes.push(SubmeshInfo { name, material, document_primitive: submesh });
    }

    /// Adds the triangles of a face. `polygon` and `vertices` are memory that faces share.
    fn face(
        &mut self,
        face: usize,
        [has_texcoords, has_normals]: [bool; 2],
        polygon: &mut Vec<[f32; 3]>,
        vertices: &mut Vec<u32>,
    ) {
        let faces = self.faces;
        let corners = self.corners_of(face);
        let lacks_normal = has_normals && faces.corner_n[corners.clone()].contains(&NONE);
        polygon.clear();
        if corners.len() > 3 || lacks_normal {
            polygon.extend(
                faces.corner_v[corners.clone()].iter().map(|&v| faces.positions[v as usize]),
            );
        }
        let made_normal = (faces.normals.len() + self.made_normals.len()) as u32;
        if lacks_normal {
            self.made_normals.push(unit(newell(polygon)));
            self.out.filled_normals += 1;
        }
        vertices.clear();
        for corner in corners {
            let texcoord = if has_texcoords { faces.corner_t[corner] } else { NONE };
            let normal = if has_normals { faces.corner_n[corner] } else { NONE };
            self.out.filled_texcoords += u64::from(has_texcoords && texcoord == NONE);
            let key = [
                faces.corner_v[corner],
                if texcoord == NONE { NONE } else { self.first_texcoord[texcoord as usize] },
                match normal {
                    NONE if lacks_normal => made_normal,
                    NONE => NONE,
                    n => self.first_normal[n as usize],
                },
            ];
            let vertex = self.vertex(key);
            vertices.push(vertex);
        }
        let triangles = &mut self.out.parts.triangles;
        if let [a, b, c] = vertices[..] {
            triangles.push([a, b, c]);
        } else {
            self.out.polygons += 1;
            let local = self.triangulator.triangulate(polygon);
            triangles.extend(local.iter().map(|t| t.map(|corner| vertices[corner as usize])));
        }
    }

    /// The vertex for a corner, made if it is new to the submesh.
    fn vertex(&mut self, key: [u32; 3]) -> u32 {
        let next = self.vertices.len() as u32;
        let first = &mut self.first_at[key[0] as usize];
        let vertex = if *first == NONE || *first < self.first_vertex {
            *first = next;
            next
        } else if self.vertices[*first as usize] == key {
            *first
        } else {
            self.unique.number(key, next, |id| self.vertices[id as usize])
        };
        if vertex == next {
            self.vertices.push(key);
        }
        vertex
    }

    /// The names of the groups with this material; several are joined as an OBJ's `g` would list
    /// them.
    fn label(&mut self, runs: &[u32]) -> String {
        // Chosen by hand: enough for people, and a bound for files with a group per face.
        const MAX_BYTES: usize = 1000;
        let mut seen = BTreeSet::new();
        let mut name = String::new();
        for &run in runs {
            let label = self.faces.runs[run as usize].label;
            // The name of the only object is that of the scene's object.
            let text = self
                .faces
                .labels
                .get(label as usize)
                .filter(|&l| self.faces.objects != [l.as_str()]);
            if !seen.insert(text) {
                continue;
            }
            let Some(text) = text else { continue };
            if name.is_empty() {
                name.clone_from(text);
            } else if name.len() + text.len() < MAX_BYTES {
                name = format!("{name} {text}");
            }
        }
        if seen.len() > 1 {
            self.out.joined_labels += seen.len() as u64;
        }
        name
    }

    fn finish(mut self) -> Assembled {
        let faces = self.faces;
        let vertices = std::mem::take(&mut self.vertices);
        let parts = &mut self.out.parts;
        parts.positions = vertices.iter().map(|k| faces.positions[k[0] as usize]).collect();
        let mut numbers = [None; 2];
        let mut push = |semantic, components, bytes: Vec<u8>| {
            parts.attributes.push(Attribute {
                semantic,
                morph_target: None,
                component: Component::F32,
                components,
                normalized: false,
                bytes,
            });
            Some(parts.attributes.len() as u32 - 1)
        };
        if self.uses[1] {
            let made = |n: usize| self.made_normals.get(n.wrapping_sub(faces.normals.len()));
            let normal = |k: &[u32; 3]| {
                let n = k[2] as usize;
                faces.normals.get(n).or_else(|| made(n)).copied().unwrap_or_default()
            };
            numbers[1] = push(Semantic::Normal, 3, stream(vertices.iter().map(normal)));
        }
        if self.uses[0] {
            let uv = |k: &[u32; 3]| faces.texcoords.get(k[1] as usize).copied().unwrap_or_default();
            numbers[0] = if faces.texcoords_w.is_empty() {
                push(Semantic::TexCoord(0), 2, stream(vertices.iter().map(uv)))
            } else {
                let w = |k: &[u32; 3]| {
                    faces.texcoords_w.get(k[1] as usize).copied().unwrap_or_default()
                };
                let uvw = vertices.iter().map(|k| [uv(k)[0], uv(k)[1], w(k)]);
                push(Semantic::TexCoord(0), 3, stream(uvw))
            };
        }
        let color = if faces.colors.is_empty() || vertices.is_empty() {
            None
        } else {
            let (light, were_bytes) = colours::linear(&faces.colors);
            self.out.byte_colors = were_bytes;
            let rgba = vertices.iter().map(|k| light[k[0] as usize]);
            if faces.color_has_alpha {
                push(Semantic::Color(0), 4, stream(rgba))
            } else {
                push(Semantic::Color(0), 3, stream(rgba.map(|[r, g, b, _]| [r, g, b])))
            }
        };
        for submesh in &mut parts.submeshes {
            let used = |i: usize| numbers[i].filter(|_| submesh.attributes[i] == 1);
            submesh.attributes = [used(1), used(0), color].into_iter().flatten().collect();
        }
        let of_file = |v: u32| faces.file_positions.get(v as usize).copied().unwrap_or(v);
        self.out.source_positions = vertices.iter().map(|k| of_file(k[0])).collect();
        self.out.imperfect_polygons = self.triangulator.imperfect;
        self.out
    }
}

fn stream<const N: usize>(values: impl ExactSizeIterator<Item = [f32; N]>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.len() * N * 4);
    for value in values {
        for c in value {
            bytes.extend_from_slice(&c.to_le_bytes());
        }
    }
    bytes
}

/// A vector of length one; along z if it has no direction.
fn unit(v: [f64; 3]) -> [f32; 3] {
    // Scaled first, so that the squares neither vanish nor overflow.
    let largest = v.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return [0.0, 0.0, 1.0];
    }
    let v = v.map(|c| c / largest);
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    #[expect(clippy::cast_possible_truncation, reason = "a made normal is as exact as its stream")]
    v.map(|c| (c / length) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_made_normal_has_length_one_at_any_scale() {
        for scale in [1e-200, 1.0, 1e200] {
            let n = unit([3.0 * scale, 0.0, -4.0 * scale]);
            assert_eq!(n, [0.6, 0.0, -0.8]);
        }
        assert_eq!(unit([0.0; 3]), [0.0, 0.0, 1.0]);
    }
}
