//! Attribute sections of a `.lodc`: a stream is stored for the vertices of the submeshes that have
//! it, and filled with zeros for the others when it is read.

use super::arrays;
use crate::{Fault, FormatError};
use lodc_mesh::{Attribute, Csr, Mesh};
use lodc_model::Layout;
use std::borrow::Cow;

/// Counts the zero bytes of attribute streams that a file leaves out, up to a bound: without it a
/// small file could ask for any amount of memory.
#[derive(Debug, Default)]
pub(super) struct OmittedZeros {
    /// Zero bytes left out so far.
    left_out: u64,
    /// Bytes that are stored; each allows two zeros more.
    stored: u64,
}

impl OmittedZeros {
    /// Zeros that any file may leave out, however small it is. Chosen by hand.
    const FREE_ZEROS: u64 = 32 << 20;

    /// With the bound for a file of `bytes` bytes.
    pub(super) fn of_file(bytes: usize) -> Self {
        Self { left_out: 0, stored: bytes as u64 }
    }

    /// Returns whether `zeros` more zeros can be left out.
    pub(super) fn take(&mut self, zeros: u64) -> bool {
        let fits = self.left_out.saturating_add(zeros)
            <= Self::FREE_ZEROS.saturating_add(self.stored.saturating_mul(2));
        if fits {
            self.left_out += zeros;
        }
        fits
    }
}

/// What is stored of the streams of a mesh.
#[derive(Debug)]
pub(super) struct Plan {
    /// For each stream whether it is stored for all vertices, as all are that a device may be
    /// given.
    pub(super) full: Vec<bool>,
    /// The submeshes that have each stream.
    users: Csr,
    submeshes: usize,
}

impl Plan {
    /// For each submesh whether it has a stream.
    fn has(&self, stream: usize) -> Vec<bool> {
        let mut has = vec![false; self.submeshes];
        self.users.row(stream as u32).iter().for_each(|&submesh| has[submesh as usize] = true);
        has
    }
}

/// Decides what is stored of the streams of a mesh.
pub(super) fn plan(mesh: &Mesh, layout: Layout, budget: &mut OmittedZeros) -> Plan {
    let (users, submeshes) = (mesh.users_of_streams(), mesh.submeshes().len());
    let mut plan = Plan { full: Vec::new(), users, submeshes };
    let full = |(i, stream): (usize, &Attribute)| {
        let has = plan.has(i);
        let (mut zeros, mut only_zeros) = (0, true);
        for (v, bytes) in stream.bytes.chunks_exact(stream.stride()).enumerate() {
            if !has[mesh.vertex_submesh()[v] as usize] {
                zeros += bytes.len() as u64;
                only_zeros &= bytes.iter().all(|&b| b == 0);
            }
        }
        let full = layout == Layout::Gpu || zeros == 0 || !only_zeros || !budget.take(zeros);
        // A reader's budget grows by twice the file's bytes, which are at least those stored here.
        budget.stored += stream.bytes.len() as u64 - if full { 0 } else { zeros };
        full
    };
    plan.full = mesh.attributes().iter().enumerate().map(full).collect();
    plan
}

/// Bytes of a vertex in the gpu layout are a multiple of this, as vertex buffers ask.
const DEVICE_STRIDE: usize = 4;

/// Appends a stream as planned.
pub(super) fn put(out: &mut Vec<u8>, mesh: &Mesh, stream: usize, plan: &Plan, layout: Layout) {
    let attribute = &mesh.attributes()[stream];
    if layout == Layout::Gpu && !attribute.stride().is_multiple_of(DEVICE_STRIDE) {
        let padding = attribute.stride().next_multiple_of(DEVICE_STRIDE) - attribute.stride();
        for bytes in attribute.bytes.chunks_exact(attribute.stride()) {
            out.extend_from_slice(bytes);
            out.extend_from_slice(&[0; DEVICE_STRIDE][..padding]);
        }
        return;
    }
    if plan.full[stream] {
        out.extend_from_slice(&attribute.bytes);
        return;
    }
    let has = plan.has(stream);
    for (bytes, &submesh) in
        attribute.bytes.chunks_exact(attribute.stride()).zip(mesh.vertex_submesh())
    {
        if has[submesh as usize] {
            out.extend_from_slice(bytes);
        }
    }
}

/// A stream of the gpu layout without the padding behind each vertex.
pub(super) fn without_padding(
    stored: &[u8],
    stride: usize,
    location: impl Fn() -> String,
) -> Result<Cow<'_, [u8]>, FormatError> {
    let padded = stride.next_multiple_of(DEVICE_STRIDE);
    if padded == stride {
        return Ok(Cow::Borrowed(stored));
    }
    arrays::check_whole_entries(stored, padded, &location)?;
    let vertices = stored.chunks_exact(padded);
    if vertices.clone().any(|vertex| vertex[stride..].iter().any(|&b| b != 0)) {
        let problem = "has padding behind a vertex that is not zero";
        return Err(FormatError::new(Fault::Malformed, location(), problem));
    }
    Ok(vertices.flat_map(|vertex| &vertex[..stride]).copied().collect())
}

/// The vertices of a mesh, and which of them have a stream.
pub(super) struct StreamVertices<'a> {
    /// For each submesh whether it has the stream.
    pub(super) has: &'a [bool],
    pub(super) vertex_submesh: &'a [u32],
}

/// A stream for all vertices: the stored bytes for those that have it, zeros for the others.
pub(super) fn with_zeros(
    stored: &[u8],
    stride: usize,
    vertices: &StreamVertices<'_>,
    budget: &mut OmittedZeros,
    location: impl Fn() -> String,
) -> Result<Vec<u8>, FormatError> {
    let StreamVertices { has, vertex_submesh } = *vertices;
    // Submeshes that are not there are refused with the mesh.
    let has = |submesh: u32| has.get(submesh as usize).copied().unwrap_or_default();
    let present = vertex_submesh.iter().filter(|&&s| has(s)).count();
    if stored.len() as u64 != present as u64 * stride as u64 {
        let problem =
            format!("{} bytes are not {stride} for each of {present} vertices", stored.len());
        return Err(FormatError::new(Fault::Malformed, location(), problem));
    }
    let all = vertex_submesh.len() as u64 * stride as u64;
    if !budget.take(all - stored.len() as u64) {
        let problem = "leaves out more zeros than a file of this size may";
        return Err(FormatError::new(Fault::Limit, location(), problem));
    }
    let mut bytes = vec![0; all as usize];
    let mut stored = stored.chunks_exact(stride);
    for (slot, &submesh) in bytes.chunks_exact_mut(stride).zip(vertex_submesh) {
        if has(submesh)
            && let Some(value) = stored.next()
        {
            slot.copy_from_slice(value);
        }
    }
    Ok(bytes)
}
