//! Instances on a device, judged by what is lit.

#![expect(clippy::print_stderr, reason = "a test that is left out says so aloud")]

use super::*;
use crate::draw::SIZE;
use crate::picture::{Framing, Lens, Up, read_back};

/// The grey of the pixel at a share of the way across, halfway down.
fn grey(stage: &Instanced<'_>, across: f32) -> u8 {
    let picture = &stage.targets.picture;
    let pixels = read_back(stage.device, picture, [SIZE; 2]).expect("a picture");
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
    let lens = Lens::Orthographic;
    let framing = Framing { up: Up::Y, azimuth: 0.0, elevation: 0.0, lens, zoom: 1.0 };
    let camera = Camera::around(&[[-1.0; 3], [1.0; 3]], &framing, 1.0);
    let stage = Instanced::new(&device, &[square.to_vec()], &camera).expect("small");
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
