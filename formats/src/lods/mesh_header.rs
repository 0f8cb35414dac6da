//! The header block of an object: counts, attribute streams, number systems of quantised values and
//! everything else that its decoder needs before the first step.

use crate::{Fault, FormatError};
use lodc_mesh::{Attribute, Component, Submesh, put_leb128, take_leb128};
use lodc_progressive::{MeshHeader, NumberSystem, Octahedral, Prediction, TextCodec, VertexLayout};

mod attribute;
mod systems;

use attribute::{attribute, put_attribute};

const LOCATION: &str = "header of an object";
/// Largest number of bytes of headers that are coded together, before compression; a reader refuses
/// more. Chosen by hand.
const MAX_BYTES: u64 = 1 << 24;
/// Largest number of streams that all submeshes list together; a reader refuses more. Chosen by
/// hand.
const MAX_ENTRIES: usize = 1 << 22;

pub(super) fn malformed(problem: &str) -> FormatError {
    FormatError::new(Fault::Malformed, LOCATION, problem)
}

/// Headers that both sides code before any other, so that the first ones take fewer bytes.
const TYPICAL: &[u8] = include_bytes!("mesh_header/typical_headers.bin");

/// The codec of all headers of a stream.
pub(super) fn codec() -> TextCodec {
    let mut codec = TextCodec::default();
    // Their encoding itself is dropped.
    let _ = codec.encode(TYPICAL);
    codec
}

/// Adds headers, coded together, as a payload has them.
pub(super) fn put(out: &mut Vec<u8>, headers: &[u8], codec: &mut TextCodec) {
    let coded = codec.encode(headers);
    put_leb128(out, headers.len() as u64);
    put_leb128(out, coded.len() as u64);
    out.extend_from_slice(&coded);
}

/// Takes headers that are coded together off the front of a payload.
pub(super) fn take(bytes: &mut &[u8], codec: &mut TextCodec) -> Result<Vec<u8>, FormatError> {
    let short = || malformed("is too short for its content");
    let mut length = || take_leb128(bytes, MAX_BYTES).ok_or_else(short);
    let [plain, coded] = [length()? as usize, length()? as usize];
    let (headers, rest) = bytes.split_at_checked(coded).ok_or_else(short)?;
    *bytes = rest;
    codec.decode(headers, plain).ok_or_else(|| malformed("cannot be decoded"))
}

/// Returns a header before it is coded; `None` if it would be too long.
pub(super) fn plain(mesh: &MeshHeader) -> Option<Vec<u8>> {
    let entries: usize = mesh.submeshes.iter().map(|s| s.attributes.len()).sum();
    let mut out = Vec::new();
    for n in [mesh.vertices, mesh.triangles, mesh.steps, u32::from(mesh.exact)] {
        put_leb128(&mut out, n.into());
    }
    put_leb128(&mut out, mesh.attributes.len() as u64);
    for (i, stream) in mesh.layout.streams.iter().enumerate() {
        // The first stream is positions, which are no attribute.
        if let Some(attribute) = i.checked_sub(1).and_then(|i| mesh.attributes.get(i)) {
            put_attribute(&mut out, attribute);
        }
        let mut systems = &mesh.layout.systems[stream.first_channel..][..stream.channels];
        if let Prediction::Octahedral(Octahedral { bits }) = stream.prediction {
            out.extend([systems::OCTAHEDRAL, bits]);
            systems = &systems[2..];
        }
        systems::put(&mut out, systems);
    }
    put_leb128(&mut out, mesh.submeshes.len() as u64);
    let mut previous: &[u32] = &[];
    for Submesh { attributes, .. } in &mesh.submeshes {
        // 0: the streams of the submesh before; else their number and 1.
        if attributes == previous {
            out.push(0);
            continue;
        }
        put_leb128(&mut out, attributes.len() as u64 + 1);
        attributes.iter().for_each(|&a| put_leb128(&mut out, a.into()));
        previous = attributes;
    }
    (entries <= MAX_ENTRIES && out.len() as u64 <= MAX_BYTES).then_some(out)
}

/// Reads what [`plain`] writes off the front of headers.
pub(super) fn parse(rest: &mut &[u8]) -> Result<MeshHeader, FormatError> {
    let [vertices, triangles, steps] = [number(rest)?, number(rest)?, number(rest)?];
    // Whether steps are in the order of the sequence, a step to a level, or in batches.
    let exact = match number(rest)? {
        0 => false,
        1 => true,
        _ => return Err(malformed("has an unknown order of steps")),
    };
    let count = number(rest)?;
    let mut attributes: Vec<Attribute> = Vec::new();
    let mut systems = systems::take(rest, 3, Component::F32)?;
    let mut octahedral = Vec::new();
    // Each takes bytes, so their number is bounded by those that are there.
    for _ in 0..count {
        let attribute = attribute(rest)?;
        let mut channels = usize::from(attribute.components);
        octahedral.push(systems::take_octahedral(rest, &attribute)?);
        if octahedral.last() != Some(&None) {
            // A direction of three components has two channels.
            systems.extend([NumberSystem::Integer; 2]);
            channels -= 3;
        }
        systems.extend(systems::take(rest, channels, attribute.component)?);
        attributes.push(attribute);
    }
    let layout = VertexLayout { systems, streams: VertexLayout::streams(&attributes, &octahedral) };
    let submeshes = submeshes(rest)?;
    if submeshes.is_empty() && vertices > 0 {
        return Err(malformed("has vertices without a submesh"));
    }
    Ok(MeshHeader { submeshes, attributes, layout, vertices, triangles, steps, exact })
}

/// Checks that nothing follows the last header.
pub(super) fn check_end(rest: &[u8]) -> Result<(), FormatError> {
    if rest.is_empty() { Ok(()) } else { Err(malformed("has extra bytes at its end")) }
}

fn submeshes(rest: &mut &[u8]) -> Result<Vec<Submesh>, FormatError> {
    let count = number(rest)?;
    let (mut submeshes, mut previous) = (Vec::new(), Vec::new());
    let mut entries = 0;
    for _ in 0..count {
        if let Some(streams) = number(rest)?.checked_sub(1) {
            previous = (0..streams).map(|_| number(rest)).collect::<Result<_, _>>()?;
        }
        // A byte can repeat a list of any length.
        entries += previous.len();
        if entries > MAX_ENTRIES {
            let problem = format!("has more than {MAX_ENTRIES} streams of submeshes");
            return Err(FormatError::new(Fault::Limit, LOCATION, problem));
        }
        submeshes.push(Submesh { attributes: previous.clone(), ..Submesh::default() });
    }
    Ok(submeshes)
}

/// Takes a number below 2^32 off the front.
fn number(bytes: &mut &[u8]) -> Result<u32, FormatError> {
    let number = take_leb128(bytes, u64::from(u32::MAX));
    number.map(|n| n as u32).ok_or_else(|| malformed("has an invalid number"))
}

/// Takes a byte off the front.
fn byte(bytes: &mut &[u8]) -> Result<u8, FormatError> {
    let (&first, rest) =
        bytes.split_first().ok_or_else(|| malformed("is too short for its content"))?;
    *bytes = rest;
    Ok(first)
}
