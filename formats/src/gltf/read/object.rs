//! A glTF mesh becomes one object: its triangle primitives are its submeshes.

use super::primitive::Primitive;
use crate::far::diagonal;
use crate::gltf::accessor::Accessor;
use crate::gltf::budget::Budget;
use crate::gltf::json::malformed;
use crate::gltf::views::Views;
use crate::{Fault, FormatError, Limits};
use lodc_mesh::{Attribute, Component, Mesh, MeshParts, Semantic, Submesh, weld_positions};
use std::collections::{BTreeMap, BTreeSet};

/// State that all meshes of a document share while they are read.
#[derive(Debug)]
pub(super) struct Reading<'a> {
    pub(super) accessors: &'a [Option<Accessor>],
    pub(super) views: &'a Views<'a>,
    pub(super) limits: Limits,
    pub(super) weld: f64,
    pub(super) numbering: Numbering,
    pub(super) counts: Counts,
    /// Vertices and triangles so far, of all meshes.
    vertices: u64,
    triangles: u64,
    /// For each accessor of positions one bit per element: whether a triangle uses it.
    used: BTreeMap<usize, Vec<u64>>,
    /// Accessors of positions of primitives that have become submeshes.
    converted: BTreeSet<usize>,
}

/// Counts of what was dropped or moved.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Triangles without an area.
    pub(super) degenerate: usize,
    /// Vertices that only these triangles used.
    pub(super) lonely_vertices: usize,
    /// Vertices that welding moved.
    pub(super) welded: usize,
    /// Primitives in which no triangle has an area.
    pub(super) only_degenerate: usize,
    /// Corners after the last whole triangle of a primitive.
    pub(super) leftover_corners: usize,
    /// Streams of texture coordinates with a third component, which is dropped.
    pub(super) third_coordinates: usize,
    /// Attribute values that are not finite; they stay.
    pub(super) not_finite: usize,
}

/// Gives the vertices that a primitive uses consecutive numbers, in time that depends on its
/// corners alone.
#[derive(Debug, Default)]
pub(super) struct Numbering {
    /// The number of the present primitive.
    epoch: u32,
    /// For each vertex the primitive that numbered it last, and its number there.
    numbered: Vec<(u32, u32)>,
}

impl Numbering {
    /// Replaces every vertex by its number; returns the vertices in the order of their numbers.
    fn number(
        &mut self,
        corners: &mut [u32],
        vertices: usize,
        budget: &Budget,
    ) -> Result<Vec<u32>, FormatError> {
        if self.numbered.len() < vertices {
            budget.charge((vertices - self.numbered.len()) as u64, 8, "")?;
            self.numbered.resize(vertices, (0, 0));
        }
        self.epoch += 1;
        let mut sources = Vec::new();
        for corner in corners {
            let (epoch, number) = &mut self.numbered[*corner as usize];
            if *epoch != self.epoch {
                (*epoch, *number) = (self.epoch, sources.len() as u32);
                sources.push(*corner);
            }
            *corner = *number;
        }
        Ok(sources)
    }
}

impl<'a> Reading<'a> {
    pub(super) fn new(
        accessors: &'a [Option<Accessor>],
        views: &'a Views<'a>,
        limits: Limits,
        weld: f64,
    ) -> Self {
        Self {
            accessors,
            views,
            limits,
            weld,
            numbering: Numbering::default(),
            counts: Counts::default(),
            vertices: 0,
            triangles: 0,
            used: BTreeMap::new(),
            converted: BTreeSet::new(),
        }
    }

    /// Reads the primitives of one mesh. Returns the mesh and which of the primitives are its
    /// submeshes: not those in which no triangle has an area. `None` if there is no triangle at
    /// all.
    pub(super) fn object(
        &mut self,
        primitives: &[Primitive],
    ) -> Result<Option<(Mesh, Vec<usize>)>, FormatError> {
        let (mut parts, mut streams) = (MeshParts::default(), Streams::default());
        for primitive in primitives {
            self.add(primitive, &mut parts, &mut streams)?;
        }
        let total = parts.positions.len();
        for a in &mut parts.attributes {
            extend_with_zeros(a, total, self.views.budget)?;
        }
        if self.weld > 0.0 {
            let tolerance = self.weld * diagonal(&parts.positions);
            self.counts.welded += weld_positions(&mut parts, tolerance);
        }
        let sizes = SubmeshSizes::of(&parts);
        parts.clean();
        let cleaned = SubmeshSizes::of(&parts);
        let with_area = drop_empty_submeshes(&mut parts);
        for &s in &with_area {
            self.counts.degenerate += sizes.triangles[s] - cleaned.triangles[s];
            self.counts.lonely_vertices += sizes.vertices[s] - cleaned.vertices[s];
            self.converted.insert(primitives[s].position);
        }
        self.counts.only_degenerate += primitives.len() - with_area.len();
        if with_area.is_empty() {
            return Ok(None);
        }
        let invalid = |e: &dyn std::fmt::Display| {
            malformed(primitives.first().map_or("", |p| p.location.as_str()), e.to_string())
        };
        Ok(Some((Mesh::try_from(parts).map_err(|e| invalid(&e))?, with_area)))
    }

    fn add(
        &mut self,
        primitive: &Primitive,
        parts: &mut MeshParts,
        streams: &mut Streams,
    ) -> Result<(), FormatError> {
        let (location, budget, views) =
            (primitive.location.as_str(), self.views.budget, self.views);
        let accessors = self.accessors;
        let get = |a: usize| {
            accessors
                .get(a)
                .and_then(Option::as_ref)
                .ok_or_else(|| malformed(location, "unknown accessor"))
        };
        let position = get(primitive.position)?;
        let mut corners = primitive.corners(position.count, accessors, views)?;
        let triangles = primitive.triangle_count(corners.len());
        self.triangles += triangles as u64;
        if self.triangles > self.limits.triangles {
            let problem = format!("more than {} triangles in all", self.limits.triangles);
            return Err(FormatError::new(Fault::Limit, location, problem));
        }
        if corners.len() % 3 != 0 && triangles == corners.len() / 3 {
            self.counts.leftover_corners += corners.len() % 3;
        }
        self.mark_used(primitive.position, position.count, &corners)?;
        let sources = self.numbering.number(&mut corners, position.count, budget)?;
        self.vertices += sources.len() as u64;
        if self.vertices > self.limits.vertices {
            let problem = format!("more than {} vertices in all", self.limits.vertices);
            return Err(FormatError::new(Fault::Limit, location, problem));
        }
        // For each vertex its source, its position and its submesh; three corners for each
        // triangle.
        budget.charge(sources.len() as u64, 4 + 12 + 4, location)?;
        budget.charge(triangles as u64, 12, location)?;

        let base = parts.positions.len();
        let submesh = parts.submeshes.len() as u32;
        parts.positions.extend(positions(position, &sources, views, location)?);
        parts.vertex_submesh.resize(base + sources.len(), submesh);
        let first_triangle = parts.triangles.len() as u32;
        parts.triangles.reserve(triangles);
        primitive.triangles(&corners, |t| parts.triangles.push(t.map(|v| v + base as u32)));
        let mut used = Vec::with_capacity(primitive.streams.len());
        for (semantic, morph_target, index) in &primitive.streams {
            let accessor = get(*index)?;
            let wanted = described(semantic, *morph_target, accessor);
            let stream = streams.find(wanted, &mut parts.attributes);
            let a = &mut parts.attributes[stream];
            extend_with_zeros(a, base, budget)?;
            budget.charge(sources.len() as u64, a.stride() as u64, location)?;
            let reader = accessor.reader(views)?;
            let wider = accessor.shape.components() > usize::from(a.components);
            self.counts.third_coordinates += usize::from(wider);
            for (i, &v) in sources.iter().enumerate() {
                reader.append(v, &mut a.bytes);
                a.bytes.truncate((base + i + 1) * a.stride());
            }
            if a.component == Component::F32 {
                self.counts.not_finite += not_finite(&a.bytes[base * a.stride()..]);
            }
            used.push(stream as u32);
        }
        parts.submeshes.push(Submesh {
            first_triangle,
            triangle_count: triangles as u32,
            attributes: used,
        });
        Ok(())
    }

    fn mark_used(
        &mut self,
        accessor: usize,
        count: usize,
        corners: &[u32],
    ) -> Result<(), FormatError> {
        if !self.used.contains_key(&accessor) {
            self.views.budget.charge(count as u64 / 64 + 1, 8, "")?;
            self.used.insert(accessor, vec![0; count / 64 + 1]);
        }
        let bits = self.used.get_mut(&accessor).expect("it was just inserted");
        for &v in corners {
            bits[v as usize / 64] |= 1 << (v % 64);
        }
        Ok(())
    }

    /// Number of elements of all accessors of positions that no primitive uses.
    pub(super) fn unused_vertices(&self) -> usize {
        let unused = |(accessor, bits): (&usize, &Vec<u64>)| {
            let used: usize = bits.iter().map(|b| b.count_ones() as usize).sum();
            self.accessors[*accessor].as_ref().map_or(0, |a| a.count - used)
        };
        self.used.iter().filter(|(a, _)| self.converted.contains(a)).map(unused).sum()
    }
}

/// Numbers of triangles and vertices of each submesh.
struct SubmeshSizes {
    triangles: Vec<usize>,
    vertices: Vec<usize>,
}

impl SubmeshSizes {
    fn of(parts: &MeshParts) -> Self {
        let mut vertices = vec![0; parts.submeshes.len()];
        parts.vertex_submesh.iter().for_each(|&s| vertices[s as usize] += 1);
        Self {
            triangles: parts.submeshes.iter().map(|s| s.triangle_count as usize).collect(),
            vertices,
        }
    }
}

/// The positions of some vertices as floats, whatever they are stored as.
fn positions(
    accessor: &Accessor,
    sources: &[u32],
    views: &Views<'_>,
    location: &str,
) -> Result<Vec<[f32; 3]>, FormatError> {
    let reader = accessor.reader(views)?;
    let mut one = described(&Semantic::Position, None, accessor);
    let mut out = Vec::with_capacity(sources.len());
    for &v in sources {
        one.bytes.clear();
        reader.append(v, &mut one.bytes);
        let p: [f32; 3] = std::array::from_fn(|i| one.value(0, i));
        if p.iter().any(|c| !c.is_finite()) {
            let problem = format!("vertex {v} has a coordinate that is not a finite number");
            return Err(malformed(format!("{location}.attributes.POSITION"), problem));
        }
        out.push(p);
    }
    Ok(out)
}

/// The streams of a mesh by meaning and format: semantic, morph target, component type, number of
/// components, and whether integers stand for fractions.
#[derive(Debug, Default)]
struct Streams(BTreeMap<(Semantic, Option<u32>, u8, u8, bool), usize>);

impl Streams {
    /// The stream of this meaning and format among `all`, which primitives share.
    fn find(&mut self, wanted: Attribute, all: &mut Vec<Attribute>) -> usize {
        let Attribute { morph_target, component, components, normalized, .. } = wanted;
        let key = (wanted.semantic.clone(), morph_target, component as u8, components, normalized);
        *self.0.entry(key).or_insert_with(|| {
            all.push(wanted);
            all.len() - 1
        })
    }
}

fn described(semantic: &Semantic, morph_target: Option<u32>, accessor: &Accessor) -> Attribute {
    Attribute {
        semantic: semantic.clone(),
        morph_target,
        component: accessor.component,
        components: match semantic {
            Semantic::TexCoord(_) => accessor.shape.components().min(2) as u8,
            _ => accessor.shape.components() as u8,
        },
        // Floats are never fractions of anything, whatever the file says.
        normalized: accessor.normalized && accessor.component != Component::F32,
        bytes: Vec::new(),
    }
}

fn extend_with_zeros(
    a: &mut Attribute,
    vertices: usize,
    budget: &Budget,
) -> Result<(), FormatError> {
    let wanted = vertices * a.stride();
    budget.charge((wanted - a.bytes.len()) as u64, 1, "")?;
    a.bytes.resize(wanted, 0);
    Ok(())
}

fn not_finite(bytes: &[u8]) -> usize {
    bytes
        .chunks_exact(4)
        .filter(|b| !f32::from_le_bytes([b[0], b[1], b[2], b[3]]).is_finite())
        .count()
}

/// Drops submeshes without triangles, and streams that no submesh is left to use. Returns which
/// submeshes stay.
fn drop_empty_submeshes(parts: &mut MeshParts) -> Vec<usize> {
    let kept: Vec<usize> =
        (0..parts.submeshes.len()).filter(|&s| parts.submeshes[s].triangle_count > 0).collect();
    if kept.len() == parts.submeshes.len() {
        return kept;
    }
    // Vertices are already gone from submeshes without triangles.
    for s in &mut parts.vertex_submesh {
        *s = kept.binary_search(&(*s as usize)).expect("a vertex is in a submesh with triangles")
            as u32;
    }
    parts.submeshes = kept.iter().map(|&s| std::mem::take(&mut parts.submeshes[s])).collect();
    let mut used = vec![false; parts.attributes.len()];
    for &stream in parts.submeshes.iter().flat_map(|s| &s.attributes) {
        used[stream as usize] = true;
    }
    let streams: Vec<usize> = (0..parts.attributes.len()).filter(|&a| used[a]).collect();
    parts.attributes = streams.iter().map(|&a| parts.attributes[a].clone()).collect();
    for stream in parts.submeshes.iter_mut().flat_map(|s| &mut s.attributes) {
        *stream = streams.binary_search(&(*stream as usize)).expect("it is used") as u32;
    }
    kept
}
