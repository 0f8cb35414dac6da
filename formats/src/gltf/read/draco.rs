//! Decodes primitives that are compressed with Draco into one more buffer, and makes their
//! accessors refer to it, before anything else reads the document.

use crate::gltf::accessor::{component_number, numbered_component};
use crate::gltf::extensions::DRACO;
use crate::gltf::json::{Json, Object, malformed, object};
use crate::gltf::views::{Buffers, put};
use crate::{Fault, FormatError, Limits};
use draco_core::{
    AttributeValueIndex, DataType, DecodeLimits, DecoderBuffer, DracoError, ErrorKind, Mesh,
    MeshDecoder, PointAttribute, PointIndex,
};
use lodc_mesh::Component;

/// Bytes that the streams of any document may decode to, however small it is. Chosen by hand.
const BASE_BYTES: u64 = 32 << 20;
/// Further bytes that they may decode to for each byte of the document and its buffers. Chosen by
/// hand: about twice what streams of large meshes decode to.
const BYTES_PER_BYTE: u64 = 64;
/// Bytes of a decoded triangle (three indices), and of a decoded position (three coordinates).
const ELEMENT_BYTES: u64 = 12;

/// The bytes, views and accessors that decoding adds to a document.
#[derive(Default)]
struct Added {
    bytes: Vec<u8>,
    views: Vec<Json>,
    /// Accessors by the numbers of those that they replace, which nothing else uses.
    replacing: Vec<(usize, Object)>,
    /// Accessors that follow those of the document.
    accessors: Vec<Json>,
}

/// The accessors that a primitive refers to once it is decoded.
struct Decoded {
    attributes: Vec<(String, usize)>,
    indices: Option<usize>,
}

/// Decodes all primitives of which the data is not there uncompressed as well; `input_bytes` is the
/// length of the file and its buffers. Returns the number of bytes that were added to these.
pub(super) fn unpack(
    root: &mut Object,
    buffers: &mut Buffers<'_>,
    limits: &Limits,
    input_bytes: u64,
) -> Result<u64, FormatError> {
    let uses = uses(root);
    let [views, accessors] = ["bufferViews", "accessors"].map(|list| root.entries(list).len());
    let max_bytes = BASE_BYTES.saturating_add(BYTES_PER_BYTE.saturating_mul(input_bytes));
    let (mut added, mut all) = (Added::default(), Vec::new());
    for (m, mesh) in root.entries("meshes").enumerate() {
        let primitives = mesh.list("primitives").iter().filter_map(Json::as_object);
        for (p, primitive) in primitives.enumerate().filter(|(_, p)| is_needed(root, p)) {
            let location = format!("meshes[{m}].primitives[{p}].extensions.{DRACO}");
            let input = Input { root, primitive, buffers, location, views, accessors, uses: &uses };
            all.push((m, p, input.decode(limits, max_bytes, &mut added)?));
        }
    }
    if all.is_empty() {
        return Ok(0);
    }
    let bytes = added.bytes.len() as u64;
    root.append("buffers", vec![object! { "byteLength" => added.bytes.len() }]);
    root.append("bufferViews", added.views);
    for (number, accessor) in added.replacing {
        *entry_mut(root, "accessors", number) = accessor;
    }
    root.append("accessors", added.accessors);
    buffers.push(Some(added.bytes.into()));
    for (mesh, primitive, decoded) in all {
        let primitive = entry_mut(entry_mut(root, "meshes", mesh), "primitives", primitive);
        for (name, accessor) in decoded.attributes {
            primitive["attributes"][&*name] = accessor.into();
        }
        if let Some(accessor) = decoded.indices {
            primitive["indices"] = accessor.into();
        }
    }
    Ok(bytes)
}

/// An entry of a list that has been read.
fn entry_mut<'o>(object: &'o mut Object, list: &str, number: usize) -> &'o mut Object {
    let entries = object.get_mut(list).and_then(Json::as_array_mut);
    let entry = entries.and_then(|entries| entries.get_mut(number)).and_then(Json::as_object_mut);
    entry.expect("it was read")
}

/// An entry of a list of the document; none if it is not there.
fn entry<'o>(root: &'o Object, list: &str, number: usize) -> Option<&'o Object> {
    root.list(list).get(number).and_then(Json::as_object)
}

/// How often primitives refer to each accessor.
fn uses(root: &Object) -> Vec<u32> {
    let mut uses = vec![0; root.entries("accessors").len()];
    let primitives = root.entries("meshes").flat_map(|mesh| mesh.list("primitives"));
    for primitive in primitives.filter_map(Json::as_object) {
        let sets = primitive.get("attributes").into_iter().chain(primitive.list("targets"));
        let named = sets.filter_map(Json::as_object).flat_map(|members| members.values());
        for accessor in named.chain(primitive.get("indices")).filter_map(Json::as_index) {
            uses.get_mut(accessor).into_iter().for_each(|count| *count += 1);
        }
    }
    uses
}

/// Returns whether a primitive is compressed, and its positions or corners are nowhere else.
fn is_needed(root: &Object, primitive: &Object) -> bool {
    let lacks_bytes = |value: Option<&Json>| {
        let accessor = value.and_then(Json::as_index).and_then(|i| entry(root, "accessors", i));
        accessor.is_some_and(|a| !a.contains_key("bufferView"))
    };
    let position = primitive.get("attributes").and_then(|a| a.get("POSITION"));
    primitive.extension(DRACO).is_some()
        && (lacks_bytes(position) || lacks_bytes(primitive.get("indices")))
}

/// A compressed primitive; `views` and `accessors` count those of the document, `uses` says how
/// often each accessor is used.
struct Input<'a> {
    root: &'a Object,
    primitive: &'a Object,
    buffers: &'a Buffers<'a>,
    location: String,
    views: usize,
    accessors: usize,
    uses: &'a [u32],
}

impl Input<'_> {
    /// Decodes it and adds its accessors. All primitives of a document together may decode to
    /// `max_bytes`.
    fn decode(
        &self,
        limits: &Limits,
        max_bytes: u64,
        added: &mut Added,
    ) -> Result<Decoded, FormatError> {
        let location = self.location.as_str();
        let packed = self.primitive.extension(DRACO).expect("only such primitives are decoded");
        if self.primitive.optional("mode", location)?.unwrap_or(4) != 4 {
            let problem = "compresses what is no list of triangles, which is not supported: \
                        decompress it first (gltf-transform copy IN OUT)";
            return Err(FormatError::new(Fault::Unsupported, location, problem));
        }
        let bytes = stream(self.root, packed, self.buffers, location)?;
        let bytes_left = max_bytes.saturating_sub(added.bytes.len() as u64);
        let mesh = decoded(bytes, limits, bytes_left, location)?;
        let mut attributes = Vec::new();
        let named = packed.get("attributes").and_then(Json::as_object);
        for (name, id) in named.into_iter().flat_map(|members| members.iter()) {
            // An attribute that the primitive does not list is not used.
            let number = self.primitive.get("attributes").and_then(|a| a.get(name));
            let Some(number) = number else { continue };
            let wrong = |problem| malformed(format!("{location}.attributes.{name}"), problem);
            let id = id.as_u64().and_then(|id| u32::try_from(id).ok());
            let attribute = id.and_then(|id| mesh.attribute_by_unique_id(id));
            let attribute = attribute.ok_or_else(|| wrong("names nothing in it"))?;
            let component = self.stated(number).and_then(|a| a["componentType"].as_u64());
            let component = component.and_then(numbered_component);
            let data = component.and_then(|c| values(attribute, mesh.num_points(), c));
            let data = data.ok_or_else(|| wrong("has values of another type than its accessor"))?;
            attributes
                .push((name.clone(), self.add(number, None, &data, mesh.num_points(), added)?));
        }
        let corners = mesh.faces().iter().flatten().flat_map(|v| v.0.to_le_bytes());
        let corners: Vec<u8> = corners.collect();
        let add =
            |number| self.add(number, Some(Component::U32), &corners, 3 * mesh.num_faces(), added);
        let indices = self.primitive.get("indices").map(add).transpose()?;
        Ok(Decoded { attributes, indices })
    }

    /// The accessor that the document has under a number.
    fn stated(&self, number: &Json) -> Option<&Object> {
        entry(self.root, "accessors", number.as_index()?)
    }

    /// Adds a copy of the accessor `number` that refers to decoded elements. Returns its number.
    fn add(
        &self,
        number: &Json,
        component: Option<Component>,
        data: &[u8],
        count: usize,
        added: &mut Added,
    ) -> Result<usize, FormatError> {
        let location = self.location.as_str();
        let stated = self.stated(number);
        let stated = stated.ok_or_else(|| malformed(location, "belongs to no accessor"))?;
        let stated_count = stated.required("count", location)?;
        if stated_count != count as u64 {
            let problem = format!("has {count} elements where its accessor has {stated_count}");
            return Err(malformed(location, problem));
        }
        let mut accessor = stated.clone();
        accessor.shift_remove("byteOffset");
        accessor["bufferView"] = (self.views + added.views.len()).into();
        if let Some(component) = component {
            accessor["componentType"] = component_number(component).into();
        }
        let mut view = put(&mut added.bytes, data);
        view["buffer"] = self.buffers.len().into();
        added.views.push(view);
        let number = number.as_index().expect("it stands for an accessor");
        if self.uses[number] == 1 {
            added.replacing.push((number, accessor));
            return Ok(number);
        }
        added.accessors.push(Json::Object(accessor));
        Ok(self.accessors + added.accessors.len() - 1)
    }
}

/// The bytes of a compressed primitive.
fn stream<'b>(
    root: &Object,
    packed: &Object,
    buffers: &'b Buffers<'_>,
    location: &str,
) -> Result<&'b [u8], FormatError> {
    let view = entry(root, "bufferViews", packed.required("bufferView", location)? as usize);
    let view = view.ok_or_else(|| malformed(location, "has a bufferView that is not there"))?;
    let buffer = buffers.get(view.required("buffer", location)? as usize);
    let buffer = buffer.and_then(Option::as_deref);
    let buffer = buffer.ok_or_else(|| malformed(location, "lies in a buffer without bytes"))?;
    let start = view.optional("byteOffset", location)?.unwrap_or(0);
    let end = start.checked_add(view.required("byteLength", location)?);
    let range = end.and_then(|end| Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?));
    let bytes = range.and_then(|range| buffer.get(range));
    bytes.ok_or_else(|| malformed(location, "lies outside its buffer"))
}

/// The mesh in a stream; refused if it takes more than `max_bytes`.
fn decoded(
    bytes: &[u8],
    limits: &Limits,
    max_bytes: u64,
    location: &str,
) -> Result<Mesh, FormatError> {
    let ceilings = DecodeLimits::default()
        .with_max_points(limits.vertices.min(max_bytes / ELEMENT_BYTES))
        .with_max_faces(limits.triangles.min(max_bytes / ELEMENT_BYTES))
        .with_max_decoded_bytes(max_bytes);
    let mut mesh = Mesh::new();
    let mut buffer = DecoderBuffer::new(bytes).with_limits(ceilings);
    let failed = |e: DracoError| match e.kind() {
        ErrorKind::LimitExceeded | ErrorKind::AllocationExceedsInput => {
            let problem =
                format!("unpacks to more than {} MiB, or than limits allow", max_bytes >> 20);
            FormatError::new(Fault::Limit, location, problem)
        }
        _ => malformed(location, format!("cannot be decoded: {}", e.message())),
    };
    MeshDecoder::new().decode(&mut buffer, &mut mesh).map_err(failed)?;
    let points = mesh.num_points() as u32;
    if mesh.faces().iter().flatten().any(|v| v.0 >= points) {
        return Err(malformed(location, "has a corner without a vertex"));
    }
    Ok(mesh)
}

/// The values of all points in the component type of their accessor. None if an integer does not
/// fit it, or only one of the two has floats.
fn values(attribute: &PointAttribute, points: usize, component: Component) -> Option<Vec<u8>> {
    let (kind, count) = (attribute.data_type(), usize::from(attribute.num_components()));
    let (size, data) = (kind.byte_length(), attribute.buffer().data());
    if size == 0 || (kind == DataType::Float32) != (component == Component::F32) {
        return None;
    }
    let mut out = Vec::with_capacity(points * count * component.size());
    for point in 0..points as u32 {
        let AttributeValueIndex(value) = attribute.mapped_index(PointIndex(point));
        let start = usize::try_from(value).ok()?.checked_mul(size * count)?;
        let element = data.get(start..start.checked_add(size * count)?)?;
        if component == Component::F32 {
            out.extend_from_slice(element);
            continue;
        }
        for bytes in element.chunks_exact(size) {
            put_integer(&mut out, integer(bytes, kind)?, component)?;
        }
    }
    Some(out)
}

fn integer(bytes: &[u8], kind: DataType) -> Option<i64> {
    Some(match (kind, bytes) {
        (DataType::Int8, &[a]) => i64::from(a.cast_signed()),
        (DataType::Uint8 | DataType::Bool, &[a]) => i64::from(a),
        (DataType::Int16, &[a, b]) => i64::from(i16::from_le_bytes([a, b])),
        (DataType::Uint16, &[a, b]) => i64::from(u16::from_le_bytes([a, b])),
        (DataType::Int32, &[a, b, c, d]) => i64::from(i32::from_le_bytes([a, b, c, d])),
        (DataType::Uint32, &[a, b, c, d]) => i64::from(u32::from_le_bytes([a, b, c, d])),
        _ => return None,
    })
}

fn put_integer(out: &mut Vec<u8>, value: i64, component: Component) -> Option<()> {
    match component {
        Component::I8 => out.extend(i8::try_from(value).ok()?.to_le_bytes()),
        Component::U8 => out.extend(u8::try_from(value).ok()?.to_le_bytes()),
        Component::I16 => out.extend(i16::try_from(value).ok()?.to_le_bytes()),
        Component::U16 => out.extend(u16::try_from(value).ok()?.to_le_bytes()),
        Component::U32 => out.extend(u32::try_from(value).ok()?.to_le_bytes()),
        Component::F32 => return None,
    }
    Some(())
}
