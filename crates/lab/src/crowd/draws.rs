//! Draws a crowd on a GPU: all characters with the same level in the same pose are one instanced
//! draw call.

use super::CrowdLevels;
use super::figures::{Figure, ground_position, rotation};
use super::picture::{DEGREES, points};
use super::report::{CrowdOnDevice, DrawnFrames};
use super::walk::WalkerPosition;
use crate::device::Device;
use crate::error::LabError;
use lodc_gpu::{GpuError, Instance, Instanced, InstancedDraw, InstancedFrame};
use lodc_measure::render::{Camera, Framing, Lens, Up};
use lodc_mesh::Lod;
use std::collections::BTreeMap;
use std::ops::Range;
use std::time::{Duration, Instant};

/// Frames that are drawn at most, evenly over the time. Chosen by hand.
const MAX_DRAWN_FRAMES: usize = 25;
/// No further round starts once drawing has taken so long. Chosen by hand.
const MAX_DRAWING_TIME: Duration = Duration::from_secs(20);

/// The camera that sees all of a crowd in all its frames.
fn camera(figures: &[Figure<'_>], positions: &[Vec<WalkerPosition>]) -> Camera {
    let lens = Lens::Perspective(DEGREES);
    let framing = Framing { up: Up::Y, azimuth: 0.0, elevation: DEGREES, lens, zoom: 1.0 };
    Camera::around(&points(figures, positions.iter().flatten()), &framing, 1.0)
}

/// Draws frames of each way to choose levels: continuous, discrete, none.
///
/// # Errors
/// If the device fails or is too small.
pub(crate) fn measure(
    device: &Device,
    figures: &mut [Figure<'_>],
    positions: &[Vec<WalkerPosition>],
    levels: [&CrowdLevels; 3],
    rounds: u32,
) -> Result<CrowdOnDevice, LabError> {
    let camera = camera(figures, positions);
    let mut buffers = Buffers::default();
    let meshes = buffers.all(figures);
    let frames = positions.len() - 1;
    let count = frames.min(MAX_DRAWN_FRAMES);
    let frame_numbers: Vec<usize> = (1..=count).map(|i| i * frames / count).collect();
    let stage = Instanced::new(device, &meshes, camera.matrix())?;
    let start = Instant::now();
    let mut drawn_frames = |levels: &CrowdLevels| -> Result<DrawnFrames, GpuError> {
        let frames: Vec<InstancedFrame> = frame_numbers
            .iter()
            .map(|&f| buffers.frame(figures, &positions[f], &levels.lods[f], f, &camera))
            .collect();
        let begun = start.elapsed();
        let mut best = f64::INFINITY;
        // In the first round drivers compile.
        for round in 0..=rounds {
            let mut sum = 0.0;
            for frame in &frames {
                sum += stage.timed(frame, &|| start.elapsed())?;
            }
            if round > 0 || start.elapsed().saturating_sub(begun) > MAX_DRAWING_TIME {
                best = f64::min(best, sum);
            }
            if start.elapsed().saturating_sub(begun) > MAX_DRAWING_TIME {
                break;
            }
        }
        let mean = |value: fn(&InstancedFrame) -> usize| {
            frames.iter().map(value).sum::<usize>() as f64 / frames.len() as f64
        };
        let triangles = |frame: &InstancedFrame| {
            let drawn = |d: &InstancedDraw| d.indices.len() / 3 * d.instances.len();
            frame.draws.iter().map(drawn).sum()
        };
        Ok(DrawnFrames {
            draw_ms_per_frame: best / 1e6 / frames.len() as f64,
            draws_per_frame: mean(|f| f.draws.len()),
            index_bytes_per_frame: mean(|f| 4 * f.indices.len()),
            triangles_per_frame: mean(triangles),
        })
    };
    let [continuous, discrete, none] = levels.map(&mut drawn_frames);
    Ok(CrowdOnDevice {
        adapter: device.adapter().to_string(),
        clock: if device.has_clock() { "device" } else { "host" },
        frames: count as u32,
        continuous: continuous?,
        discrete: discrete?,
        none: none?,
    })
}

/// The vertex buffers of all figures.
#[derive(Default)]
struct Buffers {
    /// By figure, phase and part.
    numbers: BTreeMap<(usize, usize, usize), usize>,
}

/// Instances that are one draw: their figure, phase and part, and the LOD.
type DrawKey = ((usize, usize, usize), Lod);

impl Buffers {
    fn all(&mut self, figures: &[Figure<'_>]) -> Vec<Vec<[f32; 3]>> {
        let mut meshes = Vec::new();
        for (f, figure) in figures.iter().enumerate() {
            for phase in 0..figure.phases() {
                for (p, part) in figure.parts(phase).iter().enumerate() {
                    self.numbers.insert((f, phase, p), meshes.len());
                    meshes.push(part.positions.clone());
                }
            }
        }
        meshes
    }

    /// A frame with one index list for each level, and one draw for each level of each pose.
    fn frame(
        &self,
        figures: &mut [Figure<'_>],
        positions: &[WalkerPosition],
        lods: &[Vec<Lod>],
        number: usize,
        camera: &Camera,
    ) -> InstancedFrame {
        let mut same: BTreeMap<DrawKey, Vec<Instance>> = BTreeMap::new();
        for (i, (walker, lods)) in positions.iter().zip(lods).enumerate() {
            let f = i % figures.len();
            let phase = figures[f].phase(i, number);
            let position = ground_position(walker);
            let origin = std::array::from_fn(|k| (position[k] - camera.centre[k]) as f32);
            let instance = Instance { origin, rotation: rotation(walker) };
            for (p, part) in figures[f].parts(phase).iter().enumerate() {
                same.entry(((f, phase, p), lods[part.object])).or_default().push(instance);
            }
        }
        let mut frame = InstancedFrame::default();
        // By figure, object, LOD, and whether the corners are taken the other way round.
        let mut lists: BTreeMap<(usize, usize, Lod, bool), Range<u32>> = BTreeMap::new();
        for (((f, phase, p), lod), instances) in same {
            let figure = &mut figures[f];
            let part = &figure.parts(phase)[p];
            let (object, mirrored) = (part.object, part.mirrored);
            let indices = lists.entry((f, object, lod, mirrored)).or_insert_with(|| {
                let first = frame.indices.len() as u32;
                let turned = |&[a, b, c]: &[u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
                frame.indices.extend(figure.level(object, lod).iter().flat_map(turned));
                first..frame.indices.len() as u32
            });
            let first = frame.instances.len() as u32;
            frame.instances.extend(instances);
            frame.draws.push(InstancedDraw {
                mesh: self.numbers[&(f, phase, p)],
                indices: indices.clone(),
                instances: first..frame.instances.len() as u32,
            });
        }
        frame
    }
}
