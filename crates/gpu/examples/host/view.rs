//! A LOD for every part of the surface, by the error that it makes on the screen.

use crate::file::Mapped;
use crate::gpu::Gpu;
use crate::levels::{OnDevice, STRIDE};
use lodc_lod::interactive::view::{Point, Views};
use lodc_plan::VertexRecords;

/// Triangles that a thread of the filter looks at.
const EIGHT: usize = 8;

/// An object whose level depends on the view.
pub(crate) struct ByView {
    points: wgpu::Buffer,
    links: wgpu::Buffer,
    by_error: wgpu::Buffer,
    lowest: u32,
    source: wgpu::Buffer,
    triangles: wgpu::Buffer,
    live: wgpu::Buffer,
    places: wgpu::Buffer,
    submeshes: wgpu::Buffer,
    drawn: OnDevice,
    vertices: usize,
    eights: usize,
    scale: f32,
}

impl ByView {
    pub(crate) fn new(gpu: &Gpu, file: &Mapped<'_>) -> Self {
        let mesh = file.mesh();
        let (v, f) = (mesh.vertex_count(), mesh.triangles().len());
        let views = Views::new(file.simplified(), VertexRecords::positions(mesh));
        let points: Vec<u32> = views.points().iter().flat_map(Point::words).collect();
        let (by_error, lowest) = views.by_error();
        let eights = f.div_ceil(EIGHT);
        // Zeros behind the triangles, so that the last eight are whole.
        let mut padded = file.bytes(b"TRIS").to_vec();
        padded.resize(12 * EIGHT * eights, 0);
        Self {
            points: gpu.words(&points),
            links: gpu.words(views.links().as_flattened()),
            by_error: gpu.words(by_error),
            lowest,
            source: gpu.buffer(file.bytes(b"POSI")),
            triangles: gpu.buffer(&padded),
            live: gpu.zeros(eights),
            places: gpu.zeros(eights + 1),
            submeshes: gpu.words(&file.ranges()),
            drawn: OnDevice {
                vertices: gpu.buffer(file.bytes(b"POSI")),
                indices: gpu.zeros(3 * f),
                draws: gpu.zeros(5 * mesh.submeshes().len()),
                submeshes: mesh.submeshes().len() as u32,
            },
            vertices: v,
            eights,
            // The power of two below one over the size of the mesh.
            scale: (-mesh.diagonal().max(1e-30).log2()).floor().exp2() as f32,
        }
    }

    /// Shows what an eye sees at which an error may cover `slope` of its distance.
    pub(crate) fn show(&self, gpu: &Gpu, eye: [f32; 3], slope: f32) {
        let Self { points, links, by_error, source, triangles, live, places, submeshes, .. } = self;
        let OnDevice { vertices, indices, draws, submeshes: count } = &self.drawn;
        let (v, eights, count) = (self.vertices, self.eights, *count as usize);
        let stride = ("stride", f64::from(STRIDE));
        // [view]
        let [x, y, z] = eye.map(f32::to_bits);
        let (scale, a) = (self.scale.to_bits(), (slope / self.scale).to_bits());
        let parameters = [v as u32, self.lowest, 0, 0, x, y, z, scale, a, 0, 0, 0];
        let buffers = [points, links, by_error, source, vertices];
        gpu.run("view", &[("criterion", 1.0), stride], v, &parameters, &buffers);
        let eight = [eights as u32];
        let buffers = [triangles, vertices, live, places];
        gpu.run("filter_count", &[stride], eights + 1, &eight, &buffers);
        gpu.scan(places, eights + 1);
        gpu.run("filter_write", &[], eights, &eight, &[triangles, live, places, indices]);
        let buffers = [submeshes, live, places, draws];
        gpu.run("filter_draws", &[], count, &[count as u32], &buffers);
        // [/view]
    }

    pub(crate) fn drawn(&self) -> &OnDevice {
        &self.drawn
    }
}
