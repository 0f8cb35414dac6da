//! One LOD everywhere: the lists of collapses, made once, and one shader for each change.

use crate::file::Mapped;
use crate::gpu::Gpu;

/// Words of a vertex record: a position. With attributes, records are interleaved and longer.
pub(crate) const STRIDE: u32 = 3;

/// The buffers of a draw: records, an index buffer over them, and five words for each submesh.
pub(crate) struct OnDevice {
    pub(crate) vertices: wgpu::Buffer,
    pub(crate) indices: wgpu::Buffer,
    pub(crate) draws: wgpu::Buffer,
    pub(crate) submeshes: u32,
}

impl OnDevice {
    /// Triangles that are drawn. An engine need not know.
    pub(crate) fn triangles(&self, gpu: &Gpu) -> u32 {
        let draws = gpu.read(&self.draws);
        let words: &[u32] = bytemuck::cast_slice(&draws);
        words.chunks(5).map(|draw| draw[0] / 3).sum()
    }
}

/// An object whose level is one everywhere.
pub(crate) struct Levels {
    source: wgpu::Buffer,
    offsets: wgpu::Buffer,
    entries: wgpu::Buffer,
    current: wgpu::Buffer,
    error_flag: wgpu::Buffer,
    submeshes: wgpu::Buffer,
    drawn: OnDevice,
    lod: u32,
}

impl Levels {
    /// Uploads the file's sections and makes the lists.
    pub(crate) fn new(gpu: &Gpu, file: &Mapped<'_>) -> Self {
        let v = file.mesh().vertex_count();
        let (records, targets) = (file.collapses().records(), file.collapses().targets());
        // Lengths of the lists: an entry, and one more than its target's list has.
        let mut lengths = vec![1u32; v];
        for i in (0..records as usize).rev() {
            lengths[i] = 1 + lengths[targets[i] as usize];
        }
        let longest = lengths.iter().copied().max().unwrap_or(1);
        let entries = lengths.iter().map(|&l| l as usize).sum();

        // [upload]
        let source = gpu.buffer(file.bytes(b"POSI"));
        let triangles = gpu.buffer(file.bytes(b"TRIS"));
        let collapse_to = gpu.buffer(file.bytes(b"TARG"));
        // [/upload]
        let levels = Self {
            offsets: gpu.zeros(v + 1),
            entries: gpu.zeros(entries),
            current: gpu.zeros(v),
            error_flag: gpu.zeros(1),
            submeshes: gpu.words(&file.ranges()),
            drawn: OnDevice {
                vertices: gpu.buffer(file.bytes(b"POSI")),
                indices: triangles,
                draws: gpu.zeros(5 * file.mesh().submeshes().len()),
                submeshes: file.mesh().submeshes().len() as u32,
            },
            source,
            lod: 0,
        };
        // [construction]
        let Self { offsets, entries, current, error_flag, .. } = &levels;
        let parameters = [v as u32, records, longest];
        gpu.run("lists_length", &[], v + 1, &parameters, &[&collapse_to, offsets, error_flag]);
        gpu.scan(offsets, v + 1);
        let buffers = [&collapse_to, offsets, entries, current];
        gpu.run("lists_fill", &[], v, &[v as u32], &buffers);
        // [/construction]
        levels
    }

    /// Shows a LOD, any distance away, coarser or finer.
    pub(crate) fn show(&mut self, gpu: &Gpu, lod: u32) {
        let Self { source, offsets, entries, current, error_flag, submeshes, drawn, .. } = self;
        let OnDevice { vertices, indices, draws, submeshes: count } = drawn;
        // [extraction]
        let touched = self.lod.max(lod);
        let buffers = [&*offsets, entries, source, current, vertices, error_flag];
        gpu.run("extract", &[], touched as usize, &[touched, lod, STRIDE], &buffers);
        let buffers = [&*submeshes, indices, vertices, draws];
        gpu.run("live", &[], *count as usize, &[*count, STRIDE], &buffers);
        // [/extraction]
        self.lod = lod;
    }

    pub(crate) fn drawn(&self) -> &OnDevice {
        &self.drawn
    }
}
