//! The view-dependent variant on a graphics device: buffers, kernels, and the pass that shows a
//! view.

use super::{Point, ViewQuery, Views};
use crate::interactive::shaders;
use lodc_plan::{BufferId, KernelId, Pass, Program};

/// Buffers and kernels of the view-dependent variant.
#[derive(Clone, Debug)]
pub struct ViewPasses {
    points: BufferId,
    links: BufferId,
    by_error: BufferId,
    source: BufferId,
    /// The records that are drawn.
    pub vertices: BufferId,
    /// By criterion, without and with morphing.
    kernels: [[KernelId; 2]; 5],
    sizes: [u32; 2],
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
            by_error: program.words("by_error", views.by_error().0),
            source,
            vertices,
            kernels,
            sizes: [views.points().len() as u32, views.by_error().1],
        }
    }

    /// Shows a view.
    #[must_use]
    pub fn pass(&self, view: &ViewQuery, views: &Views<'_>) -> Pass {
        let [vertices, lowest] = self.sizes;
        let p = views.selector.parameters(view);
        let lowest = if p.criterion == 4 { p.height.to_bits() } else { lowest };
        let mut parameters = vec![vertices, lowest, p.lods[0], p.lods[1]];
        parameters.extend(p.point.map(f32::to_bits));
        parameters.push(p.scale.to_bits());
        parameters.extend(p.abc.map(f32::to_bits));
        parameters.push(0);
        Pass {
            kernel: self.kernels[p.criterion as usize][usize::from(p.morph)],
            buffers: vec![self.points, self.links, self.by_error, self.source, self.vertices],
            threads: vertices,
            parameters,
        }
    }
}
