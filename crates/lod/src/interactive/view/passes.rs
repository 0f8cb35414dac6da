//! The view-dependent variant on a graphics device: buffers, kernels, and the pass that shows a
//! view.

use super::select::{FRUSTUM, Parameters};
use super::{Point, ViewQuery, Views};
use crate::interactive::shaders;
use lodc_mesh::Lod;
use lodc_plan::{BufferId, KernelId, Pass, Program};

/// Buffers and kernels of the view-dependent variant.
#[derive(Clone, Debug)]
pub struct ViewPasses {
    /// [`Views::points`], in words.
    points: BufferId,
    /// [`Views::links`].
    links: BufferId,
    /// [`Views::by_error`]: coarsest LODs.
    lods_by_error: BufferId,
    source: BufferId,
    /// The records that are drawn.
    pub vertices: BufferId,
    /// By criterion, without and with morphing.
    kernels: [[KernelId; 2]; 5],
    vertex_count: u32,
    /// The upper 18 bits of the error that `lods_by_error` begins with, from [`Views::by_error`].
    lowest_error: u32,
    /// What parameters of views are made of: the diagonal of the mesh and its last LOD.
    diagonal: f64,
    last: Lod,
}

impl ViewPasses {
    /// Uploads what the kernel reads, but for `source`, the records of the mesh; it writes to
    /// `vertices`.
    pub fn new(
        program: &mut Program,
        views: &Views<'_>,
        source: BufferId,
        vertices: BufferId,
    ) -> Self {
        let stride = views.records.stride as u32;
        let points: Vec<u32> = views.points().iter().flat_map(Point::words).collect();
        let (lods_by_error, lowest_error) = views.by_error();
        let mut kernel = |criterion, morph| {
            let constants =
                [("criterion", criterion as u32), ("morph", morph as u32), ("stride", stride)];
            program.kernel_with(shaders::VIEW, &constants)
        };
        let kernels =
            std::array::from_fn(|criterion| std::array::from_fn(|morph| kernel(criterion, morph)));
        Self {
            points: program.words("points", points),
            links: program.words("links", views.links().as_flattened()),
            lods_by_error: program.words("by_error", lods_by_error),
            source,
            vertices,
            kernels,
            vertex_count: views.points().len() as u32,
            lowest_error,
            diagonal: views.selector.diagonal,
            last: views.selector.last(),
        }
    }

    /// Shows a view.
    #[must_use]
    pub fn pass(&self, view: &ViewQuery) -> Pass {
        let p = Parameters::new(view, self.diagonal, self.last);
        // The two share a word, since no criterion needs both.
        let lowest_or_height =
            if p.criterion == FRUSTUM { p.height.to_bits() } else { self.lowest_error };
        let mut parameters = vec![self.vertex_count, lowest_or_height, p.lods[0], p.lods[1]];
        parameters.extend(p.point.map(f32::to_bits));
        parameters.push(p.scale.to_bits());
        parameters.extend(p.abc.map(f32::to_bits));
        parameters.push(0);
        Pass {
            kernel: self.kernels[p.criterion as usize][usize::from(p.morph)],
            buffers: vec![self.points, self.links, self.lods_by_error, self.source, self.vertices],
            threads: self.vertex_count,
            parameters,
        }
    }
}
