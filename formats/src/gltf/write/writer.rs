//! Builds accessors, buffer views and the binary buffer of an exported glTF: one buffer view for
//! each stride and index type or, where they are compressed (meshopt), one for each attribute
//! stream.

use super::buffers::VertexBuffers;
use super::compressed::Compressed;
use super::differences::{Deltas, MovedStreams, differences};
use super::samples::{self, Samples};
use crate::gltf::accessor::{Shape, component_number};
use crate::gltf::extensions::unknown;
use crate::gltf::json::{Json, Object, malformed, object};
use crate::gltf::meshopt::Content;
use crate::gltf::schema::{Pool, referenced, retain};
use crate::gltf::semantic;
use crate::gltf::views::put;
use crate::options::ExportOptions;
use crate::{Fault, FormatError};
use lodc_mesh::{Attribute, Component, Mesh, Semantic};
use std::collections::BTreeMap;
use std::ops::Range;
use xxhash_rust::xxh3::xxh3_64;

/// Target of views with vertex attributes (glTF 2.0).
const ARRAY_BUFFER: u32 = 34962;
/// Target of views with indices (glTF 2.0).
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// Stands for the missing target of views that no draw call reads: numbers of sparse accessors,
/// samples.
const NO_TARGET: u32 = 0;

/// A buffer view being filled.
#[derive(Debug)]
struct Group {
    target: u32,
    /// The stream, where each has a view of its own; else empty.
    name: String,
    /// Bytes from one element to the next; of indices the size of one.
    stride: usize,
    /// The type of the first stream in it.
    component: Component,
    bytes: Vec<u8>,
}

impl Group {
    /// Its bytes as the codecs see them; `direction_bits` is what unit vectors were rounded to.
    fn content(&self, direction_bits: Option<u8>) -> Content<'_> {
        let (stride, bytes) = (self.stride, &self.bytes[..]);
        match (self.target, direction_bits, &self.name[..]) {
            (ARRAY_BUFFER, Some(bits), "NORMAL" | "TANGENT") => {
                Content::Directions { bits, stride, bytes }
            }
            (ARRAY_BUFFER | NO_TARGET, ..) if self.component == Component::F32 => {
                Content::Floats { stride, bytes }
            }
            (ARRAY_BUFFER | NO_TARGET, ..) => Content::Attributes { stride, bytes },
            _ => Content::Triangles { size: stride, bytes },
        }
    }
}

/// Collects accessors and their data.
#[derive(Debug)]
pub(super) struct Writer {
    first_accessor: usize,
    first_view: usize,
    accessors: Vec<Json>,
    groups: Vec<Group>,
    /// Streams and indices by view and hash of their bytes: where each begins, and its accessor.
    /// What meshes have in common is stored once.
    stored: BTreeMap<(usize, u64), Vec<(usize, usize)>>,
    /// Sparse accessors of `accessors`, and the numbers of the elements that they replace.
    sparse: Vec<(usize, Vec<u32>)>,
    compress: bool,
    direction_bits: Option<u8>,
}

impl Writer {
    /// A writer whose accessors follow those of the document.
    pub(super) fn new(root: &Object, options: &ExportOptions) -> Self {
        Self {
            compress: options.compress,
            direction_bits: options.precision.normal,
            first_accessor: Pool::Accessors.len(root),
            first_view: Pool::BufferViews.len(root),
            accessors: Vec::new(),
            groups: Vec::new(),
            stored: BTreeMap::new(),
            sparse: Vec::new(),
        }
    }

    /// Starts a mesh whose primitives have these buffers.
    pub(super) fn mesh_writer<'w>(
        &'w mut self,
        mesh: &'w Mesh,
        buffers: VertexBuffers,
    ) -> MeshWriter<'w> {
        let (written, targets) = (BTreeMap::new(), BTreeMap::new());
        MeshWriter { writer: self, mesh, buffers, written, targets }
    }

    /// Puts accessors, buffer views and the buffer into the document, and the data behind what
    /// `blob` holds.
    pub(super) fn finish(mut self, root: &mut Object, blob: &mut Vec<u8>) {
        self.number_elements();
        let mut views = Vec::with_capacity(self.groups.len());
        let mut compressed = Compressed::new(root);
        // Views that an unknown extension may name keep their numbers.
        let rewrites = self.compress && unknown(root).is_none();
        let samples = if rewrites { samples::of(root, blob) } else { vec![] };
        for (samples, i) in samples.iter().zip(self.first_view + self.groups.len()..) {
            samples.refer_to(root, i);
        }
        let used = referenced(root, Pool::BufferViews);
        if !samples.is_empty() {
            samples::drop_unused(root, blob, &used);
        }
        for group in self.groups {
            let (content, length) = (group.content(self.direction_bits), group.bytes.len());
            let mut view = if self.compress && content.fits() {
                compressed.view(&content, length, blob)
            } else {
                put(blob, &group.bytes)
            };
            if group.target == ARRAY_BUFFER {
                view["byteStride"] = group.stride.into();
            }
            if group.target != NO_TARGET {
                view["target"] = group.target.into();
            }
            views.push(view);
        }
        for Samples { stride, bytes, .. } in &samples {
            let content = Content::Floats { stride: *stride, bytes };
            views.push(compressed.view(&content, bytes.len(), blob));
        }
        root.append("accessors", self.accessors);
        root.append("bufferViews", views);
        if !samples.is_empty() {
            let new = Pool::BufferViews.len(root) - self.first_view;
            retain(root, Pool::BufferViews, &[used, vec![true; new]].concat());
        }
        if blob.is_empty() {
            return;
        }
        if root.list("buffers").is_empty() {
            root["buffers"] = [object! {}].into();
        }
        if let Some(buffer) = root.objects_mut("buffers").next() {
            buffer["byteLength"] = blob.len().into();
        }
        compressed.finish(root);
    }

    /// The number of the view of this kind and its bytes so far, padded to a multiple of four.
    /// Indices that will be compressed follow each other without gaps.
    fn group(
        &mut self,
        target: u32,
        component: Component,
        stride: usize,
        name: &str,
    ) -> (usize, &mut Vec<u8>) {
        let name = if self.compress { name } else { "" };
        let same_kind = |g: &Group| g.target == target && g.stride == stride && g.name == name;
        let i = self.groups.iter().position(same_kind).unwrap_or_else(|| {
            let (name, bytes) = (name.to_owned(), Vec::new());
            self.groups.push(Group { target, name, stride, component, bytes });
            self.groups.len() - 1
        });
        let bytes = &mut self.groups[i].bytes;
        if !self.compress || target == ARRAY_BUFFER {
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        (self.first_view + i, bytes)
    }

    fn accessor(&mut self, accessor: Json) -> Json {
        self.accessors.push(accessor);
        (self.first_accessor + self.accessors.len() - 1).into()
    }

    /// Vertex data: the elements of a stream in the given order.
    pub(super) fn stream(&mut self, a: &Attribute, vertices: &[u32]) -> Result<Json, FormatError> {
        let name = semantic::to_name(&a.semantic);
        let Some((shape, kind)) = Shape::of_components(usize::from(a.components)) else {
            let problem = format!("glTF has no type of {} components", a.components);
            return Err(FormatError::new(Fault::Unsupported, name, problem));
        };
        let column_bytes = shape.rows * a.component.size();
        let column_stride = shape.column_stride(a.component);
        let stride = (shape.columns * column_stride).next_multiple_of(4);
        let (view, bytes) = self.group(ARRAY_BUFFER, a.component, stride, &name);
        let offset = bytes.len();
        bytes.reserve(vertices.len() * stride);
        for &v in vertices {
            let start = bytes.len();
            for (i, column) in a.at(v).chunks_exact(column_bytes).enumerate() {
                bytes.resize(start + i * column_stride, 0);
                bytes.extend_from_slice(column);
            }
            bytes.resize(start + stride, 0);
        }
        let mut accessor = object! { "componentType" => component_number(a.component) };
        if a.normalized {
            accessor["normalized"] = true.into();
        }
        accessor["count"] = vertices.len().into();
        accessor["type"] = kind.into();
        if a.semantic == Semantic::Position {
            let (min, max) = bounds(a, vertices);
            accessor["min"] = min.into();
            accessor["max"] = max.into();
        }
        Ok(self.once(view, offset, &accessor))
    }

    /// An accessor of the bytes from `offset` to the end of a view, or the one that has the same
    /// bytes in it already.
    fn once(&mut self, view: usize, offset: usize, accessor: &Json) -> Json {
        let placed = |offset: usize| {
            let mut placed = object! { "bufferView" => view };
            if offset > 0 {
                placed["byteOffset"] = offset.into();
            }
            for (key, value) in accessor.as_object().into_iter().flat_map(|all| all.iter()) {
                placed[&**key] = value.clone();
            }
            placed
        };
        let bytes = &mut self.groups[view - self.first_view].bytes;
        let (before, new) = bytes.split_at(offset);
        let known = self.stored.entry((view, xxh3_64(new))).or_default();
        let same = |&&(start, number): &&(usize, usize)| {
            before.get(start..start + new.len()) == Some(new)
                && self.accessors[number] == placed(start)
        };
        if let Some(&(_, number)) = known.iter().find(same) {
            bytes.truncate(offset);
            return (self.first_accessor + number).into();
        }
        known.push((offset, self.accessors.len()));
        self.accessor(placed(offset))
    }

    /// Puts bytes of sparse elements or samples into a view of their kind; returns a reference with
    /// the view and the offset in it.
    fn put(&mut self, name: &str, component: Component, stride: usize, values: &[u8]) -> Json {
        let (view, bytes) = self.group(NO_TARGET, component, stride, name);
        let offset = bytes.len();
        bytes.extend_from_slice(values);
        let mut reference = object! { "bufferView" => view };
        if offset > 0 {
            reference["byteOffset"] = offset.into();
        }
        reference
    }

    /// An accessor of single floats, of which there is one at least.
    pub(super) fn scalars(&mut self, name: &str, values: &[f32]) -> Json {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let mut accessor = self.put(name, Component::F32, Component::F32.size(), &bytes);
        accessor["componentType"] = component_number(Component::F32).into();
        accessor["count"] = values.len().into();
        accessor["type"] = "SCALAR".into();
        self.accessor(accessor)
    }

    /// An accessor of `count` elements of which only those in `run` may differ from 0; `deltas` has
    /// the values of these.
    pub(super) fn deltas(&mut self, deltas: &Deltas, run: Range<u32>, count: usize) -> Json {
        let Deltas { name, components, values } = deltas;
        let kind = Shape::of_components(*components).map_or("SCALAR", |(_, kind)| kind);
        let mut accessor = object! {
            "componentType" => component_number(Component::F32), "count" => count, "type" => kind,
        };
        if name == "POSITION" {
            let at_rest = if run.len() < count { 0.0 } else { f32::NAN };
            let extreme = |c: usize, larger: fn(f32, f32) -> f32| -> Json {
                let all = values.iter().skip(c).step_by(*components).copied();
                f64::from(all.fold(at_rest, larger)).into()
            };
            accessor["min"] = (0..*components).map(|c| extreme(c, f32::min)).collect();
            accessor["max"] = (0..*components).map(|c| extreme(c, f32::max)).collect();
        }
        let elements: Vec<(u32, &[f32])> = run.zip(values.chunks_exact(*components)).collect();
        let moving = elements.iter().filter(|(_, value)| value.iter().any(|&v| v != 0.0));
        let moving: Vec<(u32, &[f32])> = moving.copied().collect();
        let stride = components * Component::F32.size();
        // The numbers of a run take next to no bytes; those of scattered elements take four each.
        let number_size = Component::U32.size();
        let is_smaller = moving.len() * (stride + number_size) < elements.len() * stride;
        let chosen = if is_smaller { moving } else { elements };
        let bytes = chosen.iter().flat_map(|(_, value)| *value).flat_map(|v| v.to_le_bytes());
        let bytes: Vec<u8> = bytes.collect();
        let numbers = chosen.iter().map(|(number, _)| *number).collect();
        self.sparse(accessor, name, (Component::F32, stride), &bytes, numbers)
    }

    /// A copy of the accessor `base` in which a run of elements is replaced by a stream's values at
    /// `vertices`.
    pub(super) fn replaced(
        &mut self,
        base: &Json,
        a: &Attribute,
        vertices: &[u32],
        run: Range<u32>,
    ) -> Json {
        let number = base.as_index().map_or(0, |number| number - self.first_accessor);
        let accessor = self.accessors[number].clone();
        let bytes: Vec<u8> = vertices.iter().flat_map(|&v| a.at(v).iter().copied()).collect();
        let name = semantic::to_name(&a.semantic);
        self.sparse(accessor, &name, (a.component, a.stride()), &bytes, run.collect())
    }

    /// Adds `accessor` with other values, `stride` bytes each, for the elements of these numbers.
    fn sparse(
        &mut self,
        mut accessor: Json,
        name: &str,
        (component, stride): (Component, usize),
        bytes: &[u8],
        numbers: Vec<u32>,
    ) -> Json {
        if !numbers.is_empty() {
            let values = self.put(name, component, stride, bytes);
            accessor["sparse"] = object! { "count" => numbers.len(), "values" => values };
            self.sparse.push((self.accessors.len(), numbers));
        }
        self.accessor(accessor)
    }

    /// Writes the numbers of the elements of sparse accessors. Runs of consecutive numbers are
    /// parts of one list of consecutive numbers, which is stored once.
    fn number_elements(&mut self) {
        let all = std::mem::take(&mut self.sparse);
        let is_run = |numbers: &[u32]| match numbers {
            [first, .., last] => (last - first) as usize + 1 == numbers.len(),
            _ => true,
        };
        let ends = |numbers: &Vec<u32>| Some([*numbers.first()?, *numbers.last()?]);
        let largest = all.iter().filter_map(|(_, n)| ends(n)).map(|[_, last]| last).max();
        let Some(largest) = largest else { return };
        // The codec of elements of four bytes makes next to nothing of consecutive numbers.
        let wide = self.compress || largest > u32::from(u16::MAX);
        let component = if wide { Component::U32 } else { Component::U16 };
        let size = component.size();
        let bytes = |numbers: &mut dyn Iterator<Item = u32>| -> Vec<u8> {
            numbers.flat_map(|i| i.to_le_bytes().into_iter().take(size)).collect()
        };
        let runs = all.iter().filter(|(_, numbers)| is_run(numbers));
        let runs: Vec<[u32; 2]> = runs.filter_map(|(_, numbers)| ends(numbers)).collect();
        let first = runs.iter().map(|[first, _]| *first).min().unwrap_or(0);
        let end = runs.iter().map(|[_, last]| last + 1).max().unwrap_or(first);
        let list = self.put("numbers", component, size, &bytes(&mut (first..end)));
        let list_offset = list["byteOffset"].as_index().unwrap_or(0);
        for (accessor, numbers) in all {
            let mut reference = if is_run(&numbers) {
                let offset = list_offset + (numbers[0] - first) as usize * size;
                object! { "bufferView" => list["bufferView"].clone(), "byteOffset" => offset }
            } else {
                self.put("numbers", component, size, &bytes(&mut numbers.into_iter()))
            };
            reference["componentType"] = component_number(component).into();
            self.accessors[accessor]["sparse"]["indices"] = reference;
        }
    }

    fn indices(&mut self, indices: &[u32], vertices: usize) -> Json {
        // The largest number of each type is reserved, so one vertex less than fits.
        let short = u16::try_from(vertices).is_ok();
        let component = if short { Component::U16 } else { Component::U32 };
        let (view, bytes) = self.group(ELEMENT_ARRAY_BUFFER, component, component.size(), "");
        let offset = bytes.len();
        bytes.extend(
            indices.iter().flat_map(|i| i.to_le_bytes().into_iter().take(component.size())),
        );
        let accessor = object! {
            "componentType" => component_number(component), "count" => indices.len(),
            "type" => "SCALAR",
        };
        self.once(view, offset, &accessor)
    }
}

/// One mesh being written.
#[derive(Debug)]
pub(super) struct MeshWriter<'w> {
    writer: &'w mut Writer,
    mesh: &'w Mesh,
    buffers: VertexBuffers,
    /// Attributes and morph targets of the buffers that are written.
    written: BTreeMap<usize, (Object, Vec<Object>)>,
    /// By buffer and level the morph target that moves it to the next level, and the attributes
    /// that are replaced there.
    targets: BTreeMap<(usize, usize), (Object, Object)>,
}

impl MeshWriter<'_> {
    /// Puts the triangles of a submesh into a primitive; false if there are none.
    pub(super) fn primitive(
        &mut self,
        s: usize,
        primitive: &mut Object,
    ) -> Result<bool, FormatError> {
        let submesh = &self.mesh.submeshes()[s];
        if submesh.triangle_count == 0 {
            return Ok(false);
        }
        self.attributes(s, primitive)?;
        let numbers = self.numbers(self.mesh.triangles()[submesh.triangles()].as_flattened());
        primitive["indices"] = self.indices(s, &numbers);
        Ok(true)
    }

    /// Puts the streams of a submesh's buffer into a primitive.
    pub(super) fn attributes(
        &mut self,
        submesh: usize,
        primitive: &mut Object,
    ) -> Result<(), FormatError> {
        let buffer = self.buffers.of_submesh(submesh);
        let target_count = primitive.list("targets").len();
        let (attributes, targets) = match self.written.get(&buffer) {
            Some(written) if written.1.len() == target_count => written.clone(),
            _ => {
                let written = self.streams(submesh, target_count)?;
                self.written.insert(buffer, written.clone());
                written
            }
        };
        primitive["attributes"] = Json::Object(attributes);
        if target_count > 0 {
            primitive["targets"] = targets.into_iter().map(Json::Object).collect();
        }
        Ok(())
    }

    /// Writes the streams of a submesh's buffer; returns the attributes at rest and of each morph
    /// target.
    fn streams(
        &mut self,
        submesh: usize,
        target_count: usize,
    ) -> Result<(Object, Vec<Object>), FormatError> {
        let vertices = self.buffers.vertices(submesh);
        let mesh = self.mesh;
        let submesh = &mesh.submeshes()[submesh];
        let mut attributes = Object::default();
        let mut targets: Vec<Object> = vec![Object::default(); target_count];
        let streams = || submesh.attributes.iter().map(|&a| &mesh.attributes()[a as usize]);
        if !streams().any(|a| a.semantic == Semantic::Position && a.morph_target.is_none()) {
            // Of these vertices alone: a mesh may have thousands of submeshes.
            let positions: Vec<[f32; 3]> =
                vertices.iter().map(|&v| mesh.positions()[v as usize]).collect();
            let order: Vec<u32> = (0..positions.len() as u32).collect();
            let stream = semantic::positions(&positions);
            attributes["POSITION"] = self.writer.stream(&stream, &order)?;
        }
        for a in streams() {
            let accessor = self.writer.stream(a, vertices)?;
            let name = semantic::to_name(&a.semantic);
            let members = match a.morph_target {
                None => &mut attributes,
                Some(t) => targets.get_mut(t as usize).ok_or_else(|| {
                    malformed(&*name, format!("belongs to morph target {t}, which is not there"))
                })?,
            };
            members.insert(name, accessor);
        }
        Ok((attributes, targets))
    }

    /// The morph target that moves the vertices of a submesh's buffer that disappear with a level
    /// to where they are in `next`, and the attributes that are replaced because these take over
    /// joints and weights from there.
    pub(super) fn target(
        &mut self,
        submesh: usize,
        level: usize,
        (next, moved_streams): (&Mesh, MovedStreams),
        attributes: &Json,
    ) -> (Object, Object) {
        let buffer = (self.buffers.of_submesh(submesh), level);
        if let Some(written) = self.targets.get(&buffer) {
            return written.clone();
        }
        let (mut target, mut replaced) = (Object::default(), Object::default());
        let vertices = self.buffers.vertices(submesh);
        let run = self.buffers.run(submesh, level);
        let range = run.start as u32..run.end as u32;
        let moving = &vertices[run];
        for deltas in differences(self.mesh, next, submesh, moving, moved_streams) {
            let accessor = self.writer.deltas(&deltas, range.clone(), vertices.len());
            target.insert(deltas.name, accessor);
        }
        let streams = next.submeshes()[submesh].attributes.iter();
        for a in streams.map(|&a| &next.attributes()[a as usize]) {
            let is_joint = matches!(a.semantic, Semantic::Joints(_) | Semantic::Weights(_));
            if moved_streams.joints && is_joint && !moving.is_empty() {
                let name = semantic::to_name(&a.semantic);
                let accessor = self.writer.replaced(&attributes[&*name], a, moving, range.clone());
                replaced.insert(name, accessor);
            }
        }
        self.targets.insert(buffer, (target.clone(), replaced.clone()));
        (target, replaced)
    }

    /// Corners of triangles as indices into the buffer of their submesh.
    pub(super) fn numbers(&self, corners: &[u32]) -> Vec<u32> {
        self.buffers.indices(corners)
    }

    /// An accessor of indices into a submesh's buffer.
    pub(super) fn indices(&mut self, submesh: usize, indices: &[u32]) -> Json {
        self.writer.indices(indices, self.buffers.vertices(submesh).len())
    }
}

/// Smallest and largest of each component as they are stored: integers stay integers even where
/// they mean fractions.
fn bounds(a: &Attribute, vertices: &[u32]) -> (Vec<Json>, Vec<Json>) {
    let mut one = Attribute { normalized: false, ..a.described() };
    let mut lo = vec![f32::INFINITY; usize::from(a.components)];
    let mut hi = vec![f32::NEG_INFINITY; usize::from(a.components)];
    for &v in vertices {
        one.bytes.clear();
        one.bytes.extend_from_slice(a.at(v));
        for c in 0..lo.len() {
            let value = one.value(0, c);
            lo[c] = lo[c].min(value);
            hi[c] = hi[c].max(value);
        }
    }
    let number = |v: f32| {
        if a.component == Component::F32 { f64::from(v).into() } else { (v as i64).into() }
    };
    (lo.into_iter().map(number).collect(), hi.into_iter().map(number).collect())
}
