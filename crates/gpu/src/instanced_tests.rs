//! Instances on a device, judged by what is lit.

#![expect(clippy::print_stderr, reason = "a test that is left out says so aloud")]

use super::*;
use crate::draw::SIZE;

/// Reads back the picture's pixels, four bytes each, row by row from the top.
fn read_back(stage: &Instanced<'_>) -> Vec<u8> {
    let (gpu, bytes) = (&stage.device.device, 4 * u64::from(SIZE * SIZE));
    let buffer = gpu.create_buffer(&wgpu::BufferDescriptor {
        label: Some("pixels"),
        size: bytes,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        stage.targets.picture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * SIZE),
                rows_per_image: None,
            },
        },
        wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
    );
    stage.device.queue.submit([encoder.finish()]);
    let mut pixels = Vec::new();
    stage.device.map(&buffer, bytes, |mapped| pixels = mapped.to_vec()).expect("a picture");
    pixels
}

/// The grey of the pixel at a share of the way across, halfway down.
fn grey(stage: &Instanced<'_>, across: f32) -> u8 {
    let pixels = read_back(stage);
    let pixel = SIZE / 2 * SIZE + (across * SIZE as f32) as u32;
    pixels[4 * pixel as usize]
}

#[test]
fn instances_stand_where_they_are_put_and_turned_and_take_time() {
    let device = match Device::open(None) {
        Ok(device) => device,
        Err(GpuError::NoAdapter { why }) if !lodc_fixtures::all_asked() => {
            eprintln!("SKIPPED: no graphics adapter: {why}");
            return;
        }
        Err(e) => panic!("{e}"),
    };
    let square = [[0.4, -0.2, 0.0], [0.8, -0.2, 0.0], [0.8, 0.2, 0.0], [0.4, 0.2, 0.0]];
    // From the front, without perspective; depth grows away from the camera.
    let matrix =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -0.25, 0.0], [0.0, 0.0, 0.5, 1.0]];
    let stage = Instanced::new(&device, &[square.to_vec()], matrix).expect("small");
    let frame = |instances: &[Instance], strips: bool| InstancedFrame {
        // Two strips of one triangle each.
        indices: if strips { vec![0, 1, 3, u32::MAX, 1, 2, 3] } else { vec![0, 1, 2, 0, 2, 3] },
        strips,
        instances: instances.to_vec(),
        draws: vec![InstancedDraw {
            mesh: 0,
            indices: 0..6 + u32::from(strips),
            instances: 0..instances.len() as u32,
        }],
    };
    let start = std::time::Instant::now();
    let now = || start.elapsed();
    let ahead = Instance { origin: [0.0; 3], rotation: [1.0, 0.0] };
    let back = Instance { rotation: [-1.0, 0.0], ..ahead };
    let moved = Instance { origin: [-0.6, 0.0, 0.0], ..ahead };
    for (instances, lit) in [
        (vec![ahead], [false, false, true]),
        (vec![ahead, back], [true, false, true]),
        (vec![moved], [false, true, false]),
    ] {
        for strips in [false, true] {
            let taken = stage.timed(&frame(&instances, strips), &now).expect("a draw");
            assert!(taken >= 0.0);
            assert_eq!([0.22, 0.5, 0.78].map(|x| grey(&stage, x) > 0), lit, "{instances:?}");
        }
    }
    stage.timed(&InstancedFrame::default(), &now).expect("nothing to draw");
    assert_eq!(grey(&stage, 0.5), 0);
}
